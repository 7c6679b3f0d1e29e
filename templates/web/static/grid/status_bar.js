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
    const { errors, warnings } = this.flagged();
    const length = errors.length + warnings.length;
    this.steps.querySelector("[data-do=onlyProblems]").hidden = filter.problems;
    this.steps.hidden = length === 0;
    const place = (all) => ({ n: all.indexOf(selection.cell) + 1, count: all.length });
    put(this.steps.querySelector("span"), errors.includes(selection.cell) ? t("Error {n} of {count}", place(errors))
      : warnings.includes(selection.cell) ? t("Warning {n} of {count}", place(warnings))
        : tn("{n} cell with problems", "{n} cells with problems", { n: length }));
  }

  /** The cells with errors and those with warnings alone, each in the order of the sheet. */
  flagged() {
    const [errors, warnings] = ["error", "warning"].map((kind) => [...this.grid.table.grid.querySelectorAll(`td.flagged.is-${kind}`)]);
    return { errors, warnings };
  }

  /** To the next cell of the sheet with a problem, or the one before: through the errors, then through the warnings. */
  step(by) {
    const { table, selection } = this.grid;
    const { errors, warnings } = this.flagged();
    const all = [...errors, ...warnings].filter((cell) => table.column(cell) >= 0);
    const found = all.filter((cell) => !table.hidden.has(cell.parentElement.id));
    if (!found.length) {
      this.grid.say(all.length ? t("The filter hides the rows with problems.") : t("There are no problems in this sheet."), all.length > 0);
      return;
    }
    let at = found.indexOf(selection.cell);
    if (at < 0) { // from elsewhere to an error, if there is one
      const first = found.filter((cell) => errors.includes(cell));
      const near = first.length ? first : found;
      const above = near.filter((cell) => cell.compareDocumentPosition(selection.cell) & Node.DOCUMENT_POSITION_FOLLOWING).length;
      at = by > 0 ? (above % near.length) - 1 : above || near.length;
    }
    const cell = found[(at + by + found.length) % found.length];
    selection.go(cell.parentElement, table.column(cell));
  }
}
