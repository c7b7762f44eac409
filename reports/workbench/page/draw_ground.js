// The ground of the drawing: grid lines with their numbers, the checked square, the checked point.
// May be changed: how many grid lines there are and where their numbers stand.

import { attr, pool, s, say } from "./dom.js";
import { niceStep, roundTo, shown } from "./values.js";

const BETWEEN = 70; // pixels between grid lines, at least
const CORNER = 60; // pixels that the unit in the corner takes
const CROSS = 7; // half of the checked point's mark, in pixels

/** Grid lines at round coordinates with their numbers along the left and lower edge, and the unit where these meet. */
export function drawGrid(lines, labels, view, unit) {
  const step = niceStep((BETWEEN * view.unit) / view.scale);
  const [left, top] = view.under(0, 0);
  const [right, low] = view.under(view.width, view.height);
  const xs = multiples(left, right, step);
  const ys = multiples(low, top, step);
  const all = [...xs.map((x) => ["x", x]), ...ys.map((y) => ["y", y])];
  const drawn = pool(lines, all.length, () => s("path"));
  const named = pool(labels, all.length + 1, () => s("text"));
  const corner = named[all.length];
  say(corner, unit ? `[${unit}]` : "");
  for (const [name, value] of [["x", 6], ["y", view.height - 6], ["class", "unit"]]) attr(corner, name, value);
  all.forEach(([along, value], k) => {
    const [px, py] = view.at(value, value);
    attr(drawn[k], "d", along === "x" ? `M${px.toFixed(1)} 0V${view.height}` : `M0 ${py.toFixed(1)}H${view.width}`);
    attr(drawn[k], "class", value === 0 ? "axis" : "");
    say(named[k], shown(value, 6));
    attr(named[k], "x", along === "x" ? px.toFixed(1) : 6);
    attr(named[k], "y", along === "x" ? view.height - 6 : (py - 4).toFixed(1));
    attr(named[k], "class", along);
    attr(named[k], "visibility", isFree(along === "x" ? px : py, along, view) ? "inherit" : "hidden");
  });
}

/** Whether a number has room: not cut by the edge, not in the corner where both rows of numbers meet. */
function isFree(place, along, view) {
  return along === "x" ? place > CORNER && place < view.width - 18 : place > 16 && place < view.height - 22;
}

function multiples(from, to, step) {
  const found = [];
  for (let k = Math.ceil(from / step); k * step <= to && found.length < 100; k += 1) found.push(roundTo(k * step, step));
  return found;
}

/** The square in which the cells are asked for, and the point that is checked. */
export function drawSquare(layer, view, square) {
  const [outline, point] = pool(layer, square ? 2 : 0, () => s("path"));
  if (!square) return;
  const { x, y, radius: r } = square;
  attr(outline, "class", "square");
  attr(outline, "d", view.path([[x - r, y - r], [x + r, y - r], [x + r, y + r], [x - r, y + r]], true));
  const [px, py] = view.at(x, y);
  attr(point, "class", "checked-point");
  const half = CROSS * view.unit;
  attr(point, "d", `M${px - half} ${py}h${2 * half}M${px} ${py - half}v${2 * half}`);
}
