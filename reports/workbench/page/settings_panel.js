// The numbers of a scene that are not of one wheel, as groups of fields; and the sliders.
// May be changed: FIELDS lists what can be edited, one line each: the group, the path in the document, the label.
// A new key of scene files needs a line here and nothing else.

import { attr, h, onceAFrame, say, sparingly } from "./dom.js";
import { Field } from "./field.js";
import { isSystem, unitOf, valueAt, withValue } from "./scene_document.js";
import { fromText, headingFromText, niceStep, shown, toText } from "./values.js";

const ARRAYS = "arrays";
const SYSTEMS = "systems";
const ANY = "any";

const FIELDS = [
  { group: "Scene", of: ANY, path: ["name"], label: "Name", wide: true },
  { group: "Scene", of: ANY, path: ["description"], label: "Description", wide: true },
  { group: "Friction", of: ARRAYS, path: ["friction", "mu_roll"], label: "mu_roll (along)", hint: "Coulomb coefficient along the rim, of wheels that name none" },
  { group: "Friction", of: ARRAYS, path: ["friction", "mu_side"], label: "mu_side (across)", hint: "Coulomb coefficient across the rim, of wheels that name none" },
  { group: "Checked point and square", of: ANY, path: ["check", "equilibrium", 0], unit: "length", label: "x", start: [0, 0] },
  { group: "Checked point and square", of: ANY, path: ["check", "equilibrium", 1], unit: "length", label: "y", start: [0, 0] },
  { group: "Checked point and square", of: ANY, path: ["check", "radius"], unit: "length", label: "Radius", hint: "half-width of the checked square", auto: "radius" },
  { group: "Checked point and square", of: ANY, path: ["check", "length"], unit: "length", label: "Length l", hint: "how far off a body is that is turned by one radian; a rational number", auto: "length" },
  { group: "Checked point and square", of: ANY, path: ["check", "lyapunov"], label: "V to audit", hint: "a formula in x and y, such as x**2 + 3*y**2", wide: true },
  { group: "Body", of: ARRAYS, path: ["body", "width"], unit: "length", label: "Width", shape: "rectangle" },
  { group: "Body", of: ARRAYS, path: ["body", "height"], unit: "length", label: "Height", shape: "rectangle" },
  { group: "Body", of: ARRAYS, path: ["body", "radius"], unit: "length", label: "Radius", shape: "disc" },
  { group: "Body", of: ARRAYS, path: ["body", "heading"], label: "Heading", hint: "an angle, such as 30 deg or pi/6", shape: "any" },
  { group: "Body", of: ARRAYS, path: ["body", "centre_of_mass"], unit: "length", label: "Centre of mass", hint: "[x, y] in the body's own axes", shape: "any", pair: true },
  { group: "Tolerance", of: ARRAYS, path: ["tolerance", "position"], unit: "length", label: "Position", hint: "of each coordinate, up and down" },
  { group: "Tolerance", of: ARRAYS, path: ["tolerance", "heading"], label: "Heading", hint: "an angle, such as 1 deg" },
  { group: "Tolerance", of: ARRAYS, path: ["tolerance", "speed"], label: "Speed (share)" },
  { group: "Tolerance", of: ARRAYS, path: ["tolerance", "mu_roll"], label: "mu_roll (share)" },
  { group: "Tolerance", of: ARRAYS, path: ["tolerance", "mu_side"], label: "mu_side (share)" },
  { group: "Tolerance", of: ARRAYS, path: ["tolerance", "centre_of_mass"], unit: "length", label: "Centre of mass" },
  { group: "System", of: SYSTEMS, path: ["system", "rhs", 0], label: "First rate", wide: true, rate: 0 },
  { group: "System", of: SYSTEMS, path: ["system", "rhs", 1], label: "Second rate", wide: true, rate: 1 },
];
const SHAPES = { none: undefined, disc: { shape: "disc", radius: 1 }, rectangle: { shape: "rectangle", width: 2, height: 1 } };

export class SettingsPanel {
  constructor(container, store, results) {
    Object.assign(this, { store, results, groups: new Map(), fields: [] });
    for (const line of FIELDS) this.#add(container, line);
    this.#addShape();
    const later = sparingly(() => this.show(), () => store.isMerging);
    for (const source of [store, results]) source.addEventListener("change", later);
    this.folder = container.closest("details");
    this.folder.addEventListener("toggle", later);
  }

  #add(container, line) {
    if (!this.groups.has(line.group)) {
      const box = h("div", { class: "fields" });
      const set = h("fieldset", {}, h("legend", {}, line.group), box);
      container.append(set);
      this.groups.set(line.group, { set, box, of: line.of });
    }
    const keys = [line.path.filter((key) => typeof key === "string").join("."), line.path.join(".")];
    if (line.rate !== undefined) keys.push(`system.rhs.${line.rate + 1}`);
    const field = new Field({ ...line, keys, placeholder: line.auto ? "from the array" : "" }, (text) => this.#take(line, text));
    field.element.dataset.path = line.path.join(".");
    this.groups.get(line.group).box.append(field.element);
    this.fields.push({ line, field });
  }

