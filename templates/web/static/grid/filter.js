// The filter: rows by the values of their columns, or those with problems. It hides rows in this page only: nothing is saved, nobody
// else sees it. What is shown changes only when the filter is applied: no row goes while one works in it.

import { button, make } from "../elements.js";
import { t } from "../texts.js";

const MOST_LISTED = 500; // values
const BLANK = ""; // a value, too
const FLAGGED = "td.flagged:not(.is-info)"; // as the status line counts them

export class Filter {
  constructor(grid) {
    this.grid = grid;
    this.table = grid.table;
    this.columns = new Map(); // place of a column → the values whose rows are shown
    this.problems = false; // whether only rows with problems are shown
    this.judged = null; // ids of the rows that were there when it was applied
    this.old = null; // whether others would be shown now; null when that is not known
    this.box = null;
    this.buttons = this.table.headers.map((header, k) => {
      const open = make("button", { type: "button", className: "filter-open", tabIndex: -1, ariaHasPopup: "dialog", ariaExpanded: "false" });
      open.addEventListener("click", () => (this.box ? this.close() : this.open(k)));
      open.addEventListener("keydown", (event) => event.altKey && event.key === "ArrowDown" && (event.preventDefault(), this.open(k)));
      header.append(open);
      return open;
    });
    this.mark();
    this.table.grid.addEventListener("rrp:rows", ({ detail }) => this.came(detail.came));
    document.addEventListener("pointerdown", ({ target }) => {
      if (this.box && !this.box.contains(target) && !target.closest(".filter-open")) this.close(false);
    });
  }

  get active() {
    return this.columns.size > 0 || this.problems;
  }

  /** How many rows with texts there are, and how many of them are shown. */
  counts() {
    const { table } = this;
    const filled = table.rows.filter((row) => table.places.some((at) => table.value(row.cells[at])));
    return { rows: filled.length, n: filled.filter((row) => !table.hidden.has(row.id)).length };
  }

  /** True when other rows would be shown if it was applied now. */
  get isOld() {
    this.old ??= [...this.unwanted()].some((id) => !this.table.hidden.has(id));
    return this.active && this.old;
  }

  /** The value of a cell as the list has it. */
  value(row, k) {
    const text = this.table.value(this.table.cell(row, k));
    if (this.table.headers[k].dataset.kind === "on") return this.table.isOff(text) ? t("Off") : t("On");
    return text.trim();
  }

  matches(row, besides = -1) {
    for (const [k, values] of this.columns) if (k !== besides && !values.has(this.value(row, k).toLowerCase())) return false;
    return !this.problems || row.querySelector(FLAGGED) !== null;
  }

  /** The ids of the rows to hide. Blank ones at the end never are: one writes there. */
  unwanted(rows = this.table.rows) {
    const filled = this.table.rows.length - this.table.room();
    return new Set(rows.filter((row) => this.table.at(row) < filled && !this.matches(row)).map((row) => row.id));
  }

  /** Show the rows that are wanted now; false, with a message, when there are none. */
  apply() {
    const { grid, table } = this;
    const ids = this.active ? this.unwanted() : new Set();
    if (ids.size && grid.whole && ids.size === table.rows.length - table.room()) {
      grid.say(t("No row matches this filter."), true);
      return false;
    }
    this.judged = new Set(table.rows.map((row) => row.id));
    this.old = null;
    table.hide(ids);
    this.mark();
    const { selection } = grid;
    selection.others = [];
    if (selection.head && table.hidden.has(selection.head.row)) selection.go(selection.near(table.at(selection.row)), selection.head.k, false, false);
    else if (selection.head) selection.go(selection.row, selection.head.k, false, false);
    const { n, rows } = this.counts();
    grid.say(this.active ? t("{n} of {rows} rows shown.", { n, rows }) : t("All rows are shown."));
    return true;
  }

  /** Rows of a long sheet come in pieces: they are filtered like the others. What is new since is shown. */
  came(rows) {
    const { table, grid } = this;
    this.old = null;
    if (!this.active || grid.whole) return;
    const fresh = rows.filter((row) => !this.judged.has(row.id) && row.id !== grid.selection.head?.row);
    if (!fresh.length) return;
    for (const row of fresh) this.judged.add(row.id);
    table.hide(new Set([...table.hidden, ...this.unwanted(fresh)]));
  }

  showAll() {
    this.columns.clear();
    this.problems = false;
    this.apply();
    this.grid.selection.cell?.focus({ preventScroll: true });
  }

  /** Only rows with problems, or all others again. */
  onlyProblems(on = true) {
    const before = this.problems;
    this.problems = on;
    if (!this.apply()) this.problems = before;
  }

  /** The buttons of the columns say which of them filter. */
  mark() {
    this.buttons.forEach((open, k) => {
      const on = this.columns.has(k);
      open.classList.toggle("on", on);
      open.ariaLabel = on ? t("Filter {column} (now filtered)", { column: this.table.name(k) }) : t("Filter {column}", { column: this.table.name(k) });
    });
  }

  // ---- the list of a column's values

