// The grid: a spreadsheet in the browser over a table that the server renders (keys, pointer, clipboard, rows).

import { isComposed, press } from "../commands.js";
import { listed, t, tn } from "../texts.js";
import { Clipboard } from "./clipboard.js";
import { Editor, key } from "./editor.js";
import { Drafts, Server } from "./edits.js";
import { Filter } from "./filter.js";
import { Headers } from "./headers.js";
import { Held } from "./pending.js";
import { conflict, lost } from "./people.js";
import { comments, Mending, spoken as aboutComment, Unfinished } from "./problems.js";
import { Renaming } from "./renaming.js";
import { Looks } from "./looks.js";
import { Rows } from "./rows.js";
import { pointer, Selection } from "./selection.js";
import { Spoken, status } from "./spoken.js";
import { StatusBar } from "./status_bar.js";
import { HEADER, Threads } from "./threads.js";
import { Columns } from "./widths.js";

const BODY = 50; // rows of a body; the browser leaves out the bodies that are out of sight
const MOST_PAINTED = 1_000; // rows of a filtered sheet of which it leaves out none: it would keep their old heights

export class Grid {
  /** `page`: who this page is, see api.js; `listen`: where the server's events come. */
  constructor(scroll, page, listen) {
    this.scroll = scroll;
    const element = scroll.querySelector("[role=grid]");
    this.table = new Table(element);
    this.bar = document.getElementById("formula-bar");
    this.words = JSON.parse(document.getElementById("vocabulary").textContent);
    this.selection = new Selection(this.table, scroll, () => this.stand());
    this.held = new Held(this);
    this.whole = false; // whether all rows are here: those of a long sheet come in pieces
    this.loaded = new Promise((resolve) => (this.complete = resolve)).then(() => (this.whole = true));
    this.server = new Server(element, this.table, page.client, {
      held: this.held,
      before: () => this.selection.indexes(),
      after: (before, change, moved) => {
        if (moved) this.spoken.renumbered();
        this.selection.mend(before);
        this.editor.mend();
        this.stand();
      },
      headers: (comments) => this.threads.heads(comments),
      refused: (answer, action, body) => this.refused(answer, action, body),
    });
    listen.addEventListener("grid", ({ detail }) => this.server.receive(JSON.parse(detail.data)));
    this.editor = new Editor(this.table, scroll, {
      vocabulary: () => this.words,
      say: (text) => this.say(text, "error"), // with a text that is nowhere else
      refuses: () => this.refuses(),
      selected: () => this.selection.cell,
      named: (cell) => this.spoken.nameOf(cell),
      meant: (cell, was, text) => this.renaming.meant(cell, was, text),
      renames: (meant) => this.renaming.preview(meant),
      ask: (...names) => this.renaming.ask(...names),
      editing: (row, k, on) => this.taking(row, k, on),
      typing: () => {
        this.fillBar(); // a long text has more room there
        this.drafts.keep();
      },
      lost: (why, text) => lost(this, why, [{ text }]),
    }, (...edit) => this.edited(...edit));
    this.renaming = new Renaming(this);
    this.drafts = new Drafts(this, page);
    this.spoken = new Spoken(this, page);
    this.unfinished = new Unfinished(this);
    this.mending = new Mending(this);
    this.comments = comments(this);
    this.columns = new Columns(this);
    this.rows = new Rows(this);
    this.clipboard = new Clipboard(this);
    this.filter = new Filter(this);
    this.statusBar = new StatusBar(this);
    this.looks = new Looks(this);
    this.threads = new Threads(this);
    this.headers = new Headers(this);
    this.landing = ""; // where the cursor goes when the page is loaded again, as in its address
    this.bar.querySelector("code").addEventListener("click", () => this.selection.cell && !this.editor.isOpen && this.editor.open(this.selection.cell));
    scroll.addEventListener("keydown", (event) => press("row", event, this) && event.stopPropagation(), true);
    scroll.addEventListener("keydown", (event) => this.key(event));
    pointer(this);
    element.addEventListener("focusin", (event) => {
      const cell = event.target.closest("button") ? null : event.target.closest("[role=gridcell]");
      if (cell && !this.selection.head) this.selection.go(cell.parentElement, Math.max(this.table.column(cell), 0));
      if (event.target === this.selection.cell) this.editor.wait(cell);
    });
    element.addEventListener("change", (event) => this.switched(event));
  }

  /** A key in the sheet, unless an input method is at work. */
  key(event) {
    if (isComposed(event)) return;
    if (this.editor.isOpen) press("editor", event, this);
    else if (this.selection.head && !event.target.closest("button, [role=menu]") && !press("cell", event, this) && event.key === "Tab") this.editor.leave();
  }

