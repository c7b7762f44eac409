// Edits of wheels: moves by decimals are made here at once; mirror, rotate, copy, snap, add and delete are exact and
// therefore Python's. A scene that writes its wheels as a ring or a grid is first written out, wheel by wheel.
// May be changed: step sizes of keys. New operations: a kind here, a kind of /api/edit, a button in toolbar.js.

import { needsExpansion, withHeading, withPositions } from "./scene_document.js";
import { fromText, niceStep, roundTo } from "./values.js";

const RIM_DIGITS = 0.01; // a turned rim is a direction [a, b] of such decimals
export const RIGHT_ANGLES = 15; // degrees that the number field always holds

export class Operations {
  constructor(api, store, drawing, tell) {
    Object.assign(this, { api, store, drawing, tell, step: 0 });
  }

  /** The grid of moved wheels: as set, or as fine as a pixel. */
  get grid() {
    return this.step || niceStep(1 / this.drawing.view.scale);
  }

  /** Writes the wheels out, once, if the scene does not; resolves to whether wheels can be edited. */
  async ensureWheels() {
    if (!needsExpansion(this.store.document)) return Boolean(this.store.document.wheel);
    this.expanding ??= this.ask({ kind: "expand" }).finally(() => (this.expanding = null));
    await this.expanding;
    return Boolean(this.store.document.wheel);
  }

  /** An exact edit by Python; a newer edit in the meantime wins. */
  async ask(operation) {
    const before = this.store.document;
    try {
      const reply = await this.api.json("/api/edit", { document: before, operation });
      if (this.store.document !== before) return false;
      this.store.edit(() => ({ document: reply.document }));
      this.store.seal();
      if (reply.wheels) this.store.select(reply.wheels.map((number) => number - 1));
      return true;
    } catch (error) {
      this.tell(error.message);
      return false;
    }
  }

  /** An operation on the selected wheels, on all where none is selected. */
  async act(kind, options = {}) {
    if (!(await this.ensureWheels())) return;
    const wheels = this.store.selection.map((k) => k + 1);
    if (kind === "delete" && !wheels.length) return this.tell("Select a wheel first.");
    await this.ask({ kind, wheels, ...options });
  }

  /** A new wheel in the middle of what is seen, beside others that are there. */
  async add(place) {
    if (!(await this.ensureWheels())) return;
    const { view } = this.drawing;
    const [x, y] = place ?? freePlace(view, this.drawing.wheels(), this.grid);
    await this.ask({ kind: "add", position: [roundTo(x, this.grid), roundTo(y, this.grid)] });
  }

  /** Copies of the selected wheels, a little beside them. */
  copy() {
    const away = roundTo(40 / this.drawing.view.scale, this.step || niceStep(10 / this.drawing.view.scale));
    return this.act("copy", { offset: [away, -away] });
  }

  /** Wheels at other places: a map from index to [x, y] as floats. */
  moveTo(places, merge) {
    const rounded = new Map([...places].map(([k, [x, y]]) => [k, [roundTo(x, this.grid), roundTo(y, this.grid)]]));
    this.store.edit(({ document }) => ({ document: withPositions(document, rounded) }), { merge });
  }

  /** The selected wheels, moved by a number of grid steps; a coordinate that does not move keeps its formula. */
  async nudge(dx, dy, factor) {
    const chosen = this.store.selection;
    if (!chosen.length || !(await this.ensureWheels())) return;
    const step = this.step || niceStep(8 / this.drawing.view.scale);
    const wheels = this.drawing.wheels();
    const moved = new Map();
    for (const k of chosen) {
      const [x, y] = this.store.document.wheel[k].position;
      const shift = (value, float, by) => (by ? roundTo(float + by * step * factor, step * Math.min(1, factor)) : value);
      moved.set(k, [shift(x, wheels[k].x, dx), shift(y, wheels[k].y, dy)]);
    }
    this.store.edit(({ document }) => ({ document: withPositions(document, moved) }), { merge: `nudge ${chosen}` });
  }

  /** One rim along a direction given in floats; `straight` takes the nearest multiple of 15 degrees, exactly. */
  turnTo(index, [dx, dy], { straight = false, merge } = {}) {
    const length = Math.hypot(dx, dy);
    if (!length) return;
    const degrees = (Math.atan2(dy, dx) * 180) / Math.PI;
    const heading = straight
      ? `${(RIGHT_ANGLES * Math.round(degrees / RIGHT_ANGLES) + 360) % 360} deg`
      : [roundTo(dx / length, RIM_DIGITS), roundTo(dy / length, RIM_DIGITS)];
    const speed = fromText(this.results()?.wheels?.[index]?.exact?.speed ?? "");
    this.store.edit(({ document }) => ({ document: withHeading(document, index, heading, speed) }), { merge });
  }

  results() {
    return this.drawing.results.geometry;
  }

  /** Turns the selected rims by keys: to the next multiple of the step in degrees. */
  async turn(sense, degrees) {
    if (!this.store.selection.length || !(await this.ensureWheels())) return;
    const wheels = this.drawing.wheels();
    for (const k of this.store.selection) {
      const now = (Math.atan2(wheels[k].rim[1], wheels[k].rim[0]) * 180) / Math.PI;
      const next = ((sense > 0 ? Math.floor(now / degrees + 1.001) : Math.ceil(now / degrees - 1.001)) * degrees * Math.PI) / 180;
      this.turnTo(k, [Math.cos(next), Math.sin(next)], { straight: degrees === RIGHT_ANGLES, merge: `turn ${this.store.selection}` });
    }
  }
}

/** A place near the middle of the view that is not on top of a wheel. */
function freePlace(view, wheels, grid) {
  for (let k = 10; k < 200; k += 1) { // not in the middle: a wheel at the origin has no way inward
    const [radius, angle] = [k * 6, k * 2.4];
    const [x, y] = view.under(view.width / 2 + radius * Math.cos(angle), view.height / 2 - radius * Math.sin(angle));
    const apart = Math.max(grid, 45 / view.scale);
    if (wheels.every((wheel) => Math.hypot(wheel.x - x, wheel.y - y) > apart)) return [x, y];
  }
  return [view.x, view.y];
}
