// A small menu beside what was pressed: with the arrow keys, by mouse and touch.

import { items } from "../commands.js";
import { hasTwoKeys } from "../preferences.js";
import { t } from "../texts.js";

/** Show a menu at an element; its items are buttons, already in it. The focus goes back to `back`. */
export function popup(box, at, back) {
  const buttons = [...box.querySelectorAll("[role=menuitem]")];
  const place = at.getBoundingClientRect();
  const before = at.ariaExpanded;
  box.hidden = false;
  box.style.left = `${Math.max(8, Math.min(place.left, innerWidth - box.offsetWidth - 8))}px`;
  box.style.top = `${Math.max(8, place.top - box.offsetHeight)}px`;
  if (place.top - box.offsetHeight < 8) box.style.top = `${Math.min(place.bottom, innerHeight - box.offsetHeight - 8)}px`;
  at.ariaExpanded = "true";
  buttons[0]?.focus();
  const away = new AbortController();
  const { signal } = away;
  box.addEventListener("keydown", (event) => walk(event, buttons, close), { signal });
  box.addEventListener("click", (event) => event.target.closest("[role=menuitem]") && close(false), { signal });
  document.addEventListener("pointerdown", (event) => box.contains(event.target) || close(false), { signal });

  function close(focus = true) {
    away.abort();
    box.hidden = true;
    at.ariaExpanded = before;
    if (focus) back?.focus({ preventScroll: true });
  }
}

/** A menu of its own: `[name, action]` pairs, with a hint of keys as a third where there are some; null for a line between two. */
export function menuOf(label, entries) {
  const box = document.createElement("div");
  box.className = "menu";
  box.setAttribute("role", "menu");
  box.setAttribute("aria-label", label);
  for (const entry of entries) {
    if (!entry) {
      box.append(document.createElement("hr"));
      continue;
    }
    const [name, action, keys = ""] = entry;
    const item = document.createElement("button");
    item.type = "button";
    item.setAttribute("role", "menuitem");
    item.tabIndex = -1;
    const hint = document.createElement("kbd");
    hint.textContent = keys;
    item.append(name, hint);
    item.addEventListener("click", action);
    box.append(item);
  }
  return box;
}

/** The keys of an open menu: arrows, Home and End go through its items, Escape and Tab close it. */
function walk(event, buttons, close) {
  const now = buttons.indexOf(document.activeElement);
  const next = hasTwoKeys() && !event.shiftKey && now + 1 < buttons.length ? { Tab: now + 1 } : {};
  const to = { ...next, ArrowDown: now + 1, ArrowUp: now - 1, Home: 0, End: buttons.length - 1 }[event.key];
  if (to !== undefined) buttons[(to + buttons.length) % buttons.length].focus();
  else if (event.key === "Escape" || event.key === "Tab") close();
  else return;
  event.preventDefault();
  event.stopPropagation();
}

// The menu of cells or rows: by the right mouse button, the menu key, or the button above the grid.

export function menu(grid) {
  const button = document.querySelector("[data-do=rows]");
  let box = null;
  document.addEventListener("pointerdown", (event) => {
    if (box && !box.contains(event.target)) close(false);
  });

  function open(x, y, name = "cell") {
    if (!grid.selection.head) return;
    close(false);
    const entries = items(name, grid).map((item) => item && [item[0], () => {
      close();
      item[1]();
    }, item[2]]);
    box = menuOf({ cell: t("Cells and rows"), rows: t("Rows"), head: t("Column") }[name], entries);
    box.addEventListener("keydown", (event) => walk(event, [...box.querySelectorAll("button")], close));
    document.querySelector("main").append(box);
    button?.setAttribute("aria-expanded", "true");
    box.style.left = `${Math.max(8, Math.min(x, innerWidth - box.offsetWidth - 8))}px`;
    box.style.top = `${Math.max(8, Math.min(y, innerHeight - box.offsetHeight - 8))}px`;
    box.firstElementChild.focus();
  }

  function close(focus = true) {
    box?.remove();
    box = null;
    button?.setAttribute("aria-expanded", "false");
    if (focus) grid.selection.cell?.focus({ preventScroll: true });
  }

  return {
    open,
    below(at) {
      const { left, bottom } = at.getBoundingClientRect();
      open(left, bottom, "rows");
    },
  };
}
