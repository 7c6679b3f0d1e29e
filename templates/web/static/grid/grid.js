// The grid: a spreadsheet in the browser over a table that the server renders (keys, pointer, clipboard, rows).

import { conflict, lost } from "./conflict.js";
import { Editor } from "./editor.js";
import { keys } from "./keys.js";
import { pointer } from "./pointer.js";
import { Selection } from "./selection.js";
import { Server } from "./server.js";
import { Table } from "./table.js";
import { format, parse } from "./tsv.js";

export class Grid {
  constructor(scroll) {
    this.scroll = scroll;
    const element = scroll.querySelector("[role=grid]");
    this.table = new Table(element);
    this.bar = document.getElementById("formula-bar");
    this.words = JSON.parse(document.getElementById("vocabulary").textContent);
    this.selection = new Selection(this.table, scroll, () => this.look());
    this.server = new Server(element, this.table, {
      before: () => this.selection.indexes(),
      after: (before) => {
        this.selection.mend(before);
        this.editor.mend();
        this.look();
      },
      refused: (answer, action, body) => this.refused(answer, action, body),
      away: () => this.say("The server cannot be reached. Your changes are kept here and sent when it is back.", true),
      back: () => this.say("The server is back; your changes are saved."),
      saving: (busy) => document.body.toggleAttribute("data-saving", busy),
    });
    this.editor = new Editor(this.table, scroll, {
      vocabulary: () => this.words,
      say: (text) => this.say(text, true),
      editing: (row, k, on) => this.taking(row, k, on),
    }, (cell, text, was, move) => this.edited(cell, text, was, move));
    keys(this);
    pointer(this);
    this.clipboard();
    element.addEventListener("focusin", (event) => {
      const cell = event.target.closest("[role=gridcell]");
      if (cell && !this.selection.head) this.selection.go(cell.parentElement, Math.max(this.table.column(cell), 0));
    });
    element.addEventListener("change", (event) => this.switched(event));
  }

  /** Tell something aloud and in the status line. */
  say(text, warn = false) {
    const line = document.getElementById("status");
    line.textContent = text;
    line.classList.toggle("is-warning", warn);
  }

  /** Take a cell for editing, or give it free; when somebody else has it, the editor closes again. */
  async taking(row, k, on) {
    const answer = await this.server.send(on ? "lock" : "unlock", { row, column: this.table.sheetColumn(k) });
    if (answer.taken && this.editor.isOpen && this.editor.rowId === row && this.editor.k === k) {
      const text = this.editor.field.value;
      this.editor.close(false, null);
      if (text !== this.table.value(this.table.cell(this.table.row(row), k))) this.say(`${answer.message} You had typed: ${text}`, true);
    }
  }

  /** An edit was not made: where somebody else was quicker, both texts are shown; else it is said why. */
  refused(answer, action, body) {
    this.say(answer.message, true);
    if (answer.clashes?.length) conflict(this, answer.clashes);
    else if (action === "cells" && !answer.taken) lost(this, answer.message, body.cells);
  }

  look() {
    const { row, cell } = this.selection;
    if (!cell || !this.bar) return;
    const k = this.selection.head.k;
    const here = `${row.id} ${k}`;
    if (here !== this.here) this.server.stand(row.id, k);
    this.here = here;
    this.bar.querySelector("b").textContent = `${this.table.headers[k].dataset.letter}${row.cells[0].textContent}`;
    this.bar.querySelector("code").textContent = this.table.value(cell);
    document.dispatchEvent(new CustomEvent("rrp:row", { detail: { number: Number(row.cells[0].textContent) } }));
  }

  /** Change cells: `[cell, text]` pairs; those that stay as they are are left out. */
  change(pairs) {
    const changes = [];
    for (const [cell, text] of pairs) {
      const was = this.table.value(cell);
      if (was === text || cell.getAttribute("aria-readonly") === "true" || this.table.grid.ariaReadOnly === "true") continue;
      changes.push({ row: cell.parentElement.id, k: this.table.column(cell), text, was });
      this.table.put(cell, text);
    }
    if (changes.length) this.server.cells(changes);
    this.look();
  }

  edited(cell, text, was, move) {
    if (text !== was) {
      const change = { row: cell.parentElement.id, k: this.table.column(cell), text, was };
      this.table.put(cell, text);
      this.server.cells([change]);
    }
    const { row } = this.selection;
    const { k } = this.selection.head;
    if (move === null) {
      if (document.activeElement === document.body) this.selection.go(row, k);
    } else this.move(move, row, k);
    this.look();
  }

  /** Where a key leads: an arrow's direction, `tab` or `back` (Tab), `enter` or `raise` (Enter). As in a spreadsheet, Enter
   *  after a row of Tabs goes to the column where they began. */
  move(where, row, k) {
    const begun = this.tabs && this.tabs.row === row.id && this.tabs.k === k ? this.tabs.start : k;
    this.tabs = null;
    if (where === "enter" || where === "raise") {
      return this.selection.go(this.table.step(row, where === "enter" ? 1 : -1), begun);
    }
    const by = { up: [-1, 0], down: [1, 0], left: [0, -1], right: [0, 1], back: [0, -1], tab: [0, 1] }[where];
    this.go(by, row, k);
    if (where === "tab" || where === "back") this.tabs = { start: begun, row: this.selection.row.id, k: this.selection.head.k };
    return undefined;
  }

