// Everything by keyboard: KEYS says which key does what, and the help lists exactly that.
// May be changed: KEYS. Keys act while no field is being typed in; arrows and brackets act on the selection.

import { h } from "./dom.js";

const FAR = 5; // grid steps with Shift
const FINE = 0.1; // grid steps with Alt
const ONCE = new Set(["A", "C", "O", "Ctrl+S"]); // what a key that is held down does once

/** [keys for people, what they do, test of an event, action]. */
export function keyTable({ store, operations, actions, drawing, playback, starts, files, help }) {
  const plain = (key) => (event) => event.key === key && !event.ctrlKey && !event.metaKey;
  const command = (key, shift = false) => (event) => event.key.toLowerCase() === key && (event.ctrlKey || event.metaKey) && event.shiftKey === shift;
  const move = (event) => {
    const [dx, dy] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (store.selection.length) operations.nudge(dx, dy, event.shiftKey ? FAR : event.altKey ? FINE : 1);
    else {
      drawing.view.pan(-40 * dx, 40 * dy);
      drawing.touched = true;
      drawing.request();
    }
  };
  const next = (by) => {
    const count = drawing.wheels().length;
    if (!count) return;
    const now = store.selection.at(by > 0 ? -1 : 0);
    store.select([now === undefined ? (by > 0 ? 0 : count - 1) : (now + by + count) % count]);
  };
  const zoom = (factor) => {
    drawing.view.zoom(factor);
    drawing.touched = true;
    drawing.request();
  };
  return [
    ["N, P", "select the next, the previous wheel", (event) => plain("n")(event) || plain("p")(event), (event) => next(event.key === "n" ? 1 : -1)],
    ["Arrows", "move the selected wheels one grid step (Shift: five, Alt: a tenth); the view if none is selected", (event) => event.key.startsWith("Arrow") && !event.ctrlKey && !event.metaKey, move],
    ["[  ]", "turn the selected rims by 15 degrees, exactly", (event) => plain("[")(event) || plain("]")(event), (event) => operations.turn(event.key === "[" ? 1 : -1, 15)],
    ["{  }", "turn the selected rims by 1 degree", (event) => plain("{")(event) || plain("}")(event), (event) => operations.turn(event.key === "{" ? 1 : -1, 1)],
    ["A", "add a wheel", plain("a"), actions.add],
    ["C", "copy the selected wheels", plain("c"), actions.copy],
    ["Delete", "delete the selected wheels", (event) => plain("Delete")(event) || plain("Backspace")(event), actions.delete],
    ["M", "mirror left to right (Shift: top to bottom) about the checked point", (event) => plain("m")(event) || plain("M")(event), (event) => actions[event.shiftKey ? "mirror-y" : "mirror-x"]()],
    ["R", "rotate about the checked point by 15 degrees (Shift: backward)", (event) => plain("r")(event) || plain("R")(event), (event) => actions[event.shiftKey ? "rotate-right" : "rotate-left"]()],
    ["S", "put wheels on the grid", plain("s"), actions.snap],
    ["Ctrl+A", "select all wheels", command("a"), actions.all],
    ["Escape", "select nothing", plain("Escape"), () => store.select([])],
    ["Ctrl+Z", "undo", command("z"), () => store.undo()],
    ["Ctrl+Shift+Z, Ctrl+Y", "redo", (event) => command("z", true)(event) || command("y")(event), () => store.redo()],
    ["O", "add a start point", plain("o"), () => starts.add()],
    ["Space", "play the paths", plain(" "), () => playback.toggle()],
    ["+  −", "zoom", (event) => ["+", "=", "-"].some((key) => plain(key)(event)), (event) => zoom(event.key === "-" ? 1 / 1.25 : 1.25)],
    ["0", "show everything", plain("0"), () => drawing.fit()],
    ["Ctrl+S", "export the scene file", command("s"), () => files.export("toml")],
    ["?", "this list", plain("?"), help],
  ];
}

/** Listens, and writes the list of keys into the help; `target` is where the keys are pressed. */
export function listen(table, list, target = window) {
  list.replaceChildren(...table.map(([keys, what]) => h("tr", {}, h("th", { scope: "row" }, h("kbd", {}, keys)), h("td", {}, what))));
  target.addEventListener("keydown", (event) => {
    if (event.defaultPrevented || isTyping(event)) return;
    const line = table.find(([, , matches]) => matches(event));
    if (!line) return;
    event.preventDefault();
    if (event.repeat && ONCE.has(line[0])) return;
    line[3](event);
  });
}

/** Fields, lists and buttons keep the keys that they need themselves. */
function isTyping(event) {
  const target = event.target;
  if (document.querySelector("dialog[open]")) return true;
  if (target.matches("input[type=text], input[type=number], textarea, select")) return !((event.ctrlKey || event.metaKey) && "sz".includes(event.key.toLowerCase()) && target.matches("select"));
  if (target.matches("input[type=range]")) return event.key.startsWith("Arrow");
  return target.matches("button, summary, a, input[type=checkbox]") && (event.key === " " || event.key === "Enter");
}
