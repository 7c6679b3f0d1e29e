// What was being typed when the page went away (a reload, Back, a closed tab): kept while it is typed, offered on return.

import { button, make, open } from "./conflict.js";

const PATIENCE = 500; // milliseconds in which another page says that a draft is its own

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

  /** Whether the page that a draft belongs to is still there. */
  lives(owner) {
    return new Promise((resolve) => {
      const heard = ({ data }) => data.here === owner && over(true);
      const over = (lives) => {
        clearTimeout(timer);
        this.pages.removeEventListener("message", heard);
        resolve(lives);
      };
      const timer = setTimeout(() => over(false), PATIENCE);
      this.pages.addEventListener("message", heard);
      this.pages.postMessage({ wanted: owner });
    });
  }

  ask(draft) {
    const { table, selection, editor } = this.grid;
    const k = table.headers.findIndex((header) => Number(header.dataset.c) === draft.column);
    const cell = k < 0 ? null : table.cell(table.row(draft.row), k);
    const text = make("textarea", draft.text);
    text.readOnly = true;
    text.rows = Math.min(8, draft.text.split("\n").length + 1);
    text.setAttribute("aria-label", "What you had typed");
    const fixed = table.grid.ariaReadOnly === "true";
    const words = cell ? `You had not finished ${table.address(cell)} when this page was left.`
      : `You had not finished ${draft.address}, and its row is gone now. Copy your text, and paste it where it belongs.`;
    return new Promise((resolve) => {
      const dialog = open("You were typing", [make("p", words), text]);
      let after = () => {};
      dialog.addEventListener("close", () => {
        after();
        resolve();
      });
      const ends = (title, action) => dialog.append(button(title, () => {
        this.drop(draft);
        after = action;
        dialog.close();
      }));
      if (cell && !fixed) {
        ends("Go on typing", () => {
          selection.go(table.row(draft.row), k);
          editor.open(selection.cell, draft.text, draft.was);
        });
      }
      ends(cell && !fixed ? "Discard" : "Close", () => {});
      dialog.querySelector("button").focus();
    });
  }
}

const keyOf = ({ sheet, row, column }) => JSON.stringify([sheet, row, column]);
