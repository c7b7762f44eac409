// What the page holds: the scene document, the start points, the selection; with undo and redo.
// The document is never changed in place, so the history is a list of references and undo is exact.
// May be changed: how many steps are kept, what else belongs to a step. The server is told by conversation.js.

const STEPS = 1000; // kept for undo; documents share what they do not change

/** How long paths are followed unless somebody says otherwise: bodies on wheels come to rest soon. */
export const usualTime = (document) => (document.system ? 10 : 3);

const isSame = (a, b) => JSON.stringify(a) === JSON.stringify(b);

export class Store extends EventTarget {
  constructor() {
    super();
    this.now = { document: {}, starts: [], until: 3 };
    this.selection = [];
    this.past = [];
    this.future = [];
    this.merging = null;
  }

  get document() {
    return this.now.document;
  }

  /** Whether a drag goes on, or whatever else is one step. */
  get isMerging() {
    return this.merging !== null;
  }

  /**
   * One step: `change` maps the present state to the next. Steps with the same `merge` key that follow each other
   * (a drag, a slider in motion) are one step of undo.
   */
  edit(change, { merge = null } = {}) {
    const next = { ...this.now, ...change(this.now) };
    if (isSame(next, this.now)) return;
    if (merge === null || merge !== this.merging) this.past.push(this.now);
    if (this.past.length > STEPS) this.past.shift();
    this.merging = merge;
    this.future = [];
    this.#become(next);
  }

  /** Ends a drag: the next edit begins a new step. */
  seal() {
    this.merging = null;
  }

  /** A scene that is opened is a step as well: undo goes back to the one before. */
  open(document, starts = [], until = usualTime(document)) {
    this.selection = [];
    if (isSame({ document, starts, until }, this.now)) return;
    this.dispatchEvent(new Event("open"));
    this.edit(() => ({ document, starts, until }));
    this.seal();
  }

  /** The first state, without history. */
  begin(state) {
    this.past = [];
    this.future = [];
    this.#become({ ...this.now, ...state });
  }

  undo() {
    this.#travel(this.past, this.future);
  }

  redo() {
    this.#travel(this.future, this.past);
  }

  #travel(from, to) {
    if (!from.length) return;
    to.push(this.now);
    this.merging = null;
    this.#become(from.pop());
  }

  #become(state) {
    this.now = state;
    const count = state.document.wheel?.length;
    if (count !== undefined) this.selection = this.selection.filter((k) => k < count);
    this.dispatchEvent(new Event("change"));
  }

  /** Selects wheels, counted from 0. */
  select(indices) {
    const sorted = [...new Set(indices)].sort((a, b) => a - b);
    if (sorted.join() === this.selection.join()) return;
    this.selection = sorted;
    this.dispatchEvent(new Event("select"));
  }
}
