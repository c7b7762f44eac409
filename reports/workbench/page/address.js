// The address carries the scene: a link or a reload restores document, starts and time, compressed after the #.
// May be changed: what is carried. Old links must still open: bump VERSION and keep reading the former ones.

const VERSION = "1";
const PAUSE = 250; // milliseconds after the last change until the address is written: browsers limit how often
const LEFT = "nonsmooth-workbench-left"; // where a page that is left keeps its state, for this tab only
const RELOAD = 5000; // milliseconds that a reload may take: it asks for the address of the time when it began

/** The state as text for an address. */
export async function pack(state) {
  const bytes = new TextEncoder().encode(JSON.stringify(state));
  const packed = await through(new CompressionStream("deflate-raw"), bytes);
  const letters = Array.from(packed, (byte) => String.fromCharCode(byte)).join("");
  return `${VERSION}.${btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "")}`;
}

/** The state that such a text carries; null if it carries none. */
export async function unpack(text) {
  const [version, data] = text.split(".");
  if (version !== VERSION || !data) return null;
  try {
    const letters = atob(data.replaceAll("-", "+").replaceAll("_", "/"));
    const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
    const opened = await through(new DecompressionStream("deflate-raw"), bytes);
    const state = JSON.parse(new TextDecoder().decode(opened));
    return state && typeof state.document === "object" ? state : null;
  } catch {
    return null;
  }
}

async function through(transform, bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(transform);
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Keeps the address in step with the store, and the store with an address that is typed or followed. */
export class Address {
  constructor(store) {
    this.store = store;
    this.written = "";
    this.former = { address: "", until: 0 }; // before the last write
    store.addEventListener("change", () => this.#later());
    window.addEventListener("hashchange", () => this.#read());
    window.addEventListener("pagehide", () => this.#leave());
  }

  /** What a page that is loaded again was left with, else the state in the address; null if there is none. */
  static async opened() {
    const { addresses = [], state } = JSON.parse(window.sessionStorage.getItem(LEFT) ?? "{}");
    window.sessionStorage.removeItem(LEFT);
    const isAgain = performance.getEntriesByType("navigation")[0]?.type !== "navigate"; // a reload, or back and forth
    return isAgain && addresses.includes(window.location.hash) ? state : unpack(window.location.hash.slice(1));
  }

  #later() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.write(), PAUSE);
  }

  async write() {
    const packed = await pack(this.store.now);
    if (packed === this.written) return;
    this.written = packed;
    this.former = { address: window.location.hash, until: performance.now() + RELOAD };
    window.history.replaceState(null, "", `#${packed}`);
  }

  /** The last edit may not be in the address yet, or come there after a reload has begun. */
  #leave() {
    clearTimeout(this.timer);
    const addresses = [window.location.hash, ...(performance.now() < this.former.until ? [this.former.address] : [])];
    window.sessionStorage.setItem(LEFT, JSON.stringify({ addresses, state: this.store.now }));
  }

  async #read() {
    const hash = window.location.hash.slice(1);
    if (hash === this.written) return;
    const state = await unpack(hash);
    if (state) this.store.open(state.document, state.starts, state.until);
  }
}
