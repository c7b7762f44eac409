// What a plain system has beyond cells and arrows: level sets of the V that proves its stability, and the border of
// the region in which that is proved.
// May be changed: how they look (drawing.css). The curves are Python's.

import { attr, pool, s } from "./dom.js";

export function drawLevels(layer, view, { level_sets: levels = [], region = [] }) {
  const curves = [...levels.map((curve) => ["level", curve]), ...region.map((curve) => ["region", curve])];
  const drawn = pool(layer, curves.length, () => s("path"));
  curves.forEach(([kind, curve], k) => {
    attr(drawn[k], "d", view.path(curve));
    attr(drawn[k], "class", kind);
  });
}
