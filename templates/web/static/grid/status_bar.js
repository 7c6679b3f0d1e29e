// The line below the sheet: how many rows and selected cells there are, and the way from problem to problem.

import { put } from "../elements.js";
import { t, tn } from "../texts.js";

export class StatusBar {
  constructor(grid) {
    this.grid = grid;
    this.counts = document.getElementById("counts");
    this.steps = document.getElementById("problem-steps");
    grid.table.grid.addEventListener("rrp:rows", () => this.soon());
    document.addEventListener("htmx:after:swap", () => this.soon());
    this.soon();
  }

  /** Count when nothing else is to be done: a key must not wait for it. */
  soon() {
    this.waiting ??= (window.requestIdleCallback ?? setTimeout)(() => {
      this.waiting = null;
      this.show();
    });
  }

  show() {
    const { table, selection } = this.grid;
    const rows = table.rows.length - table.room();
    const box = selection.box();
    const cells = box ? (box.bottom - box.top + 1) * (box.right - box.left + 1) : 1;
    const parts = [tn("{n} row", "{n} rows", { n: rows })];
    if (cells > 1) parts.push(tn("{n} cell selected", "{n} cells selected", { n: cells }));
    put(this.counts, parts.join(" · "));
    const { length } = this.flagged();
    this.steps.hidden = length === 0;
    put(this.steps.querySelector("span"), tn("{n} cell with problems", "{n} cells with problems", { n: length }));
  }

  flagged() {
    return [...this.grid.table.grid.querySelectorAll("td.flagged")];
  }

  /** To the next cell of the sheet with a problem, or the one before. */
  step(by) {
    const { table, selection } = this.grid;
    const found = this.flagged().filter((cell) => table.column(cell) >= 0);
    if (!found.length) {
      this.grid.say(t("There are no problems in this sheet."));
      return;
    }
    const FOLLOWING = Node.DOCUMENT_POSITION_FOLLOWING;
    const at = found.filter((cell) => cell.compareDocumentPosition(selection.cell) & FOLLOWING).length;
    const here = found[at] === selection.cell;
    const to = by > 0 ? at + (here ? 1 : 0) : at - 1;
    const cell = found[(to + found.length) % found.length];
    selection.go(cell.parentElement, table.column(cell));
  }
}
