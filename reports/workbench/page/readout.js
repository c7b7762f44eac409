// The line under the drawing: where the pointer is, what moves there, which wheel it is on; and the legend.
// May be changed: which numbers are read out. They are floats of the last reply, for the eye only.

import { say } from "./dom.js";
import { isSystem, unitOf } from "./scene_document.js";
import { shown } from "./values.js";

const KINDS = { exact: "cells: exact", sampled: "motion: sampled in floats", later: "cells follow …", none: "" };

export function startReadout(line, how, drawing, page = document.body) {
  drawing.results.addEventListener("change", () => {
    const { geometry } = drawing.results;
    page.classList.toggle("without-cells", geometry?.geometry === "sampled");
    const known = drawing.results.isOld("geometry") && geometry?.cells?.length ? "later" : geometry?.geometry;
    say(how, known === "later" ? KINDS.later : geometry?.note ?? KINDS[known] ?? "");
  });
  drawing.element.addEventListener("readout", ({ detail }) => say(line, text(drawing, detail)));
  drawing.element.addEventListener("pointerleave", () => say(line, ""));
}

function text(drawing, { at: [x, y], cell, wheel }) {
  const { geometry } = drawing.results;
  const parts = [`(${shown(x)}, ${shown(y)})`];
  if (wheel !== undefined) parts.push(...aboutWheel(drawing.wheels()[Number(wheel)], Number(wheel), unitOf(drawing.store.document, "speed")));
  else if (cell !== undefined && !isSystem(drawing.store.document)) parts.push(...aboutCell(geometry?.cells?.[Number(cell)], x, y));
  return parts.join("   ");
}

function aboutWheel(wheel, index, unit) {
  if (!wheel) return [];
  const load = wheel.load === undefined || wheel.load === null ? "" : `, load ${shown(wheel.load)}`;
  return [`wheel ${index + 1}: speed ${shown(wheel.speed)}${unit && ` ${unit}`}${load}${wheel.carries === false ? ", carries nothing" : ""}`];
}

/** The motion in a cell at the pointer: the twist is about the world's origin. */
function aboutCell(cell, x, y) {
  if (!cell) return [];
  const [vx, vy, omega] = cell.twist ?? [...(cell.velocity ?? [0, 0]), cell.omega ?? 0];
  const velocity = cell.twist ? [vx - omega * y, vy + omega * x] : [vx, vy];
  const turns = Math.abs(omega) < 1e-12 ? "does not turn" : `turns ${omega > 0 ? "counterclockwise" : "clockwise"} at ${shown(Math.abs(omega))} rad/s`;
  if (cell.kind === "rest") return ["the body rests here"];
  return [`moves at (${velocity.map((value) => shown(value)).join(", ")}), ${turns}`, cell.wheels?.length ? `wheels ${cell.wheels.join(", ")}` : ""];
}
