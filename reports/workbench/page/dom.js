// Making and changing elements: a few helpers so that the other modules say what they show and not how.
// May be changed: add helpers that at least two modules need. Nothing here knows about arrays or the server.

const SVG = "http://www.w3.org/2000/svg";
const REST = 250; // milliseconds between two updates of fields in a drag

/** An HTML element with attributes and children; `on*` attributes that are functions become listeners. */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value != null) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child != null));
  return element;
}

/** An SVG element with attributes. */
export function s(tag, attributes = {}) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}

/** One of the symbols of index.html, as a picture that readers of the screen skip. */
export function icon(name) {
  const picture = s("svg", { class: "icon", "aria-hidden": "true" });
  picture.append(s("use", { href: `#i-${name}` }));
  return picture;
}

/** Sets an attribute only if it differs: the drawing calls this thousands of times in a frame. */
export function attr(element, name, value) {
  const seen = (element.seen ??= {});
  const text = String(value);
  if (seen[name] === text) return;
  seen[name] = text;
  element.setAttribute(name, text);
}

/** Exactly `count` children of one kind, reused from the last call: `make()` is called for new ones only. */
export function pool(parent, count, make) {
  while (parent.children.length > count) parent.lastElementChild.remove();
  while (parent.children.length < count) parent.append(make());
  return parent.children;
}

/** `work`, done once in the next frame however often it is asked for: a drag changes things faster than they show. */
export function onceAFrame(work) {
  let asked = false;
  return () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      work();
    });
  };
}

/** `work` in the next frame; while `isBusy` holds, after a pause at most: browsers take long over fields that change. */
export function sparingly(work, isBusy) {
  let timer;
  let last = 0;
  const soon = onceAFrame(() => {
    last = performance.now();
    work();
  });
  return () => {
    clearTimeout(timer);
    const wait = isBusy() ? last + REST - performance.now() : 0;
    if (wait > 0) timer = setTimeout(soon, wait);
    else soon();
  };
}

/** Replaces the text of an element only if it differs, so that screen readers are not told twice. */
export function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export const byId = (id) => document.getElementById(id);
