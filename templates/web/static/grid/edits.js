// Edits to the server and changes from it. Edits are sent in order, one request at a time; what others (and the server)
// change comes as events with rows ready to be shown.

import { ownName } from "../run/ask.js";
import { Order } from "./order.js";
import { Unsent } from "./unsent.js";

const EDITS = new Set(["cells", "insert", "delete", "move", "undo", "redo", "fix"]);
const OWN = new Set(["cells", "insert", "delete", "move"]); // edits of this sheet alone, whatever its name is by now

export class Server {
  constructor(grid, table, client, hooks) {
    this.url = grid.dataset.url;
    this.sheet = grid.dataset.sheet;
    this.table = table;
    this.hooks = hooks;
    this.client = client;
    this.secret = random(12); // begins the ids of our requests, which nobody else can guess
    this.count = 0;
    this.waiting = new Map(); // row id → tag of our newest edit in it that the server has not confirmed
    this.made = new Map(); // row id → number of its newest look that came; of two looks that cross, the later made one stays
    this.held = new Map(); // row id → what came for it while an edit of ours was on its way
    this.order = new Order(table, Number(grid.dataset.version));
    this.chain = Promise.resolve();
    this.dropped = new Set(); // tags of what is not to be sent any more
    this.unlocking = null; // the cell of the unlock that was not sent yet: an edit of the cell says that too
    this.next = null; // the edit of cells that was not sent yet: it says where the cursor is, too
    this.unsent = new Unsent(this.url, (cell) => this.address(cell));
    for (const { id, action, text } of this.unsent.entries) { // of this tab before it was loaded again
      const body = { ...JSON.parse(text), client: this.client, tag: `${this.client}-${++this.count}` };
      this.chain = this.chain.then(() => this.post(action, body, id)).catch(() => {});
    }
  }

  get name() {
    return ownName("panel" in (document.getElementById("runbar")?.dataset ?? {}));
  }

  /** Send cells `{row, k, text, was}`. */
  cells(changes) {
    const body = changes.map(({ row, k, text, was }) => ({ row, column: this.table.sheetColumn(k), text, was }));
    const { row, column, tag } = this.unlocking ?? {};
    if (!body.some((cell) => cell.row === row && cell.column === column)) return this.send("cells", { cells: body }, changes.map((c) => c.row));
    this.dropped.add(tag);
    return this.send("cells", { cells: body, unlock: { row, column } }, changes.map((c) => c.row));
  }

  /** Insert, delete or move rows (`step`: see order.js): shown at once, and taken back if the server refuses it. */
  step(action, body, step, rows = []) {
    const before = this.hooks.before();
    const answer = this.send(action, body, rows, step);
    this.shown(before, {}, this.order.show());
    return answer;
  }

  /** Take a cell for editing. */
  lock(row, column) {
    const tag = `${this.client}-${this.count + 1}`;
    this.locking = { row, column, tag };
    return this.send("lock", { row, column }).finally(() => this.locking?.tag === tag && (this.locking = null));
  }

  /** Give a cell free; when it was not even asked for yet, neither is sent. */
  unlock(row, column) {
    const lock = this.locking;
    if (lock?.row !== row || lock.column !== column || lock.sent) {
      this.unlocking = { row, column, tag: `${this.client}-${this.count + 1}` };
      return this.send("unlock", { row, column });
    }
    this.dropped.add(lock.tag);
    return Promise.resolve({});
  }

  /** Say where the cursor is; the newest place only, and nobody waits for it. */
  stand(row, k) {
    clearTimeout(this.standing);
    if (this.next) {
      this.next.stand = { row, column: this.sheetColumn(k) };
      return;
    }
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

  send(action, body, rows = [], step = null) {
    const tag = `${this.client}-${++this.count}`;
    for (const row of rows) this.waiting.set(row, tag);
    if (step) this.order.pending.push({ ...step, tag });
    const id = EDITS.has(action) ? `${this.secret}-${this.count}` : "";
    const whole = { ...body, tag, request: id, sheet: this.sheet, client: this.client, name: this.name };
    if (id) this.unsent.add(id, action, JSON.stringify(whole));
    if (action === "cells") this.next = whole;
    const job = this.chain.then(() => this.post(action, whole, id, OWN.has(action)));
    this.chain = job.catch(() => {});
    return job;
  }

  async post(action, body, id, own = false) {
    if (this.next === body) this.next = null;
    if (this.unlocking?.tag === body.tag) this.unlocking = null;
    if (this.dropped.delete(body.tag)) return {};
    if (this.locking?.tag === body.tag) this.locking.sent = true;
    const answer = await (id ? this.unsent.deliver(action, JSON.stringify(body)) : this.ask(action, JSON.stringify(body)));
    this.confirm(body.tag);
    const changes = answer.rows?.length ? answer.rows : [{}];
    const here = own ? { sheet: this.sheet } : {};
    changes.forEach((change, i) => this.receive({ ...change, ...here, tag: body.tag }, i === changes.length - 1));
    if (answer.message) this.hooks.refused(answer, action, body);
    this.unsent.done(id);
    return answer;
  }

  /** Ask for what is no edit: it is not sent again. */
  async ask(action, text) {
    const { answer } = await this.unsent.ask(action, text);
    if (answer) return answer;
    return ["lock", "unlock", "stand"].includes(action) ? {} : { message: "The server cannot be reached. Nothing was changed; try again when it is back." };
  }

  /** What people call a cell `{row, column}`. */
  address({ row, column }) {
    const k = this.table.headers.findIndex((header) => Number(header.dataset.c) === column);
    const found = this.table.row(row);
    return found && k >= 0 ? this.table.address(this.table.cell(found, k)) : this.sheet;
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
    else this.order.replaceAside(id, parse(html)[0]);
  }

  /** Show what has changed: rows to replace, new rows, another order. `last`: the answer to our edit `tag` is here as a whole. */
  receive(change, last = true) {
    if (change.sheet === undefined || change.sheet === this.sheet) this.take(change, last);
    else if (last && change.tag?.startsWith(`${this.client}-`)) this.take({ tag: change.tag }, last);
  }

  take(change, last) {
    if (last) this.confirm(change.tag);
    const before = this.hooks.before();
    for (const html of [...(change.insert ?? []).map((one) => one.html), ...(change.grown ?? [])]) {
      for (const row of parse(html)) {
        if (this.table.row(row.id)) this.show(row.id, row.outerHTML, change.made);
        else this.order.came([row]);
      }
    }
    if (change.order) this.order.take(change.order);
    const settled = last && this.order.settle(change.tag);
    for (const { id, html } of change.replace ?? []) this.show(id, html, change.made);
    for (const [id, html] of this.held) if (!this.waiting.has(id)) this.show(id, html);
    this.shown(before, change, Boolean(change.order || change.insert || settled) && this.order.show());
  }

  /** The next piece of a long sheet, as bodies of the table. */
  piece(bodies) {
    const before = this.hooks.before();
    this.shown(before, {}, this.order.append(bodies));
  }

  shown(before, change, moved) {
    if (moved) this.table.renumber();
    this.hooks.after(before, change, moved);
  }
}

const random = (bytes) => [...crypto.getRandomValues(new Uint8Array(bytes))].map((b) => b.toString(16).padStart(2, "0")).join("");

function parse(html) {
  const holder = document.createElement("template");
  holder.innerHTML = html;
  return [...holder.content.children];
}
