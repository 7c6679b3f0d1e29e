// Comments of cells: shown beside the cell on hover and where the cursor rests, written in a panel, and all of them in a list.
// A text that was not sent stays in the tab, also over a reload.

import { UNREACHED, isNamed, request, shownName } from "../api.js";
import { hintOf, isComposed } from "../commands.js";
import { button, make, put } from "../elements.js";
import { t, tn } from "../texts.js";
import { open as openDialog } from "./dialog.js";
import { lost } from "./people.js";
import { status } from "./spoken.js";

/** Stands for the row of the headers, as on the server. */
export const HEADER = "header";

const RESTS_MS = 300; // of the pointer or the cursor, until a card is shown
const MOST_LETTERS = 10_000; // of a comment, as the server takes them
const MOST_ON_CARD = 3; // comments, the newest ones

export class Threads {
  constructor(grid) {
    this.grid = grid;
    this.key = `comments ${grid.server.url}`;
    this.card = make("div", { className: "thread-card", hidden: true, ariaHidden: "true" }); // a screen reader has the cell's description
    this.panel = null;
    this.place = null; // {row, k}: the cell whose panel is open
    document.querySelector("main").append(this.card);
    const { scroll, table } = grid;
    for (const name of ["pointerover", "pointerleave"]) scroll.addEventListener(name, () => this.soon());
    scroll.addEventListener("scroll", () => {
      this.hide();
      this.soon();
    });
    document.addEventListener("pointerdown", ({ target }) => this.panel && !this.panel.contains(target) && !target.closest("dialog") && this.close(false));
    table.grid.addEventListener("rrp:rows", () => this.came());
    this.count = button("", () => this.list(), "button plain small comment-count");
    this.count.hidden = true;
    document.getElementById("counts").after(this.count);
    const told = table.headers.filter((head) => head.dataset.told);
    this.heads(told.map(({ dataset }) => ({ column: Number(dataset.c), told: dataset.told, resolved: "resolved" in dataset })));
  }

  /** Mark the headers that have comments: `{column, told, resolved}`, of the sheet's columns. */
  heads(comments) {
    const { table } = this.grid;
    for (const head of table.headers) {
      const about = comments.find(({ column }) => column === Number(head.dataset.c));
      head.classList.toggle("commented", Boolean(about));
      head.classList.toggle("resolved", Boolean(about?.resolved));
      let mark = head.querySelector(".head-comments");
      if (!about) mark?.remove();
      else {
        if (!mark) head.append((mark = button("", () => this.open(head), "head-comments")));
        const title = t("Comments on {cell}", { cell: table.address(head) });
        mark.ariaLabel = `${title}. ${about.told}`;
      }
    }
    this.came();
  }

  // ---- the card

  /** Show the comments of the cell under the pointer, else of the one with the cursor, when it rests there. */
  soon() {
    clearTimeout(this.timer);
    const { scroll, selection } = this.grid;
    const cell = scroll.querySelector(".commented:hover") ?? selection.cell;
    if (cell && cell === this.shown) return;
    this.hide();
    if (!cell?.classList.contains("commented") || this.panel) return;
    const place = this.at(cell);
    this.timer = setTimeout(async () => {
      const comments = await this.read(place);
      const now = this.cellAt(place); // the row may have been shown anew meanwhile
      if (!comments.length || !now || !this.seen(now) || this.panel || this.grid.editor.isOpen) return;
      const left = comments.length - MOST_ON_CARD;
      this.card.replaceChildren(
        ...(left > 0 ? [make("p", { className: "quiet", textContent: tn("{n} earlier comment", "{n} earlier comments", { n: left }) })] : []),
        ...comments.slice(-MOST_ON_CARD).map((one) => make("p", {}, make("b", who(one)), ` ${one.text}`)),
      );
      this.shown = now;
      this.card.hidden = false;
      beside(this.card, now);
    }, RESTS_MS);
  }

  hide() {
    clearTimeout(this.timer);
    this.card.hidden = true;
    this.shown = null;
  }

  /** True for a cell that is not scrolled out of sight. */
  seen(cell) {
    const [mine, frame] = [cell.getBoundingClientRect(), this.grid.scroll.getBoundingClientRect()];
    return cell.isConnected && mine.bottom > frame.top && mine.top < frame.bottom && mine.right > frame.left && mine.left < frame.right;
  }