  #addShape() {
    const select = h("select", { id: "body-shape" }, ...["none", "disc", "rectangle", "polygon"].map((name) => h("option", { value: name }, name)));
    select.addEventListener("change", () => this.#takeShape(select.value));
    this.shape = select;
    this.groups.get("Body").box.prepend(h("div", { class: "field" }, h("label", { for: "body-shape" }, "Shape"), select));
  }

  #takeShape(name) {
    if (name === "polygon") return this.show();
    return this.store.edit(({ document }) => ({ document: withValue(document, ["body"], SHAPES[name]) }));
  }

  #take({ path, pair, start }, text) {
    const value = pair ? headingFromText(text) : fromText(text);
    const filled = value === undefined && start ? 0 : value;
    this.store.edit(({ document }) => {
      const table = start && !valueAt(document, path.slice(0, -1)) ? withValue(document, path.slice(0, -1), start) : document;
      return { document: withValue(table, path, filled) };
    });
  }

  show() {
    if (!this.folder.open) return; // nobody sees it
    const { document } = this.store;
    const kind = isSystem(document) ? SYSTEMS : ARRAYS;
    const shape = document.body?.shape ?? "none";
    this.shape.value = shape;
    for (const { set, of } of this.groups.values()) set.hidden = of !== ANY && of !== kind;
    for (const { line, field } of this.fields) {
      field.element.hidden = (line.shape && (shape === "none" || (line.shape !== "any" && line.shape !== shape))) || (line.of !== ANY && line.of !== kind);
      if (line.auto === "length" && kind === SYSTEMS) field.element.hidden = true;
      const holds = line.auto ? this.results.geometry?.square?.[line.auto] : undefined;
      field.inUnit(unitOf(document, line.unit));
      field.show(toText(valueAt(document, line.path)), line.auto && holds !== undefined ? `${shown(holds)} (from the array)` : undefined);
      field.complain(this.results.error);
    }
  }
}

const MOST_KINDS = 6; // of wheels, with sliders of their own
const kindOf = ({ rule, mu_roll, mu_side }) => [rule, mu_roll, mu_side].join();
const speedOf = ({ speed }) => String(speed);

/**
 * Sliders: for each kind of wheel the friction across the rim as a share of that along it, for each speed that wheels
 * share that speed; the checked radius, the length l.  Wheels of one kind, and of one speed, move together.
 */
export class Sliders {
  constructor(container, store, results, conversation, operations) {
    Object.assign(this, { store, results, conversation, operations, kinds: [] });
    this.ofKinds = h("div", {});
    container.append(this.ofKinds);
    this.radius = this.#add(container, "Checked radius", { min: -2, max: 1, step: 0.01 }, (value) => this.#set(["check", "radius"], value));
    this.length = this.#add(container, "Characteristic length", { min: -2, max: 1, step: 0.01 }, (value) => this.#set(["check", "length"], value));
    const later = onceAFrame(() => this.show());
    for (const source of [store, results]) source.addEventListener("change", later);
  }

  #add(container, label, range, take) {
    const id = `slider-${label.replace(/\W+/g, "-").toLowerCase()}`;
    const input = h("input", { id, type: "range", ...range });
    const output = h("output", { for: id });
    const unit = h("span", {});
    const element = h("div", { class: "slider" }, h("label", { for: id }, label, unit), output, input);
    input.addEventListener("input", () => this.#moved(input, take, id));
    input.addEventListener("change", () => this.#released());
    container.append(element);
    return { input, output, element, unit };
  }

  #moved(input, take, id) {
    this.conversation.dragging = true;
    this.merge = id;
    take(Number(input.value));
  }