  /** To what stands beside the sheet, and back. */
  beside() {
    const part = [...document.querySelectorAll(".below a[href], .below button, .below [tabindex='0']")].find((one) => one.checkVisibility());
    if (!part || document.activeElement.closest(".below")) this.selection.cell?.focus({ preventScroll: true });
    else part.focus();
  }

  /** Tell something aloud and in the status line; `kind` as in spoken.js, or whether it is a warning. */
  say(text, kind = false) {
    status(text, typeof kind === "string" ? kind : kind ? "warning" : "told");
  }

  /** Take a cell for editing, or give it free; when somebody else has it, that is told. */
  async taking(row, k, on) {
    const comment = on ? aboutComment(this.table, this.table.cell(this.table.row(row), k)) : "";
    if (on) this.spoken.say(t("Editing {column}. {help}", { column: this.table.name(k), help: comment || t("Enter to save, Escape to cancel.") }));
    const column = this.table.sheetColumn(k);
    if (!on) this.drafts.drop();
    const answer = await this.server[on ? "lock" : "unlock"](row, column);
    if (answer.locked && this.editor.isOpen && this.editor.rowId === row && this.editor.k === k) {
      this.editor.contest();
      this.say(t("{why} Whoever finishes second is asked which text to keep.", { why: answer.message }), true);
    }
  }

  /** An edit was not made: where somebody else was quicker, both texts are shown; else it is said why. */
  refused(answer, action, body) {
    this.say(answer.message, "error");
    if (action === "replace") return; // nothing was changed: what is there now can be looked at, and searched again
    if (action === "comment") this.threads.giveBack(body, answer.message);
    if (answer.clashes?.length) conflict(this, answer.clashes);
    else if (action === "cells" && !answer.locked) {
      this.takeBack(body.cells);
      lost(this, answer.message, body.cells);
    }
  }

  /** Show again what stands in the file, where a text was not stored. */
  takeBack(cells) {
    for (const { row, column, text, was } of cells) {
      const k = this.table.placeOf(column);
      const cell = this.table.cell(this.table.row(row), k);
      if (!cell || was === null || this.table.value(cell) !== text) continue;
      this.table.put(cell, was);
      this.spoken.nameCell(cell);
    }
    this.editor.follow();
    this.stand();
  }

  /** True, with a message, when the sheet can only be read here. */
  refuses() {
    const fixed = this.table.grid.ariaReadOnly === "true";
    if (fixed) this.say(t("You cannot change this sheet here."), true);
    return fixed;
  }

  /** Show what belongs to the cell where the cursor stands, and tell the others where that is. */
  stand() {
    const { row, cell } = this.selection;
    if (!cell) return;
    const k = this.selection.head.k;
    const here = `${row.id} ${k}`;
    if (here !== this.here) this.server.stand(row.id, k);
    this.unfinished.at(row.id);
    const told = `${here} ${JSON.stringify(this.selection.boxes())}`;
    if (told !== this.told) this.spoken.moved();
    this.statusBar?.soon();
    this.here = here;
    this.told = told;
    this.mending.place();
    this.threads?.soon();
    this.bar.querySelector("b").textContent = this.table.address(cell);
    this.fillBar();
    this.bar.classList.toggle("at-comment", row.classList.contains("comment"));
    document.dispatchEvent(new CustomEvent("rrp:row", { detail: { number: Number(row.cells[0].textContent) } }));
  }

  /** Show the text of the cell, or the one that is being typed into it. */
  fillBar() {
    const text = this.editor.isOpen ? this.editor.field.value : this.table.value(this.selection.cell);
    this.bar.querySelector("code").textContent = text;
  }

  /** Change cells: `[cell, text]` pairs; those that stay as they are are left out. `carried`: comments that go along. */
  change(pairs, carried = []) {
    if (this.refuses()) return;
    const changes = [];
    for (const [cell, text] of pairs) {
      const was = this.table.value(cell);
      if (was === text) continue;
      changes.push({ row: cell.parentElement.id, k: this.table.column(cell), text, was });
      this.table.put(cell, text);
    }
    if (changes.length || carried.length) this.store(changes, { carried });
    this.stand();
  }

