// Names that a cell gives or uses, changed in all cells that have them.

import { UNREACHED, request } from "../api.js";
import { button, make, put } from "../elements.js";
import { t, tn } from "../texts.js";
import { open } from "./dialog.js";
import { key } from "./editor.js";
import { status } from "./spoken.js";

const RESTS_MS = 150; // after the last key, before the server is asked what would change
const PREVIEW_MS = 400; // after the last key in a cell: who types on needs no outlines
const MOST_LISTED = 200; // cells

export class Renaming {
  constructor(grid) {
    this.grid = grid;
    this.changing = []; // places, as the server gives them, whose cells are outlined
    this.looks = 0; // how often it was asked what would change
    grid.table.grid.addEventListener("rrp:rows", () => this.changing.length && this.mark(this.changing));
  }

  /** True for a cell that gives a name: the output of a row that does not act, a stream of Devices, a helper. */
  gives(cell) {
    const kind = this.kind(cell);
    return kind === "helper" || kind === "stream" || (kind === "output" && !this.acts(cell));
  }

  kind(cell) {
    const { table } = this.grid;
    return table.headers[table.column(cell)]?.dataset.kind;
  }

  acts(cell) {
    const { table } = this.grid;
    return key(table.value(table.cell(cell.parentElement, table.ofKind("connector")))) === "subscribe";
  }

  /** How many rows use a stream of this sheet or of Devices; undefined for a name that is none of these. */
  uses(name) {
    const { words, server } = this.grid;
    return words.uses?.[key(server.sheet)]?.[key(name)] ?? words.uses?.[""]?.[key(name)];
  }

  /** The names in a cell that can be changed in all cells. */
  names(cell) {
    const { table } = this.grid;
    const text = table.value(cell).trim();
    if (this.gives(cell)) return text ? [text] : [];
    if (!["inputs", "output", "tested"].includes(this.kind(cell))) return [];
    return [...new Set(parts(text))].filter((name) => this.uses(name) !== undefined);
  }

  /** The name that changes when the text of a cell does: `old`, `name`, in how many `rows` it is used, and whether the cell
   *  `gives` it; null when no name changes, several do, or another stream is chosen. */
  meant(cell, was, text) {
    const gives = this.gives(cell);
    const [before, after] = gives ? [[was.trim()], [text.trim()]] : [parts(was), parts(text)];
    const changed = before.flatMap((name, i) => (key(name) === key(after[i] ?? "") ? [] : [i]));
    if (before.length !== after.length || changed.length !== 1 || !after[changed[0]]) return null;
    const [old, name] = [before[changed[0]], after[changed[0]]];
    const rows = this.kind(cell) === "helper" ? 1 : this.uses(old);
    if (!old || !rows || this.uses(name) !== undefined || (!gives && !this.names(cell).length)) return null;
    return { old, name, rows, gives };
  }

  /** The cells that change with a name, or the `message` why it cannot be used; null when something else was asked since. */
  async look(old, name, column = 0) {
    const { server } = this.grid;
    const mine = ++this.looks;
    const query = new URLSearchParams({ old, new: name, ...(column ? { column } : {}) });
    const { ok, json } = await request(`${server.url}/renaming/${encodeURIComponent(server.sheet)}?${query}`);
    if (mine !== this.looks) return null;
    return ok ? { ...json, name } : { name, message: UNREACHED };
  }

  /** Outline the cells that change with the name that is being typed; null for none. */
  preview(meant) {
    clearTimeout(this.timer);
    if (meant?.old === this.previewed && (!meant || this.changing.length)) return; // they are the same for every new name
    this.previewed = meant?.old;
    this.looks++;
    this.mark();
    if (!meant) return;
    this.timer = setTimeout(async () => this.mark((await this.look(meant.old, meant.name))?.cells), PREVIEW_MS);
  }

  /** Outline cells of this sheet, and the tabs of the others that some cells are in; without any, nothing. */
  mark(places = []) {
    const { table, server } = this.grid;
    this.changing = places;
    const cells = places.filter(({ sheet }) => sheet === server.sheet).map(({ cell }) => table.named(cell));
    const others = new Set(places.map(({ sheet }) => sheet).filter((sheet) => sheet !== server.sheet));
    const tabs = [...document.querySelectorAll("#tabs a[data-sheet]")].filter((tab) => others.has(tab.dataset.sheet));
    for (const one of document.querySelectorAll(".will-change")) one.classList.remove("will-change");
    for (const one of [...cells, ...tabs]) one?.classList.add("will-change");
  }

  /** Ask for another name of a column of this table. */
  askColumn(k = this.grid.selection.head.k) {
    const { name } = this.grid.table.headers[k].dataset;
    if (name) this.ask([name], name, () => {}, this.grid.table.sheetColumn(k));
  }

