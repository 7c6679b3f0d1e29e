// What is set in the menu of each page and remembered in this browser: less motion, where what moves by itself is still or goes in
// steps (the system may wish it too), and two keys, where Tab and Enter do everything. The document's `data-calm` and
// `data-two-keys` tell the style sheets.

const system = matchMedia("(prefers-reduced-motion: reduce)");
const wished = { calm: () => system.matches, twoKeys: () => false }; // by the system, whatever is set

/** True when nothing is to move by itself. */
export const hasCalm = () => has("calm");

/** True for who has two keys: Tab goes to what is next, Enter chooses it. */
export const hasTwoKeys = () => has("twoKeys");

function has(name) {
  try {
    return wished[name]() || localStorage.getItem(name) === "yes";
  } catch {
    return wished[name]();
  }
}

function show() {
  for (const name of Object.keys(wished)) {
    document.documentElement.dataset[name] = has(name) ? "yes" : "no";
    const box = document.querySelector(`[data-preference=${name}]`);
    if (!box) continue;
    box.checked = has(name);
    box.disabled = wished[name]();
  }
  document.dispatchEvent(new Event("rrp:preferences"));
}

show();
system.addEventListener("change", show);
window.addEventListener("storage", ({ key }) => key in wished && show()); // another page of this browser
document.addEventListener("change", ({ target }) => {
  const { preference } = target.dataset;
  if (!preference) return;
  localStorage.setItem(preference, target.checked ? "yes" : "no");
  show();
});

// the menu closes with Esc, and when one goes elsewhere
const menu = document.querySelector(".page-menu");
menu?.addEventListener("keydown", (event) => {
  if (event.key !== "Escape" || !menu.open) return;
  menu.open = false;
  menu.querySelector("summary").focus();
});
for (const event of ["pointerdown", "focusin"]) {
  document.addEventListener(event, ({ target }) => {
    if (menu?.open && !menu.contains(target)) menu.open = false;
  });
}
