// The table that the server rendered, as the other modules see it: rows with ids that stay, and editable columns
// counted from 0 (`data-c` on a header is the sheet's own column number).

export class Table {
  constructor(grid) {
    this.grid = grid;
    this.body = grid.tBodies[0];
    this.headers = [...grid.tHead.rows[0].cells].filter((h) => h.dataset.c);
    this.places = this.headers.map((h) => h.cellIndex);
    this.width = this.headers.length;
    this.kind = /\bof-(\w+)/.exec(grid.className)?.[1] ?? "";
  }

  get rows() {
    return this.body.rows;
  }

  row(id) {
    return document.getElementById(id);
  }

  /** The cell of a row in an editable column. */
  cell(row, k) {
    return row?.cells[this.places[k]];
  }

  /** Which editable column a cell stands in; -1 for a read-only one. */
  column(cell) {
    return this.places.indexOf(cell.cellIndex);
  }

  sheetColumn(k) {
    return Number(this.headers[k].dataset.c);
  }

  /** The header over a column; its letter where it has none. */
  name(k) {
    return this.headers[k].dataset.name || this.headers[k].dataset.letter;
  }

  /** A cell's address, such as C4. */
  address(cell) {
    return `${this.headers[this.column(cell)].dataset.letter}${cell.parentElement.cells[0].textContent}`;
  }

  /** What stands in a cell, as it was typed. */
  value(cell) {
    return cell?.dataset.v ?? "";
  }

  /** Show a text at once; the server's rendering of the row follows. */
  put(cell, text) {
    if (text === "") delete cell.dataset.v;
    else cell.dataset.v = text;
    const box = cell.classList.contains("on") && cell.firstElementChild;
    if (box) box.checked = !/^(false|no|off|0)$/i.test(text.trim());
    else cell.textContent = text;
  }

  /** The row so many rows away, stopping at the first and the last. */
  step(row, by) {
    const to = Math.min(Math.max(this.at(row) + by, 0), this.rows.length - 1);
    return this.rows[to];
  }

  at(row) {
    return row.sectionRowIndex;
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
    for (let i = this.rows.length - 1; i >= 0; i--) {
      for (let k = 0; k < this.width; k++) if (this.value(this.cell(this.rows[i], k))) return this.rows[i];
    }
    return this.rows[0];
  }

  /** The rows' numbers, after rows came or went; a sheet's rows begin below its header. */
  renumber() {
    let number = Number(this.body.dataset.first);
    for (const row of this.rows) {
      const head = row.cells[0];
      if (head.textContent !== String(number)) head.textContent = number;
      row.setAttribute("aria-rowindex", number - Number(this.body.dataset.first) + 2);
      number++;
    }
    this.grid.setAttribute("aria-rowcount", this.rows.length + 1);
  }
}
