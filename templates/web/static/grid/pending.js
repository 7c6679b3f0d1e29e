// Input that waits for an undo or a fix, and the order of rows. While only the server knows the next state of the sheet, input
// is held and then replayed in its order; steps that the page shows before they are confirmed are kept apart from those that are.

import { isComposed } from "../commands.js";
import { t } from "../texts.js";
import { copiedOf, insert, NOTHING } from "./clipboard.js";

const TOLD_AFTER_MS = 1000; // of waiting, after which a message says that something waits
const BUTTONS = "[data-do=undo], [data-do=redo], [data-fix]"; // they may have the focus while what they began is under way
const ENDS = { ends: true }; // of an action: it ends a text that waits
const SILENT = new Set(["Dead", "Process", "Shift", "Control", "Alt", "Meta", "AltGraph"]); // they do nothing by themselves

export class Held {
  constructor(grid) {
    this.grid = grid;
    this.jobs = 0;
    this.copies = false;
    this.copied = NOTHING;
    this.actions = []; // {run, typed}: the text that it types, if any, or what it does to the one before
    this.field = document.createElement("textarea"); // takes what no key tells: an input method's text, say
    this.field.className = "only-spoken";
    this.field.tabIndex = -1;
    this.field.setAttribute("aria-label", t("Waiting for the program"));
    this.field.addEventListener("input", (event) => event.isComposing || this.text());
    this.field.addEventListener("compositionend", () => this.text());
    for (const kind of ["keydown", "paste", "copy", "cut", "pointerdown", "dblclick", "contextmenu", "click"]) {
      document.addEventListener(kind, (event) => this.event(event), true);
    }
    document.addEventListener("close", () => this.replay(), true); // of a dialog
    addEventListener("beforeunload", (event) => this.actions.length && event.preventDefault());
  }

  /** Hold what is done until a job has ended. */
  async until(job) {
    this.jobs++;
    const slow = setTimeout(() => this.grid.say(t("The program has not answered yet. This page keeps what you type and sends it later.")), TOLD_AFTER_MS);
    try {
      return await job();
    } finally {
      clearTimeout(slow);
      this.jobs--;
      if (!this.jobs) this.release();
      this.replay();
    }
  }

  /** Take the focus, so that text can come that no key tells. */
  hold() {
    if (!this.field.isConnected) this.grid.scroll.append(this.field);
    if (document.activeElement !== this.field) this.field.focus({ preventScroll: true });
  }

  release() {
    if (!this.field.isConnected) return;
    this.text();
    this.field.remove();
    if (document.activeElement === document.body) this.grid.selection.cell?.focus({ preventScroll: true });
  }

  text() {
    const text = this.field.value;
    this.field.value = "";
    if (!text) return;
    this.add(() => {
      const { editor, selection } = this.grid;
      if (editor.isOpen) document.execCommand("insertText", false, text);
      else editor.open(selection.cell, text);
    }, text);
  }

  add(run, typed = ENDS) {
    this.actions.push({ run, typed });
    this.changed();
  }

  /** The texts that wait are kept over a reload, and are counted among what is not saved. */
  changed() {
    this.grid.drafts.wait(this.texts);
    this.grid.server.unsent.show();
  }

  /** The texts that wait, each as it would go into a cell. */
  get texts() {
    const texts = [""];
    for (const { typed } of this.actions) {
      const text = texts.pop();
      if (typed === ENDS) texts.push(text, "");
      else texts.push(typed === "\b" ? [...text].slice(0, -1).join("") : text + typed);
    }
    return texts.filter((text) => text.trim());
  }

  /** Give up what waits. */
  drop() {
    this.actions = [];
    this.changed();
  }

  /** Hold an action of a menu or a button while a job is under way; true if so. It then first ends an edit, as a click does. */
  takes(action) {
    if (!this.waits || this.playing) return false;
    this.add(() => {
      if (this.grid.editor.isOpen) this.grid.editor.close(true, null);
      action();
    });
    return true;
  }

  /** Replay what can be replayed; true if new input is still to be held: a job is under way, or a dialog keeps the focus. */
  get waits() {
    if (!this.jobs && this.actions.length) this.replay();
    return this.jobs > 0 || this.actions.length > 0;
  }

  replay() {
    if (this.playing) return;
    const waited = this.actions.length > 0;
    while (this.actions.length && !this.jobs && !document.querySelector("dialog:modal")) {
      const { run } = this.actions.shift();
      this.playing = true;
      try {
        run();
      } finally {
        this.playing = false;
      }
    }
    if (waited) this.changed();
    if (!this.actions.length) this.copies = false;
  }

