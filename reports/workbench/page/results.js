// What the server said, stage by stage: how good it is (floats, exact, an error), and whether it is about the present
// scene. What is about an earlier one stays in its place until newer comes, so nothing jumps, but it is old at once.
// May be changed: when older results are dropped.

const PARTS = ["geometry", "checked", "inertia", "comparison", "tolerance", "paths"];

export class Results extends EventTarget {
  constructor(conversation, store) {
    super();
    this.geometry = null; // wheels, cells, edges, rests, field, square, body, system
    this.checked = null; // answers, clauses, verdict
    this.comparison = null;
    this.tolerance = null;
    this.inertia = null; // one more answer, of scenes that say what gravity is
    this.paths = [];
    this.error = null; // {message, key}
    this.status = "idle"; // working, fast, exact, error, lost
    this.finished = false; // everything that was asked for has come
    this.sequence = 0;
    this.stale = new Set(); // parts that were asked for and have not come
    this.subject = ""; // the document that was asked about, as text
    this.behind = false; // the scene has changed since
    conversation.addEventListener("asked", ({ detail }) => this.#asked(detail));
    conversation.addEventListener("stage", ({ detail }) => this.#stage(detail));
    store.addEventListener("open", () => this.#forget());
    store.addEventListener("change", () => this.#changed());
    this.store = store;
    conversation.addEventListener("trouble", ({ detail }) => this.#trouble(detail));
  }

  /** What was said about another scene must not stand beside this one. */
  #forget() {
    Object.assign(this, { checked: null, inertia: null, comparison: null, tolerance: null, paths: [], error: null, foreign: true });
  }

  /** Every change makes what is shown old, before anything is asked; one that is taken back makes it new again. */
  #changed() {
    const behind = JSON.stringify(this.store.document) !== this.subject;
    if (behind === this.behind) return;
    this.behind = behind;
    this.#tell("behind");
  }

  #asked({ sequence, want }) {
    const subject = JSON.stringify(this.store.document);
    const isSame = subject === this.subject && this.status !== "error"; // asked for more about the same scene
    this.stale = new Set(isSame ? PARTS.filter((part) => part === "paths" || this.stale.has(part) || !this[part]) : PARTS);
    Object.assign(this, { sequence, want, subject, behind: false, finished: false });
    this.status = this.status === "idle" ? "working" : this.status;
    this.#tell("asked");
  }

  /** Whether what is shown of a part is about an earlier state of the scene, or not there yet. */
  isOld(part) {
    return this.behind || this.stale.has(part);
  }

  #stage(line) {
    const { stage } = line;
    if (stage === "fast" || stage === "exact") this.#geometry(line);
    else if (stage === "paths") this.#take("paths", line.paths ?? []);
    else if (stage === "comparison") this.#take("comparison", line.rules ?? []);
    else if (stage === "inertia") this.#take("inertia", line.answer);
    else if (stage === "equilibria") this.geometry = { ...this.geometry, equilibria: line.equilibria };
    else if (stage === "facts") this.checked = { ...this.checked, clauses: line.clauses };
    else if (stage === "tolerance") this.#take("tolerance", line);
    else if (stage === "error") this.#error(line);
    else if (stage === "unanswered") this.#unanswered(line);
    else if (stage === "done") this.#done();
    this.took = line.took;
    this.#tell(stage);
  }

  #geometry(line) {
    this.error = null;
    this.status = line.stage;
    const { answers, clauses, verdict, reason, ...geometry } = line;
    if (line.geometry === "later") this.#wheelsOnly(geometry);
    else if (line.stage === "fast") this.#take("geometry", withSquare(geometry));
    else this.geometry = { ...this.geometry, ...geometry, system: { ...this.geometry?.system, ...geometry.system } };
    if (line.stage === "exact") this.#take("checked", { answers, clauses: clauses ?? null, verdict: verdict ?? null, reason, stage: "exact" });
    else if (answers?.length && this.stale.has("checked")) this.#guessed(answers);
  }

  /**
   * Guesses by floats until the exact answers come.  What there is no guess for stays what it was, and old; so does the
   * sentence of an answer that has the same word again: a drag would make the cards jump.
   */
  #guessed(guesses) {
    const before = this.checked?.answers ?? [];
    const guessed = guesses.map((guess) => ({ ...guess, sentence: before.find(({ key, answer }) => key === guess.key && answer === guess.answer)?.sentence }));
    const others = before.filter(({ key }) => !guesses.some((guess) => guess.key === key)).map((answer) => ({ ...answer, old: true }));
    this.#take("checked", { ...this.checked, answers: [...guessed, ...others], stage: "fast" });
  }

  /** Wheels whose cells take longer: the cells of this scene that were shown stay until then. */
  #wheelsOnly(geometry) {
    const { cells, edges, field } = this.foreign ? {} : this.geometry ?? {};
    this.geometry = { ...geometry, cells, edges, field };
    this.foreign = false;
  }

  #error({ message, key }) {
    this.error = { message, key: key ?? null };
    this.status = "error";
  }

  /** There are no answers about this scene: those about another one must not stay. */
  #unanswered(line) {
    Object.assign(this, { checked: null, inertia: null, tolerance: null, paths: [] });
    this.#error(line);
  }

  /** Parts that were wanted and did not come are not part of this scene (no tolerance, no comparison of systems). */
  #done() {
    this.finished = true;
    if (this.status === "error") return;
    for (const part of ["inertia", "comparison", "tolerance", "paths"]) {
      if (this.stale.has(part) && this.want.includes(part)) this.#take(part, part === "paths" ? [] : null);
    }
    this.stale.delete("geometry");
    this.stale.delete("checked");
  }

  #take(part, value) {
    if (part === "geometry") this.foreign = false;
    this[part] = value;
    this.stale.delete(part);
  }

  #trouble({ kind, message }) {
    if (kind === "lost" || kind === "token") this.status = "lost";
    else if (kind !== "busy") this.#error({ message, key: null });
    this.#tell("trouble");
  }

  #tell(stage) {
    this.dispatchEvent(new CustomEvent("change", { detail: { stage } }));
  }
}

/** A plain system states its checked point and radius inside its own record. */
function withSquare(geometry) {
  const { centre, square } = geometry.system ?? {};
  return centre?.length === 2 ? { ...geometry, square: { x: centre[0], y: centre[1], ...square } } : geometry;
}
