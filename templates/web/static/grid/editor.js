// The one editor, and what it suggests. It is a text field outside the table, placed over the cell. It survives whatever
// happens to the table.

import { hintOf } from "../commands.js";
import { button, make } from "../elements.js";
import { t, tn } from "../texts.js";
import { noteOf } from "./problems.js";

const WORD = /[\p{L}\p{N}_]*$/u; // the one that is being typed
const MOST_OFFERED = 12; // suggestions for what is being typed
const MOST_AT_FIRST = 40; // suggestions before anything is typed
const LEAST_OF_HELP = 3; // letters, before words of the help are looked at
const LEAST_IN_QUOTES = 2; // letters
// languages that are typed with an input method; on a touch screen a field with the focus would bring up its keyboard
const COMPOSES = [document.documentElement.lang, ...navigator.languages].some((name) => /^(ja|zh|ko)\b/.test(name)) && matchMedia("(pointer: fine)").matches;
const JAPANESE = /[\u3040-\u30ff\u3400-\u9fff]/;
const WIDE = 440; // px of the list
const NOTHING = { items: [], from: 0, sure: false }; // to suggest
const HELP = "#help, [data-do=help], [data-topic]"; // has the focus while one reads how to go on
// words of formulas that are complete as they are, though functions begin with them
const COMPLETE = new Set(["value", "total", "true", "false", "none", "blank", "pi", "e", "and", "or", "not", "in", "if", "else", "mod", "xor"]);

let serial = 0;

export class Editor {
  /** `done(cell, text, was, move, alone, devices)` is called when a text is kept; `table` and `scroll` are the grid's. */
  constructor(table, scroll, context, done) {
    this.table = table;
    this.scroll = scroll;
    this.context = context;
    this.done = done;
    this.field = null;
    this.waiting = null; // a field over the selected cell, for an input method: it can compose only where the focus is in a field
    document.addEventListener("focusout", ({ target, relatedTarget }) => this.left(target, relatedTarget));
  }

  get isOpen() {
    return this.field !== null;
  }

  /** Move the focus of a selected cell to a field over it: an input method can compose only in a field. When it begins to, or text comes
   *  without a key, that field becomes the editor, so that nothing typed is lost. */
  wait(cell) {
    if (this.isOpen || this.leaves) return;
    if (!COMPOSES || this.table.grid.ariaReadOnly === "true" || cell.classList.contains("on")) {
      this.drop();
      return;
    }
    if (!this.waiting) {
      this.build();
      [this.waiting, this.field] = [this.field, null];
      this.waiting.tabIndex = -1;
      this.box.className = "waiting";
      for (const kind of ["compositionstart", "input"]) this.waiting.addEventListener(kind, () => this.open(this.context.selected(), null));
    }
    this.waiting.value = ""; // what was refused in another cell
    this.follow();
    this.waiting.focus({ preventScroll: true });
  }

  /** Lay the field that waits over the selected cell, and name it as the cell: a screen reader tells of what has the focus. */
  follow() {
    const cell = this.waiting && this.context.selected();
    if (!cell) return;
    const [, { width, height }] = this.put(cell);
    Object.assign(this.waiting.style, { width: `${width}px`, height: `${height}px` });
    this.waiting.ariaLabel = this.context.named(cell);
    this.waiting.setAttribute("aria-describedby", cell.getAttribute("aria-describedby") ?? ""); // its problems
  }

  /** Give the focus back to the selected cell: the browser's own Tab goes on from there. */
  leave() {
    if (!this.waiting) return;
    this.leaves = true;
    this.context.selected().focus({ preventScroll: true });
    this.leaves = false;
  }

  /** Away with the field that waits. */
  drop() {
    if (this.waiting) this.box.remove();
    this.waiting = null;
  }

