// Asking for the view of the newest scene: one request in flight, older states are never asked for.
// After the fast stage the exact one gets PATIENCE; then a newer state, if there is one, goes out and the server
// cancels the older computation. So a drag never builds up a queue, and small arrays show exact answers throughout.
// May be changed: PATIENCE, and what is wanted while a drag goes on.

const PATIENCE = 60; // milliseconds between the fast stage and a newer request
const LONG_PATIENCE = 400; // where the cells themselves come later
// Cells and answers come always; these cost more.
const ALL = ["paths", "inertia", "clauses", "equilibria", "comparison", "tolerance"];
const DURING_DRAG = ["paths"];
const RETRY = [300, 700, 1500, 3000]; // milliseconds until a lost server is asked again; the last one repeats

export class Conversation extends EventTarget {
  constructor(api, store) {
    super();
    Object.assign(this, { api, store });
    this.tab = crypto.getRandomValues(new Uint32Array(4)).join("-"); // of this page load: a duplicated tab has another
    this.sequence = 0;
    this.flight = null;
    this.asked = "";
    this.dragging = false;
    this.losses = 0;
    store.addEventListener("change", () => this.refresh());
  }

  /** While a drag goes on only what can follow it is asked for; its end asks for everything. */
  drag(active) {
    this.dragging = active;
    if (!active) this.refresh();
  }

  /** Asks for the view of the present state, now or when the present request has been heard. */
  refresh({ again = false } = {}) {
    if (again) this.asked = "";
    if (this.#question() === this.asked || !this.store.document || !Object.keys(this.store.document).length) return;
    if (this.isFree) this.#ask();
  }

  /** Whether a change would be asked about at once; a lost server is asked now and then only. */
  get isFree() {
    return !this.retry && (!this.flight || this.flight.heard);
  }

  #question() {
    const { document, starts, until } = this.store.now;
    return JSON.stringify({ document, starts, until, want: this.dragging ? DURING_DRAG : ALL });
  }

  async #ask() {
    const question = this.#question();
    this.asked = question;
    this.flight?.controller.abort();
    const flight = { controller: new AbortController(), heard: false, sent: performance.now(), sequence: (this.sequence += 1) };
    this.flight = flight;
    const body = { tab: this.tab, sequence: flight.sequence, ...JSON.parse(question) };
    this.#tell("asked", { sequence: flight.sequence, want: body.want });
    try {
      await this.api.lines("/api/view", body, (line) => this.#hear(flight, line), flight.controller.signal);
      this.losses = 0;
    } catch (error) {
      if (error.name === "AbortError") return;
      if (this.flight === flight) this.#fail(error);
    } finally {
      clearTimeout(flight.timer);
      if (this.flight === flight) this.flight = null;
      if (!this.flight) this.refresh();
    }
  }

  #hear(flight, line) {
    if (flight !== this.flight) return;
    this.losses = 0;
    this.#tell("stage", { ...line, took: performance.now() - flight.sent });
    clearTimeout(flight.timer);
    const wait = line.geometry === "later" ? LONG_PATIENCE : PATIENCE;
    if (line.stage === "fast") flight.timer = setTimeout(() => this.#heard(flight), wait);
    else this.#heard(flight);
  }

  /** From now on a newer state may replace this request. */
  #heard(flight) {
    flight.heard = true;
    if (flight === this.flight) this.refresh();
  }

  #fail(error) {
    this.#tell("trouble", { kind: error.kind ?? "bug", message: error.message });
    if (error.kind !== "lost" && error.kind !== "busy") return;
    const wait = RETRY[Math.min(this.losses, RETRY.length - 1)];
    this.losses += 1;
    this.retry ??= setTimeout(() => {
      this.retry = undefined;
      this.refresh({ again: true });
    }, wait);
  }

  #tell(name, detail) {
    this.dispatchEvent(new CustomEvent(name, { detail }));
  }
}
