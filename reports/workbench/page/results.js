// What the server said about the present scene, stage by stage, and how good it is: floats, exact, or an error.
// May be changed: when older results are dropped. Older geometry stays until newer comes, so nothing flickers.

const PATIENCE = 40; // milliseconds after the cells for which exact answers are awaited before guesses are shown

const BLINK = 150; // milliseconds for which what is shown may be about the state before

export class Results extends EventTarget {
  constructor(conversation, store) {
    super();
    this.geometry = null; // wheels, cells, edges, rests, field, square, body, system
    this.checked = null; // answers, clauses, verdict
    this.comparison = null;
    this.tolerance = null;
    this.paths = [];
    this.error = null; // {message, key}
    this.status = "idle"; // working, fast, exact, error, lost
    this.finished = false; // everything that was asked for has come
    this.sequence = 0;
    this.slow = false; // the present state is being asked about for longer than a blink
    this.stale = new Set(); // parts that belong to an older state of the scene
    conversation.addEventListener("asked", ({ detail }) => this.#asked(detail));
    conversation.addEventListener("stage", ({ detail }) => this.#stage(detail));
    store.addEventListener("open", () => this.#forget());
    conversation.addEventListener("trouble", ({ detail }) => this.#trouble(detail));
  }

  /** What was said about another scene must not stand beside this one. */
  #forget() {
    Object.assign(this, { checked: null, comparison: null, tolerance: null, paths: [], error: null, foreign: true });
  }

  #asked({ sequence }) {
    clearTimeout(this.guess);
    this.sequence = sequence;
    this.finished = false;
    this.stale = new Set(["geometry", "checked", "comparison", "tolerance", "paths"]);
    this.slow = false;
    clearTimeout(this.blink);
    this.blink = setTimeout(() => {
      this.slow = true;
      this.#tell("slow");
    }, BLINK);
    this.status = this.status === "idle" ? "working" : this.status;
    this.#tell("asked");
  }

  /** Whether a part still belongs to an older state after a blink. */
  isLate(part) {
    return this.slow && this.stale.has(part);
  }

  #stage(line) {
    const { stage } = line;
    if (stage === "fast" || stage === "exact") this.#geometry(line);
    else if (stage === "paths") this.#take("paths", line.paths ?? []);
    else if (stage === "comparison") this.#take("comparison", line.rules ?? []);
    else if (stage === "equilibria") this.geometry = { ...this.geometry, equilibria: line.equilibria };
    else if (stage === "facts") this.checked = { ...this.checked, clauses: line.clauses };
    else if (stage === "tolerance") this.#take("tolerance", line);
    else if (stage === "error") this.#error(line);
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
    clearTimeout(this.guess);
    if (!answers) return;
    const checked = { answers, clauses: clauses ?? null, verdict: verdict ?? null, reason, stage: line.stage };
    if (line.stage === "exact") this.#take("checked", checked);
    else this.guess = setTimeout(() => this.#guessed(checked, this.sequence), PATIENCE);
  }

  /** Guesses by floats are shown where the exact answers take longer than a blink. */
  #guessed(checked, sequence) {
    if (sequence !== this.sequence) return;
    this.#take("checked", checked);
    this.#tell("guess");
  }

  /** Wheels whose cells take longer: the cells of this scene that were shown stay until then. */
  #wheelsOnly(geometry) {
    const { cells, edges, field } = this.foreign ? {} : this.geometry ?? {};
    this.geometry = { ...geometry, cells, edges, field };
    this.foreign = false;
  }

  #error({ message, key, part }) {
    this.error = { message, key: key ?? null };
    if (!part) this.status = "error";
  }

  /** Parts that did not come are not part of this scene (no tolerance, no comparison of systems). */
  #done() {
    this.finished = true;
    if (this.status === "error") return;
    if (this.stale.has("comparison")) this.comparison = null;
    if (this.stale.has("tolerance")) this.tolerance = null;
    if (this.stale.has("paths")) this.paths = [];
    this.stale.clear();
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