  go(by, row, k) {
    if (by[0]) return this.selection.go(this.table.step(row, by[0]), k);
    const to = k + by[1];
    if (to >= 0 && to < this.table.width) return this.selection.go(row, to);
    const next = this.table.step(row, by[1]);
    this.selection.go(next, next === row ? k : to < 0 ? this.table.width - 1 : 0);
  }

  switched(event) {
    const cell = event.target.closest("td.on");
    if (!cell) return;
    this.change([[cell, event.target.checked ? "TRUE" : "FALSE"]]);
  }

  clear() {
    this.change(this.selection.cells().flat().map((cell) => [cell, ""]));
  }

  /** The first row of the selection into the others (Ctrl+D). */
  fillDown() {
    const [first, ...others] = this.selection.cells();
    this.change(others.flatMap((line) => line.map((cell, j) => [cell, this.table.value(first[j])])));
  }

  /** Lines of texts into the cells from the selection's first cell on; one value fills the whole selection. */
  async paste(lines) {
    const box = this.selection.box();
    if (!box) return;
    if (lines.length === 1 && lines[0].length === 1) {
      this.change(this.selection.cells().flat().map((cell) => [cell, lines[0][0]]));
      return;
    }
    const height = box.bottom - box.top + 1;
    const times = height % lines.length === 0 ? height / lines.length : 1;
    const all = Array.from({ length: times }, () => lines).flat();
    const missing = box.top + all.length - this.table.rows.length;
    if (missing > 0) await this.server.send("insert", { before: null, count: missing });
    const pairs = all.flatMap((line, i) => line.slice(0, this.table.width - box.left).map((text, j) => [
      this.table.cell(this.table.rows[box.top + i], box.left + j), text,
    ]));
    this.change(pairs);
    const wide = Math.max(...all.map((line) => line.length));
    this.selection.spread(box.top, box.left, Math.min(box.top + all.length, this.table.rows.length) - 1,
      Math.min(box.left + wide, this.table.width) - 1);
  }

  copied() {
    return format(this.selection.cells().map((line) => line.map((cell) => this.table.value(cell))));
  }

  clipboard() {
    const mine = () => !this.editor.isOpen && this.selection.head && this.scroll.contains(document.activeElement);
    document.addEventListener("copy", (event) => {
      if (!mine()) return;
      event.preventDefault();
      event.clipboardData.setData("text/plain", this.copied());
      this.say("Copied.");
    });
    document.addEventListener("cut", (event) => {
      if (!mine()) return;
      event.preventDefault();
      event.clipboardData.setData("text/plain", this.copied());
      this.clear();
    });
    document.addEventListener("paste", (event) => {
      if (!mine()) return;
      event.preventDefault();
      this.paste(parse(event.clipboardData.getData("text/plain")));
    });
  }

  // ---- rows

  selectedRows() {
    const box = this.selection.box();
    return box ? [...this.table.rows].slice(box.top, box.bottom + 1) : [];
  }

  /** Insert as many rows as are selected; the selection then stands on the new ones, as in Excel. */
  async insertRows(below = false) {
    const rows = this.selectedRows();
    if (!rows.length) return;
    const box = this.selection.box();
    const before = below ? rows.at(-1).nextElementSibling : rows[0];
    const place = below ? box.bottom + 1 : box.top;
    const answer = await this.server.send("insert", { before: before?.id ?? null, count: rows.length });
    if (answer.rows) this.say(`${rows.length === 1 ? "A row" : `${rows.length} rows`} inserted.`);
    if (answer.rows) this.selection.spread(place, box.left, place + rows.length - 1, box.right);
  }

  async deleteRows() {
    const rows = this.selectedRows().map((row) => row.id);
    if (!rows.length) return;
    const answer = await this.server.send("delete", { rows });
    if (answer.rows) this.say(`${rows.length === 1 ? "The row is" : `${rows.length} rows are`} deleted.`);
  }

  moveRows(by) {
    const rows = this.selectedRows();
    const before = by < 0 ? rows[0]?.previousElementSibling : rows.at(-1)?.nextElementSibling?.nextElementSibling;
    if (!rows.length || (by < 0 && !before) || (by > 0 && !rows.at(-1).nextElementSibling)) return null;
    return this.server.send("move", { rows: rows.map((row) => row.id), before: before?.id ?? null });
  }

  async duplicateRows() {
    const rows = this.selectedRows();
    const texts = rows.map((row) => this.table.headers.map((_, k) => this.table.value(this.table.cell(row, k))));
    const last = this.table.at(rows.at(-1));
    await this.insertRows(true);
    this.change(texts.flatMap((line, i) => line.map((text, k) => [this.table.cell(this.table.rows[last + 1 + i], k), text])));
  }

  async undo() {
    if ((await this.server.send("undo", {})).rows) this.say("Undone.");
  }

  async redo() {
    if ((await this.server.send("redo", {})).rows) this.say("Done again.");
  }

  async fix(button) {
    const { code, place, title } = button.dataset;
    if ((await this.server.send("fix", { code, place, title })).rows) this.say(`Done: ${title}. Ctrl+Z takes it back.`);
  }
}
