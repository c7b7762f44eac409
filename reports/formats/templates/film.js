"use strict";
(() => {
  const film = JSON.parse(document.getElementById("film").textContent);
  const last = film.times.length - 1;
  const find = (selector) => [...document.querySelectorAll(selector)];
  const [body, marker] = ["body", "marker"].map((id) => document.getElementById(id));
  const [play, scrubber, time, carrying] = ["play", "scrubber", "time", "carrying"].map((id) => document.getElementById(id));
  const [rings, slips, speeds] = [".ring", ".slip", ".speed"].map((name) => find(`#picture ${name}`));
  const cells = find("tbody tr").map((row) => [...row.querySelectorAll("td")]);
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const names = ["", "slips", "sticks"];
  let shown = 0, running = 0, started = 0;

  // An arrow from a point along a vector, as the outline of a path; nothing where it is too short to be seen.
  const arrow = (x, y, vector) => {
    const size = vector ? Math.hypot(...vector) : 0;
    if (size < 1) return "";
    const [a, b] = [vector[0] / size, vector[1] / size];
    const head = Math.min(film.head, size), half = head / 2.4, neck = size - head;
    const at = (along, across) => `${(x + along * a - across * b).toFixed(1)} ${(y + along * b + across * a).toFixed(1)}`;
    return `M${at(0, 0)}L${at(neck, 0)}M${at(neck, half)}L${at(size, 0)}L${at(neck, -half)}Z`;
  };
  const point = (path, vector) => path.setAttribute("d", arrow(+path.dataset.x, +path.dataset.y, vector));
  const text = (value) => `t = ${value.toPrecision(4)}${film.unit ? " " + film.unit : ""}`;

  const show = (k) => {
    shown = Math.min(Math.max(k, 0), last);
    const [x, y, turn] = film.poses[shown], contacts = film.contacts[shown];
    for (const group of [body, marker]) group.setAttribute("transform", `translate(${x} ${y}) rotate(${turn})`);
    const now = film.speeds[Math.min(shown, film.speeds.length - 1)];
    contacts.forEach((kind, wheel) => {
      rings[wheel].setAttribute("class", `ring ${names[kind]}`);
      slips[wheel].setAttribute("class", kind ? "slip" : "slip idle");
      point(slips[wheel], film.slips[shown][wheel]);
      point(speeds[wheel], now[wheel]);
      if (cells.length) [film.words[kind], ...film.values[shown][wheel]].forEach((word, k) => { cells[wheel][k].textContent = word; });
    });
    scrubber.value = shown;
    time.textContent = text(film.times[shown]);
    scrubber.setAttribute("aria-valuetext", time.textContent);
    const carry = film.wheels.filter((_, wheel) => contacts[wheel]);
    carrying.textContent = carry.length > 12 ? `${carry.length} wheels carry the body` : `the body is carried by wheel${carry.length > 1 ? "s" : ""} ${carry.join(", ")}`;
  };

  const label = () => { play.textContent = running ? "Pause" : still.matches ? "Next" : shown === last ? "Again" : "Play"; };
  const stop = () => { cancelAnimationFrame(running); running = 0; label(); };
  const step = (now) => {
    show(Math.round(((now - started) / 1000 / film.seconds) * last));
    running = shown === last ? 0 : requestAnimationFrame(step);
    if (!running) label();
  };
  const start = () => {
    if (shown === last) show(0);
    started = performance.now() - (shown / last) * film.seconds * 1000;
    running = requestAnimationFrame(step);
    label();
  };
  // Where motion is not wanted the button goes on by steps: to the next event, or by a tenth of the way.
  const next = () => {
    const stops = [...film.events, ...Array.from({length: 11}, (_, k) => k / 10)].map((share) => Math.round(share * last));
    const after = stops.filter((k) => k > shown);
    show(after.length ? Math.min(...after) : 0);
    label();
  };

  play.addEventListener("click", () => (running ? stop() : still.matches ? next() : last && start()));
  still.addEventListener("change", stop);
  scrubber.addEventListener("input", () => { const k = +scrubber.value; stop(); show(k); label(); });
  for (const button of find("button.event")) {
    button.addEventListener("click", () => { stop(); show(Math.round(button.dataset.share * last)); label(); });
  }
  document.querySelector(".controls").hidden = false;
  show(0);
  label();
})();
