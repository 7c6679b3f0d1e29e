// Which cells are selected: an anchor and a head, kept by row id so that they survive what others change.

export class Selection {
  constructor(table, scroll, onChange) {
    this.table = table;
    this.scroll = scroll;
    this.onChange = onChange;
    this.anchor = null;
    this.head = null;
    this.painted = [];
    this.handle = document.createElement("div");
    this.handle.className = "fill-handle";
    this.handle.setAttribute("aria-hidden", "true");
    this.handle.hidden = true;
    scroll.append(this.handle);
    addEventListener("resize", () => this.head && this.paint()); // rows have other heights then
  }

  get row() {
    return this.head && this.table.row(this.head.row);
  }

  get cell() {
    return this.head && this.table.cell(this.row, this.head.k);
  }

  /** What stands in the row of the cursor, in the column of a kind. */
  sibling(kind) {
    const k = this.table.headers.findIndex((h) => h.dataset.kind === kind);
    return k < 0 || !this.row ? "" : this.table.value(this.table.cell(this.row, k));
  }

  /** The corners as indexes: rows from `top` to `bottom`, columns from `left` to `right`, all included. */
  box() {
    if (!this.head) return null;
    const rows = [this.anchor, this.head].map((p) => this.table.at(this.table.row(p.row)));
    const columns = [this.anchor.k, this.head.k];
    return { top: Math.min(...rows), bottom: Math.max(...rows), left: Math.min(...columns), right: Math.max(...columns) };
  }

  /** The selected cells, row by row. */
  cells() {
    const box = this.box();
    if (!box) return [];
    const found = [];
    for (let i = box.top; i <= box.bottom; i++) {
      const line = [];
      for (let k = box.left; k <= box.right; k++) line.push(this.table.cell(this.table.rows[i], k));
      found.push(line);
    }
    return found;
  }

  get single() {
    return this.anchor && this.anchor.row === this.head.row && this.anchor.k === this.head.k;
  }

  /** Select a cell; `extend` keeps the anchor, so that a range grows. */
  go(row, k, extend = false, focus = true) {
    if (!row) return;
    this.leave();
    this.head = { row: row.id, k };
    if (!extend || !this.anchor) this.anchor = this.head;
    const cell = this.cell;
    this.enter();
    if (focus) cell.focus({ preventScroll: true });
    this.reveal(cell);
    this.paint();
    this.onChange(this);
  }

  /** Mark the cell with the cursor; by classes, as :focus-within would cost time with every key in a long sheet. */
  enter() {
    const { cell } = this;
    if (this.marked !== cell) this.leave();
    this.marked = cell;
    cell.setAttribute("tabindex", "0");
    cell.classList.add("at");
    cell.parentElement.classList.add("at");
    this.piece = cell.parentElement.parentElement;
    this.piece.classList.add("at");
  }

  leave() {
    const old = this.marked;
    old?.setAttribute("tabindex", "-1");
    old?.classList.remove("at");
    old?.parentElement?.classList.remove("at");
    this.piece?.classList.remove("at");
    this.marked = null;
  }

  /** Select whole rows or everything, without leaving the head's column in view. */
  spread(top, left, bottom, right) {
    this.anchor = { row: this.table.rows[top].id, k: left };
    this.go(this.table.rows[bottom], right, true);
  }

  reveal(cell) {
    const frame = this.scroll.getBoundingClientRect();
    const box = cell.getBoundingClientRect();
    const top = frame.top + this.table.grid.tHead.offsetHeight;
    const left = frame.left + this.table.rows[0].cells[0].offsetWidth;
    if (box.top < top) this.scroll.scrollTop -= top - box.top;
    else if (box.bottom > frame.top + this.scroll.clientHeight) {
      this.scroll.scrollTop += Math.min(box.bottom - frame.top - this.scroll.clientHeight, box.top - top);
    }
    if (box.left < left + 8 && this.scroll.scrollLeft && this.scroll.scrollLeft < 48 + left - box.left) this.scroll.scrollLeft = 0; // no narrow column stays hidden
    else if (box.left < left) this.scroll.scrollLeft -= left - box.left;
    else if (box.right > frame.left + this.scroll.clientWidth) {
      this.scroll.scrollLeft += Math.min(box.right - frame.left - this.scroll.clientWidth, box.left - left);
    }
  }

  paint() {
    for (const cell of this.painted) cell.removeAttribute("aria-selected");
    const cells = this.cells();
    this.painted = cells.flat();
    for (const cell of this.painted) cell.setAttribute("aria-selected", "true");
    const corner = cells.at(-1)?.at(-1);
    this.handle.hidden = !corner;
    if (!corner) return;
    const frame = this.scroll.getBoundingClientRect();
    const box = corner.getBoundingClientRect();
    this.handle.style.left = `${box.right - frame.left + this.scroll.scrollLeft}px`;
    this.handle.style.top = `${box.bottom - frame.top + this.scroll.scrollTop}px`;
  }

  /** After rows were replaced or removed: find everything again, and keep the focus. */
  mend(before) {
    for (const end of ["anchor", "head"]) {
      if (this[end] && !this.table.row(this[end].row)) {
        const near = this.table.rows[Math.min(before[end], this.table.rows.length - 1)];
        this[end] = { row: near.id, k: this[end].k };
      }
    }
    if (!this.head) return;
    this.enter();
    if (document.activeElement === document.body) this.cell.focus({ preventScroll: true });
    this.paint();
  }

  /** Where anchor and head stand, for `mend`. */
  indexes() {
    const index = (end) => (end && this.table.row(end.row) ? this.table.at(this.table.row(end.row)) : 0);
    return { anchor: index(this.anchor), head: index(this.head) };
  }
}
