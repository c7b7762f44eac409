// The address carries the scene: a link or a reload restores document, starts and time, compressed after the #.
// May be changed: what is carried. Old links must still open: bump VERSION and keep reading the former ones.

const VERSION = "1";
const PAUSE = 250; // milliseconds after the last change until the address is written: browsers limit how often
const LEFT = "nonsmooth-workbench-left"; // where a page that is left before that keeps its state, for this tab only

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
    this.isWritten = true;
    store.addEventListener("change", () => this.#later());
    window.addEventListener("hashchange", () => this.#read());
    window.addEventListener("pagehide", () => this.#leave());
  }

  /** The state that this tab left at this address, or that in the address; null if there is none. */
  static async opened() {
    const { address, state } = JSON.parse(window.sessionStorage.getItem(LEFT) ?? "{}");
    window.sessionStorage.removeItem(LEFT);
    return state && address === window.location.hash ? state : unpack(window.location.hash.slice(1));
  }

  #later() {
    this.isWritten = false;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.write(), PAUSE);
  }

  async write() {
    const { now } = this.store;
    const packed = await pack(now);
    this.isWritten = now === this.store.now;
    if (packed === this.written) return;
    this.written = packed;
    window.history.replaceState(null, "", `#${packed}`);
  }

  /** What is not yet in the address: packing it takes longer than a page lives that is left. */
  #leave() {
    clearTimeout(this.timer);
    if (!this.isWritten) window.sessionStorage.setItem(LEFT, JSON.stringify({ address: window.location.hash, state: this.store.now }));
  }

  async #read() {
    const hash = window.location.hash.slice(1);
    if (hash === this.written) return;
    const state = await unpack(hash);
    if (state) this.store.open(state.document, state.starts, state.until);
  }
}
