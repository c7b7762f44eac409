// Scenes that are chosen, opened and exported, and links to them.
// May be changed: the kinds of EXPORTS (each is one of /api/export). A file is read by the browser and sent as text.

import { h } from "./dom.js";
import { pack } from "./address.js";

const LARGEST = 500_000; // bytes of a scene file that is opened
const EXPORTS = [
  ["toml", "Scene file (TOML)"],
  ["report", "Derivation report (HTML)"],
  ["figure", "Figure of the cells (SVG)"],
  ["json", "Answers and clauses (JSON)"],
  ["certificate", "Certificate (JSON)"],
];

export class Files {
  constructor({ scenes, rules, menu, input, dialog }, { api, store, results, tell }) {
    Object.assign(this, { scenes, rules, menu, input, dialog, api, store, results, tell });
    scenes.addEventListener("change", () => this.choose(scenes.value));
    rules.addEventListener("change", () => this.#rule(rules.value));
    input.addEventListener("change", () => this.#read(input.files[0]));
    for (const [kind, label] of EXPORTS) menu.append(h("li", {}, h("button", { type: "button", "data-export": kind, onclick: () => this.export(kind) }, label)));
    menu.append(h("li", {}, h("button", { type: "button", id: "copy-link", onclick: () => this.link() }, "Copy a link to this scene")));
    for (const source of [store, results]) source.addEventListener("change", () => this.show());
  }

  /** Fills both lists; returns what the command line opened. */
  async load() {
    const { scenes, rules, opened } = await this.api.json("/api/scenes");
    const group = (kind, label) => h("optgroup", { label }, ...scenes.filter((scene) => scene.kind === kind).map(({ name, summary }) => h("option", { value: name, title: summary }, name)));
    const own = h("option", { value: "", hidden: true }, "Choose a scene …");
    this.scenes.replaceChildren(own, group("array", "Arrays of wheels"), group("system", "Plain switched systems"));
    const mixed = h("option", { value: "mixed", hidden: true }, "mixed"); // shown where wheels have rules of their own, not chosen
    this.rules.replaceChildren(...rules.map(({ name, summary }) => h("option", { value: name, title: summary }, name)), mixed);
    this.summaries = new Map(rules.map(({ name, summary }) => [name, summary]));
    this.show();
    return opened;
  }

  async choose(name) {
    if (!name) return;
    try {
      const { document } = await this.api.json(`/api/scenes/${encodeURIComponent(name)}`);
      this.#open(document);
    } catch (error) {
      this.tell(error.message);
    }
  }

  #open(document) {
    this.store.open(document);
  }

  #rule(rule) {
    this.store.edit(({ document }) => ({ document: { ...document, contact: { ...document.contact, rule } } }));
  }

  async #read(file) {
    this.input.value = "";
    if (!file) return;
    if (file.size > LARGEST) return this.tell(`${file.name}: required at most ${LARGEST} bytes`);
    try {
      const { document } = await this.api.json("/api/open", { toml: await file.text() });
      this.#open(document);
    } catch (error) {
      this.tell(`${file.name}: ${error.message}`);
    }
  }

  async export(kind) {
    this.dialog.hidePopover();
    this.tell(`Writing the ${kind} …`);
    try {
      const { blob, name } = await this.api.file("/api/export", { ...this.store.now, kind });
      const link = h("a", { href: URL.createObjectURL(blob), download: name });
      document.body.append(link);
      link.click();
      link.remove();
      setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
      this.tell(`${name} is saved.`);
    } catch (error) {
      this.tell(`The ${kind} could not be written: ${error.message}`);
    }
  }

  /** The address of this scene, with the token: it opens on this machine only. */
  async link() {
    const url = new URL(window.location.href);
    url.search = `?token=${encodeURIComponent(this.api.token)}`;
    url.hash = await pack(this.store.now);
    this.dialog.hidePopover();
    try {
      await navigator.clipboard.writeText(url.href);
      this.tell("The link is copied. It opens on this machine only.");
    } catch {
      this.tell("The browser does not let the page copy: the address bar holds the scene too.");
    }
  }

  show() {
    const { contact, system, name = "" } = this.store.document;
    this.rules.value = contact?.rule ?? this.results.geometry?.values?.rule ?? "nearest";
    this.rules.closest("label").hidden = Boolean(system);
    this.scenes.value = [...this.scenes.options].some((option) => option.value === name) ? name : "";
  }
}
