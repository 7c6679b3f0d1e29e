// The table that the server rendered, as the other modules see it: rows with ids that stay, and editable columns
// counted from 0 (`data-c` on a header is the sheet's own column number).

const BODY = 50; // rows of a body; the browser leaves out the bodies that are out of sight

export class Table {
  constructor(grid) {
    this.grid = grid;
    this.first = Number(grid.dataset.first); // the number of its first row: the header is above it
    this.headers = [...grid.tHead.rows[0].cells].filter((h) => h.dataset.c);
    this.places = this.headers.map((h) => h.cellIndex);
    this.width = this.headers.length;
    this.kind = /\bof-(\w+)/.exec(grid.className)?.[1] ?? "";
    this.off = new Set(grid.dataset.off?.split(" ")); // the words that switch a row off
  }

  /** All rows, from top to bottom. */
  get rows() {
    this.all ??= [...this.grid.querySelectorAll(":scope > tbody > tr")];
    return this.all;
  }

  row(id) {
    return document.getElementById(id);
  }

  /** The cell of a row in an editable column. */
  cell(row, k) {
    return row?.cells[this.places[k]];
  }

  /** The place of a cell among the editable columns; -1 in a read-only one. */
  column(cell) {
    return this.places.indexOf(cell.cellIndex);
  }

  sheetColumn(k) {
    return Number(this.headers[k].dataset.c);
  }

  /** The place among the editable columns of a column of the sheet; -1 for another one. */
  placeOf(sheetColumn) {
    return this.headers.findIndex((header) => Number(header.dataset.c) === sheetColumn);
  }

  /** The first editable column of a kind, or -1. */
  ofKind(kind) {
    return this.headers.findIndex((header) => header.dataset.kind === kind);
  }

  /** The header over a column; its letter where it has none. */
  name(k) {
    return this.headers[k].dataset.name || this.headers[k].dataset.letter;
  }

  /** A cell's address, such as C4. */
  address(cell) {
    return `${this.headers[this.column(cell)].dataset.letter}${cell.parentElement.cells[0].textContent}`;
  }

  /** The text of a cell, as it was typed. */
  value(cell) {
    return cell?.dataset.v ?? "";
  }

  /** A new blank row, as the server makes it. */
  blank(id) {
    const row = document.createElement("tr");
    row.id = id;
    row.setAttribute("role", "row");
    const head = document.createElement("th");
    head.className = "number";
    head.scope = "row";
    head.setAttribute("role", "rowheader");
    row.append(head, ...[...this.grid.tHead.rows[0].cells].slice(1).map((header) => {
      const cell = document.createElement("td");
      cell.setAttribute("role", "gridcell");
      cell.className = header.dataset.kind ?? "example";
      if (header.dataset.c) cell.tabIndex = -1;
      return cell;
    }));
    return row;
  }

  /** Show a text at once; the server's rendering of the row follows. */
  put(cell, text) {
    if (text === "") delete cell.dataset.v;
    else cell.dataset.v = text;
    const box = cell.classList.contains("on") && cell.querySelector("input");
    if (box) box.checked = !this.isOff(text);
    else cell.textContent = text;
  }

  /** True for a text that switches its row off in the column On; compared as `truth_of` in model/workbook.py does. */
  isOff(text) {
    return this.off.has(text.normalize("NFKC").replace(/[\u00ad\u200b-\u200f\u2060\ufeff]/g, "").trim().replace(/^'/, "").trim().toLowerCase().replaceAll("ς", "σ"));
  }

  /** The row so many rows away, stopping at the first and the last. */
  step(row, by) {
    const to = Math.min(Math.max(this.at(row) + by, 0), this.rows.length - 1);
    return this.rows[to];
  }

  at(row) {
    this.indexes ??= new Map(this.rows.map((one, i) => [one, i]));
    return this.indexes.get(row) ?? -1;
  }

  /** The cell an arrow with Ctrl leads to: the edge of the filled block, or the next filled cell, or the end. */
  edge(row, k, down, right) {
    const filled = (r, c) => this.value(this.cell(r, c)) !== "";
    const next = (r, c) => {
      const row2 = down ? this.rows[this.at(r) + down] : r;
      const c2 = c + right;
      return row2 && c2 >= 0 && c2 < this.width ? [row2, c2] : null;
    };
    let here = [row, k];
    let there = next(row, k);
    if (!there) return here;
    const within = filled(...here) && filled(...there);
    while (there && (within ? filled(...there) : true)) {
      here = there;
      if (!within && filled(...here)) break;
      there = next(...here);
    }
    return here;
  }

  /** The last row that has something in it, or the first row. */
  lastFilled() {
    return this.rows[Math.max(this.rows.length - 1 - this.room(), 0)];
  }

  /** The number of blank rows below the last filled one. */
  room() {
    let i = this.rows.length - 1;
    while (i >= 0 && this.places.every((at) => !this.value(this.rows[i].cells[at]))) i--;
    return this.rows.length - 1 - i;
  }

  /** Rows come and go by these four only, so that whoever shows something about rows is told (`rrp:rows`). */
  insert(rows, before) {
    const body = before ? before.parentElement : this.grid.tBodies[this.grid.tBodies.length - 1];
    for (const row of rows) body.insertBefore(row, before);
    while (body.rows.length > 2 * BODY) {
      const next = body.cloneNode();
      next.classList.remove("at");
      next.append(...[...body.rows].slice(-BODY));
      body.after(next);
    }
    this.changed(rows);
  }

  remove(row) {
    const body = row.parentElement;
    row.remove();
    if (!body.rows.length && this.grid.tBodies.length > 1) body.remove();
    this.changed();
  }

  /** Its newest look may be told before what has come or gone above it: where a row stands, only those say. */
  replace(row, rows) {
    if (rows.length === 1) {
      rows[0].cells[0].textContent = row.cells[0].textContent;
      rows[0].setAttribute("aria-rowindex", row.getAttribute("aria-rowindex"));
    }
    row.replaceWith(...rows);
    this.changed(rows);
  }

  append(bodies) {
    this.grid.append(...bodies);
    this.changed(bodies.flatMap((body) => [...body.rows]));
  }

  changed(rows = []) {
    this.all = this.indexes = null;
    if (!this.came) {
      this.came = [];
      queueMicrotask(() => {
        const { came } = this;
        this.came = null;
        this.grid.dispatchEvent(new CustomEvent("rrp:rows", { detail: { came: came.filter((row) => row.isConnected) } }));
      });
    }
    this.came.push(...rows);
  }

  /** The rows' numbers, after rows came or went; a sheet's rows begin below its header. */
  renumber() {
    let number = this.first;
    for (const row of this.rows) {
      const head = row.cells[0];
      if (head.textContent !== String(number)) {
        head.textContent = number;
        row.setAttribute("aria-rowindex", number - this.first + 2);
      }
      number++;
    }
    this.grid.setAttribute("aria-rowcount", this.rows.length + 1);
  }
}