  // Only what is meant for the grid: Stop, say, never waits.
  event(event) {
    if (this.playing) return;
    const { target } = event;
    if (!this.grid.scroll.contains(target) && !(event.type === "keydown" && target.closest?.(BUTTONS))) return;
    if (!this.waits) return;
    const action = this[event.type](event);
    if (!action) return;
    event.preventDefault();
    event.stopPropagation();
    this.add(action, typedBy(event));
    this.hold();
  }

  keydown(event) {
    const { key, code, ctrlKey, metaKey, altKey, shiftKey } = event;
    const control = ctrlKey || metaKey;
    if (isComposed(event) || SILENT.has(key) || /^F(1|[3-9]|1\d)$/.test(key)) return null;
    if (control && /^[cxvrtwnlp]$/i.test(key)) return null; // the clipboard's have events of their own; the browser's
    return () => this.press({ key, code, ctrlKey, metaKey, altKey, shiftKey });
  }

  paste(event) {
    const copied = copiedOf(event.clipboardData);
    const { copies } = this; // one that waits too: what it puts on the clipboard is not there yet
    return () => {
      const { editor, clipboard } = this.grid;
      const now = copies ? this.copied : copied;
      if (editor.isOpen) insert(now);
      else clipboard.pasted(now);
    };
  }

  copy() {
    return this.takesCopy(() => this.grid.clipboard.copy());
  }

  cut() {
    return this.takesCopy(() => this.grid.clipboard.cut());
  }

  takesCopy(copy) {
    this.copies = true;
    return () => {
      if (!this.grid.editor.isOpen) this.copied = copy();
    };
  }

  pointerdown(event) {
    const { table, selection, editor } = this.grid;
    if (event.button !== 0 || event.target.closest("button, a")) return null;
    const row = event.target.closest("tr[id]")?.id;
    const cell = event.target.closest("[role=gridcell]");
    const k = cell ? table.column(cell) : -1;
    const { shiftKey } = event;
    const further = !shiftKey && (event.ctrlKey || event.metaKey);
    return () => {
      if (editor.isOpen) editor.close(true, null);
      if (k >= 0) selection.go(table.row(row), k, shiftKey, true, further);
      else selection.wholeRow(table.row(row), shiftKey, further);
    };
  }

  dblclick() {
    return () => this.grid.editor.open(this.grid.selection.cell);
  }

  contextmenu() {
    return () => {};
  }

  click(event) {
    if (event.target.closest("button, a")) return null;
    return event.target.closest("input") ? () => this.grid.selection.cell?.querySelector("input")?.click() : () => {};
  }

  /** A key as if it were pressed now. */
  press(about) {
    const { editor, selection } = this.grid;
    const target = editor.isOpen ? editor.field : selection.cell;
    if (!target) return;
    target.focus({ preventScroll: true });
    const again = new KeyboardEvent("keydown", { ...about, bubbles: true, cancelable: true });
    if (target.dispatchEvent(again) && target === editor.field) typeInto(target, about);
  }
}

// The text that a key or a paste types; a key that ends the text before it, or takes a letter of it.
function typedBy(event) {
  if (event.type === "paste") return event.clipboardData.getData("text/plain");
  if (event.type !== "keydown" || event.ctrlKey || event.metaKey) return ENDS;
  if (event.key === "Backspace") return "\b";
  if (event.key === "Enter" && event.altKey) return "\n";
  return [...event.key].length === 1 ? event.key : ENDS;
}

// The browser's own effect of a key in a text field.
function typeInto(field, { key, ctrlKey, metaKey, shiftKey }) {
  const { selectionStart: start, selectionEnd: end, value } = field;
  if (ctrlKey || metaKey) {
    if (key.toLowerCase() === "a") field.select();
    return;
  }
  if ([...key].length === 1) document.execCommand("insertText", false, key);
  else if (key === "Backspace") document.execCommand("delete");
  else if (key === "Delete") document.execCommand("forwardDelete");
  const to = { ArrowLeft: start - (start === end || shiftKey ? 1 : 0), ArrowRight: end + (start === end || shiftKey ? 1 : 0), Home: 0, End: value.length }[key];
  if (to === undefined) return;
  const at = Math.min(Math.max(to, 0), value.length);
  if (shiftKey) field.setSelectionRange(Math.min(at, start), Math.max(at, end));
  else field.setSelectionRange(at, at);
}

