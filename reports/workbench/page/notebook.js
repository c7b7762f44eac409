// The view in a notebook: drawing, answers, starts and the buttons for wheels, put together as in main.js, in a root of
// its own, so that no style of the notebook reaches it and none of its own gets out.
// May be changed: which parts of the page a notebook shows. Python makes one file of this module and what it imports.

import { AnswersPanel } from "./answers_panel.js";
import { Conversation } from "./conversation.js";
import { h, icon, s, say } from "./dom.js";
import { Drawing } from "./drawing.js";
import { PathsPanel } from "./evidence_panel.js";
import { Kernel } from "./kernel.js";
import { keyTable, listen } from "./keyboard.js";
import { Operations } from "./operations.js";
import { Pointer } from "./pointer.js";
import { startReadout } from "./readout.js";
import { Results } from "./results.js";
import { Playback, StartsPanel } from "./starts_panel.js";
import { Store } from "./store.js";
import { Toolbar, wheelActions } from "./toolbar.js";

const PAUSE = 200; // milliseconds after the last change until Python is told
const NOT_HERE = ["Ctrl+S", "?"]; // keys of files and of the help

/** One view of a widget; returns what ends it. */
export function render({ model, el }) {
  const [root, parts] = frame(model, el);
  const kernel = new Kernel(model);
  const store = new Store();
  const conversation = new Conversation(kernel, store);
  const results = new Results(conversation, store);
  const drawing = new Drawing(parts.drawing, store, results);
  const tell = (text) => say(parts.note, text);
  const operations = new Operations(kernel, store, drawing, tell);
  new AnswersPanel(parts, store, results);
  new PathsPanel(parts.ends, parts.following, store, results);
  new Toolbar(parts, { operations, store, drawing });
  const starts = new StartsPanel({ list: parts.starts, until: parts.until }, store, drawing);
  const playback = new Playback({ button: parts.play, slider: parts.time, output: parts.clock }, store, drawing);
  new Pointer(drawing, operations, conversation);
  startReadout(parts.readout, parts.how, drawing, root.host);
  const keys = keyTable({ store, operations, actions: wheelActions(operations, store), drawing, playback, starts });
  listen(keys.filter(([name]) => !NOT_HERE.includes(name)), h("tbody"), parts.drawing);
  parts.undo.addEventListener("click", () => store.undo());
  parts.redo.addEventListener("click", () => store.redo());
  parts.fit.addEventListener("click", () => drawing.fit());
  parts.add.addEventListener("click", () => starts.add());
  results.addEventListener("change", () => tell(results.error?.message ?? ""));
  conversation.addEventListener("trouble", ({ detail }) => tell(detail.message));
  store.addEventListener("change", () => {
    parts.undo.disabled = !store.past.length;
    parts.redo.disabled = !store.future.length;
  });
  const end = shared(model, store);
  return () => {
    end();
    kernel.close();
  };
}

/** Keeps what Python holds and what the page holds alike; returns what ends that. */
function shared(model, store) {
  const stated = () => ({ document: model.get("document"), starts: model.get("starts"), until: model.get("until") });
  const isSame = () => JSON.stringify(stated()) === JSON.stringify(store.now);
  let timer;
  const tell = () => {
    if (isSame()) return;
    for (const [name, value] of Object.entries(store.now)) model.set(name, value);
    model.save_changes();
  };
  const hear = () => {
    clearTimeout(timer);
    if (!isSame()) store.open(...Object.values(stated()));
  };
  store.begin(stated());
  store.addEventListener("change", () => {
    clearTimeout(timer);
    timer = setTimeout(tell, PAUSE);
  });
  model.on("change:document change:starts change:until", hear);
  return () => {
    clearTimeout(timer);
    tell();
    model.off("change:document change:starts change:until", hear);
  };
}

/** The elements, by name, inside a root of their own. */
function frame(model, el) {
  const host = h("div", { "data-lm-suppress-shortcuts": "true" }); // JupyterLab keeps its keys to itself
  const root = host.attachShadow({ mode: "open" });
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(model.get("_styles"));
  root.adoptedStyleSheets = [sheet];
  const dark = document.body.dataset.jpThemeLight;
  if (dark !== undefined) host.style.colorScheme = dark === "false" ? "dark" : "light";
  const symbols = h("div", { class: "symbols" });
  symbols.innerHTML = model.get("_symbols");
  const parts = elements();
  root.append(symbols, layout(parts));
  // the notebook scrolls with the mouse wheel, until the drawing is in use
  root.addEventListener("wheel", (event) => {
    if (root.activeElement !== parts.drawing && !event.ctrlKey) event.stopPropagation();
  }, { capture: true });
  el.append(host);
  return [root, parts];
}

const button = (name, label) => h("button", { type: "button", title: label, "aria-label": label }, icon(name));

function elements() {
  const drawing = s("svg", { id: "drawing", tabindex: "0", role: "application", "aria-label": "Drawing of the array to scale" });
  return {
    drawing,
    undo: button("undo", "Undo"),
    redo: button("redo", "Redo"),
    fit: button("fit", "Show everything"),
    add: h("button", { type: "button", id: "add-start" }, icon("add"), h("span", {}, "Add a start")),
    play: h("button", { type: "button", id: "play", title: "Play the paths" }, icon("play")),
    time: h("input", { type: "range", min: 0, max: 1000, value: 0, "aria-label": "Time along the paths" }),
    until: h("input", { type: "text", id: "until", inputmode: "decimal", "aria-label": "until t =" }),
    edits: h("div", { class: "tools", role: "toolbar", "aria-label": "Wheels" }),
    snap: h("select", { "aria-label": "Grid" }),
    layers: h("ul", { class: "menu" }),
    ...Object.fromEntries(["list", "starts", "ends"].map((name) => [name, h("ul", { class: { list: "answers", ends: "path-ends" }[name] ?? name })])),
    ...Object.fromEntries(["status", "note", "following", "readout", "how"].map((name) => [name, h("p", { id: name, class: "hint" })])),
    live: h("div", { class: "unseen", "aria-live": "polite" }),
    clock: h("output", { id: "clock" }),
  };
}

function layout({ drawing, undo, redo, fit, add, play, time, until, edits, snap, layers, list, starts, ends, status, note, following, readout, how, live, clock }) {
  const shown = h("details", {}, h("summary", {}, "What is shown"), layers);
  return h("div", { class: "notebook" },
    h("section", { class: "stage", "aria-label": "The array" },
      h("div", { class: "over" }, h("div", { class: "tools" }, undo, redo, fit), edits, h("label", { class: "pick small" }, "Grid ", snap)),
      drawing,
      h("div", { class: "under" }, play, time, clock, readout), how),
    h("section", { class: "beside" },
      h("div", { class: "section-head" }, h("h2", {}, "Answers"), status), list, note,
      h("div", { class: "row" }, add, h("label", { class: "pick small" }, "until t = ", until)), starts, following, ends, shown, live));
}