  async open(k = this.grid.selection.head.k) {
    const { grid, table } = this;
    this.close(false);
    if (grid.editor.isOpen) grid.editor.close(true, null);
    const search = make("input", { type: "search", autocomplete: "off", ariaLabel: t("Search the values") });
    const all = make("input", { type: "checkbox" });
    const list = make("div", { className: "filter-values" });
    const problems = make("input", { type: "checkbox", checked: this.problems });
    const form = make("form", {}, make("label", { className: "field" }, t("Search"), " ", search), make("label", { className: "tick" }, all, " ", t("Select all")), list,
      make("label", { className: "tick" }, problems, " ", t("Only rows with problems")));
    const submit = make("button", { type: "submit", className: "button first", textContent: t("Apply filter") });
    form.append(make("p", {}, submit, button(t("Cancel"), () => this.close())));
    const box = make("div", { className: "filter-box" }, form);
    box.setAttribute("role", "dialog");
    box.setAttribute("aria-label", t("Filter {column}", { column: table.name(k) }));
    this.box = box;
    this.opened = k;
    this.buttons[k].ariaExpanded = "true";
    document.querySelector("main").append(box);
    this.place(k);
    search.focus();

    let counts = this.values(k);
    const chosen = new Set([...counts.keys()].filter((value) => this.columns.get(k)?.has(value) ?? true));
    const found = () => [...counts].filter(([value]) => value.includes(search.value.trim().toLowerCase())); // of all, also those that are not listed
    const state = () => {
      const listed = found();
      const on = listed.filter(([value]) => chosen.has(value)).length;
      [all.checked, all.indeterminate] = [on > 0 && on === listed.length, on > 0 && on < listed.length];
      submit.disabled = on === 0;
    };
    const show = () => {
      const listed = found();
      list.replaceChildren(...listed.slice(0, MOST_LISTED).map(([value, { text, count }]) => {
        const tick = make("input", { type: "checkbox", checked: chosen.has(value) });
        tick.addEventListener("change", () => {
          chosen[tick.checked ? "add" : "delete"](value);
          state();
        });
        return make("label", { className: "tick" }, tick, make("span", text || t("(Blank)")), make("small", String(count)));
      }));
      if (!listed.length) list.append(make("p", t("No value has this text.")));
      if (listed.length > MOST_LISTED) list.append(make("p", t("… and {n} more", { n: listed.length - MOST_LISTED })));
      state();
    };
    search.addEventListener("input", show);
    all.addEventListener("change", () => {
      for (const [value] of found()) chosen[all.checked ? "add" : "delete"](value);
      show();
    });
    box.addEventListener("keydown", (event) => this.key(event));
    box.addEventListener("focusout", ({ relatedTarget: to }) => to && !box.contains(to) && to !== this.buttons[k] && this.close(false));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const wanted = new Set(found().map(([value]) => value).filter((value) => chosen.has(value)));
      if (wanted.size) this.choose(k, wanted.size === counts.size ? null : wanted, problems.checked);
    });
    show();
    if (grid.whole) return;
    await grid.loaded; // the values of the rows that were not here yet
    if (this.box !== box) return;
    const before = new Set(counts.keys());
    counts = this.values(k);
    for (const value of counts.keys()) if (!before.has(value) && (this.columns.get(k)?.has(value) ?? true)) chosen.add(value);
    show();
  }

  /** The values of a column in the rows that the other columns let be seen, with how many rows have each; blank at the end. */
  values(k) {
    const { table } = this;
    const found = new Map();
    for (const row of table.rows.slice(0, table.rows.length - table.room())) {
      if (!this.matches(row, k)) continue;
      const text = this.value(row, k);
      const value = text.toLowerCase();
      const known = found.get(value);
      if (known) known.count++;
      else found.set(value, { text, count: 1 });
    }
    const { compare } = new Intl.Collator(document.documentElement.lang || undefined, { numeric: true });
    return new Map([...found].sort(([a], [b]) => (a === BLANK) - (b === BLANK) || compare(a, b)));
  }

  choose(k, values, problems) {
    const before = [new Map(this.columns), this.problems];
    if (values) this.columns.set(k, values);
    else this.columns.delete(k);
    this.problems = problems;
    if (this.apply()) this.close();
    else [this.columns, this.problems] = before;
  }

  place(k) {
    const at = this.buttons[k].getBoundingClientRect();
    const frame = this.grid.scroll.getBoundingClientRect();
    const left = Math.min(Math.max(at.left, frame.left), frame.right) - 8;
    this.box.style.left = `${Math.max(8, Math.min(left, innerWidth - this.box.offsetWidth - 8))}px`;
    this.box.style.top = `${Math.max(8, Math.min(at.bottom + 4, innerHeight - this.box.offsetHeight - 8))}px`;
  }

  /** Arrows go through the boxes to tick; Escape closes. */
  key(event) {
    const parts = [...this.box.querySelectorAll("input")];
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    const at = parts.indexOf(document.activeElement);
    if (event.key === "Escape") this.close();
    else if (by && at >= 0) parts[Math.min(Math.max(at + by, 0), parts.length - 1)].focus();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  close(focus = true) {
    if (!this.box) return;
    this.box.remove();
    this.box = null;
    this.buttons[this.opened].ariaExpanded = "false";
    if (focus) this.grid.selection.cell?.focus({ preventScroll: true });
  }
}