  /** Send changes that are shown already; to `rename`, one that gives a name, with all cells that have it; `devices` and the comments
   *  that are `carried` come with them. */
  store(changes, { rename = false, devices: chosen = [], carried = [] } = {}) {
    this.rows.reserve(0);
    const devices = [...new Map([...this.lacking(changes), ...chosen].map((one) => [key(one.stream), one])).values()];
    const answer = this.server.cells(changes, { rename, devices, carried });
    if (devices.length) answer.then(({ rows }) => this.added(rows ?? []), () => {});
    // which cells change only the server knows: what is typed next may be into one of them
    if (rename) this.held.until(() => answer.then(({ rows }) => this.renaming.told(rows ?? [], changes[0]), () => {}));
    for (const { row, k } of changes) {
      this.spoken.nameCell(this.table.cell(this.table.row(row), k));
      this.comments.mark(this.table.row(row));
    }
    this.editor.follow();
  }

  /** What the sheet Devices lacks for names in these cells: devices with one of their choices, such as “Wave”, and those with a
   *  Japanese name. */
  lacking(changes) {
    const { choices: chosen = [], sensors = [], actuators = [] } = this.words;
    const choices = new Map([...chosen, ...[...sensors, ...actuators].filter((one) => one.named)].map((one) => [key(one.text), one]));
    return changes.flatMap(({ row, k, text }) => {
      const kind = this.editor.kind(k);
      const wanted = kind === "inputs" ? "sensor" : kind === "output" && this.connector(row) === "subscribe" ? "actuator" : "";
      const found = wanted ? text.split(/[,\n]/).map((name) => choices.get(key(name))).filter((one) => one?.kind === wanted) : [];
      return found.map((one) => ({ stream: one.text, ...one.adds }));
    });
  }

  connector(row) {
    const k = this.table.headers.findIndex((head) => head.dataset.kind === "connector");
    return k < 0 ? "" : this.table.value(this.table.cell(this.table.row(row), k)).trim();
  }

  /** Tell which devices were added to the sheet Devices. */
  added(rows) {
    const names = rows.flatMap(({ devices = [] }) => devices);
    const sheet = rows.find((change) => change.sheet !== this.server.sheet)?.sheet;
    if (sheet && names.length) this.say(t("Added to {sheet}: {names}. Press Ctrl+Z to undo.", { sheet, names: listed(names) }));
  }

  edited(cell, text, was, move, alone = false, devices = []) {
    if (text !== was) {
      const change = { row: cell.parentElement.id, k: this.table.column(cell), text, was };
      this.table.put(cell, text);
      this.unfinished.typed(change.row);
      this.store([change], { rename: !alone && was !== "" && text.trim() !== "" && this.renaming.gives(cell), devices });
    }
    const { row } = this.selection;
    const { k } = this.selection.head;
    if (move === null) {
      if (document.activeElement === document.body) this.selection.go(row, k);
    } else this.move(move, row, k);
    this.spoken.moved(text !== was ? t("Saved") : move === null ? t("Cancelled") : t("Unchanged"));
    this.stand();
  }

  /** Hold an action until the rows of a long sheet that it needs are here; true if so. */
  waits(rows, action) {
    if (this.whole || rows <= this.table.rows.length) return false;
    this.held.until(async () => {
      await this.loaded;
      action();
    });
    return true;
  }

  /** Move the cursor as a key does: an arrow's direction, `tab` or `back` (Tab), `enter` or `raise` (Enter). As in a spreadsheet, Enter
   *  after a row of Tabs goes to the column where they began. */
  move(where, row = this.selection.row, k = this.selection.head.k) {
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
    if (this.held.takes(() => this.clear())) return;
    this.change(this.selection.all().map((cell) => [cell, ""]));
  }

  /** The first row of the selection into the others (Ctrl+D), or the first column (`right`, Ctrl+R); into a single one what stands
   *  above it, or at its left. */
  fill(right = false) {
    if (this.held.takes(() => this.fill(right))) return;
    const { table, selection } = this;
    this.change(selection.boxes().flatMap((box) => {
      const lines = selection.cells(box);
      const alone = right ? box.left === box.right : lines.length === 1;
      const above = table.step(lines[0][0].parentElement, -1);
      if (alone && (right ? box.left === 0 : above === lines[0][0].parentElement)) return [];
      const from = (i, j) => (right ? lines[i][0] : lines[0][j]);
      const before = (i, j) => (right ? table.cell(lines[i][0].parentElement, box.left - 1) : table.cell(above, box.left + j));
      return lines.flatMap((line, i) => line.map((cell, j) => [cell, table.value(alone ? before(i, j) : from(i, j))]));
    }));
  }

  /** What is typed into all selected cells (Ctrl+Enter); in a single one a new name is for this cell alone. */
  fillAll() {
    const cells = this.selection.all();
    if (cells.length < 2) return this.editor.close(true, "enter", true);
    const text = this.editor.field.value;
    const again = this.selection.kept();
    this.editor.close(false, null);
    this.change(cells.map((cell) => [cell, text]));
    return again();
  }

