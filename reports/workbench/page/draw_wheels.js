// The wheels: rim to scale of the neighbours' distance, arrow for the surface speed, disc for the load, thin line for
// a friction axis of its own; the selected ones with a handle that turns the rim.
// May be changed: sizes and shapes. What a wheel carries and where its rim points come from Python's reply.

import { attr, pool, s, say } from "./dom.js";
import { arrowPath } from "./draw_cells.js";

const LENGTH = [16, 54]; // shortest and longest rim, in pixels
const SHARE = 0.42; // of the distance to the nearest other wheel
const FASTEST = 1; // length of the arrow of the fastest wheel, in rims
const HEAVIEST = 0.7; // radius of the disc of the heaviest wheel, in rims
const LETTER = 4.5; // half of the width of a letter of a name, in pixels
const HANDLE = 44; // pixels between the end of the rim and its handle

/** Length of a rim, alike for all wheels; in pixels before marks are scaled by the view's unit. */
function rimLength(view, wheels) {
  const apart = wheels.length > 1 ? (smallestDistance(wheels.slice(0, 150)) * view.scale) / view.unit : LENGTH[1];
  return Math.max(LENGTH[0], Math.min(LENGTH[1], SHARE * apart));
}

function smallestDistance(wheels) {
  let least = Infinity;
  wheels.forEach((a, k) => {
    for (const b of wheels.slice(k + 1)) least = Math.min(least, (a.x - b.x) ** 2 + (a.y - b.y) ** 2 || Infinity);
  });
  return Math.sqrt(least);
}

/** Where the handle of a wheel's rim is, in pixels from the wheel. */
function handleOf(wheel, rim) {
  return [wheel.rim[0] * (rim / 2 + HANDLE), -wheel.rim[1] * (rim / 2 + HANDLE)];
}

export function drawWheels(layer, view, wheels, selection) {
  const rim = rimLength(view, wheels);
  const fastest = Math.max(1e-300, ...wheels.map((wheel) => Math.abs(wheel.speed ?? 0)));
  const heaviest = Math.max(1e-300, ...wheels.map((wheel) => wheel.load ?? 0));
  const chosen = new Set(selection);
  const drawn = pool(layer, wheels.length, wheelMark);
  wheels.forEach((wheel, k) => {
    const mark = drawn[k];
    const [px, py] = view.at(wheel.x, wheel.y);
    attr(mark, "transform", view.mark(px, py));
    attr(mark, "class", `wheel${wheel.carries === false ? " idle" : ""}${chosen.has(k) ? " selected" : ""}`);
    attr(mark, "data-wheel", k);
    drawOne(mark, wheel, { rim, speed: (wheel.speed ?? 0) / fastest, load: Math.sqrt(Math.max(0, wheel.load ?? 0) / heaviest) });
    say(mark.querySelector("text"), wheel.name ?? String(k + 1));
    drawHandle(mark, wheel, rim, chosen.has(k) && chosen.size === 1);
  });
}

function wheelMark() {
  const mark = s("g");
  mark.append(
    s("circle", { class: "load" }), s("circle", { class: "grip" }), s("path", { class: "friction-axis" }), s("rect", { class: "rim" }),
    s("path", { class: "tread" }), s("path", { class: "speed" }), s("path", { class: "handle-line" }), s("circle", { class: "handle", r: 8 }), s("text"),
  );
  return mark;
}

function drawOne(mark, wheel, { rim, speed, load }) {
  const [disc, grip, axis, body, tread, arrow] = mark.children;
  const [ux, uy] = [wheel.rim[0], -wheel.rim[1]];
  const angle = ((Math.atan2(uy, ux) * 180) / Math.PI).toFixed(2);
  const half = rim / 2;
  attr(disc, "r", (load * HEAVIEST * rim).toFixed(1));
  attr(grip, "r", Math.max(20, rim * 0.7).toFixed(1));
  for (const [name, value] of [["x", -half], ["y", -0.19 * rim], ["width", rim], ["height", 0.38 * rim], ["rx", 0.09 * rim]]) attr(body, name, value.toFixed(1));
  attr(body, "transform", `rotate(${angle})`);
  attr(tread, "transform", `rotate(${angle})`);
  attr(tread, "d", [-0.6, -0.2, 0.2, 0.6].map((k) => `M${(k * half).toFixed(1)} ${(-0.12 * rim).toFixed(1)}v${(0.24 * rim).toFixed(1)}`).join(""));
  const reach = speed * FASTEST * rim;
  attr(arrow, "d", Math.abs(reach) > 1 ? arrowPath(ux * reach, uy * reach, 9) : "");
  attr(arrow, "transform", `translate(${((ux * reach) / 2).toFixed(1)} ${((uy * reach) / 2).toFixed(1)})`);
  const along = wheel.axis;
  attr(axis, "d", along ? `M${(-along[0] * rim).toFixed(1)} ${(along[1] * rim).toFixed(1)}L${(along[0] * rim).toFixed(1)} ${(-along[1] * rim).toFixed(1)}` : "");
  const text = mark.lastElementChild;
  const outward = wheel.speed < 0 ? 1 : -1;
  const away = half + 11 + Math.abs(ux) * LETTER * Math.max(0, (wheel.name ?? "").length - 1); // the whole name beside the rim
  attr(text, "x", (ux * outward * away).toFixed(1));
  attr(text, "y", (uy * outward * away).toFixed(1));
}

function drawHandle(mark, wheel, rim, shownNow) {
  const [line, knob] = [mark.children[6], mark.children[7]];
  const [hx, hy] = handleOf(wheel, rim);
  attr(line, "d", shownNow ? `M0 0L${hx.toFixed(1)} ${hy.toFixed(1)}` : "");
  attr(knob, "cx", hx.toFixed(1));
  attr(knob, "cy", hy.toFixed(1));
  attr(knob, "visibility", shownNow ? "inherit" : "hidden");
  attr(knob, "data-rim", shownNow ? mark.getAttribute("data-wheel") : "");
}
