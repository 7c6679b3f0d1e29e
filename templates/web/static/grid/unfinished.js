// A row that is being typed does not scold: its problems are small dots until the row is left, or nothing was typed for a
// while.

const PATIENCE = 6000; // milliseconds without a key

export class Unfinished {
  constructor(grid) {
    this.grid = grid;
    this.row = null;
    grid.table.grid.addEventListener("rrp:rows", () => this.mark());
    grid.scroll.addEventListener("keydown", () => this.row && this.wait());
    document.addEventListener("htmx:after:swap", () => this.mark());
  }

  /** Something was typed into a row. */
  typed(row) {
    if (this.row && this.row !== row) this.finish();
    this.row = row;
    this.mark();
    this.wait();
  }

  /** The cursor stands in a row. */
  at(row) {
    if (this.row && this.row !== row) this.finish();
  }

  wait() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => (this.grid.editor.isOpen ? this.wait() : this.finish(true)), PATIENCE);
  }

  finish(tell = false) {
    clearTimeout(this.timer);
    const row = this.grid.table.row(this.row);
    this.row = null;
    this.mark();
    if (!row) return;
    row.classList.remove("unfinished");
    for (const cell of row.cells) {
      if (cell.dataset.invalid) cell.setAttribute("aria-invalid", cell.dataset.invalid);
      delete cell.dataset.invalid;
    }
    if (tell && row.querySelector(".mend:not(.is-info)")) this.grid.spoken.moved();
  }

  mark() {
    const row = this.row && this.grid.table.row(this.row);
    if (row) {
      row.classList.add("unfinished");
      for (const cell of row.querySelectorAll("[aria-invalid]")) {
        cell.dataset.invalid = cell.getAttribute("aria-invalid");
        cell.removeAttribute("aria-invalid");
      }
    }
    for (const link of document.querySelectorAll(".problem-list a[data-row]")) {
      link.closest("li").classList.toggle("unfinished", Boolean(this.row) && link.dataset.row === this.row);
    }
  }
}
