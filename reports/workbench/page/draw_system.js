// The phase portrait of a plain system: level sets of V, cells of the sign pattern, the field, equilibria.
// May be changed: how many arrows are drawn; V and its level sets come from Python.

import { attr, pool, s } from "./dom.js";

export function drawLevels(layer, view, levels) {
  const drawn = pool(layer, levels.length, () => s("path"));
  levels.forEach((level, k) => {
    attr(drawn[k], "d", view.path(level));
    attr(drawn[k], "class", "level");
  });
}

/** Cells of a system, without a motion of their own: the field varies inside them. */
export function drawSigns(layer, view, cells) {
  const drawn = pool(layer, cells.length, () => s("path"));
  cells.forEach((cell, k) => {
    attr(drawn[k], "d", view.path(cell.polygon ?? cell, true));
    attr(drawn[k], "class", `cell sign-${k % 2}`);
  });
}
