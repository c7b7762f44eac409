// The cells of the chosen rule: filled by the sense in which the body turns there (hue, and a turning sign), with an
// arrow for the motion, and small arrows all over the square; edges told apart by their form; rest areas dotted.  For
// rules without cells: arrows on a grid.
// May be changed: sizes of arrows, tints (in drawing.css). The cells themselves come from Python.

import { attr, pool, s } from "./dom.js";

const SMALLEST = 700; // square pixels of a cell that still carries an arrow
const LONGEST = 44; // pixels of an arrow
const FLOW = 34; // pixels between the small arrows of a flow
const STREAM = 20; // pixels of one of them
const BESIDE = 7; // pixels from the border of a cell, at least
const CLOSEST = 15; // pixels between arrows of a sampled field, at least
const FAINTEST = 0.25; // opacity of the cell that turns least, of the one that turns most
const TURN = "M-6.5 0A6.5 6.5 0 1 1 0 6.5M-3.6 9.6L0.6 6.5L-3 2.9"; // three quarters of a circle, clockwise on screen

/** How a cell moves, as a class: by the sign of omega alone, so that hue never stands for a number. */
export function turning(omega) {
  if (Math.abs(omega) < 1e-12) return "turns-not";
  return omega > 0 ? "turns-left" : "turns-right";
}

export function drawCells(layer, view, cells) {
  const most = Math.max(1e-300, ...cells.map((cell) => Math.abs(cell.omega ?? 0)));
  const drawn = pool(layer, cells.length, () => s("path"));
  cells.forEach((cell, k) => {
    const rests = cell.kind === "rest";
    attr(drawn[k], "d", view.path(cell.polygon, true));
    attr(drawn[k], "class", `cell ${rests ? "rests" : turning(cell.omega ?? 0)}`);
    attr(drawn[k], "data-cell", k);
    const share = Math.abs(cell.omega ?? 0) / most;
    attr(drawn[k], "fill-opacity", rests ? 1 : (FAINTEST + (1 - FAINTEST) * share).toFixed(2));
  });
}

/** Arrows and turning signs, in the middle of each cell that is large enough. */
export function drawMotions(layer, view, cells) {
  const large = cells.filter((cell) => cell.kind !== "rest" && cell.velocity && areaOf(cell.polygon) * view.scale ** 2 > SMALLEST);
  const drawn = pool(layer, large.length, motionMark);
  large.forEach((cell, k) => {
    const [px, py] = view.at(...middleOf(cell.polygon));
    const size = (Math.sqrt(areaOf(cell.polygon)) * view.scale) / view.unit;
    attr(drawn[k], "class", "of-cell");
    placeMotion(drawn[k], view.mark(px, py), cell.velocity, cell.omega ?? 0, Math.min(LONGEST, 0.36 * size));
  });
}

/** Small arrows on a grid all over the square: where the body moves that is put down there. */
export function drawFlow(layer, view, cells, square) {
  const moving = cells.filter((cell) => cell.kind !== "rest" && cell.twist);
  const marks = square && moving.length ? flowOf(view, moving, square) : [];
  const drawn = pool(layer, marks.length, () => s("path", { class: "flow" }));
  marks.forEach(([px, py, vx, vy], k) => {
    const speed = Math.hypot(vx, vy);
    attr(drawn[k], "transform", view.mark(px, py));
    attr(drawn[k], "d", arrowPath((vx / speed) * STREAM, (-vy / speed) * STREAM, 5));
  });
}

/** [px, py, vx, vy] at points of a grid, not on top of the arrow in the middle of a cell, nor on its border. */
function flowOf(view, moving, { x: cx, y: cy, radius }) {
  const count = 2 * Math.min(12, Math.floor((radius * view.scale) / (FLOW * view.unit))); // even: not on the axes
  const middles = moving.map((cell) => view.at(...middleOf(cell.polygon)));
  const marks = [];
  for (let k = 0; k < count * count; k += 1) {
    const [x, y] = [cx + radius * ((2 * (k % count) + 1) / count - 1), cy + radius * ((2 * Math.floor(k / count) + 1) / count - 1)];
    const cell = moving.find(({ polygon }) => depthIn(polygon, x, y) * view.scale > BESIDE * view.unit);
    if (!cell) continue;
    const [px, py] = view.at(x, y);
    const [vx, vy] = [cell.twist[0] - cell.twist[2] * y, cell.twist[1] + cell.twist[2] * x];
    const isFree = middles.every(([mx, my]) => Math.hypot(mx - px, my - py) > 0.6 * FLOW * view.unit);
    if (isFree && Math.hypot(vx, vy) > 1e-12) marks.push([px, py, vx, vy]);
  }
  return marks;
}

/** How deep a point lies in a convex polygon, whose corners go round counterclockwise; negative outside. */
function depthIn(polygon, x, y) {
  return Math.min(...polygon.map(([a, b], k) => {
    const [c, d] = polygon[(k + 1) % polygon.length];
    return ((c - a) * (y - b) - (d - b) * (x - a)) / (Math.hypot(c - a, d - b) || 1);
  }));
}