  cellAt({ row, k }) {
    const { table } = this.grid;
    return row === HEADER ? table.headers[k] : table.cell(table.row(row), k);
  }

  at(cell) {
    return { row: cell.closest("thead") ? HEADER : cell.parentElement.id, k: this.grid.table.column(cell) };
  }

  async read({ row, k }) {
    const { server, table } = this.grid;
    const query = new URLSearchParams({ row, column: table.sheetColumn(k) });
    const { ok, json } = await request(`${server.url}/thread/${encodeURIComponent(server.sheet)}?${query}`);
    return ok ? json.comments : [];
  }

  // ---- the panel

  /** Open the panel of a cell or a header, by default of the cell with the cursor. */
  async open(cell = this.grid.selection.cell) {
    const { grid } = this;
    if (!cell || grid.held.takes(() => this.open(cell))) return;
    this.close(false);
    this.hide();
    const place = this.at(cell);
    const fixed = grid.table.grid.ariaReadOnly === "true";
    const title = t("Comments on {cell}", { cell: grid.table.address(cell) });
    this.place = place;
    this.listed = make("ol", { className: "comments", tabIndex: -1 });
    this.field = make("textarea", { rows: 3, maxLength: MOST_LETTERS, value: this.drafts()[this.name(place)] ?? "" });
    this.send = make("button", { type: "submit", className: "button first" }, t("Comment"));
    this.acts = make("div", { className: "acts" });
    const label = make("label", {}, make("span", t("Your comment")), this.field);
    this.form = make("form", { hidden: fixed }, label, make("p", { className: "quiet as" }), make("div", { className: "acts" }, this.send, make("span", { className: "quiet keys", textContent: hintOf("keepHere") })));
    const shut = button(t("Close"), () => this.close(), "button plain small");
    this.panel = make("section", { className: "thread" }, make("header", {}, make("h2", title), shut), this.listed, this.form, this.acts);
    this.panel.setAttribute("role", "dialog");
    this.panel.setAttribute("aria-label", title);
    this.field.addEventListener("input", () => this.keep(place, this.field.value));
    this.form.addEventListener("submit", (event) => (event.preventDefault(), this.add()));
    this.panel.addEventListener("keydown", (event) => this.keydown(event));
    document.querySelector("main").append(this.panel);
    this.named();
    beside(this.panel, cell);
    if (fixed) shut.focus();
    else this.field.focus();
    await this.fill();
    if (this.panel && cell.isConnected) beside(this.panel, cell);
  }

