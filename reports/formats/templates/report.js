"use strict";
(() => {
  const about = (element) => (element.dataset.about || "").split(" ").filter(Boolean);
  const marked = () => document.querySelectorAll("[data-about]");

  // There is room for the contents beside the report, not above it.
  if (matchMedia("(min-width: 70rem)").matches) document.querySelector("nav details").open = true;

  // What is about the same cell lights up together, under the pointer or the keyboard.
  const light = (marks) => {
    for (const element of marked()) {
      element.classList.toggle("lit", about(element).some((mark) => marks.includes(mark)));
    }
  };
  let chosen = [];
  const follow = (event) => {
    const near = event.target.closest("[data-about]:not(section), section[data-about]") || event.target.querySelector(":scope > [data-about]");
    light(near ? about(near) : chosen);
  };
  document.addEventListener("pointerover", follow);
  document.addEventListener("focusin", follow);
  document.addEventListener("pointerleave", () => light(chosen));

  // The slider of a figure shows one of its frames.
  for (const figure of document.querySelectorAll("figure.framed")) {
    const box = figure.querySelector(".slider");
    const input = box.querySelector("input");
    const output = box.querySelector("output");
    const labels = [...box.querySelectorAll("li")];
    const pieces = figure.querySelectorAll("[data-frame]");
    const show = () => {
      for (const piece of pieces) piece.classList.toggle("later", piece.dataset.frame !== input.value);
      const label = labels[Number(input.value)];
      output.textContent = label.textContent;
      input.setAttribute("aria-valuetext", label.textContent);
      chosen = [label.dataset.mark];
      light(chosen);
    };
    input.addEventListener("input", show);
    for (const [number, label] of labels.entries()) {
      for (const row of document.querySelectorAll(`tr[data-about~="${label.dataset.mark}"]`)) {
        row.addEventListener("click", () => { input.value = String(number); show(); });
      }
    }
    box.hidden = false;
  }

  // On wide screens a copy of the first map with links stays in sight beside the text.
  const link = document.querySelector("figure svg a [data-about]");
  if (link) {
    const copy = link.closest("svg").cloneNode(true);
    const own = (name) => `companion-${name}`;
    for (const element of [copy, ...copy.querySelectorAll("*")]) {
      if (element.id) element.id = own(element.id);
      const href = element.getAttribute("href");
      if (href && element.localName !== "a") element.setAttribute("href", `#${own(href.slice(1))}`);
      const clip = element.getAttribute("clip-path");
      if (clip) element.setAttribute("clip-path", clip.replace("#", `#${own("")}`));
    }
    for (const element of copy.querySelectorAll("a")) element.setAttribute("tabindex", "-1");
    copy.setAttribute("aria-hidden", "true");
    const companion = document.getElementById("companion");
    companion.append(copy);
    companion.hidden = false;
  }

  // Contents start closed on small screens.
  const contents = document.querySelector("nav details");
  if (window.matchMedia("(max-width: 69.99rem)").matches) contents.open = false;
})();
