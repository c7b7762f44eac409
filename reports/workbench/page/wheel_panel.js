// The wheels as a table, and the selected one as fields that take exact formulas.
// May be changed: the columns, and which keys of a wheel have a field (KEYS).

import { attr, h, pool, say, sparingly } from "./dom.js";
import { Field } from "./field.js";
import { isSystem, unitOf, withHeading, withWheel } from "./scene_document.js";
import { fromText, headingFromText, shown, toText } from "./values.js";

const KEYS = [
  { key: "x", label: "x", unit: "length", hint: "a number or a formula, such as sqrt(2)/2" },
  { key: "y", label: "y", unit: "length", hint: "a number or a formula, such as sqrt(2)/2" },
  { key: "heading", label: "Heading", hint: "the way its rim pushes a body, across the axle: inward, outward, an angle such as 30 deg, or a direction [a, b]" },
  { key: "speed", label: "Speed", unit: "speed" },
  { key: "mu_roll", label: "mu_roll", hint: "along the rim, or along the axis" },
  { key: "mu_side", label: "mu_side", hint: "across it" },
  { key: "axis", label: "Axis", hint: "of a roller: an angle or a direction [a, b]; empty for the rim" },
  { key: "speed_limit", label: "Speed limit", unit: "speed" },
];
const COLUMNS = [
  { label: "wheel" },
  { label: "x", unit: "length" },
  { label: "y", unit: "length" },
  { label: "heading", unit: "angle", title: "the way its rim pushes a body, across the axle" },
  { label: "speed", unit: "speed" },
  { label: "friction", title: "along the rim | across it" },
];

