// Edits of the sheet, from the text that is being typed to the answer of the server. They are sent in order, one request at a
// time; what others (and the server) change comes as events with rows ready to be shown.

import { deliver, once, ownName, randomId, request } from "../api.js";
import { button, make } from "../elements.js";
import { t, tn } from "../texts.js";
import { open } from "./dialog.js";
import { Order } from "./pending.js";
import { done } from "./spoken.js";

const EDITS = new Set(["cells", "insert", "delete", "move", "rename", "replace", "comment", "look", "undo", "redo", "fix", "column"]);
const OWN = new Set(["cells", "insert", "delete", "move", "comment", "look"]); // edits of this sheet alone, whatever its name is by now

export class Server {
  constructor(grid, table, client, hooks) {
    this.url = grid.dataset.url;
    this.sheet = grid.dataset.sheet;
    this.table = table;
    this.hooks = hooks;
    this.client = client;
    this.secret = randomId(12); // begins the ids of our requests, which nobody else can guess
    this.count = 0;
    this.edits = 0; // that were sent
    this.waiting = new Map(); // row id → tag of our newest edit in it that the server has not confirmed
    this.serials = new Map(); // row id → serial number of the HTML shown; HTML with a smaller one came late and is left out
    this.early = new Map(); // row id → HTML of a row that this page does not have yet: what brings the row may be older
    this.postponed = new Map(); // row id → what came for it while an edit of ours was on its way
    this.order = new Order(table, Number(grid.dataset.version));
    this.chain = Promise.resolve();
    this.dropped = new Set(); // tags of what is not to be sent any more
    this.unlocking = null; // the cell of the unlock that was not sent yet: an edit of the cell says that too
    this.next = null; // the edit of cells that was not sent yet: it says where the cursor is, too
    this.unsent = new Unsent(this.url, (cell) => this.address(cell), hooks.held);
    for (const { id, action, text } of this.unsent.entries) { // of this tab before it was loaded again
      const body = { ...JSON.parse(text), client: this.client, tag: `${this.client}-${++this.count}` };
      this.chain = this.chain.then(() => this.post(action, body, id)).catch(() => {});
    }
  }

  get name() {
    return ownName("panel" in (document.getElementById("runbar")?.dataset ?? {}));
  }

  /** Send cells `{row, k, text, was}`; to `rename`, the one that gives a name, with all that have it; with `devices` for the sheet
   *  Devices, or with `carried`, the comments of cells that were cut, each with the cell `to` which they go. */
  cells(changes, { rename = false, devices = [], carried = [] } = {}) {
    const body = changes.map(({ row, k, text, was }) => ({ row, column: this.table.sheetColumn(k), text, was }));
    const { row, column, tag } = this.unlocking ?? {};
    const more = { rename: rename || undefined, devices: devices.length ? devices : undefined, carried: carried.length ? carried : undefined };
    const whole = { cells: body, ...more };
    if (!body.some((cell) => cell.row === row && cell.column === column)) return this.send("cells", whole, changes.map((c) => c.row));
    this.dropped.add(tag);
    return this.send("cells", { ...whole, unlock: { row, column } }, changes.map((c) => c.row));
  }

