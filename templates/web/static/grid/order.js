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

  /** The server has answered a step: it is in the order that was told, or was refused. Whether it was one of ours. */
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

  /** A row that is not shown looks otherwise now; whether there is one. */
  replaceAside(id, row) {
    return this.aside.has(id) && Boolean(this.aside.set(id, row));
  }

  /** Let the table show the order; whether anything is new. Only the rows between the first and the last difference move. */
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