  keydown(event) {
    if (isComposed(event)) return;
    if (event.key === "Escape") {
      event.preventDefault();
      event.stopPropagation(); // one press closes the panel: two stop a run
      this.close();
    } else if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) {
      event.preventDefault();
      event.target.closest("form")?.requestSubmit();
    }
  }

  /** Close the panel; what was typed and not sent stays. */
  close(focus = true) {
    if (!this.panel) return;
    const { grid, place } = this;
    const left = this.field.value.trim();
    this.panel.remove();
    this.panel = null;
    const cell = this.cellAt(place);
    if (focus) (cell?.querySelector(".head-comments") ?? (cell?.matches("td") ? cell : grid.selection.cell))?.focus({ preventScroll: true });
    if (left && cell) grid.say(t("Your comment on {cell} has not been sent yet. This page keeps it: press Shift+F2 to continue.", { cell: grid.table.address(cell) }), true);
  }

  /** Show the comments of the cell as they are now; the text that is being typed stays. */
  async fill() {
    const { place } = this;
    const comments = await this.read(place);
    if (!this.panel || this.place !== place) return;
    const [first] = comments;
    this.listed.hidden = !first;
    const editing = this.listed.querySelector("form")?.closest("li").dataset.id;
    const kept = editing && this.listed.querySelector("textarea").value;
    this.listed.replaceChildren(...comments.map((one) => this.item(one)));
    if (editing) this.edit(comments.find((one) => one.id === editing), kept);
    put(this.send, first ? t("Reply") : t("Comment"));
    this.panel.classList.toggle("resolved", Boolean(first?.done));
    const fixed = this.form.hidden;
    const act = (title, what) => button(title, () => this.act({ what }), "button small");
    this.acts.replaceChildren(
      ...(first && !fixed ? [act(first.done ? t("Reopen") : t("Resolve"), first.done ? "reopen" : "resolve"), act(t("Delete thread"), "clear")] : []),
      button(t("All comments"), () => this.list(), "button plain small"),
    );
  }

  item(one) {
    const li = make("li", {}, make("b", who(one)), " ", make("time", { className: "quiet", textContent: when(one.at) }));
    if (one.done) li.append(" ", make("span", { className: "badge none", textContent: t("Resolved") }));
    li.dataset.id = one.id;
    li.append(make("p", one.text));
    if (one.author === this.grid.server.name && !this.form.hidden) {
      const label = (text) => `${text}: ${one.text.slice(0, 40)}`;
      const change = button(t("Edit"), () => this.edit(one), "button plain small");
      const remove = button(t("Delete"), () => this.act({ what: "delete", id: one.id }), "button plain small");
      change.ariaLabel = label(t("Edit"));
      remove.ariaLabel = label(t("Delete"));
      li.append(make("div", { className: "acts" }, change, remove));
    }
    return li;
  }

  /** Let a comment of one's own be edited in its place. */
  edit(one, text = one?.text) {
    const li = one && this.listed.querySelector(`[data-id="${CSS.escape(one.id)}"]`);
    if (!li) return;
    const field = make("textarea", { rows: 3, maxLength: MOST_LETTERS, value: text, ariaLabel: t("Edit the comment") });
    const form = make("form", {}, field, make("div", { className: "acts" }, make("button", { type: "submit", className: "button small" }, t("Save")), button(t("Cancel"), () => (form.remove(), this.fill()), "button plain small")));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      form.remove();
      if (field.value.trim() && field.value.trim() !== one.text) this.act({ what: "edit", id: one.id, text: field.value });
      else this.fill();
      this.field.focus();
    });
    li.querySelector("p").replaceWith(form);
    li.querySelector(":scope > .acts")?.remove();
    field.focus();
  }

  add() {
    const text = this.field.value.trim();
    if (!text) return this.field.focus();
    this.field.value = "";
    this.keep(this.place, "");
    this.field.focus();
    return this.act({ what: "add", text });
  }

  async act(body) {
    const { grid, place } = this;
    const { row, k } = place;
    const answer = await grid.server.send("comment", { ...body, row, column: grid.table.sheetColumn(k) }, [row]);
    if (answer.message) return;
    const told = { add: t("Comment saved"), edit: t("Comment saved"), delete: t("Comment deleted"), clear: t("Comments deleted"), resolve: t("Comments resolved"), reopen: t("Comments open again") };
    grid.spoken.say(told[body.what]);
    if (this.panel && this.place === place) this.fill();
  }

  /** A comment was refused: its text is there again. */
  giveBack({ what, row, column, text }, why) {
    if (what === "edit") lost(this.grid, why, [{ text }]);
    if (what !== "add") return;
    const k = this.grid.table.placeOf(column);
    if (!this.cellAt({ row, k })) {
      lost(this.grid, why, [{ text }]);
      return;
    }
    if (this.panel && this.place.row === row && this.place.k === k && !this.field.value) this.field.value = text;
    this.keep({ row, k }, text);
  }

  named() {
    const line = this.panel.querySelector(".as");
    const { name } = this.grid.server;
    put(line, t("You comment as {name}.", { name: shownName(name) }));
    if (isNamed(name)) return;
    line.append(" ", button(t("Say who you are"), () => {
      this.grid.people.ask();
      document.querySelector("dialog[open]").addEventListener("close", () => {
        if (!this.panel) return;
        this.named();
        this.field.focus();
      });
    }, "button plain small"));
  }

  /** Rows were shown anew: somebody may have commented. */
  came() {
    this.soon();
    if (this.panel && this.cellAt(this.place)) this.fill();
    const n = this.grid.table.grid.querySelectorAll(".commented").length;
    this.count.hidden = !n;
    put(this.count, tn("{n} cell with comments", "{n} cells with comments", { n }));
  }

  // ---- texts that are not sent

  name({ row, k }) {
    return `${this.grid.server.sheet}\n${row}\n${this.grid.table.sheetColumn(k)}`;
  }

  drafts() {
    try {
      return JSON.parse(sessionStorage.getItem(this.key)) ?? {};
    } catch {
      return {};
    }
  }

  keep(place, text) {
    const drafts = this.drafts();
    if (text.trim()) drafts[this.name(place)] = text;
    else delete drafts[this.name(place)];
    try {
      sessionStorage.setItem(this.key, JSON.stringify(drafts));
    } catch { // there is no room for it: then it is not kept
    }
  }

  /** After the page was loaded again: say that a comment was not sent, with the way to it. */
  offer() {
    const { table, server } = this.grid;
    for (const name of Object.keys(this.drafts())) {
      const [sheet, row, column] = name.split("\n");
      const cell = sheet === server.sheet && this.cellAt({ row, k: table.placeOf(Number(column)) });
      if (!cell) continue;
      status(t("Your comment on {cell} has not been sent yet.", { cell: table.address(cell) }), "error", [[t("Open"), () => this.goTo(cell)]]);
      return;
    }
  }

  /** Go to a cell, or to a header, and open its panel. */
  goTo(cell) {
    const { row, k } = this.at(cell);
    if (row !== HEADER) this.grid.selection.go(cell.parentElement, k);
    this.open(cell);
  }

  // ---- all of them

  /** List the comments of all sheets, with links to their cells. */
  async list() {
    this.close(false);
    const { grid } = this;
    const { ok, json } = await request(`${grid.server.url}/comments`);
    const said = make("p", { className: "quiet", role: "status" });
    const list = make("ul", { className: "all-comments" });
    const all = make("input", { type: "checkbox" });
    const dialog = openDialog(t("Comments in this workbook"), [make("label", { className: "tick" }, all, " ", t("Show resolved ones too")), said, list]);
    dialog.append(button(t("Close"), () => dialog.close()));
    const threads = (ok && json.threads) || [];
    const show = () => {
      const some = threads.filter((one) => all.checked || !one.done);
      put(said, !ok ? UNREACHED : json.message ?? tn("{n} thread", "{n} threads", { n: some.length + (json.left_out ?? 0) }));
      list.replaceChildren(...some.map((one) => this.entry(one, dialog)));
    };
    all.addEventListener("change", show);
    show();
  }

  entry(one, dialog) {
    const { table, server } = this.grid;
    const here = one.sheet === server.sheet;
    const link = make("a", { href: one.row || !here ? `${server.url}/sheet/${encodeURIComponent(one.sheet)}${one.row ? `#${one.row}~${one.cell}` : ""}` : "" }, `${one.sheet} ${one.cell}`);
    const cell = here && one.row && this.cellAt({ row: one.row, k: table.headers.findIndex((header) => header.dataset.letter === /^[A-Z]+/.exec(one.cell)[0]) });
    if (cell) {
      link.addEventListener("click", (event) => {
        event.preventDefault();
        dialog.close();
        this.goTo(cell);
      });
    }
    const place = one.row ? "" : t("This cell is not shown in the grid.");
    const replies = one.replies ? tn("{n} reply", "{n} replies", { n: one.replies }) : "";
    return make("li", {}, link.getAttribute("href") ? link : make("b", `${one.sheet} ${one.cell}`), " ", make("b", who(one)), " ", make("span", { className: "quiet", textContent: [when(one.at), replies, one.done ? t("resolved") : "", place].filter(Boolean).join(" · ") }), make("p", one.text));
  }
}

const who = ({ author }) => shownName(author);

const TIME = new Intl.DateTimeFormat(document.documentElement.lang || "en", { dateStyle: "medium", timeStyle: "short" });

function when(at) {
  const time = new Date(at);
  return Number.isNaN(time.getTime()) ? "" : TIME.format(time);
}

/** Put a box beside a cell, where there is room for it. */
function beside(box, cell) {
  const { left, right, top, bottom } = cell.getBoundingClientRect();
  const { offsetWidth: width, offsetHeight: height } = box;
  const x = right + 4 + width <= innerWidth ? right + 4 : left - 4 - width;
  const fits = x >= 8;
  box.style.left = `${fits ? x : Math.max(8, Math.min(left, innerWidth - width - 8))}px`;
  box.style.top = `${Math.max(8, Math.min(fits ? top : bottom + 4, innerHeight - height - 8))}px`;
}
