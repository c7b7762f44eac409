// Start points as handles, their Filippov paths with the events, and the body at the time that is played.
// May be changed: marks of events, sizes. Poses between the times that Python gave are interpolated, nothing more.

import { attr, pool, s, say } from "./dom.js";

export const TURN_HANDLE = 26; // pixels from a start to the knob that turns it
const EVENTS = { // forms, since colour alone must not tell them apart
  slide: "M0 -5L5 0L0 5L-5 0Z",
  cross: "M-3.4 -3.4L3.4 3.4M-3.4 3.4L3.4 -3.4",
  rest: "M-5 -5h10v10h-10Z",
  other: "M-3.5 0a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0 -7 0",
};

/** Which form an event has. */
export function eventForm(kind = "") {
  if (/slid|enter/.test(kind)) return "slide";
  if (/rest|arriv|end|stop|equilib/.test(kind)) return "rest";
  if (/cross|switch|leav/.test(kind)) return "cross";
  return "other";
}

/** The pose [x, y, theta] of a path at a time. */
export function poseAt(path, time) {
  const { times, x, y, theta } = path;
  const last = times.length - 1;
  if (last < 0) return path.start;
  if (time >= times[last]) return [x[last], y[last], theta?.[last] ?? 0];
  let [low, high] = [0, last];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  const share = times[high] > times[low] ? Math.max(0, (time - times[low]) / (times[high] - times[low])) : 0;
  const between = (values) => values[low] + share * (values[high] - values[low]);
  return [between(x), between(y), theta ? between(theta) : 0];
}

export function drawPaths(layer, view, paths) {
  const drawn = pool(layer, paths.length, () => s("path"));
  paths.forEach((path, k) => {
    attr(drawn[k], "d", view.path(path.x.map((x, i) => [x, path.y[i]])));
    attr(drawn[k], "class", `path tone-${k % 6}`);
  });
}

export function drawEvents(layer, view, paths) {
  const all = paths.flatMap((path, k) => (path.events ?? []).filter((e) => Number.isFinite(e.x)).slice(0, 60).map((event) => ({ ...event, k })));
  const drawn = pool(layer, all.length, () => {
    const mark = s("path");
    mark.append(s("title"));
    return mark;
  });
  all.forEach((event, k) => {
    const [px, py] = view.at(event.x, event.y);
    attr(drawn[k], "transform", view.mark(px, py));
    attr(drawn[k], "d", EVENTS[eventForm(event.kind)]);
    attr(drawn[k], "class", `event ${eventForm(event.kind)} tone-${event.k % 6}`);
    say(drawn[k].firstChild, `${event.text ?? event.kind} (t = ${Number(event.time).toPrecision(4)})`);
  });
}

/** Handles of the starts; `turns` says whether a start has a heading that can be turned. */
export function drawStarts(layer, view, starts, active, turns) {
  const drawn = pool(layer, starts.length, () => {
    const mark = s("g");
    mark.append(s("circle", { class: "grip", r: 20 }), s("path", { class: "stem" }), s("circle", { class: "knob", r: 6 }), s("circle", { class: "start-disc", r: 10 }), s("text", { dy: "0.35em" }));
    return mark;
  });
  starts.forEach(([x, y, theta = 0], k) => {
    const [px, py] = view.at(x, y);
    const [, stem, knob, disc, text] = drawn[k].children;
    const [tx, ty] = [TURN_HANDLE * Math.cos(theta), -TURN_HANDLE * Math.sin(theta)];
    attr(drawn[k], "transform", view.mark(px, py));
    attr(drawn[k], "class", `start tone-${k % 6}${k === active ? " active" : ""}`);
    for (const part of [drawn[k].firstChild, disc, text]) attr(part, "data-start", k);
    attr(stem, "d", turns ? `M0 0L${tx.toFixed(1)} ${ty.toFixed(1)}` : "");
    attr(knob, "cx", tx.toFixed(1));
    attr(knob, "cy", ty.toFixed(1));
    attr(knob, "data-turn", k);
    attr(knob, "visibility", turns ? "inherit" : "hidden");
    say(text, String(k + 1));
  });
}

/** The outline of the body, at the checked pose and at the poses of the paths at the played time. */
export function drawBodies(layer, view, { outline, square, paths, time, isArray }) {
  const poses = time === null ? [] : paths.map((path) => poseAt(path, time));
  const marks = [...(outline ? [{ pose: null, k: -1 }] : []), ...poses.map((pose, k) => ({ pose, k }))];
  const drawn = pool(layer, marks.length, () => s("path"));
  marks.forEach(({ pose, k }, number) => {
    attr(drawn[number], "class", pose ? `moving-body tone-${k % 6}` : "body-outline");
    attr(drawn[number], "d", pose ? moved(view, outline, square, pose, isArray) : view.path(outline, true));
  });
}

/** The outline carried to a pose; without an outline a mark of fixed size with a line that shows the heading. */
function moved(view, outline, square, [x, y, theta], isArray) {
  const [px, py] = view.at(x, y);
  const [c, n] = [Math.cos(theta), Math.sin(theta)];
  const nose = isArray ? `M${px.toFixed(1)} ${py.toFixed(1)}L${(px + 18 * c).toFixed(1)} ${(py - 18 * n).toFixed(1)}` : "";
  if (!outline || !square) return `M${(px - 9).toFixed(1)} ${py.toFixed(1)}a9 9 0 1 0 18 0a9 9 0 1 0 -18 0${nose}`;
  const carried = outline.map(([a, b]) => [a - square.x, b - square.y]).map(([a, b]) => [x + c * a - n * b, y + n * a + c * b]);
  return view.path(carried, true) + nose;
}
