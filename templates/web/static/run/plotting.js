// One small plot of numbers over time, drawn by uPlot in the page's own colours.

import uPlot from "/vendor/js/uPlot.esm.js";
import { make } from "../elements.js";

const HIGH = 72; // px
const SIDE = 46; // px, for the numbers at the right
const GAP = 1.5; // s without a value: the line has a gap
const FLAT = 0.08; // of the value: a plot never shows less than that, so that noise looks like noise,
const LEAST = { m: 0.05, rad: 0.1, "°": 5, s: 0.5, "": 0.1 }; // nor less than that

/** The page's colours, for things that are drawn. */
export function colours() {
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

/** How a kind of stream is drawn. */
export function shape(kind) {
  return { sensor: "sensor", done: "sensor", actuator: "actuator" }[kind] ?? "stream";
}

/** An item of a list of plots: the name, `told` beside it, and the `place` of the plot, described in words. */
export function framed(name, kind, told, words) {
  const place = make("div", { className: "plot" });
  place.setAttribute("role", "img");
  place.setAttribute("aria-label", words);
  const head = make("div", { className: "head" }, make("span", { className: shape(kind) }, name), told);
  return { item: make("li", {}, head, place), place };
}

/** A plot in `root`. `range()` gives the first and the last time that it shows, `limits` are drawn as dashed lines,
    `pointed(t, value)` is told what is under the pointer (nothing when it has left). */
export class Plot {
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

  /** Draw `points`, [[t, value], …] in order. */
  draw(points) {
    const times = [];
    const values = [];
    let last = null;
    for (const [t, value] of points) {
      if (last !== null && t - last > GAP) {
        times.push((t + last) / 2);
        values.push(null);
      }
      times.push(t);
      values.push(value);
      last = t;
    }
    this.plot.setData([times, values]);
  }

  remove() {
    this.watch.disconnect();
    this.plot.destroy();
  }
}

/** A number with about three digits. */
export function round(value) {
  if (!Number.isFinite(value)) return "";
  const size = Math.abs(value);
  if (size >= 1000) return value.toFixed(0);
  const digits = size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 || size === 0 ? 2 : 3;
  return String(Number(value.toFixed(digits)));
}
