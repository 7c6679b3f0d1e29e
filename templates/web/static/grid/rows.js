// Whole rows: inserted, deleted, moved, duplicated.

export class Rows {
  constructor(grid) {
    this.grid = grid;
  }

  selected() {
    const box = this.grid.selection.box();
    return box ? this.grid.table.rows.slice(box.top, box.bottom + 1) : [];
  }

  /** The row so many rows above the first of these, or below the last. */
  beyond(rows, by) {
    const { table } = this.grid;
    return table.rows[table.at(rows.at(by < 0 ? 0 : -1)) + by];
  }

  /** Insert as many rows as are selected; the selection then stands on the new ones, as in Excel. */
  async insert(below = false) {
    const rows = this.selected();
    if (!rows.length || this.grid.refuses()) return;
    const box = this.grid.selection.box();
    const before = below ? this.beyond(rows, 1) : rows[0];
    const place = below ? box.bottom + 1 : box.top;
    const answer = await this.grid.server.send("insert", { before: before?.id ?? null, count: rows.length });
    if (answer.rows) this.grid.say(`${rows.length === 1 ? "A row" : `${rows.length} rows`} inserted.`);
    if (answer.rows) this.grid.selection.spread(place, box.left, place + rows.length - 1, box.right);
  }

  async remove() {
    const rows = this.selected().map((row) => row.id);
    if (!rows.length || this.grid.refuses()) return;
    const answer = await this.grid.server.send("delete", { rows });
    if (answer.rows) this.grid.say(`${rows.length === 1 ? "The row is" : `${rows.length} rows are`} deleted.`);
  }

  move(by) {
    const rows = this.selected();
    if (!rows.length || this.grid.refuses() || !this.beyond(rows, by)) return null;
    const before = this.beyond(rows, by < 0 ? -1 : 2);
    return this.grid.server.send("move", { rows: rows.map((row) => row.id), before: before?.id ?? null });
  }

  async duplicate() {
    const rows = this.selected();
    const texts = rows.map((row) => this.grid.table.headers.map((_, k) => this.grid.table.value(this.grid.table.cell(row, k))));
    const last = this.grid.table.at(rows.at(-1));
    await this.insert(true);
    this.grid.change(texts.flatMap((line, i) => line.map((text, k) => [this.grid.table.cell(this.grid.table.rows[last + 1 + i], k), text])));
  }
}
