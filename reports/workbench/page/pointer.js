// Dragging in the drawing: wheels, rims, starts and their headings; panning, pinching, zooming; the readout.
// May be changed: what a gesture does. A drag only says where things are; conversation.js decides when to ask.

import { needsExpansion } from "./scene_document.js";
import { roundTo } from "./values.js";

const ZOOM = 1.0015; // for each pixel of the mouse wheel
const STILL = 4; // pixels that a click may move

export class Pointer {
  constructor(drawing, operations, conversation) {
    Object.assign(this, { drawing, operations, conversation, store: drawing.store, touches: new Map(), drag: null });
    const { element } = drawing;
    element.addEventListener("pointerdown", (event) => this.#down(event));
    element.addEventListener("pointermove", (event) => this.#move(event));
    element.addEventListener("pointerrawupdate", (event) => this.#ahead(event));
    for (const name of ["pointerup", "pointercancel"]) element.addEventListener(name, (event) => this.#up(event));
    element.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    element.addEventListener("dblclick", (event) => this.#double(event));
  }

  #pixel(event) {
    const box = this.drawing.element.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  #down(event) {
    if (event.button > 0) return;
    const pixel = this.#pixel(event);
    this.touches.set(event.pointerId, pixel);
    this.drawing.element.setPointerCapture(event.pointerId);
    if (this.touches.size > 1) {
      this.#end();
      return;
    }
    this.drag = { ...this.#grabbed(event), from: pixel, id: `drag ${performance.now()}`, moved: false };
    if (this.drag.kind === "wheel") this.#grabWheel(event);
    if (this.drag.kind === "start" || this.drag.kind === "turn") this.drawing.active = this.drag.index;
    this.drawing.request();
  }

  /** What lies under the pointer: the marks say it themselves. */
  #grabbed(event) {
    const { dataset } = event.target;
    if (dataset.rim) return { kind: "rim", index: Number(dataset.rim) };
    if (dataset.start) return { kind: "start", index: Number(dataset.start) };
    if (dataset.turn) return { kind: "turn", index: Number(dataset.turn) };
    const wheel = event.target.closest?.("[data-wheel]");
    return wheel ? { kind: "wheel", index: Number(wheel.dataset.wheel) } : { kind: "pan" };
  }

  #grabWheel(event) {
    const { drag, store } = this;
    const chosen = store.selection.includes(drag.index);
    if (event.shiftKey) store.select(chosen ? store.selection.filter((k) => k !== drag.index) : [...store.selection, drag.index]);
    else if (!chosen) store.select([drag.index]);
    const wheels = this.drawing.wheels();
    drag.places = new Map(store.selection.map((k) => [k, [wheels[k].x, wheels[k].y]]));
  }

  #move(event) {
    const pixel = this.#pixel(event);
    if (!this.drag) return this.touches.size > 1 ? this.#pinch(event, pixel) : this.#hover(event, pixel);
    this.touches.set(event.pointerId, pixel);
    const { drag } = this;
    if (!drag.moved && Math.hypot(pixel[0] - drag.from[0], pixel[1] - drag.from[1]) < STILL) return;
    drag.moved = true;
    this.#drawn(drag, { pixel, shift: event.shiftKey });
  }

  /** A move before its frame, where the browser tells it: taken only if it can be asked about at once. */
  #ahead(event) {
    if (this.drag && this.drag.kind !== "pan" && this.conversation.isFree) this.#move(event);
  }

  /** One step of a drag. Browsers send one move a frame, just before the frame is drawn: it shows this step already. */
  #drawn(drag, { pixel, shift }) {
    const { view } = this.drawing;
    if (drag.kind === "pan") {
      const last = drag.last ?? drag.from;
      view.pan(pixel[0] - last[0], pixel[1] - last[1]);
      drag.last = pixel;
      this.drawing.touched = true;
      return this.drawing.request();
    }
    if ((drag.kind === "wheel" || drag.kind === "rim") && needsExpansion(this.store.document)) return this.operations.ensureWheels();
    this.conversation.dragging = true;
    if (drag.kind === "wheel") return this.#dragWheels(drag, pixel, shift);
    if (drag.kind === "rim") return this.#dragRim(drag, pixel, shift);
    return this.#dragStart(drag, pixel);
  }

  #dragWheels({ places, from, id }, pixel, straight) {
    const { scale } = this.drawing.view;
    let [dx, dy] = [(pixel[0] - from[0]) / scale, -(pixel[1] - from[1]) / scale];
    if (straight) [dx, dy] = Math.abs(dx) > Math.abs(dy) ? [dx, 0] : [0, dy];
    this.operations.moveTo(new Map([...places].map(([k, [x, y]]) => [k, [x + dx, y + dy]])), id);
  }

  #dragRim({ index, id }, pixel, straight) {
    const wheel = this.drawing.wheels()[index];
    const [px, py] = this.drawing.view.at(wheel.x, wheel.y);
    this.operations.turnTo(index, [pixel[0] - px, py - pixel[1]], { straight, merge: id });
  }

  #dragStart({ kind, index, id }, pixel) {
    const grid = this.operations.grid;
    const [x, y] = this.drawing.view.under(...pixel);
    this.store.edit(({ starts }) => {
      const [oldX, oldY, ...others] = starts[index];
      const turned = [oldX, oldY, roundTo(Math.atan2(y - oldY, x - oldX), 0.01)];
      const moved = [roundTo(x, grid), roundTo(y, grid), ...others];
      return { starts: starts.map((start, k) => (k === index ? (kind === "turn" ? turned : moved) : start)) };
    }, { merge: id });
  }

  #up(event) {
    this.touches.delete(event.pointerId);
    if (this.drag?.kind === "pan" && !this.drag.moved) this.store.select([]);
    this.#end();
  }

  #end() {
    const edited = this.drag?.moved && this.drag.kind !== "pan";
    this.drag = null;
    this.pinched = null;
    this.store.seal();
    if (edited || this.conversation.dragging) this.conversation.drag(false);
  }

  #pinch(event, pixel) {
    this.touches.set(event.pointerId, pixel);
    const [a, b] = [...this.touches.values()];
    const apart = Math.hypot(a[0] - b[0], a[1] - b[1]);
    const middle = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
    if (this.pinched) {
      this.drawing.view.zoom(apart / this.pinched.apart, ...middle);
      this.drawing.view.pan(middle[0] - this.pinched.middle[0], middle[1] - this.pinched.middle[1]);
      this.drawing.touched = true;
      this.drawing.request();
    }
    this.pinched = { apart, middle };
  }

  #wheel(event) {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === 1 ? 16 : 1);
    this.drawing.view.zoom(ZOOM ** -pixels, ...this.#pixel(event));
    this.drawing.touched = true;
    this.drawing.request();
  }

  /** A double click on the ground fits the drawing; on a wheel it does nothing. */
  #double(event) {
    if (this.#grabbed(event).kind === "pan") this.drawing.fit();
  }

  #hover(event, pixel) {
    const cell = event.target.dataset?.cell;
    const wheel = event.target.closest?.("[data-wheel]")?.dataset.wheel;
    this.drawing.element.dispatchEvent(new CustomEvent("readout", { detail: { at: this.drawing.view.under(...pixel), cell, wheel } }));
  }
}
