// The menu of the rows: by the right mouse button, the menu key, or the button above the grid.

import { menuOf, walk } from "./menus.js";

const ITEMS = [
  ["Insert above", "Ctrl +", (grid) => grid.rows.insert()],
  ["Insert below", "", (grid) => grid.rows.insert(true)],
  ["Duplicate", "", (grid) => grid.rows.duplicate()],
  ["Move up", "Alt ↑", (grid) => grid.rows.move(-1)],
  ["Move down", "Alt ↓", (grid) => grid.rows.move(1)],
  ["Delete rows", "Ctrl −", (grid) => grid.rows.remove()],
  ["Fill down", "Ctrl D", (grid) => grid.fillDown()],
];

export function menu(grid) {
  const box = menuOf("Rows", ITEMS.map(([name, keys, action]) => [name, () => {
    close();
    action(grid);
  }, keys]));
  box.hidden = true;
  document.querySelector("main").append(box);
  const button = document.querySelector("[data-do=rows]");

  document.addEventListener("rrp:menu", (event) => {
    if (!grid.selection.head) return;
    box.hidden = false;
    button?.setAttribute("aria-expanded", "true");
    box.style.left = `${Math.min(event.detail.x, innerWidth - box.offsetWidth - 8)}px`;
    box.style.top = `${Math.min(event.detail.y, innerHeight - box.offsetHeight - 8)}px`;
    box.firstElementChild.focus();
  });
  box.addEventListener("keydown", (event) => walk(event, [...box.children], close));
  document.addEventListener("pointerdown", (event) => {
    if (!box.hidden && !box.contains(event.target)) close(false);
  });

  function close(focus = true) {
    box.hidden = true;
    button?.setAttribute("aria-expanded", "false");
    if (focus) grid.selection.cell?.focus({ preventScroll: true });
  }
}
