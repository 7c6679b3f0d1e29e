// Small plots of the numbers that streams carry: live, the last 30 seconds; or a whole recorded run.

import { Plot, round } from "./plotting.js";

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
    this.list = document.createElement("ul");
    this.empty = make("p", "quiet", EMPTY);
    this.choice = document.createElement("details");
    this.choice.append(make("summary", "", "Choose what is plotted"), document.createElement("fieldset"));
    this.choice.lastChild.append(make("legend", "only-spoken", "Streams that are plotted"));
    this.choice.addEventListener("change", ({ target }) => this.choose(target));
    this.table = document.createElement("details");
    this.table.append(make("summary", "", "As a table"), document.createElement("table"));
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
    const items = shown.map((key) => {
      const entry = this.series.get(key);
      const item = document.createElement("li");
      const head = make("div", "head", "");
      entry.now = make("b", "", "");
      head.append(make("span", shape(entry.kind), key), entry.now);
      entry.place = make("div", "plot", "");
      entry.place.setAttribute("role", "img");
      entry.place.setAttribute("aria-label", `${key}, last ${SPAN} seconds`);
      item.append(head, entry.place);
      return item;
    });
    this.list.replaceChildren(...items);
    for (const key of shown) {
      const entry = this.series.get(key);
      entry.plot = new Plot(entry.place, { kind: shape(entry.kind), limits: this.limits[key] ?? [], unit: this.unit(key), range: () => [this.t - SPAN, this.t] });
    }
    const boxes = [...this.series.keys()].sort().map((key) => {
      const label = make("label", "", "");
      const box = document.createElement("input");
      Object.assign(box, { type: "checkbox", value: key, checked: shown.includes(key), disabled: !shown.includes(key) && shown.length >= MOST_SHOWN });
      label.append(box, make("span", shape(this.series.get(key).kind), key));
      return label;
    });
    const here = this.choice.contains(document.activeElement) ? document.activeElement.value : null;
    this.choice.lastChild.replaceChildren(this.choice.lastChild.firstChild, ...boxes);
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
      if (entry.now.textContent !== words) entry.now.textContent = words;
      if (atOnce || performance.now() - (entry.spoken ?? 0) > 1000) {
        entry.spoken = performance.now();
        entry.place.setAttribute("aria-label", `${key}, last ${SPAN} seconds, now ${words}`);
      }
    }
    if (this.table.open) fill(this.table.lastChild, [...this.series].map(([key, { points }]) => [key, this.value(key), points]));
  }
}

function fill(table, rows) {
  const line = (tag, words) => {
    const made = document.createElement("tr");
    made.append(...words.map((w, n) => {
      const cell = make(n ? tag : "th", "", w);
      cell.scope = tag === "th" ? "col" : n ? "" : "row";
      if (!cell.scope) cell.removeAttribute("scope");
      return cell;
    }));
    return made;
  };
  const body = rows.filter(([, , points]) => points.length).map(([key, now, points]) => {
    const values = points.map(([, v]) => v);
    return line("td", [key, now, round(Math.min(...values)), round(Math.max(...values))]);
  });
  table.replaceChildren(line("th", ["Stream", "Newest", "Lowest", "Highest"]), ...body);
}

/** A whole record: `series` is [{name, unit, kind, points: [[t, value], …], limits}, …], `whole` its first and its last time,
    else those of the points. Returns what takes it away. */
export function plotRecord(root, series, whole = null) {
  root.classList.add("plots");
  const all = series.flatMap(({ points }) => points.map(([t]) => t));
  const range = () => whole ?? [Math.min(0, all[0] ?? 0), all.reduce((a, b) => Math.max(a, b), 0.1)];
  const list = document.createElement("ul");
  root.append(list);
  const made = series.map(({ name, unit = "", kind = "stream", points, limits = [] }, n) => {
    const item = document.createElement("li");
    const head = make("div", "head", "");
    const values = points.map(([, v]) => v);
    const low = values.reduce((a, b) => Math.min(a, b), Infinity);
    const top = values.reduce((a, b) => Math.max(a, b), -Infinity);
    const words = values.length ? `${round(low)} to ${round(top)}${unit && ` ${unit}`}` : "no value";
    const told = make("small", "", words);
    const pointed = (t, value) => { // the pointer tells the value under it, of all plots at once
      told.textContent = t === null || value === null ? words : `${t.toFixed(1)} s: ${round(value)}${unit && ` ${unit}`}`;
    };
    head.append(make("span", shape(kind), name), told);
    const place = make("div", "plot", "");
    place.setAttribute("role", "img");
    place.setAttribute("aria-label", `${name} during the run: ${words}`);
    item.append(head, place);
    list.append(item);
    const plot = new Plot(place, { kind: shape(kind), limits, unit, range, times: n === series.length - 1, cursor: true, sync: "record", pointed });
    plot.draw(points);
    return plot;
  });
  return () => {
    for (const plot of made) plot.remove();
    list.remove();
  };
}

/** The numbers that the formulas of the sheet compare a stream with: `distance < 0.5` → {Distance: [0.5]}. */
function thresholds(grid = document.querySelector("table[role=grid]")) {
  const found = {};
  const heads = [...(grid?.tHead?.rows[0]?.cells ?? [])];
  const [inputs, formula] = ["inputs", "formula"].map((kind) => heads.findIndex((head) => head.dataset.kind === kind));
  if (inputs < 0 || formula < 0) return found;
  for (const row of grid.querySelectorAll("tbody > tr")) {
    const name = (row.cells[inputs]?.dataset.v ?? "").trim();
    const text = row.cells[formula]?.dataset.v ?? "";
    if (!name || /[,;\n]/.test(name)) continue;
    for (const [, word, number] of text.matchAll(/\b([A-Za-z]\w*)\s*[<>]=?\s*(-?\d+(?:\.\d+)?)/g)) put(found, name, word, number);
    for (const [, number, word] of text.matchAll(/(-?\d+(?:\.\d+)?)\s*[<>]=?\s*([A-Za-z]\w*)/g)) put(found, name, word, number);
  }
  return found;
}

function put(found, name, word, number) {
  const plain = (text) => text.toLowerCase().replace(/[^\p{L}\p{N}]/gu, "");
  if (plain(word) !== "value" && plain(word) !== plain(name)) return;
  (found[name] ??= []).push(Number(number));
}

function shape(kind) {
  return { sensor: "sensor", done: "sensor", actuator: "actuator" }[kind] ?? "stream";
}

function read(store) {
  try {
    const found = JSON.parse(localStorage.getItem(store));
    return Array.isArray(found) ? found.filter((key) => typeof key === "string") : null;
  } catch {
    return null;
  }
}

function make(tag, name, text) {
  const made = document.createElement(tag);
  if (name) made.className = name;
  made.textContent = text;
  return made;
}
