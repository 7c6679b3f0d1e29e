// Find and replace in the sheet that is shown.

import { t, tn } from "../texts.js";

export function finder(grid) {
  const bar = document.getElementById("find-bar");
  const { find, by } = bar.elements;

  bar.addEventListener("submit", (event) => {
    event.preventDefault();
    next();
  });
  bar.addEventListener("keydown", (event) => {
    if (event.key === "Escape") close();
  });
  bar.addEventListener("click", (event) => {
    const action = event.target.closest("[data-find]")?.dataset.find;
    if (action === "close") close();
    if (action === "one") {
      const { cell } = grid.selection;
      if (cell && has(cell)) grid.change([[cell, replaced(cell)]]);
      next();
    }
    if (action === "all") {
      const cells = all().filter(has);
      grid.change(cells.map((cell) => [cell, replaced(cell)]));
      grid.say(cells.length ? tn("Replaced in {n} cell.", "Replaced in {n} cells.", { n: cells.length }) : t("Not found."));
    }
  });

  const wanted = () => find.value.toLocaleLowerCase();
  const has = (cell) => wanted() !== "" && grid.table.value(cell).toLocaleLowerCase().includes(wanted());
  const all = () => [...grid.table.rows].flatMap((row) => grid.table.headers.map((_, k) => grid.table.cell(row, k)));

  return { open };

  function replaced(cell) {
    const pattern = new RegExp(find.value.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"), "giu");
    return grid.table.value(cell).replace(pattern, () => by.value);
  }

  function next() {
    const cells = all();
    const from = cells.indexOf(grid.selection.cell);
    const found = [...cells.slice(from + 1), ...cells.slice(0, from + 1)].find(has);
    if (!found) {
      grid.say(t("Not found."));
      return;
    }
    grid.selection.go(found.parentElement, grid.table.column(found), false, false);
    grid.say(t("Found in {cell}.", { cell: grid.bar.querySelector("b").textContent }));
  }

  function open() {
    bar.hidden = false;
    find.focus();
    find.select();
  }

  function close() {
    bar.hidden = true;
    grid.selection.cell?.focus({ preventScroll: true });
  }
}