  /** Insert, delete or move rows (`step`: see Order): shown at once, and taken back if the server refuses it. */
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
    request(`${this.url}/part`, { body: { client: this.client, name: this.name }, keepalive: true });
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
    if (id) {
      this.edits++;
      done();
      this.unsent.add(id, action, JSON.stringify(whole));
    }
    if (action === "cells") this.next = whole;
    const job = this.chain.then(() => this.post(action, whole, id, OWN.has(action) && !body.rename && !body.devices));
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
    const { answer } = await once(`${this.url}/${action}`, text);
    if (answer) return answer;
    return ["lock", "unlock", "stand"].includes(action) ? {} : { message: t("This page has no connection to the program. Nothing was changed. Check that the program is running, then try again.") };
  }

  /** The address of a cell `{row, column}` for people, such as C4. */
  address({ row, column }) {
    const k = this.table.placeOf(column);
    const found = this.table.row(row);
    return found && k >= 0 ? this.table.address(this.table.cell(found, k)) : this.sheet;
  }

  confirm(tag) {
    for (const [row, mine] of this.waiting) if (mine === tag) this.waiting.delete(row);
  }

  /** Show the newest HTML of a row; while an edit of ours is on its way to it, keep it until the answer is here. */
  show(id, html, made = Infinity) {
    if (made < (this.serials.get(id) ?? 0)) return;
    if (Number.isFinite(made)) this.serials.set(id, made);
    if (this.waiting.has(id)) {
      this.postponed.set(id, html);
      return;
    }
    this.postponed.delete(id);
    const row = this.table.row(id);
    if (row) this.table.replace(row, parse(html));
    else if (!this.order.replaceAside(id, parse(html)[0])) this.early.set(id, html);
  }

  /** Show what has changed: rows to replace, new rows, another order. `last`: the answer to our edit `tag` is here as a whole. */
  receive(change, last = true) {
    if (change.sheet === undefined || change.sheet === this.sheet) this.take(change, last);
    else if (last && change.tag?.startsWith(`${this.client}-`)) this.take({ tag: change.tag }, last);
  }

  take(change, last) {
    if (last) this.confirm(change.tag);
    const before = this.hooks.before();
    for (const [column, header] of change.heads ?? []) this.table.rename(column, header);
    if (change.headers) this.hooks.headers(change.headers);
    for (const html of [...(change.insert ?? []).map((one) => one.html), ...(change.grown ?? [])]) {
      for (const row of parse(html)) {
        if (this.table.row(row.id)) this.show(row.id, row.outerHTML, change.made);
        else this.order.came([this.newest(row, change.made)]);
      }
    }
    for (const id of change.remove ?? []) this.early.delete(id);
    if (change.order) this.order.take(change.order);
    const settled = last && this.order.settle(change.tag);
    for (const { id, html } of change.replace ?? []) this.show(id, html, change.made);
    for (const [id, html] of this.postponed) if (!this.waiting.has(id)) this.show(id, html);
    this.shown(before, change, Boolean(change.order || change.insert || change.heads || settled) && (this.order.show() || Boolean(change.heads)));
  }

  /** A row that is new here, in its newest HTML: a change of it may have been quicker. */
  newest(row, made) {
    const html = this.early.get(row.id);
    this.early.delete(row.id);
    return html && made < this.serials.get(row.id) ? parse(html)[0] : row;
  }

  /** The next piece of a long sheet, as bodies of the table; `made` is its serial number. */
  piece(bodies, made) {
    for (const body of bodies) for (const row of [...body.rows]) row.replaceWith(this.newest(row, made));
    const before = this.hooks.before();
    this.shown(before, {}, this.order.append(bodies));
  }

  shown(before, change, moved) {
    if (moved) this.table.renumber();
    this.hooks.after(before, change, moved);
  }
}

function parse(html) {
  const holder = document.createElement("template");
  holder.innerHTML = html;
  return [...holder.content.children];
}

// Edits that the server has not answered yet. They stay in the tab, also over a reload, until there is an answer, and go
// again in their order when the server is back. Those that cannot be sent are shown, so that they can be copied.

class Unsent {
  /** `place` gives the address of a cell `{row, column}` for people, if it is there; `held` is what waits, see pending.js. */
  constructor(url, place, held) {
    this.url = url;
    this.place = place;
    this.held = held;
    this.key = `unsent ${url}`;
    this.entries = this.read(); // {id, action, text}, the oldest first
    this.box = null;
    window.addEventListener("beforeunload", (event) => this.box && this.entries.length && event.preventDefault());
    this.show();
  }

  /** Keep an edit until `done`; `text` is what is sent. */
  add(id, action, text) {
    this.entries.push({ id, action, text });
    this.keep();
  }

  done(id) {
    this.entries = this.entries.filter((entry) => entry.id !== id);
    this.keep();
  }

  /** Send an edit until there is an answer. The server makes it once, however often it comes. */
  deliver(action, text) {
    return deliver(`${this.url}/${action}`, text, (words) => this.tell(words));
  }

  read() {
    try {
      return JSON.parse(sessionStorage.getItem(this.key) ?? "[]");
    } catch {
      return [];
    }
  }

