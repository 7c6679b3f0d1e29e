// Plots of a whole recorded run; the pointer tells the values under it.

import { make } from "../elements.js";
import { Plot, framed, round, shape } from "./plotting.js";

/** A whole record: `series` is [{name, unit, kind, points: [[t, value], …], limits}, …], `whole` its first and its last time,
    else those of the points. Returns what takes it away. */
export function plotRecord(root, series, whole = null) {
  root.classList.add("plots");
  const all = series.flatMap(({ points }) => points.map(([t]) => t));
  const range = () => whole ?? [Math.min(0, all[0] ?? 0), all.reduce((a, b) => Math.max(a, b), 0.1)];
  const list = make("ul");
  root.append(list);
  const made = series.map(({ name, unit = "", kind = "stream", points, limits = [] }, n) => {
    const values = points.map(([, v]) => v);
    const low = values.reduce((a, b) => Math.min(a, b), Infinity);
    const top = values.reduce((a, b) => Math.max(a, b), -Infinity);
    const words = values.length ? `${round(low)} to ${round(top)}${unit && ` ${unit}`}` : "no value";
    const told = make("small", {}, words);
    const pointed = (t, value) => { // the pointer tells the value under it, of all plots at once
      told.textContent = t === null || value === null ? words : `${t.toFixed(1)} s: ${round(value)}${unit && ` ${unit}`}`;
    };
    const { item, place } = framed(name, kind, told, `${name} during the run: ${words}`);
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