export class WheelPanel {
  constructor({ fields, title, head, body, empty }, store, results, operations) {
    Object.assign(this, { store, results, operations, title, head, body, empty, hint: empty.textContent, box: fields });
    this.fields = KEYS.map((line) => ({ line, field: new Field({ ...line }, (text) => this.#take(line.key, text)) }));
    fields.append(...this.fields.map(({ field }) => field.element));
    const later = sparingly(() => this.show(), () => store.isMerging);
    for (const name of ["change", "select"]) store.addEventListener(name, later);
    results.addEventListener("change", later);
  }

  async #take(key, text) {
    const [index] = this.store.selection;
    if (index === undefined || !(await this.operations.ensureWheels())) return;
    this.store.edit(({ document }) => ({ document: this.#changed(document, index, key, text) }));
    this.store.seal();
  }

  #changed(document, index, key, text) {
    const wheel = document.wheel[index];
    if (key === "x" || key === "y") {
      const place = key === "x" ? 0 : 1;
      return withWheel(document, index, { position: wheel.position.map((old, k) => (k === place ? fromText(text) ?? old : old)) });
    }
    const value = key === "heading" || key === "axis" ? headingFromText(text) : fromText(text);
    if (key === "heading" && value !== undefined) return withHeading(document, index, value, fromText(this.#reply(index)?.exact?.speed ?? ""));
    if (value !== undefined) return withWheel(document, index, { [key]: value });
    const { [key]: removed, ...others } = wheel;
    return { ...document, wheel: document.wheel.map((old, k) => (k === index ? others : old)) };
  }

  #reply(index) {
    const wheels = this.results.geometry?.wheels;
    return wheels?.length === (this.store.document.wheel?.length ?? wheels?.length) ? wheels?.[index] : undefined;
  }

  show() {
    const wheels = isSystem(this.store.document) ? [] : this.results.geometry?.wheels ?? [];
    this.#showTable(wheels);
    const chosen = this.store.selection;
    const one = chosen.length === 1;
    this.box.hidden = !one;
    this.empty.hidden = chosen.length > 0;
    const unit = unitOf(this.store.document, "length");
    say(this.empty, unit ? `${this.hint} Lengths are in ${unit}, speeds in ${unitOf(this.store.document, "speed")}.` : this.hint);
    say(this.title, one ? `Wheel ${wheels[chosen[0]]?.name ?? chosen[0] + 1}` : chosen.length ? `${chosen.length} wheels selected` : "Wheels");
    if (one) this.#showFields(chosen[0]);
    else for (const { field } of this.fields) field.complain(null);
  }

  #showFields(index) {
    const stated = this.store.document.wheel?.[index];
    const reply = this.#reply(index);
    const number = index + 1;
    for (const { line, field } of this.fields) {
      const { key } = line;
      const inPlace = key === "x" || key === "y";
      const value = inPlace ? stated?.position?.[key === "x" ? 0 : 1] ?? reply?.exact?.position?.[key === "x" ? 0 : 1] : stated?.[key];
      field.keys = inPlace ? [`wheel.${number}.position`, `wheel.${number}.position.${key === "x" ? 1 : 2}`] : [`wheel.${number}.${key}`];
      field.inUnit(unitOf(this.store.document, line.unit));
      field.show(toText(value), inPlace ? "" : this.#default(key, reply));
      field.complain(inPlace && !this.#isMeant(value, stated) ? null : this.results.error);
    }
  }

  /** An error names the position, not which of its numbers: it is shown at the one whose text it repeats. */
  #isMeant(value, stated) {
    const { message = "" } = this.results.error ?? {};
    const repeated = (stated?.position ?? []).filter((text) => typeof text === "string" && message.includes(text));
    return !repeated.length || repeated.includes(value);
  }

  /** What holds where the wheel names nothing itself. */
  #default(key, reply) {
    if (!reply) return "";
    if (key === "heading") return reply.exact?.rim ? `[${reply.exact.rim.join(", ")}]` : "inward";
    if (key === "speed") return reply.exact?.speed ?? shown(reply.speed);
    if (key === "mu_roll" || key === "mu_side") return shown(reply[key]);
    return key === "axis" ? "the rim" : "none";
  }

  /** The columns with their units; angles without one are in degrees where the scene states units. */
  #showHead() {
    const { document } = this.store;
    const heads = pool(this.head, COLUMNS.length, () => h("th", { scope: "col" }));
    COLUMNS.forEach(({ label, unit, title = "" }, k) => {
      const words = unit && unitOf(document, unit);
      attr(heads[k], "title", title);
      say(heads[k], words ? `${label} [${words}]` : label);
    });
  }

  #showTable(wheels) {
    this.#showHead();
    const rows = pool(this.body, wheels.length, () => this.#row());
    const chosen = new Set(this.store.selection);
    const stated = this.store.document.wheel;
    wheels.forEach((wheel, k) => {
      const row = rows[k];
      row.dataset.row = k;
      row.classList.toggle("selected", chosen.has(k));
      attr(row.firstChild.firstChild, "aria-pressed", chosen.has(k));
      attr(row.firstChild.firstChild, "aria-label", `Wheel ${wheel.name ?? k + 1}`);
      const own = stated?.length === wheels.length ? stated[k] : null;
      const place = own?.position ?? wheel.exact?.position ?? [shown(wheel.x), shown(wheel.y)];
      const friction = wheel.mu_roll === undefined ? "" : `${shown(wheel.mu_roll, 2)} | ${shown(wheel.mu_side, 2)}`;
      const texts = [wheel.name ?? k + 1, toText(place[0]), toText(place[1]), own?.heading === undefined ? "field" : toText(own.heading), shown(wheel.speed), friction];
      if (own?.heading === undefined && !this.store.document.field) texts[3] = "inward";
      texts.forEach((text, column) => say(column ? row.children[column] : row.firstChild.firstChild, String(text)));
    });
  }

  #row() {
    const button = h("button", { type: "button", class: "row-button" });
    const row = h("tr", {}, h("th", { scope: "row" }, button), ...COLUMNS.slice(1).map(() => h("td")));
    row.addEventListener("click", (event) => {
      const k = Number(row.dataset.row);
      const { selection } = this.store;
      const added = selection.includes(k) ? selection.filter((old) => old !== k) : [...selection, k];
      this.store.select(event.shiftKey || event.ctrlKey || event.metaKey ? added : [k]);
    });
    return row;
  }
}