  /** Take back one's newest edit: which that is, and what it changes, only the server knows. */
  undo(isRedo = false) {
    if (this.held.takes(() => this.undo(isRedo))) return;
    this.held.until(async () => {
      const answer = await this.server.send(isRedo ? "redo" : "undo", {});
      if (answer.sheets) document.dispatchEvent(new CustomEvent("rrp:sheets", { detail: { ...answer.sheets, undone: true } }));
      else if (answer.rows?.length) retrace(this, answer.rows, isRedo);
    });
  }

  redo() {
    this.undo(true);
  }

  fix(button) {
    const { finding, fix, title } = button.dataset;
    if (this.held.takes(() => this.fix(button))) return;
    this.held.until(async () => {
      const answer = await this.server.send("fix", { finding, fix, title });
      if (!answer.rows?.length) return;
      this.selection.cell?.focus({ preventScroll: true });
      const others = [...new Set(answer.rows.map((r) => r.sheet))].filter((name) => name !== this.server.sheet);
      this.say(others.length
        ? t("Done: {title} (also in {sheets}). Press Ctrl+Z to undo.", { title, sheets: listed(others) })
        : t("Done: {title}. Press Ctrl+Z to undo.", { title }));
      this.lead(answer.rows);
    });
  }

  /** Go to the cell that is to be filled in after an edit, if it names one: of another sheet, or of a column that comes when the page
   *  is loaded again. */
  lead(changes) {
    const found = changes.find(({ cursor }) => cursor);
    if (!found) return;
    const [row, address] = found.cursor;
    const cell = found.sheet === this.server.sheet && this.table.named(address);
    if (cell) this.selection.go(cell.parentElement, this.table.column(cell));
    else if (found.sheet === this.server.sheet) this.landing = `#${row}~${address}`;
    else if (!document.getElementById("session")) location.assign(`${this.server.url}/sheet/${encodeURIComponent(found.sheet)}#${row}~${address}`);
  }
}

// The changes of an undo or a redo: told in words, and shown.

/** Go to what an undo or redo has changed, and tell it. */
function retrace(grid, entries, isRedo) {
  const here = entries.filter((entry) => entry.sheet === grid.server.sheet);
  const others = [...new Set(entries.map((entry) => entry.sheet))].filter((name) => name !== grid.server.sheet);
  const told = here.map((entry) => describe(grid, entry)).filter(Boolean);
  if (others.length) told.push(t("changed in {sheets}", { sheets: listed(others) }));
  const changes = told.slice(0, 3).join("; ") || t("nothing to be seen");
  grid.say(isRedo ? t("Redone: {changes}.", { changes }) : t("Undone: {changes}.", { changes }));
}

function describe(grid, { cells, about, heads, insert, remove, move }) {
  const { table, selection } = grid;
  if (heads?.length) {
    const [column, text] = heads[0];
    if (!text) return t("the column is removed");
    return table.placeOf(column) < 0 ? t("the column “{text}” is back", { text }) : t("the column is “{text}” again", { text });
  }
  if (cells?.length) {
    if (cells[0][0] === HEADER) return t("comments of {cell}", { cell: table.address(table.headers[table.placeOf(cells[0][1])]) });
    const places = cells.map(([row, column]) => [table.row(row), table.placeOf(column)]);
    const known = places.filter(([row, k]) => row && k >= 0);
    if (!known.length) return "";
    const [row, k] = known[0];
    selection.go(row, k);
    const cell = table.cell(row, k);
    const text = table.value(cell);
    const address = table.address(cell);
    if (about === "comments") return t("comments of {cell}", { cell: address });
    if (about === "looks") return tn("format of {cell}", "format of {n} cells from {cell} on", { n: known.length, cell: address });
    if (known.length > 1) return t("{n} cells from {cell} on", { n: known.length, cell: address });
    return text ? t("{cell} is “{text}” again", { cell: address, text: shortened(text) }) : t("{cell} is empty again", { cell: address });
  }
  if (insert?.length || move?.length) {
    const ids = insert?.length ? insert.map(({ html }) => /id="([^"]+)"/.exec(html)[1]) : move.map((m) => m.id);
    const numbers = ids.map((id) => Number(table.row(id)?.cells[0].textContent)).filter(Boolean).sort((a, b) => a - b);
    const first = [...table.rows].find((row) => Number(row.cells[0].textContent) === numbers[0]);
    if (first) selection.go(first, selection.head.k);
    const span = { first: numbers[0], last: numbers.at(-1) };
    if (insert?.length) return numbers.length > 1 ? t("rows {first} to {last} are back", span) : t("row {first} is back", span);
    return numbers.length > 1 ? t("rows {first} to {last} moved", span) : t("row {first} moved", span);
  }
  if (remove?.length) return tn("a row was deleted", "{n} rows were deleted", { n: remove.length });
  return "";
}

