// Small plots of the numbers that streams carry, the last 30 seconds, while a run goes on.

import { make, put } from "../elements.js";
import { Plot, framed, round, shape } from "./plotting.js";
import { thresholds } from "./thresholds.js";

const SPAN = 30; // s
const FIRST = 4; // plots that are shown before anyone has chosen
const MOST_SHOWN = 12;
const KEPT = 1500; // points of a key
const MOST_KEYS = 120;
const EMPTY = "Streams with numbers are plotted here during a run.";

/** Fill `#plots`. */
export function plots(root) {
  const view = new Live(root);
  document.addEventListener("rrp:run", ({ detail }) => view.run(detail));
  document.addEventListener("rrp:live", ({ detail }) => view.live(detail));
  document.addEventListener("visibilitychange", () => view.draw());
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => view.arrange());
}

class Live {
  constructor(root) {
    root.classList.add("plots");
    this.root = root;
    this.series = new Map(); // key → { points, kind, unit, item, plot, now }
    this.t = 0;
    this.list = make("ul");
    this.empty = make("p", { className: "quiet" }, EMPTY);
    this.boxes = make("fieldset", {}, make("legend", { className: "only-spoken" }, "Streams that are plotted"));
    this.choice = make("details", {}, make("summary", {}, "Choose what is plotted"), this.boxes);
    this.choice.addEventListener("change", ({ target }) => this.choose(target));
    this.table = make("details", {}, make("summary", {}, "As a table"), make("table"));
    this.table.addEventListener("toggle", () => this.tell(true));
    root.replaceChildren(this.empty, this.list, this.choice, this.table);
    this.choice.hidden = this.table.hidden = true;
    this.units = {};
    fetch("/robot/model.json").then((r) => r.json()).then(({ units }) => { this.units = units ?? {}; }).catch(() => {});
  }

  run(detail) {
    if (detail.id !== this.id) {
      for (const entry of this.series.values()) entry.plot?.remove();
      this.series.clear();
      this.t = 0;
      this.limits = null;
      this.store = `plots ${detail.book ?? ""}`;
      this.chosen = read(this.store);
      this.arrange();
    }
    this.id = detail.id;
  }

  live(detail) {
    this.t = detail.t ?? this.t;
    if (detail.full) for (const entry of this.series.values()) entry.points = [];
    let fresh = false;
    for (const [name, { v, kind }] of Object.entries(detail.streams ?? {})) {
      const entry = this.series.get(name);
      if (entry) Object.assign(entry, { text: v, kind });
      (this.kinds ??= {})[name] = kind;
    }
    for (const [key, points] of detail.plots ?? []) {
      if (!this.series.has(key)) {
        if (this.series.size >= MOST_KEYS) continue;
        this.series.set(key, { points: [], kind: this.kind(key), text: detail.streams?.[key]?.v ?? "" });
        fresh = true;
      }
      const entry = this.series.get(key);
      entry.points.push(...points);
    }
    for (const entry of this.series.values()) {
      const old = entry.points.findIndex(([t]) => t >= this.t - SPAN - 2);
      entry.points.splice(0, Math.max(old < 0 ? entry.points.length - 1 : old - 1, entry.points.length - KEPT, 0));
    }
    if (fresh) this.arrange();
    this.draw();
  }

  kind(key) {
    return this.kinds?.[key] ?? this.kinds?.[key.split(".")[0]] ?? (key.includes(".") ? "sensor" : "stream");
  }

  /** The keys that are shown: those chosen, else the ordinary streams, then what sensors give. */
  shown() {
    const keys = [...this.series.keys()];
    if (this.chosen) return keys.filter((key) => this.chosen.includes(key)).slice(0, MOST_SHOWN);
    const kinds = { stream: 0, sensor: 1, ".distance": 2, ".x": 3, ".y": 3 };
    const rank = (key) => kinds[/\.\w+$/.exec(key)?.[0] ?? this.series.get(key).kind] ?? 4;
    return keys.filter((key) => rank(key) < 4).sort((a, b) => rank(a) - rank(b)).slice(0, FIRST);
  }