  #released() {
    this.store.seal();
    this.conversation.drag(false);
    this.show();
  }

  /** Groups of wheels that are alike, in the order of their first wheels: what a slider of theirs moves. */
  #groups(wheels, key, label, value, range, change) {
    const groups = Map.groupBy(wheels.map((wheel, k) => ({ ...wheel, k })), key);
    if (groups.size > MOST_KINDS) return [];
    return [...groups.values()].map((members) => {
      const indices = members.map(({ k }) => k);
      const names = groups.size > 1 ? `, wheel${indices.length > 1 ? "s" : ""} ${named(members)}` : "";
      return { label: `${label(members[0])}${names}`, value: value(members[0]), range, take: (share) => this.#setWheels(indices, change(members[0], share)) };
    });
  }

  #kindsOf(wheels) {
    const rules = new Set(wheels.map(({ rule }) => rule));
    const title = ({ rule }) => `mu_side / mu_roll${rules.size > 1 ? ` (${rule})` : ""}`;
    const ratio = ({ mu_roll, mu_side }) => (mu_roll ? mu_side / mu_roll : 1);
    const across = ({ mu_roll }, share) => ({ mu_side: Number((share * mu_roll).toPrecision(6)) });
    return [...this.#groups(wheels, kindOf, title, ratio, { min: 0, max: 2, step: 0.01 }, across), ...this.#speedsOf(wheels)];
  }

  #speedsOf(wheels) {
    const most = Math.max(...wheels.map(({ speed }) => Math.abs(speed)), 1e-12);
    const top = 2 * Number(most.toPrecision(1));
    const unit = unitOf(this.store.document, "speed");
    const change = (_, speed) => ({ speed: Number(speed.toPrecision(6)) });
    return this.#groups(wheels, speedOf, () => `Speed${unit ? ` [${unit}]` : ""}`, ({ speed }) => speed, { min: -top, max: top, step: niceStep(top / 400) }, change);
  }

  /** One slider for each kind and each speed; while one is dragged they stay as they are. */
  #showKinds(wheels) {
    if (this.conversation.dragging) return this.kinds.forEach(({ slider }) => say(slider.output, shown(Number(slider.input.value))));
    const kinds = this.#kindsOf(wheels);
    const drawn = kinds.map(({ label, range }) => [label, ...Object.values(range)].join()).join("|");
    if (drawn !== this.drawn) {
      this.drawn = drawn;
      this.ofKinds.replaceChildren();
      this.kinds = kinds.map((kind, k) => ({ slider: this.#add(this.ofKinds, kind.label, kind.range, (value) => this.kinds[k].take(value)) }));
    }
    kinds.forEach((kind, k) => {
      this.kinds[k].take = kind.take;
      this.#put(this.kinds[k].slider, kind.value, kind.value);
    });
  }

  /** The same keys for several wheels; those that the scene states for all of them alike stay stated once. */
  async #setWheels(indices, change) {
    const { document } = this.store;
    const count = this.results.geometry?.wheels?.length;
    const own = document.wheel?.some((wheel) => wheel.mu_side !== undefined || wheel.mu_roll !== undefined);
    if (change.mu_side !== undefined && indices.length === count && !own) return this.#setShared(change.mu_side);
    const merge = this.merge;
    if (!(await this.operations.ensureWheels())) return undefined;
    return this.store.edit((now) => ({ document: { ...now.document, wheel: now.document.wheel.map((old, k) => (indices.includes(k) ? { ...old, ...change } : old)) } }), { merge });
  }

  /** Radius and length have three digits on a logarithmic scale about the size of the array. */
  #set(path, exponent) {
    const value = Number((this.size() * 10 ** exponent).toPrecision(2));
    this.store.edit(({ document }) => ({ document: withValue(document, path, value) }), { merge: this.merge });
  }

  /** mu_side of all wheels; a mu_roll that is a formula stays one. */
  #setShared(across) {
    this.store.edit(({ document }) => {
      const along = valueAt(document, ["friction", "mu_roll"]) ?? 1;
      return { document: withValue(withValue(document, ["friction", "mu_roll"], along), ["friction", "mu_side"], across) };
    }, { merge: this.merge });
  }

  /** About how large the array is: a round power of ten that does not change while a wheel is dragged. */
  size() {
    const wheels = this.results.geometry?.wheels ?? [];
    const far = Math.max(...wheels.map((wheel) => Math.hypot(wheel.x, wheel.y)), 1e-6);
    return wheels.length ? 10 ** Math.round(Math.log10(far)) : 1;
  }

  show() {
    const { geometry } = this.results;
    if (!geometry) return;
    const system = isSystem(this.store.document);
    this.ofKinds.hidden = system;
    this.length.element.hidden = system;
    const unit = unitOf(this.store.document, "length");
    for (const slider of [this.radius, this.length]) say(slider.unit, unit ? ` [${unit}]` : "");
    this.#showKinds(system ? [] : geometry.wheels ?? []);
    for (const [slider, value] of [[this.radius, geometry.square?.radius], [this.length, geometry.square?.length]]) this.#put(slider, value > 0 ? Math.log10(value / this.size()) : 0, value);
  }

  #put({ input, output }, position, value) {
    const free = document.activeElement !== input || !this.conversation.dragging;
    if (free && Number(input.value) !== position) input.value = String(position ?? 0);
    say(output, shown(value));
    attr(input, "aria-valuetext", shown(value));
  }
}

/** Wheels by their names; `1-3, 5` where these are their numbers. */
function named(wheels) {
  if (wheels.some(({ name, k }) => name !== String(k + 1))) return wheels.map(({ name }) => name).join(", ");
  const parts = [];
  for (const { k } of wheels) {
    const last = parts.at(-1);
    if (last?.[1] === k - 1) last[1] = k;
    else parts.push([k, k]);
  }
  return parts.map(([a, b]) => (a === b ? `${a + 1}` : `${a + 1}\u2013${b + 1}`)).join(", ");
}
