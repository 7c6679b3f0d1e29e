// The looks of cells: bold, a fill, and whether long texts are broken into lines. They are kept in the .xlsx file.

import { t } from "../texts.js";
import { menuOf, popup } from "./menus.js";

const FILLS = [["yellow", t("Yellow")], ["green", t("Green")], ["blue", t("Blue")], ["red", t("Red")], ["purple", t("Purple")], ["grey", t("Grey")], ["", t("No fill")]];

export class Looks {
  constructor(grid) {
    this.grid = grid;
  }

  bold() {
    this.toggle("bold", "bold", false);
  }

  wrap() {
    this.toggle("wrap", "unwrapped", true);
  }

  /** Turn something on in all selected cells, or off when they all have it; `inverse`: the class is of cells without it. */
  toggle(name, className, inverse) {
    const cells = this.grid.selection.cells().flat();
    const on = !cells.every((cell) => cell.classList.contains(className) !== inverse);
    this.set({ [name]: on }, (cell) => cell.classList.toggle(className, on !== inverse));
  }

  /** Ask for a fill in a small menu at the cell. */
  choose() {
    const { cell } = this.grid.selection;
    if (!cell || this.grid.refuses()) return;
    const box = menuOf(t("Fill colour"), FILLS.map(([name, label]) => [label, () => {
      this.set({ fill: name }, (one) => tint(one, name));
      this.grid.selection.cell?.focus({ preventScroll: true });
    }]));
    for (const [i, item] of [...box.children].entries()) item.classList.add("swatch", `tint-${FILLS[i][0] || "none"}`);
    document.querySelector("main").append(box);
    popup(box, cell, cell);
    new MutationObserver((_, watch) => {
      if (!box.hidden) return;
      watch.disconnect();
      box.remove();
    }).observe(box, { attributeFilter: ["hidden"] });
  }

  /** Send a look of the selected cells; `show` shows it in one. */
  set(look, show) {
    const { grid } = this;
    if (grid.held.takes(() => this.set(look, show)) || grid.refuses()) return;
    const before = grid.selection.cells().flat().map((cell) => [cell, cell.className]);
    for (const [cell] of before) show(cell);
    const cells = before.map(([cell]) => ({ row: cell.parentElement.id, column: grid.table.sheetColumn(grid.table.column(cell)) }));
    const answer = grid.server.send("look", { ...look, cells }, [...new Set(cells.map(({ row }) => row))]);
    answer.then(({ message }) => {
      if (message) for (const [cell, classes] of before) cell.className = classes;
    }, () => {});
  }
}

function tint(cell, name) {
  for (const [one] of FILLS) if (one) cell.classList.toggle(`tint-${one}`, one === name);
}