  keep() {
    try {
      if (this.entries.length) sessionStorage.setItem(this.key, JSON.stringify(this.entries));
      else sessionStorage.removeItem(this.key);
    } catch { // too much for the browser: it is kept as long as the page is open
    }
    this.show();
  }

  /** The header says whether everything is saved. */
  show() {
    const line = document.getElementById("saved");
    const unsent = this.entries.length > 0 || this.held.texts.length > 0;
    if (line) line.textContent = !unsent ? t("Saved") : this.box ? t("Not saved") : t("Saving …");
    line?.classList.toggle("is-warning", unsent && Boolean(this.box));
    document.body.toggleAttribute("data-saving", unsent);
    const count = this.entries.filter((entry) => this.told(entry)).length + this.held.texts.length;
    if (this.box) this.box.querySelector("b").textContent = tn("{n} change is not saved.", "{n} changes are not saved.", { n: count });
  }

  /** Say what is wrong, and offer what can be done; an empty text when nothing is any more. */
  tell(text) {
    if (!text) {
      this.box?.remove();
      this.box = null;
    } else if (!this.box) {
      this.box = make("div");
      this.box.className = "unsent";
      this.box.setAttribute("role", "alert");
      this.box.append(make("b"), make("span"), button(t("Try again"), () => document.dispatchEvent(new Event("rrp:again"))), button(t("Show changes"), () => this.offer()));
      document.querySelector(".topbar").after(this.box);
    }
    if (text) this.box.querySelector("span").textContent = text;
    this.show();
  }

  /** All texts that are not saved, to be copied or given up. */
  offer() {
    const lines = [...this.entries.map((entry) => this.told(entry)).filter(Boolean), ...this.held.texts].join("\n");
    const area = make("textarea", lines);
    area.readOnly = true;
    area.rows = Math.min(10, lines.split("\n").length + 1);
    area.setAttribute("aria-label", t("Changes that are not saved"));
    const dialog = open(t("Changes that are not saved"), [make("p", t("This page sends them when the program accepts them again. You can copy them.")), area]);
    const copy = button(t("Copy"), async () => {
      area.select();
      if (navigator.clipboard) await navigator.clipboard.writeText(lines);
      else document.execCommand("copy"); // browsers have no other way without encryption, as with --lan
      copy.textContent = t("Copied");
    });
    dialog.append(copy, button(t("Close"), () => dialog.close()), button(t("Discard changes"), () => {
      this.entries = [];
      this.held.drop();
      this.tell("");
      this.keep();
      location.reload();
    }));
  }

  told({ action, text }) {
    const sent = JSON.parse(text);
    if (action === "insert" && sent.before === null) return ""; // blank rows at the end, which no person asked for
    if (action === "comment" && sent.text) return t("Comment: {text}", { text: sent.text });
    if (action === "cells") return sent.cells.map((cell) => `${this.place(cell)}: ${cell.text}`).join("\n");
    if (action === "replace") return sent.sheets.flatMap(({ sheet, cells }) => cells.map(({ text }) => `${sheet}: ${text}`)).join("\n");
    const rows = sent.rows?.length ?? sent.count;
    return {
      insert: t("Insert rows: {n}", { n: rows }), delete: t("Delete rows: {n}", { n: rows }), move: t("Move rows: {n}", { n: rows }),
      comment: t("Change of a comment"), look: t("Format of cells"), undo: t("Undo"), redo: t("Redo"), fix: t("Fix: {title}", { title: sent.title }),
      column: t("Add the column {header}", { header: sent.title }),
    }[action] ?? action;
  }
}

// Drafts: a text that was being typed when the page went away (a reload, Back, a closed tab) is offered on return.

const CLAIMED_WITHIN = 500; // milliseconds in which another page says that a draft is its own

export class Drafts {
  constructor(grid, page) {
    this.grid = grid;
    this.page = page;
    this.place = `drafts:${grid.server.url}`;
    this.pages = new BroadcastChannel("rrp-pages"); // a tab that was duplicated has the other's drafts, too
    this.pages.addEventListener("message", ({ data }) => {
      if (data.wanted === page.id) this.pages.postMessage({ here: page.id });
    });
  }

