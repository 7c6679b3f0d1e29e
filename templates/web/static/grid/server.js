// Edits to the server and changes from it. Edits are sent in order, one request at a time; what others (and the server)
// change comes as events with rows ready to be shown.

export class Server {
  constructor(grid, table, hooks) {
    this.url = grid.dataset.url;
    this.sheet = grid.dataset.sheet;
    this.table = table;
    this.hooks = hooks;
    this.client = [...crypto.getRandomValues(new Uint8Array(6))].map((b) => b.toString(16).padStart(2, "0")).join("");
    this.name = localStorage.getItem("name") ?? "Somebody";
    this.count = 0;
    this.waiting = new Map(); // row id → tag of our newest edit in it that the server has not confirmed
    this.chain = Promise.resolve();
  }

  /** Send cells `{row, k, text, was}`. */
  cells(changes) {
    const body = changes.map(({ row, k, text, was }) => ({ row, column: this.table.sheetColumn(k), text, was }));
    return this.send("cells", { cells: body }, changes.map((c) => c.row));
  }

  send(action, body, rows = []) {
    const tag = `${this.client}-${++this.count}`;
    for (const row of rows) this.waiting.set(row, tag);
    this.hooks.saving(true);
    const job = this.chain.then(() => this.post(action, { ...body, tag, sheet: this.sheet, client: this.client, name: this.name }));
    this.chain = job.catch(() => {});
    return job;
  }

  async post(action, body) {
    let answer;
    try {
      const response = await fetch(`${this.url}/${action}`, {
        method: "POST", headers: { "Content-Type": "application/json", "X-RRP": "grid" }, body: JSON.stringify(body),
      });
      answer = response.headers.get("Content-Type")?.startsWith("application/json")
        ? await response.json() : { message: `The server refused this (${response.status}). Reload the page.` };
    } catch {
      answer = { message: "The server cannot be reached. Your change is not saved; try again when it is back.", lost: true };
    }
    if (answer.rows) this.receive({ ...answer.rows, tag: body.tag });
    else this.confirm(body.tag);
    if (answer.message) this.hooks.refused(answer);
    this.hooks.saving(this.waiting.size > 0);
    return answer;
  }

  confirm(tag) {
    for (const [row, mine] of this.waiting) if (mine === tag) this.waiting.delete(row);
  }

  /** Show what has changed: rows to replace, to insert, to remove. */
  receive(change) {
    if (change.sheet !== undefined && change.sheet !== this.sheet) return;
    this.confirm(change.tag);
    const before = this.hooks.before();
    for (const id of change.remove ?? []) this.table.row(id)?.remove();
    for (const { before: next, html } of change.insert ?? []) {
      const rows = parse(html).filter((row) => !this.table.row(row.id));
      const place = next ? this.table.row(next) : null;
      for (const row of rows) this.table.body.insertBefore(row, place);
    }
    for (const { id, html } of change.replace ?? []) {
      const old = this.table.row(id);
      if (!old || this.waiting.has(id)) continue; // ours is newer: its answer is on the way
      const [row] = parse(html);
      old.replaceWith(row);
    }
    for (const { id, before: next } of change.move ?? []) {
      this.table.body.insertBefore(this.table.row(id), next ? this.table.row(next) : null);
    }
    if (change.insert?.length || change.remove?.length || change.move?.length) this.table.renumber();
    this.hooks.after(before, change);
  }
}

function parse(html) {
  const holder = document.createElement("template");
  holder.innerHTML = html;
  return [...holder.content.children];
}
