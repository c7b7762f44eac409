// Pure edits of a scene document: each function returns a new document and leaves the given one as it is.
// May be changed: which simple edits the page makes itself. What needs exact mathematics (mirror, rotate, snap,
// expanding a ring into wheels) is asked of Python, see operations.js.

/** The value at a path such as ["wheel", 2, "position", 0]; undefined where something on the way is missing. */
export function valueAt(document, path) {
  return path.reduce((value, key) => (value === undefined || value === null ? undefined : value[key]), document);
}

/** The document with another value at the path; undefined removes the key, and tables that end up empty. */
export function withValue(document, path, value) {
  const [key, ...rest] = path;
  const inner = rest.length ? withValue(document?.[key] ?? (typeof rest[0] === "number" ? [] : {}), rest, value) : value;
  if (Array.isArray(document)) return document.map((old, k) => (k === key ? inner : old));
  const others = { ...document };
  if (inner === undefined || isEmptyTable(inner)) delete others[key];
  else others[key] = inner;
  return others;
}

function isEmptyTable(value) {
  return value !== null && typeof value === "object" && !Array.isArray(value) && Object.keys(value).length === 0;
}

/** Whether this is a plain switched system and not an array. */
export const isSystem = (document) => Boolean(document?.system);

/** Whether the wheels are written as a ring or a grid, so that Python must write them out before one is edited. */
export const needsExpansion = (document) => !isSystem(document) && !document.wheel;

/** The document with some keys of one wheel changed; wheels are counted from 0 here. */
export function withWheel(document, index, change) {
  const wheel = document.wheel.map((old, k) => (k === index ? { ...old, ...change } : old));
  return { ...document, wheel };
}

/** The document with wheels at other places: a map from index to [x, y]. */
export function withPositions(document, places) {
  const wheel = document.wheel.map((old, k) => (places.has(k) ? { ...old, position: places.get(k) } : old));
  return { ...document, wheel };
}

/** A wheel that names a heading must name its speed too, or it would run at 1. */
export function withHeading(document, index, heading, speed) {
  const old = document.wheel[index];
  const keep = old.speed === undefined && speed !== undefined && speed !== 1 ? { speed } : {};
  return withWheel(document, index, { heading, ...keep });
}

/** The unit of a length, a speed or a time, as the scene states it; empty where it states none. */
export function unitOf({ units }, kind) {
  if (kind === "angle") return units?.angle ?? (units?.length ? "deg" : "");
  if (!units?.length) return "";
  return { length: units.length, speed: units.speed ?? `${units.length}/s`, time: "s" }[kind] ?? "";
}