  read() {
    try {
      return JSON.parse(sessionStorage.getItem(this.place)) ?? {};
    } catch {
      return {};
    }
  }

  write(drafts) {
    try {
      if (Object.keys(drafts).length) sessionStorage.setItem(this.place, JSON.stringify(drafts));
      else sessionStorage.removeItem(this.place);
    } catch { // there is no room for it: then it is not kept
    }
  }

  /** Keep what is being typed. */
  keep() {
    const { editor, server, table } = this.grid;
    if (!editor.isOpen) return;
    const { rowId: row, k, was, field } = editor;
    const column = table.sheetColumn(k);
    const cell = table.cell(table.row(row), k);
    this.open ??= { owner: this.page.id, sheet: server.sheet, row, column, was, address: cell ? table.address(cell) : "" };
    const drafts = this.read();
    if (field.value === was) delete drafts[keyOf(this.open)];
    else drafts[keyOf(this.open)] = { ...this.open, text: field.value };
    this.write(drafts);
  }

  /** Keep texts that wait for the server, and for which no cell is known yet; none when nothing waits any more. */
  wait(texts) {
    this.waiting ??= { owner: this.page.id, sheet: this.grid.server.sheet, row: this.page.client, column: -1 };
    const drafts = this.read();
    if (texts.length) drafts[keyOf(this.waiting)] = { ...this.waiting, text: texts.join("\n") };
    else delete drafts[keyOf(this.waiting)];
    this.write(drafts);
    if (!texts.length) this.waiting = null; // the sheet may have another name when texts wait again
  }

  /** Nothing is being typed any more. */
  drop(draft = this.open) {
    this.open = null;
    if (!draft) return;
    const drafts = this.read();
    delete drafts[keyOf(draft)];
    this.write(drafts);
  }

  /** Offer what was being typed on this sheet. */
  async offer() {
    const mine = Object.values(this.read()).filter((draft) => draft.sheet === this.grid.server.sheet);
    for (const draft of mine) {
      if (draft.owner !== this.page.id && await this.lives(draft.owner)) this.drop(draft);
      else await this.ask({ ...draft });
    }
  }

  /** Resolve to true if the page that a draft belongs to is still there. */
  lives(owner) {
    return new Promise((resolve) => {
      const heard = ({ data }) => data.here === owner && over(true);
      const over = (lives) => {
        clearTimeout(timer);
        this.pages.removeEventListener("message", heard);
        resolve(lives);
      };
      const timer = setTimeout(() => over(false), CLAIMED_WITHIN);
      this.pages.addEventListener("message", heard);
      this.pages.postMessage({ wanted: owner });
    });
  }

  ask(draft) {
    const { table, selection, editor } = this.grid;
    const k = table.placeOf(draft.column);
    const cell = k < 0 ? null : table.cell(table.row(draft.row), k);
    const text = make("textarea", draft.text);
    text.readOnly = true;
    text.rows = Math.min(8, draft.text.split("\n").length + 1);
    text.setAttribute("aria-label", t("What you had typed"));
    const fixed = table.grid.ariaReadOnly === "true";
    const words = draft.column < 0 ? t("You typed this while the program did not answer, and it is not saved. Copy your text, and paste it where it belongs.")
      : cell ? t("You had not finished {cell} when this page was left.", { cell: table.address(cell) })
      : t("You had not finished {cell}, and its row has been deleted. Copy your text, and paste it where it belongs.", { cell: draft.address });
    return new Promise((resolve) => {
      const dialog = open(t("You were typing"), [make("p", words), text]);
      dialog.addEventListener("close", resolve);
      const ends = (title, action) => dialog.append(button(title, () => {
        this.drop(draft);
        dialog.close();
        action(); // at once: the next key is for the editor
      }));
      if (cell && !fixed) {
        ends(t("Continue typing"), () => {
          selection.go(table.row(draft.row), k);
          editor.open(selection.cell, draft.text, draft.was);
        });
      }
      ends(cell && !fixed ? t("Discard") : t("Close"), () => {});
      dialog.querySelector("button").focus();
    });
  }
}

const keyOf = ({ sheet, row, column }) => JSON.stringify([sheet, row, column]);