  /** Begin to edit a cell: with what it holds, or (as when typing starts) with a first text; or go on with a text that was
   *  begun when the cell held `was`. With null its text is what comes into the field that waits. */
  open(cell, first, was) {
    if (this.isOpen || !cell || this.context.refuses()) return;
    const k = this.table.column(cell);
    this.rowId = cell.parentElement.id;
    this.k = k;
    this.contested = false;
    this.was = was ?? this.table.value(cell);
    this.adds = new Map(); // text of a suggestion that was taken → what it adds to the sheet Devices
    this.mode = first === undefined || was !== undefined ? "edit" : "enter";
    if (first === null) {
      [this.field, this.waiting] = [this.waiting, null];
      this.box.className = "editor";
    } else {
      this.drop();
      this.build();
      this.field.value = first ?? this.was;
    }
    this.field.className = ["formula", "send", "expect"].includes(this.kind(k)) ? "code" : "";
    for (const [name, value] of Object.entries({
      "aria-haspopup": "listbox", "aria-autocomplete": "list", "aria-controls": this.list.id, // of several lines, so no combobox
      "aria-label": t("{column}, row {row}", { column: this.table.name(k), row: cell.parentElement.cells[0].textContent }),
    })) this.field.setAttribute(name, value);
    this.scroll.classList.add("typing");
    this.scold(cell);
    this.place(cell);
    if (first !== null) {
      this.field.focus({ preventScroll: true });
      this.field.setSelectionRange(this.field.value.length, this.field.value.length);
    }
    this.update(first !== undefined, first === null);
    this.context.editing(this.rowId, k, true);
  }

