// The answers, first and largest: a word, a form and a colour for each, never a colour alone; and whether they are
// exact or only the fast floats. What is said aloud to readers of the screen is said here as well.
// May be changed: the words of TITLES. Verdicts, tones and sentences are Python's.

import { h, icon, onceAFrame, pool, say } from "./dom.js";
import { isSystem } from "./scene_document.js";

const TITLES = { position: "Position", inertia: "With inertia", heading: "Heading", pose: "Pose", stability: "Stability" };
const QUESTIONS = {
  position: "Does the body come to the point?",
  inertia: "What does a body with inertia do?",
  heading: "What does its heading do?",
  pose: "Can feedback hold both?",
  stability: "Do solutions come to the point?",
};
const ICONS = { good: "good", fair: "fair", bad: "bad", open: "open-answer" };
const QUIET = 500; // milliseconds without a change before readers of the screen are told

export class AnswersPanel {
  constructor({ list, status, live }, store, results) {
    Object.assign(this, { list, status, live, store, results });
    const later = onceAFrame(() => this.show());
    results.addEventListener("change", () => {
      this.#state();
      later();
    });
  }

  /** How good the answers are, at once: for those who wait for it. */
  #state() {
    const { status, checked, error } = this.results;
    const answered = this.results.isOld("checked") ? "working" : checked?.stage;
    this.status.dataset.state = (error && status === "error" ? "error" : status === "lost" ? "lost" : answered) ?? "working";
  }

  show() {
    const { checked, inertia } = this.results;
    const answers = this.#complete(checked?.answers ?? []);
    if (inertia) answers.splice(1, 0, { ...inertia, old: this.results.isOld("inertia") });
    const items = pool(this.list, answers.length, card);
    answers.forEach((answer, k) => fill(items[k], answer));
    this.list.classList.toggle("stale", this.results.isOld("checked") || this.results.status === "error");
    this.#look();
    if (checked?.stage === "exact" && !this.results.isOld("checked")) this.#announce(answers);
  }

  /** A card for every question, also for those that nothing is known about yet. */
  #complete(found) {
    const keys = isSystem(this.store.document) ? ["stability"] : ["position", "heading", "pose"];
    return keys.map((key) => {
      const answer = found.find((one) => one.key === key) ?? { key, answer: "…", tone: "open" };
      return answer.provisional ? { ...answer, sentence: answer.sentence ?? "a guess by floats; the exact answer follows" } : answer;
    });
  }

  /** The same in words. */
  #look() {
    const { state } = this.status.dataset;
    const words = {
      error: "not checked: see the message",
      lost: "waiting for the server",
      working: "checking …",
      fast: "guesses by floats, not yet proved",
      exact: "exact",
    };
    if (this.status.dataset.look !== state) this.status.dataset.look = state;
    say(this.status, words[state] ?? words.working);
  }

  #announce(answers) {
    const text = answers.map(({ key, answer }) => `${TITLES[key] ?? key}: ${answer}.`).join(" ");
    clearTimeout(this.timer);
    this.timer = setTimeout(() => say(this.live, text), QUIET);
  }
}

function card() {
  return h("li", { class: "answer" },
    h("p", { class: "answer-title" }), h("p", { class: "answer-word" }, h("span", { class: "answer-icon" }), h("span", {})), h("p", { class: "answer-sentence" }));
}

function fill(item, { key, question, answer, tone, sentence, old, provisional }) {
  const [title, word, line] = item.children;
  const asked = question && question !== key ? question : QUESTIONS[key] ?? "";
  item.dataset.key = key;
  item.classList.toggle("old", Boolean(old));
  item.classList.toggle("provisional", Boolean(provisional));
  if (item.dataset.tone !== tone) {
    item.dataset.tone = tone;
    word.firstChild.replaceChildren(icon(ICONS[tone] ?? ICONS.open));
  }
  say(title, TITLES[key] ?? key);
  title.title = asked;
  say(word.lastChild, answer);
  say(line, sentence ?? "");
}
