// Bodies of very many parts: balls as round points that shrink with the distance, cells as the rectangles of their
// outside. viewer.html includes it; places are whole numbers of 16 bits, as drawn_parts.py packs them. What is drawn of
// them goes into the layer of viewer_layer.js: `pieces` lists it in portions, each from everywhere, those that show most
// first.
const MOST_PIXELS = 256, PORTION = 1024;  // a ball's diameter; balls or rectangles
const SHADE = `
  in uvec4 place; uniform mat4 pose, seen; uniform vec3 corner, middle; uniform vec2 range; uniform float step; uniform int by;
  vec4 world() { return pose * vec4(corner + step * vec3(place.xyz), 1.0); }
  float shadeAt(vec4 w) { return clamp(((by == 0 ? w.z : distance(w.xyz, middle)) - range.x) / (range.y - range.x), 0.0, 1.0); }`;
const TINT = `  // from blue over green to yellow, as viridis goes
  vec3 tint(float shade) {
    vec3 low = vec3(0.27, 0.30, 0.56), mid = vec3(0.16, 0.60, 0.55), high = vec3(0.96, 0.87, 0.25);
    return 255.0 * (shade < 0.5 ? mix(low, mid, 2.0 * shade) : mix(mid, high, 2.0 * shade - 1.0));
  }`;
// Each writes colours and the body's number, by which a click finds it. A ball's place goes with its radius, that of a
// rectangle across an axis is a corner.
const partsPrograms = {
  balls: linked(`${SHADE}${TINT}
  uniform float pixels; flat out vec3 colour;
  void main() {
    vec4 w = world();
    gl_Position = seen * w;
    gl_PointSize = clamp(2.0 * step * float(place.w) * pixels / gl_Position.w, 1.0, ${MOST_PIXELS}.0);
    colour = tint(shadeAt(w));
  }`, `
  flat in vec3 colour; uniform uint number; out uvec4 shown;
  void main() {
    vec2 from = gl_PointCoord - 0.5;
    float r2 = dot(from, from);
    if (r2 > 0.25) discard;
    shown = uvec4(colour * (1.0 - 1.2 * r2) + 0.5, number);
  }`),
  cells: linked(`${SHADE}
  uniform int axis; out float shade; flat out float light;
  void main() {
    vec4 w = world();
    gl_Position = seen * w;
    light = 0.62 + 0.38 * abs(dot(mat3(pose)[axis], vec3(0.35, 0.25, 0.9)));
    shade = shadeAt(w);
  }`, `${TINT}
  in float shade; flat in float light; uniform uint number; out uvec4 shown;
  void main() { shown = uvec4(tint(shade) * light + 0.5, number); }`),
};
const NAMES = ["pose", "seen", "corner", "middle", "range", "step", "pixels", "axis", "by", "number"];
const partsAt = Object.fromEntries(Object.entries(partsPrograms).map(([kind, made]) => [kind, places(made, NAMES)]));
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
  const array = gl.createVertexArray(), at = gl.getAttribLocation(partsPrograms[faces ? "cells" : "balls"], "place");
  gl.bindVertexArray(array);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.STATIC_DRAW);
  gl.enableVertexAttribArray(at);
  gl.vertexAttribIPointer(at, 4, gl.UNSIGNED_SHORT, 0, 0);
  if (!faces) return { array, count: numbers.length / 4, draw: (from, count) => gl.drawArrays(gl.POINTS, from, count) };
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
  return { array, count: faces.length / 6, draw: (from, count) => gl.drawElements(gl.TRIANGLES, 6 * count, gl.UNSIGNED_INT, 24 * from) };
}
const halves = (count) => Uint32Array.from({ length: 6 * count }, (_, i) => 4 * Math.floor(i / 6) + [0, 1, 2, 2, 1, 3][i % 6]);
const parts = data.parts.map((each, k) => {
  const groups = each.groups.map((text, side) => {
    const numbers = unpacked(text, Uint16Array);
    return each.kind === "balls" ? partsArray(scattered(numbers)) : partsArray(corners(largestFirst(numbers), side >> 1), halves(numbers.length / 5));
  });
  return { ...each, groups, index: meshes.length + k, poses: unpacked(each.poses, Float32Array) };
});
const pieces = parts.flatMap((each) => each.groups.flatMap((group, side) =>
  Array.from({ length: Math.ceil(group.count / PORTION) }, (_, k) => ({ each, group, side, from: k * PORTION, count: Math.min(PORTION, group.count - k * PORTION) }))
)).sort((a, b) => a.from / a.group.count - b.from / b.group.count);
let colourBy = wishes.get("colour") === "distance" ? 1 : 0;  // 0 the height, 1 the distance from what is looked at
function drawPieces(chosen, width, height) {
  for (const [kind, made] of Object.entries(partsPrograms)) {
    gl.useProgram(made);
    gl.uniformMatrix4fv(partsAt[kind].seen, false, seen());
    gl.uniform3f(partsAt[kind].middle, ...data.centre);
    gl.uniform1f(partsAt[kind].pixels, Math.min(width, height) / (2 * Math.tan(FIELD / 2)));
    gl.uniform1i(partsAt[kind].by, colourBy);
  }
  for (const { each, group, side, from, count } of chosen) {
    const at = partsAt[each.kind];
    gl.useProgram(partsPrograms[each.kind]);
    gl.uniform1ui(at.number, each.index + 1);
    gl.uniformMatrix4fv(at.pose, false, poseOf(each));
    gl.uniform3f(at.corner, ...each.corner);
    gl.uniform1f(at.step, each.step);
    gl.uniform2f(at.range, ...each.ranges[colourBy]);
    gl.uniform1i(at.axis, side >> 1);
    gl.bindVertexArray(group.array);
    group.draw(from, count);
  }
  gl.useProgram(program);
}
