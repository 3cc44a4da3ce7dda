// The layer that bodies of very many parts are drawn into: colours, numbers and depths of their own, over which each
// picture draws all else. Where this takes long, e.g. without a graphics card, it is drawn in slices of some ms, one a
// frame, so that whatever moves the view ends it at once. While the view moves, a frame has one slice, which holds as much
// as fits, and the picture fewer and larger pixels. Portions keep their order, so that slices give pixel for pixel what one draw gives.
const SLICE = 40, MOVING_SLICE = 25, BETWEEN = 250;  // ms of a slice; ms between pictures that show how far it is
const COARSE = 2, FEWEST = 8192;  // how much larger, each way, pixels are while the view moves; parts of a slice
const layer = { into: gl.createFramebuffer(), width: 0, height: 0, key: "", chosen: [], next: 0, count: 0, spent: 0, slices: 0 };
const atOnce = wishes.get("bare") || wishes.get("still");  // a picture that may be taken before the next frame
// Parts in a first slice, fine and coarse, as the last ones had time for; ms that all took, fine.
const pace = { first: [FEWEST, 2 * FEWEST], whole: Infinity };
let moving = wishes.has("moving"), resting = 0, waiting = false, painted = 0;

function texture(inner, format, kind, width, height) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.texImage2D(gl.TEXTURE_2D, 0, inner, width, height, 0, format, kind, null);
  for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
  return made;
}
function resizeLayer(width, height) {
  for (const old of [layer.colours, layer.depths]) if (old) gl.deleteTexture(old);
  layer.colours = texture(gl.RGBA16UI, gl.RGBA_INTEGER, gl.UNSIGNED_SHORT, width, height);
  layer.depths = texture(gl.DEPTH_COMPONENT24, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, width, height);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, layer.colours, 0);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, layer.depths, 0);
  Object.assign(layer, { width, height });
}
const isCoarse = () => moving && pace.whole > MOVING_SLICE && parts.some((each) => shown(each.layer));
function beginLayer() {  // anew, if anything that shows has changed
  const coarse = isCoarse() ? 1 : 0, { width, height } = canvas, there = parts.filter((each) => shown(each.layer));
  const key = JSON.stringify([coarse, width, height, colourBy, [...seen()], there.map((each) => [each.index, ...poseOf(each)])]);
  if (key === layer.key) return false;
  if (width !== layer.width || height !== layer.height) resizeLayer(width, height);
  gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
  gl.clearBufferfv(gl.DEPTH, 0, [1]);
  Object.assign(layer, { key, coarse, next: 0, spent: 0, slices: 0, count: pace.first[coarse] });
  layer.chosen = pieces.filter(({ each }) => there.includes(each));
  return true;
}
function drawSlice(whole) {
  const began = performance.now(), from = layer.next, all = whole || atOnce && !moving || pace.whole <= MOVING_SLICE;
  let count = 0;
  while (layer.next < layer.chosen.length && (all || count < layer.count)) count += layer.chosen[layer.next++].count;
  drawPieces(layer.chosen.slice(from, layer.next), layer.width, layer.height);
  gl.readPixels(0, 0, 1, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, new Uint32Array(4));  // waits until it is drawn
  const took = performance.now() - began;
  layer.slices += 1;
  layer.spent += took;
  layer.count = Math.max(FEWEST, Math.min(4 * count, count * (moving ? MOVING_SLICE : SLICE) / took));
  if (layer.slices === 1) pace.first[layer.coarse] = layer.count;
  if (layer.next === layer.chosen.length && !layer.coarse) pace.whole = layer.spent;
}
const unfinished = () => layer.next < layer.chosen.length && !(layer.coarse && layer.slices);
function drawLayer(whole) {  // a slice more, or all the rest; whether it began anew
  gl.bindFramebuffer(gl.FRAMEBUFFER, layer.into);
  const anew = beginLayer();
  if (unfinished()) drawSlice(whole);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  if (unfinished()) drawSoon();
  return anew;
}
function draw(whole) {  // all at once, or what there is time for
  prepare();
  if (parts.length) drawLayer(whole);
  paintAll();
}
function drawSoon() {  // in the next frame; painting takes time of its own, so that not every slice is shown
  if (!waiting) requestAnimationFrame(() => {
    waiting = false;
    prepare();
    const anew = !parts.length || drawLayer(false);
    if (anew || !unfinished() || performance.now() - painted > BETWEEN) paintAll();
  });
  waiting = true;
}
function drawMoving() {  // the whole of it when the view has come to rest, ms
  moving = true;
  drawSoon();
  clearTimeout(resting);
  resting = setTimeout(() => { moving = false; drawSoon(); }, 250);
}

const layerProgram = linked(`
  void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`, `
  uniform highp usampler2D colours; uniform highp sampler2D depths; uniform bool numbers; out vec4 shown;
  void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    uvec4 found = texelFetch(colours, at, 0);
    if (found.a == 0u) discard;
    gl_FragDepth = texelFetch(depths, at, 0).r;
    shown = vec4(vec3(numbers ? uvec3(found.a, found.a >> 8, 0) & 255u : found.rgb) / 255.0, 1.0);
  }`);
const layerAt = places(layerProgram, ["colours", "depths", "numbers"]), nothing = gl.createVertexArray();
function showLayer(numbers) {  // its colours; or, for a click, the numbers of its bodies
  if (!layer.chosen.length) return;
  gl.useProgram(layerProgram);
  gl.activeTexture(gl.TEXTURE1);
  gl.bindTexture(gl.TEXTURE_2D, layer.depths);
  gl.activeTexture(gl.TEXTURE0);
  gl.bindTexture(gl.TEXTURE_2D, layer.colours);
  gl.uniform1i(layerAt.colours, 0);
  gl.uniform1i(layerAt.depths, 1);
  gl.uniform1i(layerAt.numbers, numbers ? 1 : 0);
  gl.bindVertexArray(nothing);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  gl.useProgram(program);
}
