// The buttons over the drawing: edits of wheels, zoom, what is shown.
// May be changed: BUTTONS, one line each; the same actions have keys in keyboard.js.

import { h, icon } from "./dom.js";
import { isSystem } from "./scene_document.js";

const SNAPS = [["0", "finest"], ["0.01", "0.01"], ["0.05", "0.05"], ["0.1", "0.1"], ["0.25", "1/4"], ["0.5", "1/2"], ["1", "1"]];
const EXACT_STEPS = { 0: "1/4", 0.01: "1/100", 0.05: "1/20", 0.1: "1/10", 0.25: "1/4", 0.5: "1/2", 1: "1" };
const SHOWN = [["cells", "Cells and edges"], ["motions", "Motion arrows"], ["levels", "Level sets of V"], ["paths", "Starts and paths"], ["wheels", "Wheels"]];

/** What can be done to wheels: by buttons and by keys alike. */
export function wheelActions(operations, store) {
  return {
    add: () => operations.add(),
    delete: () => operations.act("delete"),
    copy: () => operations.copy(),
    "mirror-x": () => operations.act("mirror", { axis: "y" }),
    "mirror-y": () => operations.act("mirror", { axis: "x" }),
    "rotate-left": () => operations.act("rotate", { angle: "15 deg" }),
    "rotate-right": () => operations.act("rotate", { angle: "-15 deg" }),
    snap: () => operations.act("snap", { step: EXACT_STEPS[operations.step] ?? "1/4" }),
    all: () => store.select([...(store.document.wheel ?? []).keys()]),
  };
}

const BUTTONS = [
  ["add", "Add", "Add a wheel (A)"],
  ["copy", "Copy", "Copy the selected wheels (C)"],
  ["delete", "Delete", "Delete the selected wheels (Delete)"],
  ["mirror-x", "Mirror left to right", "Mirror left to right about the checked point (M)"],
  ["mirror-y", "Mirror top to bottom", "Mirror top to bottom about the checked point (Shift+M)"],
  ["rotate-left", "Rotate left", "Rotate about the checked point by 15 degrees (R)"],
  ["rotate-right", "Rotate right", "Rotate about the checked point by −15 degrees (Shift+R)"],
  ["snap", "Snap", "Put wheels on the grid exactly (S)"],
];

export class Toolbar {
  constructor({ edits, snap, layers }, { operations, store, drawing }) {
    Object.assign(this, { edits, store });
    const actions = wheelActions(operations, store);
    for (const [name, label, hint] of BUTTONS) edits.append(h("button", { type: "button", "data-action": name, title: hint, "aria-label": label, onclick: actions[name] }, icon(name), h("span", {}, label)));
    snap.append(...SNAPS.map(([value, label]) => h("option", { value }, label)));
    snap.addEventListener("change", () => (operations.step = Number(snap.value)));
    layers.append(...SHOWN.map(([name, label]) => layer(name, label, drawing)));
    for (const name of ["change", "select"]) store.addEventListener(name, () => this.show());
  }

  show() {
    const system = isSystem(this.store.document);
    this.edits.hidden = system;
    this.edits.querySelector("[data-action=delete]").disabled = !this.store.selection.length;
  }
}

function layer(name, label, drawing) {
  const box = h("input", { type: "checkbox", checked: true, "data-layer": name });
  box.addEventListener("change", () => {
    if (box.checked) drawing.hidden.delete(name);
    else drawing.hidden.add(name);
    drawing.request();
  });
  return h("li", {}, h("label", {}, box, label));
}