  /** Ask for the new name, with the cells that would change; `back` is done when it is given up. `column`: of a table, whose
   *  header it is. */
  ask(names, name = names[0], back = () => {}, column = 0) {
    const { grid } = this;
    if (grid.held.takes(() => this.ask(names, name, back, column)) || grid.refuses()) return;
    let old = names[0];
    let found = null; // what would change
    const mark = () => this.mark([...(found?.cells ?? []), ...(found?.unsure ?? []).filter((one) => ticked().includes(idOf(one)))]);
    let done = back;
    const field = make("input", { value: name, maxLength: 200, autocomplete: "off", spellcheck: false });
    const told = make("p", { className: "told", role: "status" });
    const list = make("div", { className: "changes", tabIndex: 0 });
    const which = make("select", {}, ...names.map((one) => make("option", one)));
    const label = (text, part) => make("label", { className: "field" }, `${text} `, part);
    const submit = make("button", { type: "submit", className: "button first", textContent: t("Rename") });
    const form = make("form", {}, ...(names.length > 1 ? [label(t("Stream"), which)] : []), label(t("New name"), field), told, list, submit);
    const title = column ? t("Rename the column “{name}”", { name: old }) : t("Rename “{name}”", { name: old });
    const dialog = open(names.length > 1 ? t("Rename a stream") : title, [form]);
    form.append(button(t("Cancel"), () => dialog.close()));
    dialog.classList.add("renaming");
    dialog.addEventListener("close", () => {
      this.preview(null);
      this.mark();
      done();
    });
    list.addEventListener("change", mark);
    const look = async () => {
      const name = field.value.trim();
      const answer = !name || name === old ? { name } : await this.look(old, name, column);
      if (answer && dialog.open) show(answer);
    };
    which.addEventListener("change", () => {
      [old, field.value] = [which.value, which.value];
      look();
    });
    let timer = 0;
    field.addEventListener("input", () => {
      clearTimeout(timer);
      timer = setTimeout(look, RESTS_MS);
    });
    form.addEventListener("submit", async (event) => {
      event.preventDefault();
      clearTimeout(timer);
      if (!found || found.name !== field.value.trim()) await look();
      if (!found?.cells?.length || !dialog.open) return;
      done = () => {};
      const also = ticked();
      dialog.close();
      const body = { old, new: found.name, ...(column ? { column, also } : {}) };
      grid.held.until(async () => this.told((await grid.server.send("rename", body)).rows ?? [], { was: old, text: found.name }));
    });
    field.select();
    look();

    function ticked() {
      return [...list.querySelectorAll("input:checked")].map((box) => box.value);
    }

    function show(answer) {
      found = answer;
      const cells = answer.cells ?? [];
      told.classList.toggle("is-wrong", Boolean(answer.message));
      put(told, answer.message ?? (cells.length ? tn("{n} cell changes:", "{n} cells change:", { n: cells.length }) : ""));
      submit.ariaDisabled = String(!cells.length); // not `disabled`: Enter may come before the answer
      const sheets = Map.groupBy(cells.slice(0, MOST_LISTED), (cell) => cell.sheet);
      list.replaceChildren(...[...sheets].flatMap(([sheet, places]) => [make("h3", sheet), make("ul", {}, ...places.map(place))]));
      if (cells.length > MOST_LISTED) list.append(make("p", t("… and {n} more", { n: cells.length - MOST_LISTED })));
      if (answer.unsure?.length) {
        const boxes = answer.unsure.map((one) => {
          const box = make("input", { type: "checkbox", value: idOf(one) });
          return make("li", {}, make("label", { className: "tick" }, box, make("span", {}, ...texts({ ...one, cell: `${one.sheet} ${one.cell}` }))));
        });
        list.append(make("h3", t("Perhaps these too: tick those that read this column")), make("ul", {}, ...boxes));
      }
      if (answer.unsafe?.length) {
        list.append(make("h3", t("Change these yourself: the name means something else there too")), make("p", answer.unsafe.join(", ")));
      }
      mark();
    }
  }

  /** Tell that a name was changed, which can be undone; of a cell that gives it (`row` and `k`) in the other cells alone, too. */
  told(entries, { was, text, row, k }) {
    const { grid } = this;
    const alone = row && (() => grid.held.until(async () => {
      await grid.server.send("undo", {});
      grid.change([[grid.table.cell(grid.table.row(row), k), text]]);
    }));
    const head = entries.some(({ heads }) => heads);
    const rows = new Set(entries.flatMap(({ sheet, cells = [] }) => cells.map(([row]) => `${sheet} ${row}`))).size;
    if (!(rows || head) || (alone && rows < 2)) return;
    const { edits } = grid.server;
    const newest = (act) => () => {
      if (grid.server.edits === edits) act();
      else grid.say(t("You have changed something else since. Press Ctrl+Z to undo your changes one by one."), true);
    };
    const acts = [[t("Undo"), newest(() => grid.undo())], ...(alone ? [[t("Only this cell"), newest(alone)]] : [])];
    if (head) {
      const told = rows ? tn("The column “{was}” is now “{text}”, also in {n} row that reads it.", "The column “{was}” is now “{text}”, also in {n} rows that read it.", { was, text, n: rows }) : t("The column “{was}” is now “{text}”.", { was, text });
      status(told, "told", acts);
    } else status(tn("“{was}” is now “{text}” in {n} row.", "“{was}” is now “{text}” in {n} rows.", { was, text, n: rows }), "told", acts);
  }
}

const idOf = ({ sheet, cell }) => `${sheet}!${cell}`;

const parts = (text) => text.split(/[,\n]/).map((name) => name.trim());

const texts = ({ cell, was, text }) => [make("b", cell), " ", make("del", was), " ", make("ins", text)];

function place(one) {
  return make("li", {}, ...texts(one));
}