  build() {
    this.box = document.createElement("div");
    this.box.className = "editor";
    this.field = document.createElement("textarea");
    this.field.rows = 1;
    this.field.spellcheck = false;
    this.field.autocomplete = "off";
    this.field.autocapitalize = "off";
    this.list = document.createElement("div");
    this.list.className = "suggestions";
    this.list.id = `editor-${++serial}`;
    this.list.hidden = true;
    this.list.setAttribute("role", "listbox");
    this.list.tabIndex = 0; // as it scrolls; Tab never leads there
    this.list.setAttribute("aria-label", t("Suggestions"));
    this.hint = document.createElement("div");
    this.hint.className = "signature";
    this.hint.hidden = true;
    this.wrong = document.createElement("div"); // what is wrong with the cell stays in sight, above the list
    this.wrong.className = "wrong";
    this.box.append(this.field, this.wrong, this.hint, this.list);
    this.scroll.append(this.box);
    this.field.addEventListener("input", (event) => this.isOpen && this.update(true, event.isComposing));
    this.field.addEventListener("compositionend", () => this.isOpen && this.update(true));
    this.field.addEventListener("click", () => this.update(false));
    this.hint.addEventListener("pointerdown", (event) => event.target.closest("button") && event.preventDefault()); // the focus stays
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

  put(cell) {
    const frame = this.scroll.getBoundingClientRect();
    const box = cell.getBoundingClientRect();
    const left = box.left - frame.left + this.scroll.scrollLeft;
    this.box.style.left = `${left}px`;
    this.box.style.top = `${box.top - frame.top + this.scroll.scrollTop}px`;
    return [frame, box];
  }

  place(cell) {
    const [frame, box] = this.put(cell);
    const over = box.left + Math.min(WIDE, 0.9 * innerWidth) - frame.right;
    this.box.style.setProperty("--back", `${Math.max(0, Math.min(over, box.left - frame.left))}px`); // the list stays in sight
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

  /** Show the suggestions once the word list is loaded, if an editor was opened before and none of its suggestions would be
   *  taken by Enter; Enter takes none of the new ones. */
  renew() {
    if (this.isOpen && this.chosen < 0 && this.typed !== null) this.update(false);
  }

  /** Look again at what could be meant; while an input method composes, nothing is chosen. */
  update(typed, composing = false) {
    this.typed = typed;
    this.grow();
    this.context.typing();
    const row = this.table.row(this.rowId);
    const choices = JSON.parse(this.table.headers[this.k].dataset.choices ?? "[]");
    const where = { kind: this.kind(this.k), name: this.table.name(this.k), choices, row, table: this.table };
    const before = this.field.value.slice(0, this.field.selectionStart);
    this.found = this.field.selectionStart === this.field.selectionEnd && typed !== null
      ? suggest(this.context.vocabulary(), where, before, this.field.value)
      : NOTHING;
    const renaming = row && this.context.meant(this.table.cell(row, this.k), this.was, this.field.value);
    this.renaming = renaming?.gives || !this.found.sure ? renaming : null;
    this.context.renames(this.renaming);
    if (this.renaming) this.found = NOTHING;
    this.chosen = this.found.sure && typed && !composing ? 0 : -1;
    this.moved = false;
    this.show();
    const help = this.renaming ? this.offer() : this.meant() ?? signature(this.context.vocabulary(), where, before);
    this.hint.hidden = !help;
    this.hint.replaceChildren(...(help ?? []));
  }

  /** What can be done with a name that is changed. */
  offer() {
    const { old, rows, gives } = this.renaming;
    const all = [tn("Rename, also in the row that uses it", "Rename, also in {n} rows that use it", { n: rows }), "keep", () => this.close(true, "enter")];
    const alone = [t("Change this cell only"), gives ? "keepHere" : "keep", () => this.close(true, "enter", true)];
    const look = [gives ? t("Show the cells first") : t("Rename “{name}” in all cells", { name: old }), "showCells", () => this.look()];
    return [...(gives ? [all] : []), alone, look].map(([text, command, act]) => {
      const choice = button(text, act, "choice");
      choice.tabIndex = -1;
      choice.append(make("kbd", hintOf(command)));
      return choice;
    });
  }

  /** Look at the cells that a changed name is in, before they change; the text stays until that is done. */
  look() {
    const { field, rowId, k, was, renaming } = this;
    if (!renaming) return;
    const text = field.value;
    this.close(false, null);
    this.context.ask([renaming.old], renaming.name, () => this.open(this.table.cell(this.table.row(rowId), k), text, was));
  }

  show() {
    const { items, word = "" } = this.found;
    this.list.hidden = items.length === 0;
    const options = items.map((item, i) => this.option(item, i, word.trim().toLowerCase()));
    const groups = Map.groupBy(options, (_, i) => items[i].group);
    this.list.replaceChildren(...(groups.size < 2 ? options : [...groups].map(([name, parts]) => {
      const group = make("div", {}, make("div", { className: "group-name", ariaHidden: "true" }, TITLES[name] ?? ""), ...parts);
      group.setAttribute("role", "group");
      group.setAttribute("aria-label", TITLES[name] ?? "");
      return group;
    })));
    this.options = options;
    this.point();
  }

  option(item, i, word) {
    const option = make("div", { id: `${this.list.id}-${i}` });
    option.dataset.i = i;
    option.setAttribute("role", "option");
    option.setAttribute("aria-selected", String(i === this.chosen));
    const state = item.row ? t("row {n}", { n: item.row }) : item.used ? t("in use") : item.adds ? t("+ Devices") : item.meaning ?? "";
    const label = make("span", { className: `name ${item.kind ?? ""}` }, ...marked(item.label ?? item.text, word));
    option.append(label, ...(state ? [make("span", { className: "adds" }, state)] : []), make("small", {}, ...marked(item.help ?? "", word)));
    return option;
  }

  /** Ask whether a name was meant that is spelled nearly as what is typed, when no name fits; null when there is none. */
  meant() {
    const { from, names, word } = this.found;
    const near = this.found.items.length || this.typed === null ? "" : nearest(word ?? "", names ?? []);
    if (!near) return null;
    const take = button(near, () => {
      const end = from + word.length;
      this.field.setRangeText(near, from, end, "end");
      this.field.focus();
      this.update(true);
    }, "button small");
    take.tabIndex = -1;
    return [make("p", t("No name fits “{typed}”. Did you mean “{name}”?", { typed: word, name: near })), take];
  }

  point() {
    for (const option of this.options) option.setAttribute("aria-selected", String(Number(option.dataset.i) === this.chosen));
    const option = this.options[this.chosen];
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
    if (item.adds) this.adds.set(key(item.text), { stream: item.text, ...item.adds });
    const caret = this.found.from + item.text.length;
    this.field.focus();
    this.field.setSelectionRange(caret, caret);
    this.update(null);
  }

  /** True while there are suggestions to choose from. */
  get offers() {
    return !this.list.hidden;
  }

  /** The next suggestion, or the one before. */
  choose(by) {
    const count = this.found.items.length;
    this.chosen = (this.chosen + (by > 0 ? 1 : count - (this.chosen < 0 ? 0 : 1))) % count;
    this.moved = true;
    this.point();
  }

  /** From typing, where arrows lead to the next cell, to moving within the text, and back. */
  change() {
    this.mode = this.mode === "edit" ? "enter" : "edit";
  }

  newLine() {
    this.field.setRangeText("\n", this.field.selectionStart, this.field.selectionEnd, "end");
    this.update(true);
  }

  /** Away with the suggestions, or with what was typed. */
  escape() {
    if (this.offers && this.mode === "edit") this.update(null);
    else this.close(false, null);
  }

  /** Enter or Tab: takes a suggestion, or keeps the text. */
  end({ key, shiftKey }) {
    const chosen = this.offers && this.chosen >= 0;
    if (this.offers && key === "Enter" && this.moved) return this.accept(this.chosen);
    if (chosen && !shiftKey && this.found.partial) return this.accept(this.chosen);
    if (chosen && (this.moved || this.found.whole)) this.accept(this.chosen);
    return this.close(true, key === "Enter" ? (shiftKey ? "raise" : "enter") : shiftKey ? "back" : "tab");
  }

  /** Stop editing; keep the text or not. `move` says where the selection goes, null for nowhere; `alone` gives a name to this
   *  cell only. */
  close(keep, move, alone = false) {
    const field = this.field;
    if (!field) return;
    this.field = null;
    const text = field.value;
    this.box.remove();
    this.scroll.classList.remove("typing");
    this.context.renames(null);
    this.context.editing(this.rowId, this.k, false);
    const row = this.table.row(this.rowId);
    const devices = text.split(/[,\n]/).map((name) => this.adds.get(key(name))).filter(Boolean);
    if (row) this.done(this.table.cell(row, this.k), keep ? text : this.was, this.was, move, alone, devices);
    else if (keep && text !== this.was) this.context.lost(t("The row has been deleted. Copy your text, and paste it where it belongs."), text);
  }

  /** The focus goes from one element to another, or to none: that ends editing, but not while help is read. */
  left(from, to) {
    const later = (act) => setTimeout(() => document.hasFocus() && document.activeElement === document.body && act());
    if (from === this.waiting && !to) later(() => from === this.waiting && this.drop()); // else the window lost the focus
    else if (from === this.waiting && !to.closest("[role=gridcell]")) this.drop(); // else it goes along with the cursor
    if (!this.isOpen || to === this.field || to?.closest(HELP)) return;
    if (to || from === this.field) this.close(true, null);
    else later(() => this.close(true, null)); // else its piece was renewed
  }

  /** The table has changed around the editor. */
  mend() {
    this.follow();
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

// Suggestions for the text that is being typed: names for the cell's kind, and in formulas names, functions and fields.

export const key = (text) => text.normalize("NFKC").toLowerCase().replace(/[\s_\-\u00a0\u2010-\u2015]+/g, "");

/** Suggestions for a cell: `items`, where the replaced text begins, and how sure they are: `sure` when the first one
 *  continues what is typed, so that Enter and Tab take it; then (whole) the cell is left, or (partial) one goes on typing. */
function suggest(words, where, before, text) {
  const { kind } = where;
  if (kind === "formula") return inFormula(words, where, before);
  if (kind === "inputs") {
    const from = Math.max(before.lastIndexOf(","), before.lastIndexOf("\n")) + 1;
    const start = from + (before.slice(from).length - before.slice(from).trimStart().length);
    const [sensors, joints] = simple(words.sensors);
    return grouped(pick([...streams(words, where), ...sensors, ...chosen(words, "sensor"), ...words.dones, ...joints], before.slice(start), start, true));
  }
  if (kind === "output" && isSubscribe(where)) {
    const [actuators, joints] = simple(words.actuators);
    return grouped(pick([...actuators, ...chosen(words, "actuator"), ...joints], text, 0, true));
  }
  if (kind === "output") {
    const actuators = text.trim() ? [...chosen(words, "actuator"), ...simple(words.actuators).flat()].map(({ help, group, ...word }) => ({ ...word, does: help })) : []; // found by their names alone
    const { items, ...found } = pick([...proposed(words, where), ...actuators], text, 0, true);
    const told = items.map(({ does, ...word }) => (does === undefined ? word : { ...word, help: t("Only a subscribe row can control it. {help}", { help: does }) }));
    return { ...found, items: told, sure: false, names: [] };
  }
  const other = inCell(words, where, before, text);
  if (other) return other;
  const choices = {
    connector: words.connectors, device: words.devices, fieldname: words.fields, tested: [...words.streams, ...words.dones],
  }[kind] ?? where.choices;
  return pick(choices, text, 0, true);
}

/** Help on the function around the caret: its usage with a line of explanation, or null. */
function signature(words, where, before) {
  if (where.kind !== "formula") return shown(cellHelp(words, where));
  let depth = 0;
  for (let i = before.length - 1; i >= 0; i--) {
    if (before[i] === ")") depth++;
    if (before[i] !== "(" || depth-- > 0) continue;
    const name = WORD.exec(before.slice(0, i))[0];
    const found = [...words.functions, ...words.helpers].find((f) => key(f.name ?? f.text) === key(name));
    if (!found) return null;
    return shown([found.label, found.example ? t("{help} For example {example}", found) : found.help]);
  }
  return null;
}

function shown(texts) {
  return texts && texts.map((text, i) => {
    const part = document.createElement(i ? "p" : "code");
    part.textContent = text;
    return part;
  });
}

/** Those of the choices that begin with what is typed, those that hold it, then those of which a plain word or a word of their
 *  help begins with it; single joints last. What is complete stays in the list only beside others. */
function pick(choices, typed, from, whole) {
  const wanted = key(typed);
  const [starts, holds, alike, about, joints] = [[], [], [], [], []];
  let complete = false;
  for (const choice of choices ?? []) {
    const k = key(choice.text);
    if (k === wanted && wanted) complete = true;
    if (k.startsWith(wanted)) (choice.joint ? joints : starts).push(choice);
    else if (!wanted) continue;
    else if (k.includes(wanted)) (choice.joint ? joints : holds).push(choice);
    else if (begins(choice.words, wanted)) alike.push(choice);
    else if (wanted.length >= LEAST_OF_HELP && !choice.joint && begins(choice.help, wanted)) about.push(choice);
  }
  const items = [...starts, ...holds, ...alike, ...about, ...joints].slice(0, wanted ? MOST_OFFERED : MOST_AT_FIRST);
  if (complete) return { items: items.length > 1 ? items : [], from, sure: false, word: typed };
  return { items, from, sure: wanted !== "" && key(items[0]?.text ?? "").startsWith(wanted), whole, partial: false, word: typed, names: choices };
}

const groupOf = ({ group, kind, row }) => (row || kind === "stream" || kind === "done" ? "book" : group === "gesture" || group === "posture" ? "gestures" : kind);
const TITLES = { sensor: t("Sensors"), actuator: t("Actuators"), book: t("This workbook"), gestures: t("Gestures and postures") };

/** The same suggestions by group, the best one first. */
function grouped(found) {
  const groups = Map.groupBy(found.items.map((item) => ({ ...item, group: groupOf(item) })), (item) => item.group);
  return { ...found, items: [...groups.values()].flat() };
}

/** Devices with one of the choices that they have, as “Wave”. */
const chosen = (words, kind) => (words.choices ?? []).filter((word) => word.kind === kind);

/** Devices that have a plain name or are in use, and the single joints. */
function simple(devices) {
  const { plain = [], joints = [] } = Object.groupBy(devices ?? [], (word) => (word.words || word.used ? "plain" : "joints"));
  return [plain, joints.map((word) => ({ ...word, joint: true }))]; // the help of each is that of all
}

/** A text in pieces, with what is typed marked in it. */
function marked(text, word) {
  const at = word ? text.toLowerCase().indexOf(word) : -1;
  return at < 0 ? [text] : [text.slice(0, at), make("mark", text.slice(at, at + word.length)), text.slice(at + word.length)];
}

/** The word of the names, or of their plain words, that is spelled nearly as one that is typed; empty for none. */
function nearest(typed, choices) {
  const word = typed.trim().toLowerCase();
  const most = word.length < LEAST_OF_HELP ? 0 : word.length < 6 ? 1 : 2;
  let best = ["", most + 1];
  for (const choice of choices) {
    for (const name of [choice.text, ...(choice.words ?? "").split(" ")]) {
      const far = Math.abs(name.length - word.length) < best[1] ? distance(word, name.toLowerCase()) : best[1];
      if (far < best[1]) best = [name, far];
    }
  }
  return best[0];
}

/** How many letters must be changed, added or left out, or change places with the next one, to make one word of another. */
function distance(a, b) {
  const rows = [Array.from({ length: b.length + 1 }, (_, j) => j)];
  for (let i = 1; i <= a.length; i++) {
    rows[i] = [i];
    for (let j = 1; j <= b.length; j++) {
      const swapped = i > 1 && j > 1 && a[i - 1] === b[j - 2] && a[i - 2] === b[j - 1] ? rows[i - 2][j - 2] + 1 : Infinity;
      rows[i][j] = Math.min(rows[i - 1][j] + 1, rows[i][j - 1] + 1, rows[i - 1][j - 1] + (a[i - 1] === b[j - 1] ? 0 : 1), swapped);
    }
  }
  return rows[a.length][b.length];
}

/** True when a word of a text begins with what is typed; between Japanese words there are no spaces. */
function begins(text, wanted) {
  if (!text) return false;
  const plain = text.normalize("NFKC").toLowerCase();
  return JAPANESE.test(wanted) ? plain.includes(wanted) : plain.split(/[^\p{L}\p{N}]+/u).some((word) => word.startsWith(wanted));
}

/** What a name in a formula holds; `value` is the row's input. */
const recordOf = (words, where, name) => words.records[key(name)] ?? (name === "value" ? words.records[key(inputs(where)[0] ?? "")] : null);

function inFormula(words, where, before) {
  const none = { items: [], from: 0, sure: false };
  if (within(before, '"') || within(before, "'")) return quoted(words, where, before);
  const word = WORD.exec(before)[0];
  const from = before.length - word.length;
  if (before[from - 1] === ".") {
    const owner = WORD.exec(before.slice(0, from - 1))[0];
    return { ...pick(recordOf(words, where, owner)?.fields ?? [], word, from, false), partial: true };
  }
  if (/^\d/.test(word) || COMPLETE.has(word.toLowerCase())) return none;
  if (word && /\d\s*$/.test(before.slice(0, from))) return none; // a unit
  const mine = inputs(where).map((name) => words.names[key(name)] ?? unchecked(name)).filter(Boolean);
  const period = words.periods?.includes(connector(where));
  if (period) return before.trim() ? none : { ...pick(words.durations, "", 0, true), sure: false };
  const fields = word ? [] : mine.flatMap(({ text }) => (words.records[key(text)]?.fields ?? []).map((one) => ({ ...one, text: `${text}.${one.text}` })));
  const all = [...mine, ...fields, ...words.helpers, ...words.tables, ...(word ? words.functions : [])];
  if (!word && before.trim()) return none;
  return { ...pick(all, word, from, false), partial: true };
}

/** The field of a stream's record that is called so, also in English or Japanese. */
const fieldOf = (record, name) => record?.fields.find(({ text, words }) => [text, ...words.split(" ")].some((one) => key(one) === key(name)));

/** The values of the field that a text in a formula is compared with, or else names of gestures and postures; Enter takes none of
 *  these by itself, as a text may be anything. */
function quoted(words, where, before) {
  const from = Math.max(before.lastIndexOf('"'), before.lastIndexOf("'")) + 1;
  const typed = before.slice(from);
  const [, owner, name] = /([\p{L}\p{N}_]+)\.([\p{L}\p{N}_]+)\s*(?:==?|<>|!=|≠)\s*["']$/u.exec(before.slice(0, from)) ?? [];
  const { choices = [] } = (owner && fieldOf(recordOf(words, where, owner), name)) || {};
  if (choices.length) return { ...pick(choices, typed, from, false), partial: true };
  if (typed.length < (JAPANESE.test(typed) ? 1 : LEAST_IN_QUOTES)) return NOTHING;
  return { ...pick([...words.gestures ?? [], ...words.postures ?? []], typed, from, false), sure: false, partial: true };
}

function within(text, quote) {
  return (text.split(quote).length - 1) % 2 === 1;
}

const named = (where, kind) => {
  const k = where.table.ofKind(kind);
  return k < 0 ? "" : where.table.value(where.table.cell(where.row, k));
};

const connector = (where) => key(named(where, "connector"));
const isSubscribe = (where) => connector(where) === "subscribe";

/** The names of a row's input streams; a blank cell means the output of the row above. */
export function inputs(where) {
  const own = (named(where, "inputs") || named(where, "parameters")).split(/[,\n]/).map((n) => n.trim()).filter(Boolean);
  if (own.length || where.table.kind === "helpers") return own;
  for (let i = where.table.at(where.row) - 1; i >= 0; i--) {
    const above = { ...where, row: where.table.rows[i] };
    if (!named(above, "connector")) continue;
    if (isSubscribe(above)) return inputs(above);
    return [named(above, "output")].filter(Boolean);
  }
  return [];
}

/** The name that is proposed for the output of a row whose formula is a field alone: “Distance” of redBall.distance, or
 *  “Red ball distance” where that is the name of something else. */
function proposed(words, where) {
  const field = /^=?\s*[\p{L}\p{N}_]+\.([\p{L}\p{N}_]+)\s*$/u.exec(named(where, "formula"))?.[1];
  if (!field) return [];
  const plain = field.replace(/(\p{Ll})(\p{Lu})/gu, (_, end, start) => `${end} ${start.toLowerCase()}`);
  const taken = new Set([...streams(words, where), ...words.sensors, ...words.actuators].map(({ text }) => key(text)));
  const name = [plain[0].toUpperCase() + plain.slice(1), ...inputs(where).map((input) => `${input} ${plain}`)].find((one) => !taken.has(key(one)));
  return name ? [{ text: name, kind: "stream", help: t("named as the field") }] : [];
}

// A stream that the check has not seen yet, as it was named a moment ago; a name that is spelled otherwise in formulas
// (a digit first, a word of the language) waits for the check.
function unchecked(name) {
  const parts = name.normalize("NFKC").split(/[\s_\-\u00a0\u2010-\u2015]+/).filter(Boolean);
  if (!parts.length || !/^\p{L}/u.test(parts[0]) || !parts.every((part) => /^[\p{L}\p{N}]+$/u.test(part))) return null;
  const first = parts[0] === parts[0].toUpperCase() ? parts[0].toLowerCase() : parts[0][0].toLowerCase() + parts[0].slice(1);
  return { text: first + parts.slice(1).map((part) => part[0].toUpperCase() + part.slice(1)).join(""), kind: "stream", help: "" };
}

function streams(words, where) {
  const k = where.table.ofKind("output");
  if (k < 0) return words.streams;
  const found = new Map();
  const actuators = new Set(words.actuators.map((word) => key(word.text)));
  for (const row of where.table.rows) {
    const name = where.table.value(where.table.cell(row, k));
    if (name && row !== where.row && !actuators.has(key(name))) found.set(key(name), { text: name, row: row.cells[0].textContent });
  }
  return [...found.values()].map((word) => ({ ...word, kind: "stream", help: words.names[key(word.text)]?.help ?? "" }));
}

// Suggestions and help for cells without a formula: by the column, and by the other cells of the row.

/** Suggestions for a cell of the Devices, Scene, test or Protocol sheets; null for another kind of cell. */
function inCell(words, where, before, text) {
  const { kind } = where;
  if (kind === "setting") return pick(setting(words, where)?.choices ?? [], text, 0, true);
  if (kind === "actor") return pick(words.things, text, 0, true);
  if (kind === "gesture") return free(words.gestures ?? [], text);
  if (kind === "verb") return pick(verbs(words, where).map(([verb, values]) => ({ text: verb, help: values[0]?.text ?? "" })), text, 0, true);
  if (kind === "value") return free(values(words, where), text);
  if (kind === "amount" && where.table.kind === "scene") return free(times(words), text);
  if (kind === "fieldvalue") {
    const field = key(named(where, "fieldname"));
    return field === "run" ? after(words.values.run, before) : free(words.values?.[field] ?? [], text, words.closed?.includes(field));
  }
  if (kind === "send" || kind === "expect") return sent(words, where, before);
  return null;
}

/** Help on what a setting's cell is for. */
function cellHelp(words, where) {
  const found = where.kind === "setting" ? setting(words, where) : null;
  if (found) return [named(where, "device"), `${found.name}: ${found.help}`];
  if (where.kind === "setting") return untaken(words, where);
  if (where.kind === "angle") {
    const joint = words.joints?.[key(where.name)];
    return joint ? [joint.name, joint.help] : [where.name, t("No joint of the robot: this column is not used.")];
  }
  if (where.kind === "value") {
    const verb = named(where, "verb");
    const shown = values(words, where).map((v) => v.text).join("   " + t("or") + "   ");
    return verb && shown ? [`${named(where, "actor")} ${verb}`, shown] : null;
  }
  return null;
}

/** Help on the cell of a setting that the device does not take: it names the device of its kind that takes it. */
function untaken(words, where) {
  const device = named(where, "device");
  const about = (name) => words.devices?.find((d) => key(d.text) === key(name))?.help ?? "";
  if (!words.takes?.[key(device)]) return null;
  const other = words.instead?.[key(device)]?.[key(where.name)]?.[0];
  const remedy = other ? t("Or use the device “{device}”, which takes {setting}. {help}", { setting: where.name, device: other, help: about(other) }) : t("Leave the cell blank.");
  return [t("{device} takes no {setting}", { device, setting: where.name }), `${about(device)} ${remedy}`];
}

/** Values that may also be anything else: only a word that is being typed is completed, no number. */
function free(choices, text, whole = /^\p{L}+$/u.test(text)) {
  const found = pick(choices, text, 0, whole);
  return { ...found, sure: found.sure && whole };
}

function after(choices, before) {
  const from = before.lastIndexOf(",") + 1;
  const start = from + (before.slice(from).length - before.slice(from).trimStart().length);
  return pick(choices, before.slice(start), start, true);
}

function setting(words, where) {
  return words.takes?.[key(named(where, "device"))]?.[key(where.name)];
}

function verbs(words, where) {
  const thing = named(where, "actor");
  const acts = words.acts ?? {};
  if (!thing) return Object.values(acts).flat();
  const name = key(thing).replace(/\d+$/, "");
  return acts[Object.entries(words.kinds ?? {}).find(([word]) => name.endsWith(word))?.[1] ?? "person"];
}

/** Times at which something may happen, also after the end of what an actuator does. */
function times(words) {
  return [...(words.scenetimes ?? []), ...(words.dones ?? []).map(({ text, help }) => ({ text: `${text} + 1`, help }))];
}

function values(words, where) {
  const verb = key(named(where, "verb"));
  return verbs(words, where).find(([name]) => key(name) === verb || key(name) === `${verb}s`)?.[1] ?? [];
}

/** Suggestions for a value that is sent into a stream, or expected of it: its fields, behind each semicolon. */
function sent(words, where, before) {
  const from = before.lastIndexOf(";") + 1;
  const start = from + (before.slice(from).length - before.slice(from).trimStart().length);
  const typed = before.slice(start);
  const record = words.records?.[key(named(where, "tested").replace(/^.*!/, ""))];
  const [given, name] = /^([^=<>≈"]+)=\s*"?(?=[^=<>≈"]*$)/.exec(typed) ?? [];
  const { choices = [] } = (name && fieldOf(record, name)) || {};
  if (choices.length) return { ...pick(choices, typed.slice(given.length), start + given.length, false), partial: true };
  if (/[=<>≈"]/.test(typed)) return { items: [], from: start, sure: false };
  const fields = (record?.fields ?? []).map((f) => ({ text: `${f.text}=`, help: f.help }));
  const others = where.kind === "expect" && !from ? words.expects : from ? [] : [{ text: "BLANK", help: t("a blank") }];
  return { ...pick([...fields, ...others], typed, start, false), partial: true };
}