// The order of the rows: the newest that the server has told, and on top of it what this page has done since. So it is the
// same whether an answer comes before or after what others have done, and a step that was refused leaves no trace.

export class Order {
  /** `version`: of the order that the page shows at first. */
  constructor(table, version) {
    this.table = table;
    this.version = version;
    this.confirmed = table.rows.map((row) => row.id);
    this.whole = false; // whether `confirmed` has all rows of the sheet: a long one comes in pieces
    this.pending = []; // {tag, insert | remove | move: ids, before}
    this.aside = new Map(); // id → a row that the server has and this page does not show, or not yet
    this.below = new Map(); // id of a row that is gone → the next row that was below it
  }

  /** The server has answered a step: it is in the order that was told, or was refused. True if it was one of ours. */
  settle(tag) {
    const before = this.pending.length;
    this.pending = this.pending.filter((step) => step.tag !== tag);
    return this.pending.length < before;
  }

  /** The order of the server, if it is not older than the one that is known. */
  take({ version, rows }) {
    if (version < this.version) return;
    const here = new Set(rows);
    let below = null;
    for (const id of [...this.confirmed].reverse()) {
      if (here.has(id)) below = id;
      else this.below.set(id, below);
    }
    this.version = version;
    this.confirmed = rows;
    this.whole = true;
  }

  /** Rows that came: as new ones, or as a piece of a long sheet. */
  came(rows) {
    for (const row of rows) if (!this.table.row(row.id)) this.aside.set(row.id, row);
  }

  /** The next piece of a long sheet, as bodies of the table. */
  append(bodies) {
    const rows = bodies.flatMap((body) => [...body.rows]).filter((row) => !this.table.row(row.id));
    if (this.whole) {
      this.came(rows);
      return this.show();
    }
    const fresh = new Set(rows);
    for (const body of bodies) for (const row of [...body.rows]) if (!fresh.has(row)) row.remove();
    this.confirmed.push(...rows.map((row) => row.id));
    this.table.append(bodies.filter((body) => body.rows.length));
    return rows.length > 0;
  }

  /** Replace a row that is not shown; true if there is one. */
  replaceAside(id, row) {
    return this.aside.has(id) && Boolean(this.aside.set(id, row));
  }

  /** Let the table show the order; true if anything is new. Only the rows between the first and the last difference move. */
  show(wanted = this.pending.reduce((ids, step) => applied(ids, step, this.below), this.confirmed)) {
    const { table } = this;
    const now = table.rows;
    const ids = wanted.filter((id) => table.row(id) || this.aside.has(id));
    let top = 0;
    while (top < now.length && top < ids.length && now[top].id === ids[top]) top++;
    if (top === now.length && top === ids.length) return false;
    let end = 0;
    while (end < Math.min(now.length, ids.length) - top && now.at(-1 - end).id === ids.at(-1 - end)) end++;
    const next = end ? now[now.length - end] : null;
    const middle = now.slice(top, now.length - end);
    for (const row of middle) {
      this.aside.set(row.id, row);
      table.remove(row);
    }
    table.insert(ids.slice(top, ids.length - end).map((id) => this.aside.get(id)), next);
    for (const row of table.rows.slice(top, ids.length - end)) this.aside.delete(row.id);
    this.forget(middle);
    return true;
  }

  // what cannot come back without being told anew
  forget(rows) {
    const kept = new Set([...this.confirmed, ...this.pending.flatMap((step) => step.insert ?? [])]);
    for (const row of rows) if (!kept.has(row.id)) this.aside.delete(row.id);
  }
}

// An order with a step made in it. A row that is to stand before one that is gone stands before the next that was below it.
function applied(ids, { insert = [], remove = [], move = [], before }, below) {
  const [gone, here] = [new Set([...remove, ...move]), new Set(ids)];
  const block = [...insert.filter((id) => !here.has(id)), ...move.filter((id) => here.has(id))];
  let next = before ?? null;
  while (next !== null && !here.has(next)) next = below.get(next) ?? null;
  const rest = ids.filter((id) => !gone.has(id) || id === next); // a row may be moved before itself
  if (!block.length) return rest.filter((id) => !gone.has(id));
  const at = next === null ? rest.length : rest.indexOf(next);
  return [...rest.slice(0, at), ...block, ...rest.slice(at).filter((id) => !gone.has(id))];
}
