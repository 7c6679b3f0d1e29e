// Edits that the server has not answered yet. They stay in the tab, also over a reload, until there is an answer, and go
// again in their order when the server is back. What cannot be sent is shown, so that it can be copied.

import { button, make, open } from "./conflict.js";

const PAUSES = [0.5, 1, 2, 4, 8, 15, 30, 30, 30, 30, 30, 30]; // seconds before the next try; then it waits for a person
const PATIENCE = 60_000; // milliseconds for one answer
const AWAY = new Set([502, 503, 504]);
const STOPPED = {
  0: "The server cannot be reached. Start it again, then choose Try again.",
  403: "This browser is signed out. Open the link that the server prints, then choose Try again.",
  404: "The workbook was renamed or moved. Copy your changes, then open it from the shelf.",
};
const REFUSED = { 413: "That is too much at once. Paste it in smaller pieces." };

export class Unsent {
  /** `place` gives the address of a cell `{row, column}` for people, if it is there. */
  constructor(url, place) {
    this.url = url;
    this.place = place;
    this.key = `unsent ${url}`;
    this.entries = this.read(); // {id, action, text}, the oldest first
    this.box = null;
    document.addEventListener("rrp:line", ({ detail }) => detail.lost || this.again());
    document.addEventListener("rrp:again", () => this.again());
    window.addEventListener("online", () => this.again());
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
  async deliver(action, text) {
    for (let tries = 0; ; tries++) {
      const { status, answer } = await this.ask(action, text);
      if (answer) {
        this.tell("");
        return answer;
      }
      const pause = status ? undefined : PAUSES[tries];
      if (pause === undefined) {
        this.tell(STOPPED[status], status);
        await this.until();
        tries = -1;
      } else {
        if (tries) this.tell("The server cannot be reached. Your changes are kept here and sent when it is back.");
        await this.until(pause * 1000);
      }
    }
  }

  /** One try: the answer, or the status of a server that takes nothing from this page now; 0 when there is none. */
  async ask(action, text) {
    let response;
    try {
      response = await fetch(`${this.url}/${action}`, {
        method: "POST", headers: { "Content-Type": "application/json", "X-RRP": "grid" }, body: text, signal: AbortSignal.timeout(PATIENCE),
      });
      if (response.headers.get("Content-Type")?.startsWith("application/json")) return { answer: await response.json() };
    } catch {
      return { status: 0 };
    }
    if (AWAY.has(response.status)) return { status: 0 };
    if (response.status in STOPPED) return { status: response.status };
    return { answer: { message: REFUSED[response.status] ?? `The server refused this (${response.status}). Reload the page.`, refused: true } };
  }

  /** Wait so many milliseconds, or until a person or the line to the server says that it can be tried again. */
  until(milliseconds) {
    return new Promise((resume) => {
      const timer = milliseconds === undefined ? 0 : setTimeout(resume, milliseconds);
      this.again = () => {
        clearTimeout(timer);
        resume();
      };
    });
  }

  again() {}

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
    const unsent = this.entries.length > 0;
    if (line) line.textContent = !unsent ? "Saved" : this.box ? "Not saved" : "Saving …";
    line?.classList.toggle("is-warning", unsent && Boolean(this.box));
    document.body.toggleAttribute("data-saving", unsent);
    const count = this.entries.filter((entry) => this.told(entry)).length;
    if (this.box) this.box.querySelector("b").textContent = count === 1 ? "1 change is not saved." : `${count} changes are not saved.`;
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
      this.box.append(make("b"), make("span"), button("Try again", () => document.dispatchEvent(new Event("rrp:again"))), button("Show changes", () => this.offer()));
      document.querySelector(".topbar").after(this.box);
    }
    if (text) this.box.querySelector("span").textContent = text;
    this.show();
  }

  /** All texts that are not saved, to be copied or given up. */
  offer() {
    const lines = this.entries.map((entry) => this.told(entry)).filter(Boolean).join("\n");
    const area = make("textarea", lines);
    area.readOnly = true;
    area.rows = Math.min(10, lines.split("\n").length + 1);
    area.setAttribute("aria-label", "Changes that are not saved");
    const dialog = open("Changes that are not saved", [make("p", "They are sent when the server takes them again. You can copy them."), area]);
    const copy = button("Copy", async () => {
      area.select();
      if (navigator.clipboard) await navigator.clipboard.writeText(lines);
      else document.execCommand("copy"); // browsers have no other way without encryption, as with --lan
      copy.textContent = "Copied";
    });
    dialog.append(copy, button("Close", () => dialog.close()), button("Discard changes", () => {
      this.entries = [];
      this.tell("");
      this.keep();
      location.reload();
    }));
  }

  told({ action, text }) {
    const sent = JSON.parse(text);
    if (action === "insert" && sent.before === null) return ""; // blank rows at the end, which no person asked for
    if (action === "cells") return sent.cells.map((cell) => `${this.place(cell)}: ${cell.text}`).join("\n");
    const rows = sent.rows?.length ?? sent.count;
    return { insert: `Insert rows: ${rows}`, delete: `Delete rows: ${rows}`, move: `Move rows: ${rows}`, undo: "Undo", redo: "Redo", fix: `Fix: ${sent.title}` }[action] ?? action;
  }
}
