// Problems at the cells: messages and their remedies, rows that are comments, and the row that is being typed.

import { hintOf } from "../commands.js";
import { make } from "../elements.js";
import { t } from "../texts.js";

const SHOWN_AFTER_MS = 6000; // without a key in a row that is being typed

export class Mending {
  constructor(grid) {
    this.grid = grid;
    grid.scroll.addEventListener("keydown", (event) => this.key(event), true);
    grid.scroll.addEventListener("focusin", () => grid.scroll.classList.remove("left"));
    grid.scroll.addEventListener("focusout", (event) => {
      grid.scroll.classList.toggle("left", Boolean(event.relatedTarget) && !grid.scroll.contains(event.relatedTarget));
    });
  }

  buttons() {
    return [...(this.grid.selection.cell?.querySelectorAll(".mend [data-fix]") ?? [])];
  }

  /** Ctrl+. in a cell. */
  go() {
    const buttons = this.buttons();
    if (!buttons.length) this.grid.say(t("There is no fix to apply in this cell."));
    else if (buttons.length === 1) this.grid.fix(buttons[0]);
    else buttons[0].focus();
  }

  key(event) {
    const button = event.target.closest?.(".mend [data-fix]");
    if (!button) return;
    const buttons = this.buttons();
    const at = buttons.indexOf(button);
    const to = { ArrowDown: at + 1, ArrowRight: at + 1, ArrowUp: at - 1, ArrowLeft: at - 1 }[event.key];
    if (event.key === "Escape") this.grid.selection.cell.focus({ preventScroll: true });
    else if (event.key === "Tab") buttons[(at + (event.shiftKey ? buttons.length - 1 : 1)) % buttons.length].focus();
    else if (to !== undefined) buttons[(to + buttons.length) % buttons.length].focus();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** Keep the messages of the cell with the cursor within what is seen of the sheet. */
  place() {
    const box = this.grid.selection.cell?.querySelector(":scope > .mends");
    if (!box) return;
    box.classList.remove("above");
    box.style.marginLeft = "";
    const frame = this.grid.scroll.getBoundingClientRect();
    const mine = box.getBoundingClientRect();
    if (!mine.height) return;
    const cell = box.parentElement.getBoundingClientRect();
    const top = frame.top + this.grid.table.grid.tHead.offsetHeight;
    if (mine.bottom > frame.top + this.grid.scroll.clientHeight && cell.top - mine.height > top) box.classList.add("above");
    const over = mine.right - (frame.left + this.grid.scroll.clientWidth);
    if (over > 0) box.style.marginLeft = `${-Math.min(over, Math.max(mine.left - frame.left, 0))}px`;
  }
}

// A row whose first cell begins with # is a comment, which the robot leaves out: whoever types into one is told at once.

/** The cell with the # that makes a row a comment; undefined when it is none. */
function markOf(table, row) {
  const first = table.places.map((at) => row.cells[at]).find((cell) => table.value(cell).trim());
  return first && table.value(first).trimStart().startsWith("#") ? first : undefined;
}

/** The note above the editor of a cell beside a comment, with a button where the # is all that is to go; else null. */
export function noteOf(table, cell) {
  const mark = markOf(table, cell.parentElement);
  if (!mark || mark === cell) return null;
  const note = document.createElement("div");
  note.className = "mend is-warning is-comment";
  const title = document.createElement("b");
  title.className = "severity";
  title.textContent = t("Comment");
  const words = document.createElement("span");
  words.textContent = `${spoken(table, cell)} `;
  note.append(title, " ", words);
  if (alone(table, mark)) note.append(offer());
  return note;
}

/** The same, to be told aloud; empty for a cell that is beside no comment. */
export function spoken(table, cell) {
  const mark = markOf(table, cell.parentElement);
  if (!mark || mark === cell) return "";
  return alone(table, mark) ? t("This row begins with #, so the robot skips it. Without the # the row is used.")
    : t("This row begins with #, so the robot skips it. Write your row into an empty one (Esc to leave this cell).");
}

/** The actions of the key and the button beside a comment; `mark` shows at once whether what was typed into a row makes it one. */
export function comments(grid) {
  const { table, scroll } = grid;
  scroll.addEventListener("pointerdown", (event) => {
    if (!event.target.closest("[data-uncomment]")) return;
    event.preventDefault(); // else the editor closes before
    uncomment(table.row(grid.editor.rowId));
  });
  /** True when the # of the cursor's row is all that is to go. */
  function can() {
    const { row, cell } = grid.selection;
    const mark = row && markOf(table, row);
    return Boolean(mark) && alone(table, mark) && !(mark === cell && grid.editor.isOpen);
  }

  function uncomment(row = grid.selection.row) {
    const mark = row && markOf(table, row);
    if (!mark || grid.refuses()) return;
    grid.change([[mark, table.value(mark).trimStart().replace(/^#+\s*/, "")]]);
    if (grid.editor.isOpen) grid.editor.mend();
    grid.say(t("The # is removed: the row is used. Press Ctrl+Z to undo."));
  }

  function mark(row) {
    const sign = row && markOf(table, row);
    if (!row) return;
    row.classList.toggle("comment", Boolean(sign));
    row.classList.toggle("buried", Boolean(sign) && table.places.some((at) => row.cells[at] !== sign && table.value(row.cells[at])));
  }

  return { mark, can, uncomment };
}

// true when the row is whole without its #: there is nothing else in the cell, or it is the name of a stream
function alone(table, mark) {
  const { kind } = table.headers[table.column(mark)].dataset;
  return kind === "inputs" || !table.value(mark).replaceAll("#", "").trim();
}

function offer() {
  const button = make("button", { type: "button", className: "button small", tabIndex: -1 }, t("Remove the #"), " ", make("kbd", hintOf("uncomment")));
  button.dataset.uncomment = "";
  return button;
}

// A row that is being typed does not scold: its problems are small dots until the row is left, or nothing was typed for a
// while.

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
    this.timer = setTimeout(() => (this.grid.editor.isOpen ? this.wait() : this.finish(true)), SHOWN_AFTER_MS);
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
