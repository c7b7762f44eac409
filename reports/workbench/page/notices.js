// What the page must say aside from answers: short notes, an error of the scene, a server that is gone.
// May be changed: how long a note stays. A lost server is asked every PULSE whether it is back.

import { say } from "./dom.js";

const STAYS = 6000; // milliseconds
const PULSE = 5000; // milliseconds between looks at a server that is idle

export class Notices {
  constructor({ note, banner, words, form, error }, { api, results, conversation }) {
    Object.assign(this, { note, banner, words, form, error, api, results, conversation, started: null });
    results.addEventListener("change", ({ detail }) => this.#heard(detail.stage));
    conversation.addEventListener("trouble", ({ detail }) => this.#trouble(detail));
    form.addEventListener("submit", (event) => this.#token(event));
    setInterval(() => this.look(), PULSE);
  }

  /** A note that goes away by itself. */
  tell(text) {
    say(this.note, text);
    this.note.hidden = false;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => (this.note.hidden = true), STAYS);
  }

  #heard(stage) {
    const { error } = this.results;
    this.error.hidden = !error;
    say(this.error, error?.message ?? "");
    if (!["asked", "trouble"].includes(stage)) this.#found();
  }

  #trouble({ kind, message }) {
    if (kind === "lost") this.#raise("The workbench's server does not answer. The page tries again by itself; nothing is lost.", false);
    else if (kind === "token") this.#raise("The server has another token now. Paste the address that the command printed:", true);
    else if (kind !== "busy") this.tell(message);
  }

  #raise(text, asks) {
    say(this.words, text);
    this.form.hidden = !asks;
    this.banner.hidden = false;
    this.lost = true;
  }

  #found() {
    if (!this.lost) return;
    this.lost = false;
    this.banner.hidden = true;
    this.tell("The server is back.");
    this.conversation.refresh({ again: true });
  }

  /** Whether the server is there; a hidden page does not ask. */
  async look() {
    if (document.hidden || this.conversation.flight) return;
    try {
      const { started } = await this.api.json("/api/health");
      if (this.started && started !== this.started) this.lost = true;
      this.started = started;
      this.#found();
    } catch (error) {
      this.#trouble({ kind: error.kind, message: error.message });
    }
  }

  #token(event) {
    event.preventDefault();
    const typed = new FormData(this.form).get("token").trim();
    const token = /[?&]token=([^&#]+)/.exec(typed)?.[1] ?? typed;
    this.api.use(decodeURIComponent(token));
    this.conversation.refresh({ again: true });
    this.look();
  }
}
