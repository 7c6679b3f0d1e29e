// The behaviours that ran: one is shown at a time, its rows with the formulas of the time, its diagram lit.

import { lights } from "../../grid/diagram.js";
import { clock } from "../../run/time.js";
import { values } from "../../run/values.js";
import { t } from "../../texts.js";

const editedWords = ({ when, was }) => t("since {time}, was {text}", { time: clock(when), text: was || t("blank") });

export class Sheets {
  constructor(root, edits) {
    this.tabs = [...root.querySelectorAll(".sheet-tabs [role=tab]")];
    this.panels = [...root.querySelectorAll(".ran-sheet")];
    this.edits = edits; // [t, place, was, now]
    this.places = new Map(); // formula cells that were edited → their text at the begin
    this.diagrams = [...root.querySelectorAll(".ran-diagram")]; // of each panel one
    this.lights = this.panels.map((panel, number) => {
      const table = panel.querySelector("table");
      values(table);
      return lights(() => this.diagrams[number].querySelector(".diagram svg"), () => table);
    });
    for (const tab of this.tabs) {
      tab.addEventListener("click", () => this.choose(tab));
      tab.addEventListener("keydown", (event) => this.key(event));
    }
    root.addEventListener("click", (event) => this.goto(event));
    root.addEventListener("keydown", (event) => ["Enter", " "].includes(event.key) && this.goto(event));
    document.addEventListener("htmx:after:swap", () => this.drawn());
  }

  /** The diagram of the behaviour that is shown is wanted now. */
  want() {
    this.diagrams.find((diagram) => !diagram.hidden)?.dispatchEvent(new CustomEvent("wanted"));
  }

  drawn() {
    for (const part of this.lights) part.redrawn();
    for (const box of document.querySelectorAll(".ran-diagram [role=button]")) box.setAttribute("tabindex", "0");
  }

  choose(chosen) {
    for (const tab of this.tabs) {
      const on = tab === chosen;
      tab.setAttribute("aria-selected", String(on));
      tab.tabIndex = on ? 0 : -1;
      const panel = document.getElementById(tab.getAttribute("aria-controls"));
      panel.hidden = this.diagrams[this.panels.indexOf(panel)].hidden = !on;
    }
    this.want();
  }

  key(event) {
    const ways = { ArrowRight: 1, ArrowLeft: -1 };
    const here = this.tabs.indexOf(event.target);
    const next = event.key === "Home" ? 0 : event.key === "End" ? this.tabs.length - 1 : here + (ways[event.key] ?? NaN);
    const tab = this.tabs[(next + this.tabs.length) % this.tabs.length];
    if (!tab) return;
    event.preventDefault();
    this.choose(tab);
    tab.focus();
  }

  /** From a box of the diagram to its row. */
  goto(event) {
    const number = event.target.closest?.(".ran-diagram [data-row]")?.dataset.row;
    const panel = this.panels[this.diagrams.indexOf(event.target.closest?.(".ran-diagram"))];
    const row = number && [...panel.querySelectorAll("tbody th")].find((head) => head.textContent === number);
    if (!row) return;
    event.preventDefault();
    row.focus({ preventScroll: true });
    row.scrollIntoView({ block: "center" });
  }

  /** The formulas as they were at a time; returns since when each edited row has been used. */
  show(seconds, ids) {
    const since = {};
    const now = new Map();
    for (const [when, place, was, text] of this.edits) {
      const id = ids[place];
      const cell = id && document.getElementById(id)?.querySelector(".formula code");
      if (!cell) continue;
      if (!this.places.has(cell)) this.places.set(cell, cell.textContent);
      if (when > seconds) continue;
      now.set(cell, { text, was, when });
      since[id] = when;
    }
    for (const [cell, first] of this.places) {
      const edited = now.get(cell);
      const text = edited?.text ?? first;
      if (cell.textContent !== text) cell.textContent = text;
      cell.parentElement.classList.toggle("edited", Boolean(edited));
      cell.parentElement.dataset.edited = edited ? editedWords(edited) : "";
    }
    return since;
  }
}
