// The line below the sheet: how many rows and selected cells there are, and the way from problem to problem.

import { put } from "../elements.js";
import { t, tn } from "../texts.js";

const LATEST_MS = 500; // a busy browser has no idle moment for long

export class StatusBar {
  constructor(grid) {
    this.grid = grid;
    this.counts = document.getElementById("counts");
    this.steps = document.getElementById("problem-steps");
    this.filtered = document.getElementById("filtered");
    grid.table.grid.addEventListener("rrp:rows", () => this.soon());
    document.addEventListener("htmx:after:swap", () => this.soon());
    this.soon();
  }

  /** Count when nothing else is to be done: a key must not wait for it. */
  soon() {
    this.waiting ??= (window.requestIdleCallback ?? setTimeout)(() => {
      this.waiting = null;
      this.show();
    }, { timeout: LATEST_MS });
  }

  show() {
    const { filter, selection } = this.grid;
    const { n, rows } = filter.counts();
    const cells = selection.painted.length;
    const parts = [filter.active ? t("{n} of {rows} rows shown", { n, rows }) : tn("{n} row", "{n} rows", { n: rows })];
    if (selection.adding) parts.push(t("Add to selection"));
    if (cells > 1) parts.push(tn("{n} cell selected", "{n} cells selected", { n: cells }));
    put(this.counts, parts.join(" · "));
    this.filtered.hidden = !filter.active;
    this.filtered.querySelector("[data-do=filterAgain]").hidden = !filter.isOld;
    const { length } = this.flagged();
    this.steps.querySelector("[data-do=onlyProblems]").hidden = filter.problems;
    this.steps.hidden = length === 0;
    put(this.steps.querySelector("span"), tn("{n} cell with problems", "{n} cells with problems", { n: length }));
  }

  flagged() {
    return [...this.grid.table.grid.querySelectorAll("td.flagged:not(.is-info)")];
  }

  /** To the next cell of the sheet with a problem, or the one before. */
  step(by) {
    const { table, selection } = this.grid;
    const all = this.flagged().filter((cell) => table.column(cell) >= 0);
    const found = all.filter((cell) => !table.hidden.has(cell.parentElement.id));
    if (!found.length) {
      this.grid.say(all.length ? t("The filter hides the rows with problems.") : t("There are no problems in this sheet."), all.length > 0);
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
