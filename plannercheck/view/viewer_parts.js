// Draws bodies of very many parts: balls as round points that shrink with the distance, cells as the rectangles of
// their outside. viewer.html includes it; places are whole numbers of 16 bits, as drawn_parts.py packs them. While the
// view moves, fewer balls are drawn, and small: they would be drawn over each other many times; of the rectangles those
// that show most.
const BALLS_IN_MOTION = 20000, PIXELS_IN_MOTION = 4, MOST_PIXELS = 256, RECTANGLES_IN_MOTION = 20000;  // on each side
const partsProgram = linked(`
  in uvec4 place; uniform mat4 pose, seen; uniform vec3 corner, middle; uniform vec2 range;
  uniform float step, pixels, most; uniform int axis, by; out float shade; flat out float light;
  void main() {  // axis -1: a ball with its radius; else a corner of a rectangle across that axis
    vec4 w = pose * vec4(corner + step * vec3(place.xyz), 1.0);
    gl_Position = seen * w;
    gl_PointSize = clamp(2.0 * step * float(place.w) * pixels / gl_Position.w, 1.0, most);
    vec3 n = vec3(0.0);
    if (axis >= 0) n[axis] = 1.0;
    light = axis < 0 ? 0.0 : 0.62 + 0.38 * abs(dot(mat3(pose) * n, vec3(0.35, 0.25, 0.9)));
    shade = clamp(((by == 0 ? w.z : distance(w.xyz, middle)) - range.x) / (range.y - range.x), 0.0, 1.0);
  }`, `
  in float shade; flat in float light; uniform vec4 colour; out vec4 shown;
  void main() {  // from blue over green to yellow, as viridis goes; a colour that is given counts instead
    vec3 low = vec3(0.27, 0.30, 0.56), mid = vec3(0.16, 0.60, 0.55), high = vec3(0.96, 0.87, 0.25);
    vec3 c = shade < 0.5 ? mix(low, mid, 2.0 * shade) : mix(mid, high, 2.0 * shade - 1.0);
    float r = light > 0.0 ? 0.0 : length(gl_PointCoord - 0.5);
    if (r > 0.5) discard;
    shown = colour.a > 0.0 ? colour : vec4(c * (light > 0.0 ? light : 1.0 - 1.2 * r * r), 1.0);
  }`);
const partsAt = places(partsProgram, ["pose", "seen", "corner", "middle", "range", "step", "pixels", "most", "axis", "by", "colour"]);
function corners(rectangles, axis) {  // x, y, z and two lengths a rectangle: four corners, each with a 0
  const count = rectangles.length / 5, made = new Uint16Array(16 * count), u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (let i = 0; i < count; i++) for (let k = 0; k < 4; k++) {
    const to = 16 * i + 4 * k, from = 5 * i;
    for (let c = 0; c < 3; c++) made[to + c] = rectangles[from + c];
    if (k & 1) made[to + u] += rectangles[from + 3];
    if (k & 2) made[to + v] += rectangles[from + 4];
  }
  return made;
}
function largestFirst(rectangles) {
  const area = (i) => rectangles[5 * i + 3] * rectangles[5 * i + 4], made = new Uint16Array(rectangles.length);
  const order = Uint32Array.from({ length: rectangles.length / 5 }, (_, i) => i).sort((a, b) => area(b) - area(a));
  order.forEach((from, i) => made.set(rectangles.subarray(5 * from, 5 * from + 5), 5 * i));
  return made;
}
function scattered(balls) {  // so that the first ones are from everywhere: steps around the circle of all
  const count = balls.length / 4, made = new Uint16Array(balls.length), divisor = (a, b) => b ? divisor(b, a % b) : a;
  let step = Math.ceil(0.618 * count);
  while (divisor(step, count) > 1) step++;
  for (let i = 0, from = 0; i < count; i++, from = (from + step) % count)
    for (let c = 0; c < 4; c++) made[4 * i + c] = balls[4 * from + c];
  return made;
}
function partsArray(numbers, faces) {
  const array = gl.createVertexArray(), at = gl.getAttribLocation(partsProgram, "place");
  gl.bindVertexArray(array);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.STATIC_DRAW);
  gl.enableVertexAttribArray(at);
  gl.vertexAttribIPointer(at, 4, gl.UNSIGNED_SHORT, 0, 0);
  const count = numbers.length / 4;
  if (!faces) return { array, draw: () => gl.drawArrays(gl.POINTS, 0, moving ? Math.min(count, BALLS_IN_MOTION) : count) };
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
  const few = 6 * RECTANGLES_IN_MOTION, all = faces.length;
  return { array, draw: () => gl.drawElements(gl.TRIANGLES, moving ? Math.min(all, few) : all, gl.UNSIGNED_INT, 0) };
}
const halves = (count) => Uint32Array.from({ length: 6 * count }, (_, i) => 4 * Math.floor(i / 6) + [0, 1, 2, 2, 1, 3][i % 6]);
const parts = data.parts.map((each, k) => {
  const groups = each.groups.map((text, side) => {
    const numbers = unpacked(text, Uint16Array);
    return each.kind === "balls" ? partsArray(scattered(numbers)) : partsArray(corners(largestFirst(numbers), side >> 1), halves(numbers.length / 5));
  });
  return { ...each, groups, index: meshes.length + k, poses: unpacked(each.poses, Float32Array) };
});
let moving = wishes.has("moving"), resting = 0;
function drawMoving() {  // the whole of it when the view has come to rest, ms
  moving = true;
  draw();
  clearTimeout(resting);
  resting = setTimeout(() => { moving = false; draw(); }, 250);
}
let colourBy = wishes.get("colour") === "distance" ? 1 : 0;  // 0 the height, 1 the distance from what is looked at
function drawParts(number) {  // `number`: a body's colour by which a click finds it
  gl.useProgram(partsProgram);
  gl.uniformMatrix4fv(partsAt.seen, false, seen());
  gl.uniform3f(partsAt.middle, ...data.centre);
  gl.uniform1f(partsAt.pixels, Math.min(canvas.width, canvas.height) / (2 * Math.tan(FIELD / 2)));
  gl.uniform1f(partsAt.most, moving ? PIXELS_IN_MOTION : MOST_PIXELS);
  gl.uniform1i(partsAt.by, colourBy);
  for (const each of parts) if (shown(each.layer)) {
    gl.uniform4f(partsAt.colour, ...(number ? number(each.index) : [0, 0, 0]), number ? 1 : 0);
    gl.uniformMatrix4fv(partsAt.pose, false, poseOf(each));
    gl.uniform3f(partsAt.corner, ...each.corner);
    gl.uniform1f(partsAt.step, each.step);
    gl.uniform2f(partsAt.range, ...each.ranges[colourBy]);
    each.groups.forEach((group, side) => {
      gl.bindVertexArray(group.array);
      gl.uniform1i(partsAt.axis, each.kind === "balls" ? -1 : side >> 1);
      group.draw();
    });
  }
  gl.useProgram(program);
}
