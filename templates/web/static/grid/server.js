// Edits to the server and changes from it. Edits are sent in order, one request at a time; what others (and the server)
// change comes as events with rows ready to be shown.

import { ownName } from "../run/ask.js";

export class Server {
  constructor(grid, table, hooks) {
    this.url = grid.dataset.url;
    this.sheet = grid.dataset.sheet;
    this.table = table;
    this.hooks = hooks;
    this.client = [...crypto.getRandomValues(new Uint8Array(6))].map((b) => b.toString(16).padStart(2, "0")).join("");
    this.count = 0;
    this.waiting = new Map(); // row id → tag of our newest edit in it that the server has not confirmed
    this.made = new Map(); // row id → number of its newest look that came; of two looks that cross, the later made one stays
    this.held = new Map(); // row id → what came for it while an edit of ours was on its way
    this.chain = Promise.resolve();
  }

  get name() {
    return ownName("panel" in (document.getElementById("runbar")?.dataset ?? {}));
  }

  /** Send cells `{row, k, text, was}`. */
  cells(changes) {
    const body = changes.map(({ row, k, text, was }) => ({ row, column: this.table.sheetColumn(k), text, was }));
    return this.send("cells", { cells: body }, changes.map((c) => c.row));
  }

  /** Say where the cursor is; the newest place only, and nobody waits for it. */
  stand(row, k) {
    clearTimeout(this.standing);
    this.standing = setTimeout(() => {
      const place = { row, column: this.sheetColumn(k), sheet: this.sheet, client: this.client, name: this.name };
      this.ask("stand", JSON.stringify(place));
    }, 150);
  }

  /** Say that this page is being closed; the browser sends it although the page is gone. */
  part() {
    const body = JSON.stringify({ client: this.client, name: this.name });
    fetch(`${this.url}/part`, { method: "POST", keepalive: true, headers: { "Content-Type": "application/json", "X-RRP": "grid" }, body }).catch(() => {});
  }

  sheetColumn(k) {
    return this.table.sheetColumn(k);
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
    const answer = await this.ask(action, JSON.stringify(body));
    this.confirm(body.tag);
    for (const change of answer.rows?.length ? answer.rows : [{}]) this.receive({ ...change, tag: body.tag });
    if (answer.message) this.hooks.refused(answer, action, body);
    this.hooks.saving(this.waiting.size > 0);
    return answer;
  }

  /** Ask until there is an answer. A text may be sent twice, as nothing is changed by that; a new row may not. */
  async ask(action, body) {
    for (let tries = 0; ; tries++) {
      try {
        const response = await fetch(`${this.url}/${action}`, {
          method: "POST", headers: { "Content-Type": "application/json", "X-RRP": "grid" }, body,
        });
        if (tries) this.hooks.back();
        return response.headers.get("Content-Type")?.startsWith("application/json")
          ? await response.json() : { message: refusals[response.status] ?? `The server refused this (${response.status}). Reload the page.`, refused: true };
      } catch {
        if (action === "lock" || action === "unlock" || action === "stand") return {};
        if (action !== "cells") return { message: "The server cannot be reached. Nothing was changed; try again when it is back." };
        this.hooks.away();
        await new Promise((resume) => setTimeout(resume, 1000));
      }
    }
  }

  confirm(tag) {
    for (const [row, mine] of this.waiting) if (mine === tag) this.waiting.delete(row);
  }

  /** Show the newest look of a row; while an edit of ours is on its way to it, keep it until the answer is here. */
  show(id, html, made = Infinity) {
    if (made < (this.made.get(id) ?? 0)) return;
    if (Number.isFinite(made)) this.made.set(id, made);
    if (this.waiting.has(id)) {
      this.held.set(id, html);
      return;
    }
    this.held.delete(id);
    const row = this.table.row(id);
    if (row) this.table.replace(row, parse(html));
  }

  /** Show what has changed: rows to replace, to insert, to remove. */
  receive(change) {
    if (change.sheet !== undefined && change.sheet !== this.sheet) return;
    this.confirm(change.tag);
    const before = this.hooks.before();
    for (const id of change.remove ?? []) {
      const row = this.table.row(id);
      if (row) this.table.remove(row);
    }
    for (const { before: next, html } of change.insert ?? []) {
      const rows = parse(html).filter((row) => !this.table.row(row.id));
      this.table.insert(rows, next ? this.table.row(next) : null);
    }
    for (const { id, html } of change.replace ?? []) this.show(id, html, change.made);
    for (const [id, html] of this.held) if (!this.waiting.has(id)) this.show(id, html);
    for (const { id, before: next } of change.move ?? []) {
      this.table.insert([this.table.row(id)], next ? this.table.row(next) : null);
    }
    if (change.insert?.length || change.remove?.length || change.move?.length) this.table.renumber();
    this.hooks.after(before, change);
  }
}

const refusals = {
  403: "The server was started anew, so this page may not change anything. Open the address that it has printed.",
  404: "The workbook was renamed or moved. Go to the shelf.",
  413: "That is too much at once. Paste it in smaller pieces.",
};

function parse(html) {
  const holder = document.createElement("template");
  holder.innerHTML = html;
  return [...holder.content.children];
}
