// A trajectory is played in real time, above a plot of the least clearance over time; a click there goes to an instant.
const clock = data.times && data.times.length > 1 ? data.times : null;
const WIDE = 1000, HIGH = 100, PAUSE = 1;  // of the plot, in its own lengths; s, at the end
function frameAt(time) {  // the last one that is not later
  let low = 0, high = clock.length - 1;
  while (low < high) { const middle = low + high + 1 >> 1; if (clock[middle] <= time) low = middle; else high = middle - 1; }
  return low;
}
let hand = null;
const across = (time) => WIDE * (time - clock[0]) / (clock[clock.length - 1] - clock[0]);
if (clock && data.clearances) {
  const most = Math.max(...data.clearances, 1e-3), least = Math.min(...data.clearances, 0), spare = 0.08 * (most - least);
  const down = (clearance) => HIGH * (most + spare - clearance) / (most - least + 2 * spare);
  const points = clock.map((time, k) => `${across(time)},${down(data.clearances[k])}`).join(" "), thin = 'vector-effect="non-scaling-stroke"';
  element("plot").insertAdjacentHTML("afterbegin", `<svg viewBox="0 0 ${WIDE} ${HIGH}" preserveAspectRatio="none">
    <line x1="0" x2="${WIDE}" y1="${down(0)}" y2="${down(0)}" stroke="var(--bad)" stroke-dasharray="4 4" ${thin}/>
    <polyline points="${points}" fill="none" stroke="var(--blue)" stroke-width="1.5" ${thin}/>
    <line y1="0" y2="${HIGH}" stroke="var(--text)" ${thin}/></svg>`);
  const picture = element("plot").firstElementChild;
  hand = picture.lastElementChild;
  picture.onclick = (event) => {
    const box = picture.getBoundingClientRect(), part = (event.clientX - box.left) / box.width;
    show(frameAt(clock[0] + part * (clock[clock.length - 1] - clock[0])));
  };
  element("plot").hidden = false;
  document.body.classList.add("timed");
}
function showInstant() {
  if (!hand) return;
  for (const end of ["x1", "x2"]) hand.setAttribute(end, across(clock[frame]));
  element("plot").querySelector("span").textContent = `least clearance ${Number((1000 * data.clearances[frame]).toPrecision(3))} mm`;
}
function playInTime() {  // again and again, from the frame that is shown, also after it was chosen by hand
  let shown = frame, began = performance.now() - 1000 * (clock[frame] - clock[0]);
  const whole = clock[clock.length - 1] - clock[0];
  return setInterval(() => {
    if (frame !== shown) began = performance.now() - 1000 * (clock[frame] - clock[0]);
    shown = frameAt(clock[0] + (performance.now() - began) / 1000 % (whole + PAUSE));
    if (shown !== frame) show(shown);
  }, 16);
}
