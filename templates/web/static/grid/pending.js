// What is done while only the server knows what the sheet will be (an undo is on its way) waits for it, in its order.

const PATIENCE = 1000; // milliseconds until it is told that something waits
const BUTTONS = "[data-do=undo], [data-do=redo], [data-fix]"; // they may have the focus while what they began is under way
const SILENT = new Set(["Dead", "Process", "Shift", "Control", "Alt", "Meta", "AltGraph"]); // they do nothing by themselves

export class Held {
  constructor(grid) {
    this.grid = grid;
    this.jobs = 0;
    this.copies = false;
    this.copied = "";
    this.actions = [];
    this.field = document.createElement("textarea"); // takes what no key tells: an input method's text, say
    this.field.className = "only-spoken";
    this.field.tabIndex = -1;
    this.field.setAttribute("aria-label", "Waiting for the server");
    this.field.addEventListener("input", (event) => event.isComposing || this.text());
    this.field.addEventListener("compositionend", () => this.text());
    for (const kind of ["keydown", "paste", "copy", "cut", "pointerdown", "dblclick", "contextmenu", "click"]) {
      document.addEventListener(kind, (event) => this.event(event), true);
    }
    addEventListener("beforeunload", (event) => this.actions.length && event.preventDefault());
  }

  /** Hold what is done until a job has ended. */
  async until(job) {
    this.jobs++;
    const slow = setTimeout(() => this.grid.say("The server has not answered yet. What you type is kept and follows."), PATIENCE);
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
    this.actions.push(() => {
      const { editor, selection } = this.grid;
      if (editor.isOpen) document.execCommand("insertText", false, text);
      else editor.open(selection.cell, text);
    });
  }

  /** Whether an action of a menu or a button has to wait; it is done later then, and first ends an edit as a click does. */
  takes(action) {
    if (!this.jobs || this.playing) return false;
    this.actions.push(() => {
      if (this.grid.editor.isOpen) this.grid.editor.close(true, null);
      action();
    });
    return true;
  }

  replay() {
    while (this.actions.length && !this.jobs) {
      const action = this.actions.shift();
      this.playing = true;
      try {
        action();
      } finally {
        this.playing = false;
      }
    }
    if (!this.actions.length) this.copies = false;
  }

  // Only what is meant for the grid: Stop, say, never waits.
  event(event) {
    if (!this.jobs || this.playing) return;
    const { target } = event;
    if (!this.grid.scroll.contains(target) && !(event.type === "keydown" && target.closest?.(BUTTONS))) return;
    const action = this[event.type](event);
    if (!action) return;
    event.preventDefault();
    event.stopPropagation();
    this.actions.push(action);
    this.hold();
  }

  keydown(event) {
    const { key, code, ctrlKey, metaKey, altKey, shiftKey } = event;
    const control = ctrlKey || metaKey;
    if (event.isComposing || event.keyCode === 229 || SILENT.has(key) || /^F(1|[3-9]|1\d)$/.test(key)) return null;
    if (control && /^[cxvrtwnlp]$/i.test(key)) return null; // the clipboard's have events of their own; the browser's
    return () => this.press({ key, code, ctrlKey, metaKey, altKey, shiftKey });
  }

  paste(event) {
    const text = event.clipboardData.getData("text/plain");
    const { copies } = this; // one that waits too: what it puts on the clipboard is not there yet
    return () => {
      const { editor, clipboard } = this.grid;
      const now = copies ? this.copied : text;
      if (editor.isOpen) document.execCommand("insertText", false, now);
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
    return () => {
      if (editor.isOpen) editor.close(true, null);
      if (k >= 0) selection.go(table.row(row), k, shiftKey);
      else if (table.row(row)) selection.spread(table.at(table.row(row)), 0, table.at(table.row(row)), table.width - 1);
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

// What the browser does with a key in a text field.
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