/** Samples [x, y, vx, vy, omega] of the motion, for rules without cells. */
export function drawField(layer, view, samples) {
  const known = thinned(samples, view).filter((row) => row.every((value) => value !== null));
  const drawn = pool(layer, known.length, motionMark);
  const apart = known.length > 1 ? (nearest(known) * view.scale) / view.unit : 40;
  known.forEach(([x, y, vx, vy, omega], k) => {
    placeMotion(drawn[k], view.mark(...view.at(x, y)), [vx, vy], omega ?? 0, Math.min(LONGEST, 0.62 * apart), apart > 34);
    attr(drawn[k], "class", "sample");
  });
}

function motionMark() {
  const mark = s("g");
  mark.append(s("path", { class: "motion" }), s("path", { class: "turn", d: TURN }));
  return mark;
}

/** Every second, third ... row and column of a square grid of samples that would be drawn too close together. */
function thinned(samples, view) {
  const row = Math.round(Math.sqrt(samples.length));
  if (row < 2 || row * row !== samples.length) return samples;
  const every = Math.ceil((CLOSEST * view.unit) / (nearest(samples) * view.scale));
  return every > 1 ? samples.filter((_, k) => (k % row) % every === 0 && Math.floor(k / row) % every === 0) : samples;
}

function placeMotion(mark, place, [vx, vy], omega, length, signed = true) {
  const [arrow, turn] = mark.children;
  const speed = Math.hypot(vx, vy);
  attr(mark, "transform", place);
  attr(arrow, "d", speed > 1e-12 ? arrowPath((vx / speed) * length, (-vy / speed) * length) : "M-2 0a2 2 0 1 0 4 0a2 2 0 1 0 -4 0");
  attr(turn, "visibility", signed && Math.abs(omega) > 1e-12 && length > 11 ? "inherit" : "hidden");
  const size = Math.min(1, 0.55 + length / 100);
  const away = speed > 1e-12 ? [(vy / speed) * 14 * size, (vx / speed) * 14 * size] : [0, 14 * size];
  attr(turn, "transform", `translate(${away[0].toFixed(1)} ${away[1].toFixed(1)}) scale(${omega > 0 ? -size : size} ${size})`);
}

/** An arrow of the given components with its middle at the origin. */
export function arrowPath(dx, dy, head = 7) {
  const length = Math.hypot(dx, dy) || 1;
  const [ux, uy] = [dx / length, dy / length];
  const tip = Math.min(head, length * 0.6);
  const [x, y] = [dx / 2, dy / 2];
  const wing = (side) => `${(x - tip * ux + side * 0.5 * tip * uy).toFixed(1)} ${(y - tip * uy - side * 0.5 * tip * ux).toFixed(1)}`;
  return `M${(-x).toFixed(1)} ${(-y).toFixed(1)}L${x.toFixed(1)} ${y.toFixed(1)}M${wing(1)}L${x.toFixed(1)} ${y.toFixed(1)}L${wing(-1)}`;
}

/** Edges that are slid along, that solutions leave, on which bodies rest; edges that are crossed are thin. */
export function drawEdges(layer, view, edges) {
  const drawn = pool(layer, edges.length, () => s("path"));
  edges.forEach((edge, k) => {
    attr(drawn[k], "d", view.path([edge.from, edge.to]));
    attr(drawn[k], "class", `edge ${edge.kind}`);
  });
}

const REST_FORMS = ["rest-point", "rest-segment", "rest-area"];

/** Where bodies rest: single points as rings, segments and areas dotted. */
export function drawRests(layer, view, equilibria) {
  const drawn = pool(layer, equilibria.length, () => s("path"));
  equilibria.forEach(({ points }, k) => {
    attr(drawn[k], "class", REST_FORMS[Math.min(points.length, 3) - 1]);
    if (points.length > 1) {
      attr(drawn[k], "transform", "");
      return attr(drawn[k], "d", view.path(points, true));
    }
    const [px, py] = view.at(...points[0]);
    attr(drawn[k], "transform", view.mark(px, py));
    return attr(drawn[k], "d", "M-7 0a7 7 0 1 0 14 0a7 7 0 1 0 -14 0");
  });
}

function areaOf(polygon) {
  return Math.abs(polygon.reduce((sum, [x, y], k) => {
    const [u, v] = polygon[(k + 1) % polygon.length];
    return sum + x * v - u * y;
  }, 0)) / 2;
}

function middleOf(polygon) {
  const mean = (k) => polygon.reduce((sum, point) => sum + point[k], 0) / polygon.length;
  return [mean(0), mean(1)];
}

function nearest([first, ...others]) {
  return Math.min(...others.map(([x, y]) => Math.hypot(x - first[0], y - first[1])));
}
