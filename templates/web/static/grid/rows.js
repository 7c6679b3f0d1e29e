// Whole rows: inserted, deleted, moved, duplicated. Each is shown at once, and sent after what was done before.

import { randomId } from "../api.js";
import { t, tn } from "../texts.js";

const ROOM = 20; // blank rows below the last filled one, at least: as many as the server keeps
const MORE = 20; // added beyond that, so that not every row needs some
const MOST = 5000; // rows that are sent at once

export class Rows {
  constructor(grid) {
    this.grid = grid;
    this.mark = randomId(6);
    this.count = 0;
  }

  /** The rows of all ranges, from top to bottom. */
  selected() {
    const { selection, table } = this.grid;
    const rows = new Set(selection.boxes().flatMap((box) => table.rows.slice(box.top, box.bottom + 1)));
    return [...rows].filter((row) => !table.hidden.has(row.id)).sort((a, b) => table.at(a) - table.at(b));
  }

  /** The row so many rows above the first of these, or below the last. */
  beyond(rows, by) {
    const { table } = this.grid;
    return table.rows[table.at(rows.at(by < 0 ? 0 : -1)) + by];
  }

  /** True, with a message, when rows at several places are selected. */
  apart() {
    const apart = this.grid.selection.others.length > 0;
    if (apart) this.grid.say(t("Select one block of rows first."), true);
    return apart;
  }

  /** Insert as many rows as are selected; the selection then stands on the new ones, as in Excel. */
  insert(below = false) {
    if (this.grid.held.takes(() => this.insert(below))) return;
    const rows = this.selected();
    if (!rows.length || this.grid.refuses() || this.apart()) return;
    const box = this.grid.selection.box();
    this.put(below, rows, rows.map(() => []), box);
    this.grid.say(tn("A row inserted.", "{n} rows inserted.", { n: rows.length }));
  }

  /** Insert rows with texts above or below those that are selected. */
  put(below, rows, texts, box) {
    const { table, server, selection } = this.grid;
    if (below && this.grid.waits(box.bottom + 2, () => this.put(below, rows, texts, box))) return;
    if (below) this.reserve(Math.max(this.blank(box.bottom), this.beyond(rows, 1) ? 0 : table.room() - ROOM + 1));
    const before = (below ? this.beyond(rows, 1) : rows[0])?.id ?? null;
    const place = below ? box.bottom + 1 : box.top;
    const made = texts.map((line) => this.make(line));
    server.step("insert", {
      before,
      rows: made.map((row, i) => ({ id: row.id, texts: Object.fromEntries(texts[i].map((text, k) => [table.sheetColumn(k), text])) })),
    }, { insert: made.map((row) => row.id), before }, made.map((row) => row.id));
    for (const row of made) this.grid.comments.mark(row);
    selection.spread(place, box.left, place + made.length - 1, box.right);
  }

  make(texts = []) {
    const { table, server } = this.grid;
    const row = table.blank(`w${this.mark}-${++this.count}`);
    texts.forEach((text, k) => text && table.put(table.cell(row, k), text));
    server.order.came([row]);
    return row;
  }

  /** The number of the blank rows at the end, down to a place. */
  blank(place) {
    const { table } = this.grid;
    return Math.max(0, place - (table.rows.length - 1 - table.room()));
  }

  /** Append blank rows, so that `ROOM` of them are left after `used` of them have been filled or deleted. */
  reserve(used) {
    const { table, server } = this.grid;
    const missing = used + ROOM - table.room();
    if (missing <= 0 || !this.grid.whole) return;
    for (let left = missing + MORE; left > 0; left -= MOST) {
      const insert = Array.from({ length: Math.min(left, MOST) }, () => this.make().id);
      server.step("insert", { before: null, rows: insert.map((id) => ({ id })) }, { insert, before: null });
    }
  }

  remove() {
    if (this.grid.held.takes(() => this.remove())) return;
    const selected = this.selected();
    if (!selected.length || this.grid.refuses()) return;
    this.reserve(Math.min(selected.length, this.blank(this.grid.selection.box().bottom)));
    const rows = selected.map((row) => row.id);
    this.grid.server.step("delete", { rows }, { remove: rows });
    this.grid.say(tn("The row is deleted.", "{n} rows are deleted.", { n: rows.length }));
  }

  move(by) {
    if (this.grid.held.takes(() => this.move(by))) return;
    const rows = this.selected();
    if (!rows.length || this.grid.refuses() || this.apart()) return;
    const { table } = this.grid;
    const next = table.step(rows.at(by < 0 ? 0 : -1), by); // over the rows between them that are hidden, too
    if (rows.includes(next)) return;
    this.reserve(by > 0 ? 1 : this.blank(this.grid.selection.box().top) ? rows.length : 0);
    const before = (by < 0 ? next : this.beyond([next], 1))?.id ?? null;
    const move = rows.map((row) => row.id);
    this.grid.server.step("move", { rows: move, before }, { move, before });
  }

  /** Move the selected rows above another one. */
  moveBefore(row) {
    if (this.grid.held.takes(() => this.moveBefore(row))) return;
    const rows = this.selected();
    if (!rows.length || rows.includes(row) || this.grid.refuses()) return;
    this.reserve(rows.length);
    const move = rows.map((one) => one.id);
    this.grid.server.step("move", { rows: move, before: row.id }, { move, before: row.id });
  }

  duplicate() {
    if (this.grid.held.takes(() => this.duplicate())) return;
    const rows = this.selected();
    if (!rows.length || this.grid.refuses() || this.apart()) return;
    const { table } = this.grid;
    const texts = rows.map((row) => table.headers.map((_, k) => table.value(table.cell(row, k))));
    this.put(true, rows, texts, this.grid.selection.box());
  }
}
