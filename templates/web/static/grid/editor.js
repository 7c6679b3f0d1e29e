// The one editor: a text field outside the table, placed over the cell. It survives whatever happens to the table.

import { noteOf } from "./comments.js";
import { suggest, signature } from "./suggest.js";

let serial = 0;

export class Editor {
  /** `done(cell, text, was, move)` is called when a text is kept; `table` and `scroll` are the grid's. */
  constructor(table, scroll, context, done) {
    this.table = table;
    this.scroll = scroll;
    this.context = context;
    this.done = done;
    this.field = null;
  }

  get isOpen() {
    return this.field !== null;
  }

  /** Begin to edit a cell: with what it holds, or (as when typing starts) with a first text; or go on with a text that was
   *  begun when the cell held `was`. */
  open(cell, first, was) {
    if (this.isOpen || !cell || this.context.refuses()) return;
    const k = this.table.column(cell);
    this.rowId = cell.parentElement.id;
    this.k = k;
    this.contested = false;
    this.was = was ?? this.table.value(cell);
    this.mode = first === undefined || was !== undefined ? "edit" : "enter";
    this.build(cell, k);
    this.field.value = first ?? this.was;
    this.place(cell);
    this.field.focus({ preventScroll: true });
    this.field.setSelectionRange(this.field.value.length, this.field.value.length);
    this.update(first !== undefined);
    this.context.editing(this.rowId, k, true);
  }

