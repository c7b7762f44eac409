// Puts the page together: every module gets the elements of index.html that it fills.
// May be changed: what is wired to what. What a thing does is said in its own module.

import { Address } from "./address.js";
import { AnswersPanel } from "./answers_panel.js";
import { Api, takeToken } from "./api.js";
import { Conversation } from "./conversation.js";
import { byId } from "./dom.js";
import { Drawing } from "./drawing.js";
import { ClausesPanel, ComparisonPanel, PathsPanel, TolerancePanel } from "./evidence_panel.js";
import { Files } from "./files.js";
import { keyTable, listen } from "./keyboard.js";
import { Notices } from "./notices.js";
import { Operations } from "./operations.js";
import { Pointer } from "./pointer.js";
import { startReadout } from "./readout.js";
import { Results } from "./results.js";
import { Sliders, SettingsPanel } from "./settings_panel.js";
import { Playback, StartsPanel } from "./starts_panel.js";
import { Store, usualTime } from "./store.js";
import { startTheme } from "./theme.js";
import { Toolbar, wheelActions } from "./toolbar.js";
import { WheelPanel } from "./wheel_panel.js";

const FIRST = "four-wheel"; // shown when neither the address nor the command line names a scene

const api = new Api(takeToken());
const store = new Store();
const conversation = new Conversation(api, store);
const results = new Results(conversation, store);
const drawing = new Drawing(byId("drawing"), store, results);
const notices = new Notices({ note: byId("note"), banner: byId("banner"), words: byId("banner-words"), form: byId("token-form"), error: byId("error") }, { api, results, conversation });
const tell = (text) => notices.tell(text);
const operations = new Operations(api, store, drawing, tell);

function panels() {
  new AnswersPanel({ list: byId("answers"), status: byId("status"), live: byId("live") }, store, results);
  new ClausesPanel({ list: byId("clauses"), total: byId("theorem") }, results);
  new ComparisonPanel({ section: byId("rules-section"), body: byId("rules-body"), head: byId("rules-head") }, store, results, (rule) => {
    byId("rule").value = rule;
    byId("rule").dispatchEvent(new Event("change"));
  });
  new TolerancePanel({ section: byId("tolerance-section"), body: byId("tolerance") }, results);
  new PathsPanel(byId("path-ends"), byId("following"), store, results);
  new SettingsPanel(byId("settings"), store, results);
  new Sliders(byId("sliders"), store, results, conversation, operations);
  new WheelPanel({ fields: byId("wheel-fields"), title: byId("wheel-title"), head: byId("wheel-head"), body: byId("wheel-rows"), empty: byId("wheel-hint") }, store, results, operations);
  new Toolbar({ edits: byId("edits"), snap: byId("snap"), layers: byId("layers") }, { operations, store, drawing });
}

function controls() {
  const starts = new StartsPanel({ list: byId("starts"), until: byId("until") }, store, drawing);
  const playback = new Playback({ button: byId("play"), slider: byId("time"), output: byId("clock") }, store, drawing);
  const files = new Files({ scenes: byId("scene"), rules: byId("rule"), menu: byId("export-menu"), input: byId("file"), dialog: byId("export-box") }, { api, store, results, tell });
  const help = () => byId("help").showModal();
  new Pointer(drawing, operations, conversation);
  startReadout(byId("readout"), byId("how"), drawing);
  startTheme(byId("theme"));
  listen(keyTable({ store, operations, actions: wheelActions(operations, store), drawing, playback, starts, files, help }), byId("keys"));
  byId("help-button").addEventListener("click", help);
  byId("help-close").addEventListener("click", () => byId("help").close());
  byId("undo").addEventListener("click", () => store.undo());
  byId("redo").addEventListener("click", () => store.redo());
  byId("open").addEventListener("click", () => byId("file").click());
  byId("fit").addEventListener("click", () => drawing.fit());
  byId("zoom-in").addEventListener("click", () => zoom(1.25));
  byId("zoom-out").addEventListener("click", () => zoom(0.8));
  byId("add-start").addEventListener("click", () => starts.add());
  store.addEventListener("change", header);
  return files;
}

function zoom(factor) {
  drawing.view.zoom(factor);
  drawing.touched = true;
  drawing.request();
}

/** What changes with the scene as a whole. */
function header() {
  byId("undo").disabled = !store.past.length;
  byId("redo").disabled = !store.future.length;
  const { name, description } = store.document;
  document.title = name ? `${name} · nonsmooth workbench` : "nonsmooth workbench";
  byId("description").textContent = description ?? "";
  document.body.classList.toggle("is-system", Boolean(store.document.system));
}

async function begin() {
  panels();
  const files = controls();
  const carried = await Address.opened();
  new Address(store);
  if (carried) store.begin({ starts: [], until: usualTime(carried.document), ...carried });
  await scenes(files, carried);
  notices.look();
}

/** The lists of scenes and rules, and the first scene; asked for again while the server is gone, not if it refuses. */
async function scenes(files, carried) {
  try {
    const opened = await files.load();
    if (!carried) await first(opened ?? FIRST);
  } catch (error) {
    conversation.dispatchEvent(new CustomEvent("trouble", { detail: { kind: error.kind, message: error.message } }));
    if (error.kind !== "refused") setTimeout(() => scenes(files, carried), 2000);
  }
}

/** The scene of the command line; the usual one, with a word about it, where that cannot be opened. */
async function first(name) {
  try {
    const { document } = await api.json(`/api/scenes/${encodeURIComponent(name)}`);
    store.begin({ document, starts: [], until: usualTime(document) });
  } catch (error) {
    if (error.kind !== "refused" || name === FIRST) throw error;
    tell(`${name}: ${error.message}`);
    await first(FIRST);
  }
}

window.workbench = Object.freeze({ store, conversation, results, drawing }); // for the console, and for measurements
begin();
