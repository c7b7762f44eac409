// What stands behind the answers: Theorem 4 clause by clause, the contact rules side by side, the tolerance.
// May be changed: the order within a section. A clause that Python adds appears by itself.

import { h, icon, onceAFrame, pool, say } from "./dom.js";
import { shown } from "./values.js";

const GOOD = /^(holds|asymptotically stable|stabilizable|stable|comes home|comes near|returns|can be held|certified|valid)/;
const FAIR = /^(stays near|drifts)/;
const BAD = /^(fails|unstable|leaves|cannot be held|invalid)/;

/** The tone of a verdict that comes without one: for its colour and form; the word itself is always shown. */
export function toneOf(word = "") {
  if (GOOD.test(word)) return "good";
  if (FAIR.test(word)) return "fair";
  return BAD.test(word) ? "bad" : "open";
}

/** A verdict as a word with its form. */
function verdict(word, tone = toneOf(word)) {
  return h("span", { class: "verdict", "data-tone": tone }, icon(tone === "open" ? "open-answer" : tone), word);
}

export class ClausesPanel {
  constructor({ list, total }, results) {
    Object.assign(this, { list, total, results, text: "" });
    results.addEventListener("change", onceAFrame(() => this.show()));
  }

  show() {
    const { checked } = this.results;
    this.list.classList.toggle("stale", this.results.isOld("checked") || checked?.stage === "fast");
    if (!checked) return this.#clear();
    const text = JSON.stringify([checked.clauses, checked.verdict, checked.reason]);
    if (!checked.clauses || text === this.text) return;
    this.text = text;
    const open = new Set([...this.list.querySelectorAll("details[open]")].map((element) => element.dataset.key));
    this.list.replaceChildren(...checked.clauses.map((clause) => this.#clause(clause, open.has(clause.key))));
    this.total.replaceChildren(...(checked.verdict ? [verdict(checked.verdict), h("span", { class: "reason" }, checked.reason ?? "")] : []));
  }

  #clear() {
    this.text = "";
    this.list.replaceChildren();
    this.total.replaceChildren();
  }

  #clause({ key, title, verdict: word, reason, facts = [] }, open) {
    const heading = h("div", { class: "clause-head" }, h("span", { class: "clause-title" }, title), verdict(word));
    const list = facts.length ? h("details", { "data-key": key, open }, h("summary", {}, facts.length === 1 ? "1 fact" : `${facts.length} facts`), factList(facts)) : null;
    return h("li", { class: "clause" }, heading, h("p", { class: "reason" }, reason ?? ""), list);
  }
}

/** Facts with a label as a list of terms, the others as plain lines. */
function factList(facts) {
  if (facts.every(({ label }) => label)) return h("dl", {}, ...facts.flatMap(({ label, text }) => [h("dt", {}, label), h("dd", {}, text)]));
  return h("ul", { class: "facts" }, ...facts.map(({ label, text }) => h("li", {}, label ? `${label}: ${text}` : text)));
}

export class ComparisonPanel {
  constructor({ section, body, head }, store, results, choose) {
    Object.assign(this, { section, body, head, store, results, choose });
    results.addEventListener("change", onceAFrame(() => this.show()));
  }

  show() {
    const { comparison, finished } = this.results;
    this.section.hidden = comparison === null && finished;
    this.section.classList.toggle("stale", this.results.isOld("comparison"));
    if (comparison === this.drawn) return;
    this.drawn = comparison;
    if (!comparison) return this.body.replaceChildren();
    const chosen = { rule: this.results.geometry?.values?.rule, answers: this.results.checked?.answers ?? [] };
    const all = [chosen, ...comparison.filter(({ rule }) => rule !== chosen.rule)];
    const keys = all.find((rule) => rule.answers?.length)?.answers.map(({ key }) => key) ?? [];
    this.head.replaceChildren(h("th", { scope: "col" }, "Rule"), ...keys.map((key) => h("th", { scope: "col" }, key)));
    this.body.replaceChildren(...all.map((rule) => this.#row(rule, keys, rule === chosen)));
  }

  #row({ rule, answers, verdict: said, why_not: whyNot, reason }, keys, now) {
    const name = h("button", { type: "button", class: "link", title: `Check under rule ${rule}`, onclick: () => this.choose(rule) }, rule);
    const cells = answers?.length
      ? keys.map((key) => {
        const found = answers.find((answer) => answer.key === key);
        return h("td", {}, found ? verdict(found.answer, found.tone) : "–");
      })
      : [h("td", { colspan: Math.max(1, keys.length), class: "reason" }, whyNot ?? reason ?? said ?? "not checked")];
    return h("tr", now ? { class: "selected", "aria-current": "true" } : {}, h("th", { scope: "row" }, name), ...cells);
  }
}

const STATED = ["sequence", "stage", "time", "took", "verdict", "sentence", "tone"]; // shown otherwise, or not at all
const LABELS = { factor: "holds up to this multiple", radius: "bodies end within" };

export class TolerancePanel {
  constructor({ section, body }, results) {
    Object.assign(this, { section, body, results });
    results.addEventListener("change", onceAFrame(() => this.show()));
  }

  show() {
    const { tolerance, finished } = this.results;
    this.section.classList.toggle("stale", this.results.isOld("tolerance"));
    if (!tolerance) {
      if (finished) this.body.replaceChildren(h("p", { class: "hint" }, "No tolerance is stated. Fill in how far the built array may be off, under Numbers, and what still holds is proved here."));
      this.drawn = null;
      return;
    }
    if (tolerance === this.drawn) return;
    this.drawn = tolerance;
    const rows = Object.entries(tolerance).filter(([key, value]) => !STATED.includes(key) && ["number", "string"].includes(typeof value));
    this.body.replaceChildren(
      verdict(tolerance.verdict ?? "undecided", tolerance.tone), h("p", {}, tolerance.sentence ?? ""),
      h("dl", {}, ...rows.flatMap(([key, value]) => [h("dt", {}, LABELS[key] ?? key.replaceAll("_", " ")), h("dd", {}, typeof value === "number" ? shown(value) : value)])),
    );
  }
}

/** Where, when and how each path ends, in the sentences that `nonsmooth simulate` prints, and how many events it has. */
export class PathsPanel {
  constructor(list, waiting, store, results) {
    Object.assign(this, { list, waiting, store, results });
    results.addEventListener("change", onceAFrame(() => this.show()));
  }

  show() {
    const { paths } = this.results;
    this.waiting.hidden = paths.length >= this.store.now.starts.length;
    this.list.classList.toggle("stale", this.results.isOld("paths"));
    if (paths === this.drawn) return;
    this.drawn = paths;
    const items = pool(this.list, paths.length, () => h("li", {}, h("span", { class: "start-name" }), h("span", {})));
    paths.forEach(({ end, events = [], error, sentences = [] }, k) => {
      items[k].className = `tone-${k % 6}`;
      say(items[k].firstChild, `Start ${k + 1}`);
      const said = sentences.length ? sentences.join("; ") : end;
      say(items[k].lastChild, error ?? `${said}${events.length ? `, ${events.length} event${events.length === 1 ? "" : "s"}` : ""}`);
    });
  }
}
