// Find and replace in the sheet that is shown, with a list of what was found.

import { button, make, put } from "../elements.js";
import { t, tn } from "../texts.js";
import { key } from "./editor.js";

const RESTS_MS = 150; // after the last key, before the list is made
const MOST_LISTED = 100; // cells
const NAMES = /[\p{L}_][\p{L}\p{N}_]*/gu; // in a formula

export function finder(grid) {
  const { table } = grid;
  const bar = document.getElementById("find-bar");
  const { find, by, sameCase, whole, names } = bar.elements;
  const count = bar.querySelector(".found");
  const list = document.getElementById("found");
  let timer = 0;

  bar.addEventListener("submit", (event) => {
    event.preventDefault();
    next();
  });
  bar.addEventListener("input", ({ target }) => {
    clearTimeout(timer);
    if (target !== by) timer = setTimeout(show, RESTS_MS);
  });
  for (const part of [bar, list]) {
    part.addEventListener("keydown", (event) => {
      if (event.key === "Escape") close();
    });
  }
  bar.addEventListener("click", (event) => {
    const action = event.target.closest("[data-find]")?.dataset.find;
    if (action === "close") close();
    if (action === "one" && replaces()) {
      const { cell } = grid.selection;
      if (cell && has(cell)) grid.change([[cell, replaced(cell)]]);
      next();
      show();
    }
    if (action === "all" && replaces()) {
      const cells = hits();
      grid.change(cells.map((cell) => [cell, replaced(cell)]));
      grid.say(cells.length ? tn("Replaced in {n} cell.", "Replaced in {n} cells.", { n: cells.length }) : t("Not found."));
      show();
    }
  });
  table.grid.addEventListener("rrp:rows", () => {
    if (bar.hidden) return;
    clearTimeout(timer);
    timer = setTimeout(show, RESTS_MS);
  });

  const pattern = () => {
    const text = find.value.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
    return new RegExp(whole.checked ? `^${text}$` : text, sameCase.checked ? "gu" : "giu");
  };
  const hits = () => {
    const has = matcher();
    return table.shown.flatMap((row) => table.headers.map((_, k) => table.cell(row, k))).filter(has);
  };
  const has = (cell) => matcher()(cell);

  return { open };

  // what tells whether a cell is meant: a name is one of those between commas, or one in a formula
  function matcher() {
    if (!find.value) return () => false;
    if (!names.checked) {
      const found = pattern();
      return (cell) => table.value(cell).search(found) >= 0;
    }
    const wanted = key(find.value);
    const named = (text, isFormula) => (isFormula ? text.match(NAMES) ?? [] : text.split(/[,\n]/)).some((name) => key(name) === wanted);
    return (cell) => named(table.value(cell), table.headers[table.column(cell)].dataset.kind === "formula");
  }

  function replaces() {
    if (names.checked) grid.say(t("To change a name, use “Rename everywhere” in the menu of its cell."), true);
    return !names.checked;
  }

  function replaced(cell) {
    return table.value(cell).replace(pattern(), () => by.value);
  }

  function next() {
    const cells = hits();
    const here = grid.selection.cell;
    const found = cells.find((cell) => here.compareDocumentPosition(cell) & Node.DOCUMENT_POSITION_FOLLOWING) ?? cells[0];
    if (!found) {
      grid.say(t("Not found."));
      return;
    }
    go(found);
  }

  function go(cell) {
    grid.selection.go(cell.parentElement, table.column(cell), false, false);
    grid.say(t("Found in {cell}.", { cell: grid.bar.querySelector("b").textContent }));
  }

  function show() {
    const cells = hits();
    put(count, find.value ? tn("{n} cell", "{n} cells", { n: cells.length }) : "");
    list.hidden = !cells.length;
    list.replaceChildren(...cells.slice(0, MOST_LISTED).map((cell) => {
      const hit = button("", () => cell.isConnected && go(cell), "hit");
      hit.append(make("b", table.address(cell)), ` ${table.value(cell)}`);
      return make("li", {}, hit);
    }));
    if (cells.length > MOST_LISTED) list.append(make("li", t("… and {n} more", { n: cells.length - MOST_LISTED })));
  }

  function open() {
    bar.hidden = false;
    find.focus();
    find.select();
    show();
  }

  function close() {
    bar.hidden = true;
    list.hidden = true;
    grid.selection.cell?.focus({ preventScroll: true });
  }
}
