// The selected cells: from an anchor to a head, which has the cursor; kept by row id so that they survive what others change.
// When whole rows, whole columns or everything are selected, they go from the anchor to `far`, and the head is a cell within.
// Further ranges (Ctrl+click) are in `others`, each with its two corners. A hidden row is in none of them.

export class Selection {
  constructor(table, scroll, onChange) {
    this.table = table;
    this.scroll = scroll;
    this.onChange = onChange;
    this.anchor = null;
    this.head = null;
    this.far = null;
    this.frozen = { count: 0, width: 0 }; // columns that stay in sight, and their width with the rows' numbers; see widths.js
    this.others = [];
    this.adding = false; // whether the next range is a further one (Ctrl+Shift+F8)
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

  /** The text in the row of the cursor, in the column of a kind. */
  sibling(kind) {
    const k = this.table.ofKind(kind);
    return k < 0 || !this.row ? "" : this.table.value(this.table.cell(this.row, k));
  }

  /** The corners as indexes: rows from `top` to `bottom`, columns from `left` to `right`, all included. */
  box() {
    return this.head && this.between([this.anchor, this.far ?? this.head]);
  }

  between(corners) {
    const rows = corners.map((p) => this.table.at(this.table.row(p.row)));
    const columns = corners.map((p) => p.k);
    return { top: Math.min(...rows), bottom: Math.max(...rows), left: Math.min(...columns), right: Math.max(...columns) };
  }

  /** The corners of all ranges, that with the cursor at the end. */
  boxes() {
    return this.head ? [...this.others.map((corners) => this.between(corners)), this.box()] : [];
  }

  /** The cells of the range with the cursor or of another one, row by row. */
  cells(box = this.box()) {
    const found = [];
    for (let i = box?.top; i <= box?.bottom; i++) {
      const row = this.table.rows[i];
      const line = [];
      if (this.table.hidden.has(row.id)) continue;
      for (let k = box.left; k <= box.right; k++) line.push(this.table.cell(row, k));
      found.push(line);
    }
    return found;
  }

  /** The cells of all ranges, each once. */
  all() {
    const found = this.boxes().flatMap((box) => this.cells(box).flat());
    return this.others.length ? [...new Set(found)] : found;
  }

  /** What selects again what is selected now. */
  kept() {
    const { head, anchor, far, others } = this;
    return () => {
      Object.assign(this, { head, anchor, far, others });
      this.mend({ anchor: 0, head: 0, far: 0 });
      this.onChange(this);
    };
  }

  /** Begin a further range: the next cell, and what it grows to, is selected besides what is. */
  add() {
    this.adding = true;
    this.keep();
    this.paint();
    this.onChange(this);
  }

  /** Select no further ranges; true if any were to come. */
  ends() {
    const { adding } = this;
    this.adding = false;
    return adding;
  }

  keep() {
    const corners = [this.anchor, this.far ?? this.head];
    const alike = ([one, other]) => one.row === corners[0].row && one.k === corners[0].k && other.row === corners[1].row && other.k === corners[1].k;
    if (this.head && !this.others.some(alike)) this.others.push(corners);
  }

  /** Deselect a single cell that was selected besides others; true if it was one. */
  without(cell) {
    const { id } = cell.parentElement;
    const k = this.table.column(cell);
    const mine = (corners) => corners.every((corner) => corner.row === id && corner.k === k);
    const rest = this.others.filter((corners) => !mine(corners));
    if (mine([this.anchor, this.far ?? this.head]) && rest.length) {
      const [anchor, far] = rest.pop();
      this.others = rest;
      const { others } = this;
      this.go(this.table.row(far.row), far.k);
      Object.assign(this, { anchor, others });
      this.paint();
    } else if (rest.length < this.others.length) {
      this.others = rest;
      this.paint();
    } else return false;
    this.onChange(this);
    return true;
  }

  /** Select a cell; `extend` keeps the anchor, so that a range grows; `further` keeps what is selected. */
  go(row, k, extend = false, focus = true, further = false) {
    if (!row) return;
    this.table.show(row);
    if (further) this.keep();
    else if (!extend && !this.adding) this.others = [];
    if (extend && this.far) {
      const { far } = this;
      this.far = { row: row.id, k };
      this.reveal(this.table.cell(row, k), { down: far.row !== row.id, right: far.k !== k });
      this.paint();
      this.onChange(this);
      return;
    }
    this.leave();
    this.head = { row: row.id, k };
    this.far = null;
    if (!extend || !this.anchor) this.anchor = this.head;
    const cell = this.cell;
    this.enter();
    if (focus) cell.focus({ preventScroll: true });
    this.reveal(cell);
    this.paint();
    this.onChange(this);
  }

  /** So many rows down and columns to the right, as far as there are any. */
  step(down, right, extend) {
    const from = this.from(extend);
    const k = Math.min(Math.max(from.k + right, 0), this.table.width - 1);
    this.go(this.table.step(this.table.row(from.row), down), k, extend);
  }

  /** To the edge of what is filled. */
  jump(down, right, extend) {
    const { row, k } = this.from(extend);
    const from = this.table.row(row);
    const [there, at] = this.table.edge(down ? from : this.row, down ? this.head.k : k, down, right);
    this.go(down ? there : from, down ? k : at, extend);
  }

  /** What a key moves: the cursor, or the corner to which the selection grows. */
  from(extend) {
    return (extend && this.far) || this.head;
  }

  /** The rows of a page. */
  get page() {
    return Math.max(1, Math.floor(this.scroll.clientHeight / this.row.offsetHeight) - 1);
  }

  /** True at the last cell of the table; with `before`, at the first. */
  isLast(before) {
    const { shown, width } = this.table;
    return this.head.k === (before ? 0 : width - 1) && this.row === shown.at(before ? 0 : -1);
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

  /** Select a block; the cursor goes to its last cell. */
  spread(top, left, bottom, right) {
    this.far = null;
    this.others = [];
    this.anchor = { row: this.table.rows[top].id, k: left };
    this.go(this.table.rows[bottom], right, true);
  }

  /** Select a block around the cursor, which stays where it is. */
  surround(top, left, bottom, right) {
    this.anchor = { row: this.table.rows[top].id, k: left };
    this.far = { row: this.table.rows[bottom].id, k: right };
    this.paint();
    this.onChange(this);
  }

  /** Select a whole row, and put the cursor into its first cell; `extend` selects all rows from the anchor's to it, `further` keeps
   *  what is selected. */
  wholeRow(row, extend, further = false) {
    if (!row) return;
    const at = this.table.at(row);
    const from = extend && this.head ? this.table.at(this.table.row(this.anchor.row)) : at;
    if (!extend || !this.head) this.go(row, 0, false, true, further);
    else this.cell.focus({ preventScroll: true });
    this.surround(from, 0, at, this.table.width - 1);
  }

  /** True for a row that is selected as a whole. */
  has(row) {
    return this.table.places.every((at) => row.cells[at].ariaSelected === "true");
  }

  /** Scroll a cell into sight, `down` and to the `right` or in one direction alone. */
  reveal(cell, { down = true, right = true } = {}) {
    const frame = this.scroll.getBoundingClientRect();
    const box = cell.getBoundingClientRect();
    const top = frame.top + this.table.grid.tHead.offsetHeight;
    const left = frame.left + this.frozen.width;
    if (down && box.top < top) this.scroll.scrollTop -= top - box.top;
    else if (down && box.bottom > frame.top + this.scroll.clientHeight) {
      this.scroll.scrollTop += Math.min(box.bottom - frame.top - this.scroll.clientHeight, box.top - top);
    }
    if (!right || this.isFrozen(cell)) return;
    if (box.left < left + 8 && this.scroll.scrollLeft && this.scroll.scrollLeft < 48 + left - box.left) this.scroll.scrollLeft = 0; // no narrow column stays hidden
    else if (box.left < left) this.scroll.scrollLeft -= left - box.left;
    else if (box.right > frame.left + this.scroll.clientWidth) {
      this.scroll.scrollLeft += Math.min(box.right - frame.left - this.scroll.clientWidth, box.left - left);
    }
  }

  paint() {
    for (const cell of this.painted) cell.removeAttribute("aria-selected");
    this.painted = this.all();
    for (const cell of this.painted) cell.setAttribute("aria-selected", "true");
    this.hold();
  }

  /** True for a cell that stays in sight while the table is scrolled to the right. */
  isFrozen(cell) {
    return Boolean(cell) && cell.cellIndex <= this.frozen.count && !cell.parentElement.matches(".comment:not(.buried)");
  }

  /** Put the handle for filling at the last selected cell. */
  hold() {
    const corner = this.others.length ? null : this.painted.at(-1);
    this.handle.hidden = !corner;
    if (!corner) return;
    const frame = this.scroll.getBoundingClientRect();
    const box = corner.getBoundingClientRect();
    this.handle.style.left = `${box.right - frame.left + this.scroll.scrollLeft}px`;
    this.handle.style.top = `${box.bottom - frame.top + this.scroll.scrollTop}px`;
  }

  /** After rows were replaced or removed: find everything again, and keep the focus. */
  mend(before) {
    for (const end of ["anchor", "head", "far"]) {
      if (this[end] && !this.table.row(this[end].row)) {
        const near = this.table.rows[Math.min(before[end], this.table.rows.length - 1)];
        this[end] = { row: (this.table.hidden.has(near.id) ? this.near(before[end]) : near).id, k: this[end].k };
      }
    }
    this.others = this.others.filter((corners) => corners.every((corner) => this.table.row(corner.row)));
    if (!this.head) return;
    this.enter();
    if (document.activeElement === document.body) this.cell.focus({ preventScroll: true });
    this.paint();
  }

  /** The shown row at a place among all rows, or the next one there is. */
  near(place) {
    return this.table.shown.find((row) => this.table.at(row) >= place) ?? this.table.shown.at(-1);
  }

  /** The rows of anchor, head and far as indexes, for `mend`. */
  indexes() {
    const index = (end) => (end && this.table.row(end.row) ? this.table.at(this.table.row(end.row)) : 0);
    return { anchor: index(this.anchor), head: index(this.head), far: index(this.far) };
  }
}

// Mouse, pen and touch: selecting, extending, the fill handle, whole rows, opening a cell.

export function pointer(grid) {
  const { table, selection, scroll } = grid;
  const cellAt = (event) => {
    const cell = document.elementFromPoint(event.clientX, event.clientY)?.closest?.("[role=gridcell]");
    return cell && table.grid.contains(cell) && table.column(cell) >= 0 ? cell : null;
  };

  const rowAt = (event) => {
    const row = document.elementFromPoint(event.clientX, event.clientY)?.closest?.("tr[id]");
    return row && table.grid.contains(row) ? row : null;
  };

  let touched = false; // two taps on one place are a double click to the browser, also when the table has scrolled between
  table.grid.addEventListener("pointerdown", (event) => {
    touched = event.pointerType === "touch";
    if (event.button !== 0 || event.target.closest("button, a")) return;
    const header = event.target.closest("[role=rowheader]");
    const cell = event.target.closest("[role=gridcell]");
    const further = (event.ctrlKey || event.metaKey) && !event.shiftKey && selection.head !== null;
    selection.ends();
    if (grid.editor.isOpen) grid.editor.close(true, null);
    if (event.target.closest("input")) {
      selection.go(cell.parentElement, table.column(cell), event.shiftKey);
      return;
    }
    if (header) {
      event.preventDefault();
      const row = header.parentElement;
      if (event.pointerType === "mouse" && !event.shiftKey && !further && selection.has(row)) {
        carry(event, row);
        return;
      }
      selection.wholeRow(row, event.shiftKey, further);
      if (event.pointerType === "mouse") drag(event, (over) => selection.wholeRow(over, true), () => {}, rowAt);
      return;
    }
    if (!cell || table.column(cell) < 0) return;
    if (event.pointerType === "touch") {
      tap(event, cell);
      return;
    }
    event.preventDefault();
    if (soonAfter(event) && table.row(pressed.row)) {
      selection.go(table.row(pressed.row), pressed.k, event.shiftKey);
      return;
    }
    pressed = { time: event.timeStamp, x: event.clientX, y: event.clientY, row: cell.parentElement.id, k: table.column(cell) };
    if (further && selection.without(cell)) return;
    selection.go(cell.parentElement, table.column(cell), event.shiftKey, true, further);
    drag(event, (over) => selection.go(over.parentElement, table.column(over), true));
  });

  // the first click may have ended an edit, which can make its row higher: meant is the cell that was there then
  let pressed = { time: -1e9 };
  const forget = () => { pressed = { time: -1e9 }; };
  scroll.addEventListener("keydown", forget, true); // within a double click there is no key, and no press on a menu
  document.addEventListener("pointerdown", ({ target }) => table.grid.contains(target) || forget(), true);
  const soonAfter = (event) => event.timeStamp - pressed.time < 500
    && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) < 5;
  table.grid.addEventListener("dblclick", (event) => {
    if (touched) return;
    const cell = soonAfter(event) ? table.cell(table.row(pressed.row), pressed.k) : event.target.closest("[role=gridcell]");
    if (cell && table.column(cell) >= 0) grid.editor.open(cell);
  });

  // a tap selects; a tap on the selected cell edits it; a finger that moves scrolls
  function tap(event, cell) {
    const from = [event.clientX, event.clientY];
    const again = cell === selection.cell;
    const up = (end) => {
      stop();
      if (Math.hypot(end.clientX - from[0], end.clientY - from[1]) > 10) return;
      if (again) grid.editor.open(cell);
      else selection.go(cell.parentElement, table.column(cell), false);
    };
    const stop = () => {
      removeEventListener("pointerup", up);
      removeEventListener("pointercancel", stop);
    };
    addEventListener("pointerup", up);
    addEventListener("pointercancel", stop);
  }

  // whole rows that are selected go with the pointer; one that stays where it is selects its row
  function carry(event, row) {
    let to = null;
    const mark = (next) => {
      to?.classList.remove("drop-above");
      next?.classList.add("drop-above");
      to = next;
    };
    drag(event, mark, () => {
      const target = to;
      mark(null);
      if (target && target !== row) grid.rows.moveBefore(target);
      else selection.wholeRow(row);
    }, rowAt);
  }

  function drag(event, over, done = () => {}, at = cellAt) {
    let last = null;
    const move = (now) => {
      scroll.classList.add("dragging"); // no message hides the cells below
      const cell = at(now);
      if (cell && cell !== last) over((last = cell));
    };
    const up = () => {
      removeEventListener("pointermove", move);
      removeEventListener("pointerup", up);
      removeEventListener("pointercancel", up);
      scroll.classList.remove("dragging");
      done(last);
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", up);
    addEventListener("pointercancel", up);
  }

  // the fill handle: by mouse it repeats the selection downwards; by touch it extends the selection
  selection.handle.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    const source = selection.cells().map((line) => line.map((cell) => table.value(cell)));
    const box = selection.box();
    const touch = event.pointerType === "touch";
    drag(event, (over) => {
      const to = touch ? table.column(over) : box.right;
      selection.anchor = { row: table.rows[box.top].id, k: box.left };
      selection.go(table.rows[Math.max(table.at(over.parentElement), touch ? 0 : box.bottom)], to, true);
    }, () => {
      if (touch) return;
      const lines = selection.cells().slice(source.length);
      grid.change(lines.flatMap((line, i) => line.map((cell, j) => [cell, source[i % source.length][j]])));
    });
  });

  scroll.addEventListener("contextmenu", (event) => {
    const target = event.target === grid.editor.waiting ? selection.cell : event.target; // by the menu key
    const row = target.closest("tr[id]");
    const k = table.headers.indexOf(target.closest("[role=columnheader]"));
    if (k >= 0 && selection.row && !grid.editor.isOpen) {
      event.preventDefault();
      selection.go(selection.row, k);
      grid.menu.open(event.clientX, event.clientY, "head");
      return;
    }
    if (!row || grid.editor.isOpen) return;
    event.preventDefault();
    const header = target.closest("[role=rowheader]");
    const cell = target.closest("[role=gridcell]");
    const within = header ? selection.has(row) : cell?.ariaSelected === "true";
    if (!within && header) selection.wholeRow(row);
    else if (!within) selection.go(row, Math.max(cell ? table.column(cell) : 0, 0));
    grid.menu.open(event.clientX, event.clientY, header ? "rows" : "cell");
  });
}
