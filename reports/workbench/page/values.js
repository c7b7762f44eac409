// Numbers as a scene document holds them: JSON numbers (decimals) or formulas as text; and how they are shown.
// May be changed: how floats are rounded for reading. What is exact must stay exact: a text that is not a plain
// short decimal is passed on as it was typed, and Python reads it.

const PLAIN = /^-?(0|[1-9]\d{0,11})(\.\d{1,12})?$/;

/** What was typed into a field, as a value of the document; undefined for an empty field. */
export function fromText(text) {
  const typed = text.trim();
  if (typed === "") return undefined;
  if (PLAIN.test(typed) && String(Number(typed)) === typed) return Number(typed);
  return typed;
}

/** A value of the document as a field shows it. */
export function toText(value) {
  if (value === undefined || value === null) return "";
  if (Array.isArray(value)) return `[${value.map(toText).join(", ")}]`;
  return String(value);
}

/** A heading as typed: a word, an angle, or a direction `[a, b]` (each a number or a formula). */
export function headingFromText(text) {
  const typed = text.trim();
  if (!(typed.startsWith("[") && typed.endsWith("]"))) return fromText(typed);
  return splitAtCommas(typed.slice(1, -1)).map((part) => (part.trim().startsWith("[") ? headingFromText(part) : fromText(part) ?? ""));
}

/** Splits at commas that stand in no bracket. */
function splitAtCommas(text) {
  const parts = [""];
  let depth = 0;
  for (const letter of text) {
    if ("([".includes(letter)) depth += 1;
    if (")]".includes(letter)) depth -= 1;
    if (letter === "," && depth === 0) parts.push("");
    else parts[parts.length - 1] += letter;
  }
  return parts;
}

/** Nearest multiple of the step, as a decimal of as few digits as the step has. */
export function roundTo(value, step) {
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) + (String(step).includes("5") ? 1 : 0);
  return Number((Math.round(value / step) * step).toFixed(Math.min(digits, 12))) + 0;
}

/** The smallest of 1, 2, 5 times a power of ten that is at least the bound. */
export function niceStep(bound) {
  const power = 10 ** Math.floor(Math.log10(bound));
  const factor = [1, 2, 5, 10].find((k) => k * power >= bound * 0.999999);
  return Number((factor * power).toPrecision(1));
}

/** A float for reading: three digits, a true minus sign. */
export function shown(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const rounded = Number(value.toPrecision(digits));
  const size = Math.abs(rounded);
  const text = size !== 0 && (size >= 1e5 || size < 1e-4) ? rounded.toExponential() : String(rounded);
  return text.replace("-", "\u2212");
}
