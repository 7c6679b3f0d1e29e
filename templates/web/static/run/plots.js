// Small plots of the numbers that streams carry: of the last 30 seconds while a run goes on, and of a whole run.

import uPlot from "../vendor/js/uPlot.esm.js";
import { request } from "../api.js";
import { make, put } from "../elements.js";
import { t } from "../texts.js";

const SPAN = 30; // s
const FIRST = 4; // plots that are shown before anyone has chosen
const MOST_SHOWN = 12;
const KEPT = 1500; // points of a key
const MOST_KEYS = 120;
const HIGH = 72; // px, of a plot
const SIDE = 46; // px, for the numbers at the right
const GAP = 1.5; // s without a value: the line has a gap
const FLAT = 0.08; // of the value: a plot never shows less than that, so that noise looks like noise,
const LEAST = { m: 0.05, rad: 0.1, "°": 5, s: 0.5, "": 0.1 }; // nor less than that, by unit
const EMPTY = t("Streams with numbers are plotted here during a run.");

/** The plots of the run that goes on, in `root`: its streams of the last 30 seconds. */
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
    this.boxes = make("fieldset", {}, make("legend", { className: "only-spoken" }, t("Streams that are plotted")));
    this.choice = make("details", {}, make("summary", {}, t("Choose what is plotted")), this.boxes);
    this.choice.addEventListener("change", ({ target }) => this.choose(target));
    this.table = make("details", {}, make("summary", {}, t("As a table")), make("table"));
    this.table.addEventListener("toggle", () => this.tell(true));
    root.replaceChildren(this.empty, this.list, this.choice, this.table);
    this.choice.hidden = this.table.hidden = true;
    this.units = {};
    request("/robot/model.json").then(({ json }) => { this.units = json?.units ?? {}; });
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
      const old = entry.points.findIndex(([seconds]) => seconds >= this.t - SPAN - 2);
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
      const { item, place } = framed(key, entry.kind, entry.now, t("{stream}, last {n} seconds", { stream: key, n: SPAN }));
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

  /** The unit of a key: of a sensor's field as the catalogue says, of a stream as its newest value has it. */
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
        entry.place.setAttribute("aria-label", t("{stream}, last {n} seconds, now {value}", { stream: key, n: SPAN, value: words }));
      }
    }
    if (this.table.open) fill(this.table.lastChild, [...this.series].map(([key, { points }]) => [key, this.value(key), points]));
  }
}

