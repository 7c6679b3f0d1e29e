// The run's clock as the page can tell it between two tellings, and times in words.

import { hasCalm } from "../preferences.js";
import { t } from "../texts.js";

let told = 0;
let heard = performance.now();
let state = { phase: "none" };

document.addEventListener("rrp:run", ({ detail }) => {
  if (detail.phase === "none" || detail.id !== state.id) told = detail.t ?? 0;
  else told = Math.max(told, detail.t ?? 0);
  heard = performance.now();
  state = detail;
});
document.addEventListener("rrp:live", ({ detail }) => {
  told = detail.t;
  heard = performance.now();
});

/** Seconds on the run's clock now. */
export function now() {
  if (state.phase !== "running") return told;
  const since = Math.min((performance.now() - heard) / 1000, 1); // a run that says nothing is not told to go on
  return told + since * (state.speed || 1);
}

export const EXACT = 2; // digits after the point in lists of events, and where single frames count

/** `0:42.3`, or `0:42.33`, rounded as the server does (`clock` in metadata.py). */
export function clock(seconds, digits = 1) {
  const parts = 10 ** digits;
  const all = Math.floor(seconds * parts + 0.5);
  const [minutes, rest] = [Math.floor(all / (60 * parts)), all % (60 * parts)];
  const text = (rest / parts).toFixed(digits).padStart(3 + digits, "0");
  return minutes < 60 ? `${minutes}:${text}` : `${Math.floor(minutes / 60)}:${String(minutes % 60).padStart(2, "0")}:${text}`;
}

/** An age: `0.1 s`, `26 s`, `3 min`. */
export function age(seconds) {
  if (seconds < 9.95 && !hasCalm()) return t("{n} s", { n: Math.max(seconds, 0).toFixed(1) });
  return seconds < 120 ? t("{n} s", { n: Math.round(seconds) }) : t("{n} min", { n: Math.round(seconds / 60) });
}
