// Messages to the person. To a screen reader: the cell with the cursor and its problems, the edits of others, the names of the cells.

import { spokenHintOf } from "../commands.js";
import { button as act } from "../elements.js";
import { t, tn } from "../texts.js";

const CURSOR_RESTS_MS = 150; // when the cursor runs, only the cell where it stops is told
const MOST_NAMED = 500; // rows whose cells all have names; in a longer sheet only the one with the cursor
const SHOWN_MS = { told: 5_000, warning: 15_000, error: Infinity }; // of a message in the status line, besides the time to read
const LETTER_MS = 50; // to read a letter
const ERROR_STAYS_MS = 5_000; // after an edit

export class Spoken {
  constructor(grid, page) {
    this.grid = grid;
    this.page = page;
    this.line = document.getElementById("spoken");
    this.locked = new Set();
    this.untag([grid.table.grid]);
    this.name(grid.table.rows);
    grid.table.grid.addEventListener("rrp:rows", ({ detail }) => this.came(detail.came));
  }

  /** Tell something aloud only. */
  say(text) {
    clearTimeout(this.soon);
    if (this.line) this.line.textContent = this.line.textContent === text ? `${text}\u00a0` : text;
  }

  /** The cursor stands on another cell; `first` is what is to be told before that. */
  moved(first = "") {
    clearTimeout(this.soon);
    this.first = first || this.first;
    this.soon = setTimeout(() => {
      const parts = [this.first, this.told()];
      this.first = "";
      this.say(sentences(parts));
    }, CURSOR_RESTS_MS);
  }

  /** A cell's address, column, text, problems, and who is editing it. */
  told(cell = this.grid.selection.cell) {
    if (!cell) return "";
    const { table } = this.grid;
    const k = table.column(cell);
    const parts = [t("{cell} {column}: {text}", { cell: table.address(cell), column: table.name(k), text: content(cell) })];
    if (cell.ariaReadOnly === "true") parts.push(t("cannot be filled in here"));
    if (!cell.parentElement.classList.contains("unfinished")) {
      for (const mend of cell.querySelectorAll(".mend:not(.is-info)")) parts.push(words(mend));
    }
    const comments = cell.querySelector(":scope > .about-comments");
    if (comments) parts.push(comments.textContent);
    const verdict = cell.querySelector(":scope > .verdict"); // of a test
    if (verdict) parts.push(verdict.textContent.replace(/^[✓✗] /, ""));
    const tag = cell.querySelector(".name-tag");
    if (tag) parts.push(tag.textContent);
    const count = this.grid.selection.painted.length;
    if (count > 1) parts.push(tn("{n} cell selected", "{n} cells selected", { n: count }));
    return sentences(parts);
  }

  came(rows) {
    this.untag(rows);
    this.name(rows);
    for (const row of rows) {
      for (const cell of row.cells) {
        const place = `${row.id} ${cell.cellIndex}`;
        const tag = cell.querySelector(".name-tag");
        if (tag && !this.locked.has(place)) this.say(`${tag.textContent}: ${this.grid.table.address(cell)}`);
        this.locked[tag ? "add" : "delete"](place);
      }
    }
  }

  /** Nobody is told of what this very page edits: a row made meanwhile may arrive when the editor is closed again. */
  untag(parts) {
    for (const tag of parts.flatMap((part) => [...part.querySelectorAll(".name-tag")])) {
      if (!this.own(tag.dataset.client)) continue;
      tag.parentElement.classList.remove("taken");
      tag.remove();
    }
  }

  /** True for a client that is this very page, perhaps before it was loaded again. */
  own(client) {
    return client.startsWith(`${this.page.id}.`);
  }

  /** Name the cells of rows by column and row. */
  name(rows) {
    const { table } = this.grid;
    if (table.rows.length > MOST_NAMED) return;
    for (const row of rows) for (const at of table.places) this.nameCell(row.cells[at]);
  }

  /** The column, row and text of a cell. */
  nameOf(cell) {
    return this.placeOf(cell) + content(cell);
  }

  placeOf(cell) {
    const { table } = this.grid;
    return t("{column}, row {row}:", { column: table.name(table.column(cell)), row: cell.parentElement.cells[0].textContent }) + " ";
  }