  build(cell, k) {
    const id = `editor-${++serial}`;
    this.box = document.createElement("div");
    this.box.className = "editor";
    this.field = document.createElement("textarea");
    this.field.rows = 1;
    this.field.spellcheck = false;
    this.field.autocomplete = "off";
    this.field.className = ["formula", "send", "expect"].includes(this.kind(k)) ? "code" : "";
    for (const [name, value] of Object.entries({
      "aria-haspopup": "listbox", "aria-autocomplete": "list", "aria-controls": id, // of several lines, so no combobox
      "aria-label": `${this.table.name(k)}, row ${cell.parentElement.cells[0].textContent}`, autocapitalize: "off",
    })) this.field.setAttribute(name, value);
    this.list = document.createElement("div");
    this.list.className = "suggestions";
    this.list.id = id;
    this.list.hidden = true;
    this.list.setAttribute("role", "listbox");
    this.list.tabIndex = 0; // as it scrolls; Tab never leads there
    this.list.setAttribute("aria-label", "Suggestions");
    this.hint = document.createElement("div");
    this.hint.className = "signature";
    this.hint.hidden = true;
    this.wrong = document.createElement("div"); // what is wrong with the cell stays in sight, above the list
    this.wrong.className = "wrong";
    this.box.append(this.field, this.wrong, this.hint, this.list);
    this.scroll.append(this.box);
    this.scroll.classList.add("typing");
    this.scold(cell);
    this.field.addEventListener("input", () => this.update(true));
    this.field.addEventListener("click", () => this.update(false));
    this.field.addEventListener("blur", () => this.isOpen && this.close(true, null));
    this.list.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      const option = event.target.closest("[role=option]");
      if (option) this.accept(Number(option.dataset.i));
    });
  }

  kind(k) {
    return this.table.headers[k].dataset.kind;
  }

  scold(cell) {
    const note = noteOf(this.table, cell);
    const told = note || cell.parentElement.classList.contains("unfinished") ? [] : cell.querySelectorAll(".mend:not(.is-info)");
    this.wrong.replaceChildren(...(note ? [note] : []), ...[...told].map((mend) => {
      const copy = mend.cloneNode(true);
      copy.removeAttribute("id");
      for (const button of copy.querySelectorAll("button")) button.remove();
      return copy;
    }));
  }

  place(cell) {
    const frame = this.scroll.getBoundingClientRect();
    const box = cell.getBoundingClientRect();
    const left = box.left - frame.left + this.scroll.scrollLeft;
    this.box.style.left = `${left}px`;
    this.box.style.top = `${box.top - frame.top + this.scroll.scrollTop}px`;
    this.field.style.minWidth = `${box.width}px`;
    this.field.style.minHeight = `${box.height}px`;
    this.field.style.width = `${Math.max(box.width, this.kind(this.k) === "formula" ? 200 : 0)}px`;
    this.grow();
  }

  /** As tall as its text; measured only when that can have changed, as each measure lays the page out. */
  grow() {
    const { value, style } = this.field;
    const [letters, lines] = [value.length, value.split("\n").length];
    const less = letters < this.letters || lines < this.lines;
    [this.letters, this.lines] = [letters, lines];
    if (style.height && !less && this.field.scrollHeight <= this.field.clientHeight) return;
    this.field.style.height = "auto";
    this.field.style.height = `${this.field.scrollHeight + 4}px`;
  }

  /** Show the suggestions once the word list is loaded, if an editor was opened before; Enter takes none of them. */
  renew() {
    if (this.isOpen && this.list.hidden && this.typed !== null) this.update(false);
  }

  /** Look again at what could be meant. */
  update(typed) {
    this.typed = typed;
    this.grow();
    this.context.typing();
    const row = this.table.row(this.rowId);
    const where = { kind: this.kind(this.k), name: this.table.name(this.k), row, table: this.table };
    const before = this.field.value.slice(0, this.field.selectionStart);
    this.found = this.field.selectionStart === this.field.selectionEnd && typed !== null
      ? suggest(this.context.vocabulary(), where, before, this.field.value)
      : { items: [], from: 0, sure: false };
    this.chosen = this.found.sure && typed ? 0 : -1;
    this.moved = false;
    this.show();
    const help = signature(this.context.vocabulary(), where, before);
    this.hint.hidden = !help;
    if (help) this.hint.replaceChildren(...help);
  }

  show() {
    const items = this.found.items;
    this.list.hidden = items.length === 0;
    this.list.replaceChildren(...items.map((item, i) => {
      const option = document.createElement("div");
      option.id = `${this.list.id}-${i}`;
      option.dataset.i = i;
      option.setAttribute("role", "option");
      option.setAttribute("aria-selected", String(i === this.chosen));
      const label = document.createElement("span");
      label.className = `name ${item.kind ?? ""}`;
      label.textContent = item.label ?? item.text;
      const help = document.createElement("small");
      help.textContent = item.help ?? "";
      option.append(label, help);
      return option;
    }));
    this.point();
  }

  point() {
    for (const option of this.list.children) option.setAttribute("aria-selected", String(Number(option.dataset.i) === this.chosen));
    const option = this.list.children[this.chosen];
    if (option) {
      this.field.setAttribute("aria-activedescendant", option.id);
      option.scrollIntoView({ block: "nearest" });
    } else this.field.removeAttribute("aria-activedescendant");
  }

  accept(i) {
    const item = this.found.items[i];
    const start = this.field.selectionStart;
    const value = this.field.value;
    this.field.value = value.slice(0, this.found.from) + item.text + value.slice(start);
    const caret = this.found.from + item.text.length;
    this.field.focus();
    this.field.setSelectionRange(caret, caret);
    this.update(null);
  }

  /** A key while editing; true when the editor has dealt with it. */
  key(event) {
    if (event.isComposing || event.keyCode === 229) return true; // Enter ends what an input method composes
    const open = !this.list.hidden;
    const key = event.key;
    if (key === "Escape") {
      if (open && this.mode === "edit") this.update(null);
      else this.close(false, null);
    } else if (open && (key === "ArrowDown" || key === "ArrowUp")) {
      const count = this.found.items.length;
      this.chosen = (this.chosen + (key === "ArrowDown" ? 1 : count - (this.chosen < 0 ? 0 : 1))) % count;
      this.moved = true;
      this.point();
    } else if (key === "Enter" && event.altKey) {
      this.field.setRangeText("\n", this.field.selectionStart, this.field.selectionEnd, "end");
      this.update(true);
    } else if (key === "Enter" && open && this.moved) this.accept(this.chosen);
    else if ((key === "Tab" || key === "Enter") && !event.shiftKey && open && this.chosen >= 0 && this.found.partial) this.accept(this.chosen);
    else if (key === "Enter" || key === "Tab") {
      if (open && this.chosen >= 0 && this.found.whole) this.accept(this.chosen);
      const back = event.shiftKey;
      this.close(true, key === "Enter" ? (back ? "raise" : "enter") : back ? "back" : "tab");
    } else if (this.mode === "enter" && /^Arrow/.test(key) && !open) this.close(true, key.slice(5).toLowerCase());
    else if (key === "F2") this.mode = this.mode === "edit" ? "enter" : "edit";
    else return false;
    event.preventDefault();
    return true;
  }

  /** Stop editing; keep the text or not. `move` says where the selection goes, null for nowhere. */
  close(keep, move) {
    const field = this.field;
    if (!field) return;
    this.field = null;
    const text = field.value;
    this.box.remove();
    this.scroll.classList.remove("typing");
    this.context.editing(this.rowId, this.k, false);
    const row = this.table.row(this.rowId);
    if (row) this.done(this.table.cell(row, this.k), keep ? text : this.was, this.was, move);
    else if (keep && text !== this.was) this.context.lost("The row was deleted meanwhile. Copy your text, and paste it where it belongs.", text);
  }

  /** The table has changed around the editor. */
  mend() {
    if (!this.isOpen) return;
    const row = this.table.row(this.rowId);
    this.box.classList.toggle("orphan", !row);
    if (row) {
      const cell = this.table.cell(row, this.k);
      this.place(cell);
      this.scold(cell);
      this.box.classList.toggle("contested", this.contested || this.table.value(cell) !== this.was);
    }
  }

  /** Somebody else is editing the cell too. */
  contest() {
    this.contested = true;
    this.mend();
  }
}