  choose({ value, checked }) {
    const now = new Set(this.shown());
    if (checked) now.add(value);
    else now.delete(value);
    this.chosen = [...now];
    try {
      localStorage.setItem(this.store, JSON.stringify(this.chosen));
    } catch { /* a browser that stores nothing forgets the choice */ }
    this.arrange();
    this.draw();
  }

  /** Make the plots that are shown, and the check boxes. */
  arrange() {
    const shown = this.shown();
    this.empty.hidden = this.series.size > 0;
    this.choice.hidden = this.table.hidden = !this.series.size;
    this.limits ??= thresholds();
    for (const entry of this.series.values()) {
      entry.plot?.remove();
      entry.plot = null;
    }
    this.list.replaceChildren(...shown.map((key) => {
      const entry = this.series.get(key);
      entry.now = make("b");
      const { item, place } = framed(key, entry.kind, entry.now, `${key}, last ${SPAN} seconds`);
      entry.place = place;
      return item;
    }));
    for (const key of shown) {
      const entry = this.series.get(key);
      entry.plot = new Plot(entry.place, { kind: shape(entry.kind), limits: this.limits[key] ?? [], unit: this.unit(key), range: () => [this.t - SPAN, this.t] });
    }
    this.offer(shown);
  }

  /** The check boxes of all that can be plotted. */
  offer(shown) {
    const boxes = [...this.series.keys()].sort().map((key) => {
      const checked = shown.includes(key);
      const box = make("input", { type: "checkbox", value: key, checked, disabled: !checked && shown.length >= MOST_SHOWN });
      return make("label", {}, box, make("span", { className: shape(this.series.get(key).kind) }, key));
    });
    const here = this.boxes.contains(document.activeElement) ? document.activeElement.value : null;
    this.boxes.replaceChildren(this.boxes.firstChild, ...boxes);
    if (here) boxes.map((b) => b.firstChild).find((b) => b.value === here)?.focus();
  }

  draw() {
    if (document.hidden || !this.root.isConnected) return;
    for (const entry of this.series.values()) {
      if (!entry.plot) continue;
      entry.plot.draw(entry.points);
    }
    this.tell();
  }

  /** Of a sensor's field as the catalogue says, of a stream as its newest value has it. */
  unit(key) {
    if (key.includes(".")) return this.units[key.split(".").at(-1).toLowerCase().replace(/\W|_/g, "")] ?? "";
    return /^-?[\d.]+(?:e[-+]?\d+)? (\S+)$/.exec(this.series.get(key).text)?.[1] ?? "";
  }

  value(key) {
    const { text, points } = this.series.get(key);
    if (text && !key.includes(".")) return text;
    const unit = this.unit(key);
    return points.length ? round(points.at(-1)[1]) + (unit && ` ${unit}`) : "";
  }

  /** The numbers in words, once a second: beside each plot always, in the table when it is open. */
  tell(atOnce = false) {
    if (!atOnce && performance.now() - (this.told ?? 0) < 250) return;
    this.told = performance.now();
    for (const [key, entry] of this.series) {
      if (!entry.plot) continue;
      const words = this.value(key);
      put(entry.now, words);
      if (atOnce || performance.now() - (entry.spoken ?? 0) > 1000) {
        entry.spoken = performance.now();
        entry.place.setAttribute("aria-label", `${key}, last ${SPAN} seconds, now ${words}`);
      }
    }
    if (this.table.open) fill(this.table.lastChild, [...this.series].map(([key, { points }]) => [key, this.value(key), points]));
  }
}

function fill(table, rows) {
  const head = make("tr", {}, ...["Stream", "Newest", "Lowest", "Highest"].map((words) => make("th", { scope: "col" }, words)));
  const body = rows.filter(([, , points]) => points.length).map(([key, now, points]) => {
    const values = points.map(([, v]) => v);
    const cells = [now, round(Math.min(...values)), round(Math.max(...values))].map((words) => make("td", {}, words));
    return make("tr", {}, make("th", { scope: "row" }, key), ...cells);
  });
  table.replaceChildren(head, ...body);
}

function read(store) {
  try {
    const found = JSON.parse(localStorage.getItem(store));
    return Array.isArray(found) ? found.filter((key) => typeof key === "string") : null;
  } catch {
    return null;
  }
}