function fill(table, rows) {
  const head = make("tr", {}, ...[t("Stream"), t("Newest"), t("Lowest"), t("Highest")].map((words) => make("th", { scope: "col" }, words)));
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

/** The page's colours, for things that are drawn. */
function colours() {
  const style = getComputedStyle(document.documentElement);
  const probe = document.createElement("i");
  document.body.append(probe);
  const of = (name) => {
    probe.style.color = style.getPropertyValue(`--${name}`);
    return getComputedStyle(probe).color;
  };
  const found = Object.fromEntries(["sensor", "stream", "actuator", "quiet", "line", "edge", "ink"].map((n) => [n, of(n)]));
  probe.remove();
  return found;
}

/** The class of a kind of stream in the style sheet; its colour has the same name. */
function shape(kind) {
  return { sensor: "sensor", done: "sensor", actuator: "actuator" }[kind] ?? "stream";
}

/** An item of a list of plots: the name, `told` beside it, and the `place` of the plot, described in words. */
function framed(name, kind, told, words) {
  const place = make("div", { className: "plot" });
  place.setAttribute("role", "img");
  place.setAttribute("aria-label", words);
  const head = make("div", { className: "head" }, make("span", { className: shape(kind) }, name), told);
  return { item: make("li", {}, head, place), place };
}

/** A plot in `root`. `range()` gives the first and the last time that it shows, `limits` are drawn as dashed lines,
    `pointed(seconds, value)` is told what is under the pointer (nothing when it has left). */
class Plot {
  constructor(root, { kind = "stream", limits = [], unit = "", range, times = false, cursor = false, high = HIGH, sync = "", pointed = null }) {
    this.limits = limits;
    this.least = LEAST[unit] ?? LEAST[""];
    this.points = [];
    this.lines = times;
    const paint = colours();
    const colour = paint[kind] ?? paint.stream;
    const axis = { stroke: paint.quiet, font: "11px sans-serif", grid: { stroke: paint.line, width: 1 }, ticks: { show: false } };
    const options = {
      width: Math.max(root.clientWidth, 80),
      height: high + (times ? 24 : 0),
      legend: { show: false },
      cursor: cursor ? { y: false, points: { size: 7 }, drag: { x: false, y: false }, sync: sync ? { key: sync } : undefined } : { show: false },
      padding: [6, 0, times ? 0 : 6, cursor ? 14 : 0],
      scales: { x: { time: false, range }, y: { range: (_, low, top) => this.span(low, top) } },
      axes: [
        { ...axis, show: times, size: 24, grid: { show: false }, space: 60, values: (_, at) => at.map((v) => `${round(v)} s`) },
        { ...axis, side: 1, size: SIDE, gap: 4, space: 26, values: (_, at) => at.map((v) => round(v)) },
      ],
      series: [
        {},
        { stroke: colour, width: 1.5, spanGaps: false, points: { size: 4, width: 0, fill: colour } },
      ],
      hooks: {
        drawClear: [(plot) => this.rules(plot, paint)],
        setCursor: pointed ? [({ cursor: { idx }, data: [times, values] }) => pointed(times[idx] ?? null, values[idx] ?? null)] : [],
      },
    };
    this.plot = new uPlot(options, [[], []], root);
    this.watch = new ResizeObserver(() => this.plot.setSize({ width: Math.max(root.clientWidth, 80), height: options.height }));
    this.watch.observe(root);
  }

  span(low, top) {
    if (low === null || low === undefined || !Number.isFinite(low)) return [0, 1];
    const near = this.limits.filter((l) => l > low - (top - low) * 1.5 - 0.1 && l < top + (top - low) * 1.5 + 0.1);
    const [a, b] = [Math.min(low, ...near), Math.max(top, ...near)];
    const least = Math.max(Math.abs(a + b) / 2 * FLAT, this.least);
    const extra = Math.max((b - a) * 0.08, (least - (b - a)) / 2);
    return [a - extra, b + extra];
  }

  rules(plot, paint) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.strokeStyle = paint.edge;
    ctx.lineWidth = devicePixelRatio;
    ctx.setLineDash([3 * devicePixelRatio, 3 * devicePixelRatio]);
    for (const limit of this.limits) {
      const y = Math.round(plot.valToPos(limit, "y", true)) + 0.5;
      if (y < bbox.top || y > bbox.top + bbox.height) continue;
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
    }
    ctx.restore();
  }

  /** Draw `points`, [[seconds, value], …] in order. */
  draw(points) {
    const times = [];
    const values = [];
    let last = null;
    for (const [seconds, value] of points) {
      if (last !== null && seconds - last > GAP) {
        times.push((seconds + last) / 2);
        values.push(null);
      }
      times.push(seconds);
      values.push(value);
      last = seconds;
    }
    this.plot.setData([times, values]);
  }

  remove() {
    this.watch.disconnect();
    this.plot.destroy();
  }
}

/** A number with about three digits. */
function round(value) {
  if (!Number.isFinite(value)) return "";
  const size = Math.abs(value);
  if (size >= 1000) return value.toFixed(0);
  const digits = size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 || size === 0 ? 2 : 3;
  return String(Number(value.toFixed(digits)));
}

// Plots of a whole recorded run; the pointer tells the values under it.

/** The plots of a whole run, in `root`: `series` is [{name, unit, kind, points: [[seconds, value], …], limits}, …], `whole` its first and its last time,
    else those of the points. Returns a function that removes them. */
export function plotRecord(root, series, whole = null) {
  root.classList.add("plots");
  const all = series.flatMap(({ points }) => points.map(([seconds]) => seconds));
  const range = () => whole ?? [Math.min(0, all[0] ?? 0), all.reduce((a, b) => Math.max(a, b), 0.1)];
  const list = make("ul");
  root.append(list);
  const made = series.map(({ name, unit = "", kind = "stream", points, limits = [] }, n) => {
    const values = points.map(([, v]) => v);
    const low = values.reduce((a, b) => Math.min(a, b), Infinity);
    const top = values.reduce((a, b) => Math.max(a, b), -Infinity);
    const words = values.length ? t("{low} to {high}", { low: round(low), high: round(top) + (unit && ` ${unit}`) }) : t("no value");
    const told = make("small", {}, words);
    const pointed = (seconds, value) => { // the pointer tells the value under it, of all plots at once
      told.textContent = seconds === null || value === null ? words : `${seconds.toFixed(1)} s: ${round(value)}${unit && ` ${unit}`}`;
    };
    const { item, place } = framed(name, kind, told, t("Plot of {stream} over the run: {values}", { stream: name, values: words }));
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
    for (const [, word, number] of text.matchAll(/\b([A-Za-z]\w*)\s*[<>]=?\s*(-?\d+(?:\.\d+)?)/g)) note(found, name, word, number);
    for (const [, number, word] of text.matchAll(/(-?\d+(?:\.\d+)?)\s*[<>]=?\s*([A-Za-z]\w*)/g)) note(found, name, word, number);
  }
  return found;
}

function note(found, name, word, number) {
  const plain = (text) => text.toLowerCase().replace(/[^\p{L}\p{N}]/gu, "");
  if (plain(word) !== "value" && plain(word) !== plain(name)) return;
  (found[name] ??= []).push(Number(number));
}