  nameCell(cell) {
    if (this.grid.table.column(cell) < 0) return;
    const old = cell.querySelector(":scope > .cell-name");
    if (!cell.querySelector(":scope > .mends, :scope > .name-tag, :scope > .verdict")) {
      old?.remove();
      cell.setAttribute("aria-label", [this.nameOf(cell), cell.querySelector(".name-tag")?.textContent ?? ""].join(" ").trim());
      return;
    }
    cell.removeAttribute("aria-label"); // its name is what is to be seen, with the message while that is shown
    const mark = old ?? document.createElement("span");
    mark.className = "cell-name only-spoken";
    mark.textContent = this.placeOf(cell);
    if (!old) cell.prepend(mark);
  }

  /** Rows have other numbers now. */
  renumbered() {
    this.name(this.grid.table.rows);
  }
}

/** Texts one after the other, each with a full stop but the last. */
function sentences(parts) {
  return parts.filter(Boolean).reduce((before, after) => (before ? t("{before}. {after}", { before: before.replace(/[.。]$/, ""), after }) : after), "");
}

function content(cell) {
  const box = cell.querySelector("input[type=checkbox]");
  if (box) return box.checked ? t("ticked") : t("not ticked");
  const names = [...cell.querySelectorAll(":scope > .name")];
  if (names.length > 1) { // as they are to be seen, then their kinds
    const kinds = names.map((name) => name.querySelector(".only-spoken")?.textContent.trim() ?? "");
    return t("{names} ({kinds})", { names: names.map((name) => name.lastChild.textContent.trim()).join(", "), kinds: kinds.join(", ") });
  }
  const below = cell.querySelector(".hint-word")?.textContent ?? "";
  return names[0]?.textContent.trim() || cell.dataset.v || [t("blank"), below].join(" ").trim();
}

function words(mend) {
  const fix = mend.querySelector("[data-fix]");
  const texts = [...mend.children].filter((part) => !part.matches("button, .code")).map((part) => part.textContent.trim());
  return texts.join(" ").replace("→ ", "") + (fix ? ` ${fix.dataset.title}: ${spokenHintOf("mend")}.` : "");
}

// The status line below the sheet. A message goes by itself after a time that suffices to read it; a warning stays longer,
// and an error, or one with buttons, until an edit is made or it is closed. None goes while the pointer or the focus is on it, or while
// the page is out of sight.

const line = document.getElementById("status");
const place = line?.parentElement;
const button = place?.querySelector("button");
let left = 0; // milliseconds that the message still has
let since = 0; // when it was shown, or went on being shown
let timer = 0;

/** Show a message of a kind: `told`, `warning` or `error`; `acts` are buttons beside it, each a title and what it does. */
export function status(text, kind = "told", acts = []) {
  if (!line) return;
  for (const old of place.querySelectorAll(".act")) old.remove();
  button.before(...acts.map(([title, run]) => act(title, () => (clear(), run()), "button plain small act")));
  if (line.textContent === text && line.classList.contains("is-error")) return; // said again and again while it lasts
  line.textContent = text;
  for (const name of ["warning", "error"]) line.classList.toggle(`is-${name}`, name === kind);
  button.hidden = !text || (kind === "told" && !acts.length);
  left = acts.length ? Infinity : SHOWN_MS[kind] + LETTER_MS * text.length;
  since = Date.now();
  go();
}

/** What a message told of is over: it goes, if it is still there. */
export function over(text) {
  if (line && text && line.textContent === text) clear();
}

/** An edit was made: let an error, or a message with buttons, go soon. */
export function done() {
  if (!line?.textContent || left !== Infinity) return;
  left = ERROR_STAYS_MS;
  go();
}

function clear() {
  if (place.contains(document.activeElement)) document.querySelector("[role=grid] [tabindex='0']")?.focus({ preventScroll: true });
  for (const old of place.querySelectorAll(".act")) old.remove();
  line.textContent = "";
  line.classList.remove("is-warning", "is-error");
  button.hidden = true;
}

const paused = () => document.hidden || place.matches(":hover, :focus-within");

/** Count the time on, or stop counting. */
function go() {
  clearTimeout(timer);
  timer = 0;
  if (left === Infinity || !line.textContent || paused()) return;
  since = Date.now();
  timer = setTimeout(clear, left);
}

function pause() {
  if (timer) left = Math.max(0, left - (Date.now() - since));
  go();
}

button?.addEventListener("click", clear);
for (const kind of ["pointerenter", "pointerleave", "focusin"]) place?.addEventListener(kind, pause);
place?.addEventListener("focusout", () => setTimeout(pause)); // the focus is elsewhere a moment later
document.addEventListener("visibilitychange", () => place && pause());
