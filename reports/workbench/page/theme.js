// Light and dark: as the system has it, or as chosen here; the choice is kept in this browser.
// May be changed: nothing but the order of the choices. Colours are in tokens.css.

const KEY = "nonsmooth-workbench-theme";
const dark = window.matchMedia("(prefers-color-scheme: dark)");

export function startTheme(button) {
  apply(window.localStorage.getItem(KEY));
  button.addEventListener("click", () => {
    const next = isDark() ? "light" : "dark";
    const own = next === (dark.matches ? "dark" : "light") ? null : next; // the same as the system's: follow it again
    if (own) window.localStorage.setItem(KEY, own);
    else window.localStorage.removeItem(KEY);
    apply(own);
    label(button);
  });
  dark.addEventListener("change", () => label(button));
  label(button);
}

const isDark = () => (document.documentElement.dataset.theme ?? (dark.matches ? "dark" : "light")) === "dark";

function apply(theme) {
  if (theme === "light" || theme === "dark") document.documentElement.dataset.theme = theme;
  else delete document.documentElement.dataset.theme;
}

function label(button) {
  const text = isDark() ? "Light theme" : "Dark theme";
  button.setAttribute("aria-label", text);
  button.title = text;
  button.querySelector("use").setAttribute("href", isDark() ? "#i-light" : "#i-dark");
}
