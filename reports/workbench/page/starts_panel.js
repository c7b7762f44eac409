// Start points as numbers, adding and removing them, the time to follow them for, and the play button.
// May be changed: where a new start is put, how fast time is played.

import { h, icon, pool, say, sparingly } from "./dom.js";
import { isSystem, unitOf } from "./scene_document.js";
import { roundTo, shown } from "./values.js";

export const MOST = 12; // starts on a page; the server follows each of them
const SECONDS = 6; // that playing the whole time takes
const SHOWN_DIGITS = 9; // of a heading in degrees
const RING = 0.7; // of the checked radius: how far from the point a new start lies

export class StartsPanel {
  constructor({ list, until }, store, drawing) {
    Object.assign(this, { list, until, store, drawing });
    this.unit = h("span", { class: "unit" });
    this.legend = h("p", { class: "hint" });
    until.after(this.unit);
    list.before(this.legend);
    until.addEventListener("change", () => this.#takeUntil());
    const later = sparingly(() => this.show(), () => store.isMerging);
    for (const source of [store, drawing.results]) source.addEventListener("change", later);
  }

  /** A start on a ring about the checked point, each at another angle. */
  add(place) {
    const { square } = this.drawing.results.geometry ?? {};
    if (this.store.now.starts.length >= MOST || !square) return;
    const angle = 0.6 + this.store.now.starts.length * 2.4;
    const step = 10 ** (Math.floor(Math.log10(square.radius)) - 1);
    const [x, y] = place ?? [square.x + RING * square.radius * Math.cos(angle), square.y + RING * square.radius * Math.sin(angle)];
    const others = (this.store.document.system?.states.length ?? 3) - 2; // theta, or further states
    const start = [roundTo(x, step), roundTo(y, step), ...Array(others).fill(0)];
    this.store.edit(({ starts }) => ({ starts: [...starts, start] }));
    this.drawing.active = this.store.now.starts.length - 1;
    this.drawing.request();
  }

  remove(index) {
    this.store.edit(({ starts }) => ({ starts: starts.filter((_, k) => k !== index) }));
    this.drawing.active = Math.max(0, Math.min(this.drawing.active, this.store.now.starts.length - 1));
  }

  #takeUntil() {
    const seconds = Number(this.until.value);
    const valid = seconds > 0 && seconds <= 1000;
    this.until.setAttribute("aria-invalid", String(!valid));
    if (valid) this.store.edit(() => ({ until: seconds }));
  }

  #take(index, place, input) {
    const entered = Number(input.value.replace("\u2212", "-"));
    const value = entered * this.#unitOf(place);
    const valid = input.value.trim() !== "" && Number.isFinite(value);
    input.setAttribute("aria-invalid", String(!valid));
    if (!valid) return;
    this.store.edit(({ starts }) => ({ starts: starts.map((start, k) => (k === index ? start.map((old, i) => (i === place ? value : old)) : start)) }));
  }

  /** What a number of a field stands for: a heading is kept in radians, and shown in the unit of the scene's angles. */
  #unitOf(place) {
    const inDegrees = place === 2 && !isSystem(this.store.document) && unitOf(this.store.document, "angle") === "deg";
    return inDegrees ? Math.PI / 180 : 1;
  }

  show() {
    const { starts, until } = this.store.now;
    put(this.until, until);
    const [length, time] = ["length", "time"].map((kind) => unitOf(this.store.document, kind));
    say(this.unit, time ? ` [${time}]` : "");
    say(this.legend, length && starts.length ? `a start: x [${length}], y [${length}], theta [${unitOf(this.store.document, "angle")}]` : "");
    const names = isSystem(this.store.document) ? this.store.document.system.states : ["x", "y", "theta"];
    if (names.length !== this.width) this.list.replaceChildren();
    this.width = names.length;
    const rows = pool(this.list, starts.length, () => this.#row(names.length));
    starts.forEach((start, k) => {
      rows[k].className = `start-row tone-${k % 6}`;
      const [name, ...parts] = rows[k].children;
      say(name, String(k + 1));
      parts.pop().setAttribute("aria-label", `Remove start ${k + 1}`);
      parts.forEach((input, place) => {
        input.setAttribute("aria-label", `${names[place]} of start ${k + 1}`);
        const unit = this.#unitOf(place);
        put(input, unit === 1 ? (start[place] ?? 0) : Number((start[place] / unit).toPrecision(SHOWN_DIGITS)));
      });
    });
  }

  #row(width) {
    const index = () => [...this.list.children].indexOf(row);
    const inputs = [...Array(width).keys()].map((place) => {
      const input = h("input", { type: "text", inputmode: "decimal", autocomplete: "off" });
      input.addEventListener("change", () => this.#take(index(), place, input));
      return input;
    });
    const remove = h("button", { type: "button", class: "quiet", onclick: () => this.remove(index()) }, icon("delete"));
    const row = h("li", {}, h("span", { class: "start-name" }), ...inputs, remove);
    return row;
  }
}

/** Shows a number, unless somebody types there. */
function put(input, value) {
  const text = String(value);
  if (document.activeElement === input || input.value === text) return;
  input.value = text;
  input.removeAttribute("aria-invalid");
}

export class Playback {
  constructor({ button, slider, output, box }, store, drawing) {
    Object.assign(this, { button, slider, output, box, store, drawing, playing: false });
    button.addEventListener("click", () => this.toggle());
    slider.addEventListener("input", () => this.#seek(Number(slider.value) / 1000));
    drawing.results.addEventListener("change", () => this.#refresh());
  }

  /** The longest time of a path. */
  get span() {
    return Math.max(0, ...this.drawing.results.paths.map(({ times }) => times[times.length - 1] ?? 0));
  }

  toggle() {
    if (!this.drawing.results.paths.length) return;
    this.playing = !this.playing;
    if (this.playing && (this.drawing.time === null || this.drawing.time >= this.span)) this.drawing.time = 0;
    this.before = undefined;
    this.#show();
    if (this.playing) requestAnimationFrame((now) => this.#step(now));
  }

  #step(now) {
    if (!this.playing) return;
    const elapsed = this.before === undefined ? 0 : (now - this.before) / 1000;
    this.before = now;
    this.drawing.time = Math.min(this.span, this.drawing.time + (elapsed * this.span) / SECONDS);
    if (this.drawing.time >= this.span) this.playing = false;
    this.drawing.draw();
    this.#show();
    if (this.playing) requestAnimationFrame((next) => this.#step(next));
  }

  #seek(share) {
    this.playing = false;
    this.drawing.time = share * this.span;
    this.drawing.request();
    this.#show();
  }

  #refresh() {
    const any = this.drawing.results.paths.length > 0;
    this.button.disabled = !any;
    this.slider.disabled = !any;
    if (!any) this.drawing.time = null;
    else if (this.drawing.time === null) this.drawing.time = 0;
    this.#show();
  }

  #show() {
    const time = this.drawing.time ?? 0;
    const span = this.span || 1;
    this.button.setAttribute("aria-label", this.playing ? "Pause" : "Play the paths");
    this.button.setAttribute("aria-pressed", String(this.playing));
    this.button.firstElementChild.firstElementChild.setAttribute("href", this.playing ? "#i-pause" : "#i-play");
    if (document.activeElement !== this.slider || this.playing) this.slider.value = String(Math.round((1000 * time) / span));
    this.slider.setAttribute("aria-valuetext", `${shown(time)} of ${shown(span)}`);
    say(this.output, `t = ${shown(time)}`);
  }
}
