// One labelled field for a number, a formula or a word: what is typed is kept as typed, and what Python says is wrong
// with it is shown at the field.
// May be changed: how a field looks. It reads no formula itself; Enter or leaving the field hands the text on.

import { attr, h, say } from "./dom.js";

let count = 0;

export class Field {
  /** `take(text)` is called with what was typed; `keys` are the names under which the server complains about it. */
  constructor({ label, hint = "", placeholder = "", keys = [], wide = false }, take) {
    const id = `field-${(count += 1)}`;
    this.keys = keys;
    this.shownText = "";
    this.input = h("input", { id, type: "text", autocomplete: "off", autocapitalize: "off", spellcheck: "false", placeholder, "aria-describedby": `${id}-error` });
    this.unit = h("span", { class: "unit" });
    this.message = h("p", { id: `${id}-error`, class: "field-error", hidden: true });
    this.element = h("div", { class: wide ? "field wide" : "field" }, h("label", { for: id, title: hint }, label, this.unit), this.input, this.message);
    if (hint) this.input.title = hint;
    this.input.addEventListener("change", () => take(this.input.value));
    this.input.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.#restore(event);
    });
  }

  #restore(event) {
    event.stopPropagation();
    this.input.value = this.shownText;
    this.input.blur();
  }

  /** Says behind the label in which unit the number is; nothing where the scene states none. */
  inUnit(unit) {
    say(this.unit, unit ? ` [${unit}]` : "");
  }

  /** Shows a value, unless somebody is typing; `placeholder` is what holds while the field is empty. */
  show(text, placeholder) {
    if (placeholder !== undefined) attr(this.input, "placeholder", placeholder);
    if (document.activeElement === this.input && this.input.value !== this.shownText) return;
    this.shownText = text;
    if (this.input.value !== text) this.input.value = text;
  }

  /** Shows the error if it is about this field; says whether it is. */
  complain(error) {
    const key = error?.key ?? null;
    const meant = key !== null && this.keys.some((own) => key === own || key.startsWith(`${own}.`));
    attr(this.input, "aria-invalid", meant);
    if (this.message.hidden === meant) this.message.hidden = !meant;
    say(this.message, meant ? error.message : "");
    return meant;
  }
}