const shortened = (text) => (text.length > 60 ? `${text.slice(0, 59)}…` : text);

// The table that the server rendered, as the other modules see it: rows with ids that stay, and editable columns
// counted from 0 (`data-c` on a header is the sheet's own column number).

export class Table {
  constructor(grid) {
    this.grid = grid;
    this.first = Number(grid.dataset.first); // the number of its first row: the header is above it
    this.headers = [...grid.tHead.rows[0].cells].filter((h) => h.dataset.c);
    this.places = this.headers.map((h) => h.cellIndex);
    this.width = this.headers.length;
    this.kind = /\bof-(\w+)/.exec(grid.className)?.[1] ?? "";
    this.off = new Set(grid.dataset.off?.split(" ")); // the words that switch a row off
    this.hidden = new Set(); // ids of the rows that are not shown in this page
  }

  /** All rows, from top to bottom. */
  get rows() {
    this.all ??= [...this.grid.querySelectorAll(":scope > tbody > tr")];
    return this.all;
  }

  /** The rows that are not hidden. */
  get shown() {
    this.seen ??= this.hidden.size ? this.rows.filter((row) => !this.hidden.has(row.id)) : this.rows;
    return this.seen;
  }

  /** Hide the rows of these ids, and show all others. */
  hide(ids) {
    this.hidden = ids;
    this.grid.classList.toggle("filtered", ids.size > 0 && this.rows.length - ids.size < MOST_PAINTED);
    for (const row of this.rows) if (row.hidden !== ids.has(row.id)) row.hidden = !row.hidden;
    for (const body of this.grid.tBodies) body.hidden = [...body.rows].every((row) => row.hidden);
    this.changed();
  }

  /** Show a row that is hidden. */
  show(row) {
    if (!this.hidden.delete(row.id)) return;
    row.hidden = row.parentElement.hidden = false;
    this.changed();
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

  /** Give a column of the sheet another header. */
  rename(sheetColumn, text) {
    const header = this.headers[this.placeOf(sheetColumn)];
    if (!header) return;
    Object.assign(header.dataset, { name: text, spellings: key(text) });
    header.ariaLabel = t("{name}, column {letter}", { name: text, letter: header.dataset.letter });
    header.querySelector(".title").textContent = text;
    header.querySelector(".widen").ariaLabel = t("Width of {column}", { column: text });
  }

  /** A cell's address, such as C4. */
  address(cell) {
    return `${this.headers[this.column(cell)].dataset.letter}${cell.closest("thead") ? this.first - 1 : cell.parentElement.cells[0].textContent}`;
  }

  /** The cell or the header of an address; undefined for one that is not here. */
  named(address) {
    const [, letters, number] = /^([A-Z]+)(\d+)$/.exec(address);
    const k = this.headers.findIndex((header) => header.dataset.letter === letters);
    return Number(number) === this.first - 1 ? this.headers[k] : this.cell(this.rows[number - this.first], k);
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

  /** The row so many shown rows away, stopping at the first and the last. */
  step(row, by) {
    const to = Math.min(Math.max(this.spot(row) + by, 0), this.shown.length - 1);
    return this.shown[to];
  }

  /** The place of a row among those that are shown. */
  spot(row) {
    if (!this.hidden.size) return this.at(row);
    this.spots ??= new Map(this.shown.map((one, i) => [one, i]));
    return this.spots.get(row) ?? -1;
  }

  at(row) {
    this.indexes ??= new Map(this.rows.map((one, i) => [one, i]));
    return this.indexes.get(row) ?? -1;
  }

  /** The cell an arrow with Ctrl leads to: the edge of the filled block, or the next filled cell, or the end. */
  edge(row, k, down, right) {
    const filled = (r, c) => this.value(this.cell(r, c)) !== "";
    const next = (r, c) => {
      const row2 = down ? this.shown[this.spot(r) + down] : r;
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
    const last = this.rows.length - 1 - this.room();
    return this.shown.findLast((row) => this.at(row) <= last) ?? this.shown[0];
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

  /** Show new HTML of a row. It may come before inserts and deletes above it, so the row keeps its number until they are shown. */
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
    this.all = this.indexes = this.seen = this.spots = null;
    for (const row of this.hidden.size ? rows : []) {
      row.hidden = this.hidden.has(row.id);
      if (!row.hidden && row.parentElement) row.parentElement.hidden = false;
    }
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
