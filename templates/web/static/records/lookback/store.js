// The recorded run, loaded in pieces and kept: a run of an hour is not loaded at once.

import { request } from "../../api.js";

const LITTLE = 1e-6; // s
const MOST_KEPT = 400; // pieces
const AGAIN_MS = 1500; // after a piece could not be loaded
const ERROR_SHOWN = 1; // s: a row's error is shown for at least so long, although a value comes
const POSE_EVERY = 0.1; // s between two poses while something moves
const LONGEST_GAP = 0.15; // s: after a longer gap nothing moved at first

/** The number of the last of some times that is not after t, or -1. */
export function last(times, t) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t + LITTLE) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** Pieces of one kind, each loaded when it is wanted. `made` makes of the answer what is kept. */
export class Pieces {
  constructor(times, address, made, came) {
    Object.assign(this, { times, address, made, came });
    this.kept = new Map(); // number → piece
    this.asked = new Map(); // number → when (ms)
  }

  /** The piece that has a time, or null while it is being loaded; undefined when there is none. */
  at(t) {
    if (!this.times.length) return undefined;
    const number = Math.max(0, last(this.times, t));
    return this.get(number);
  }

  get(number) {
    if (number < 0 || number >= this.times.length) return undefined;
    const found = this.kept.get(number);
    if (found) return found;
    this.load(number);
    return null;
  }

  /** Have the piece of a time and the one after it ready. */
  ahead(t) {
    const number = Math.max(0, last(this.times, t));
    for (const next of [number, number + 1]) if (next < this.times.length && !this.kept.has(next)) this.load(next);
  }

  async load(number) {
    if (performance.now() - (this.asked.get(number) ?? -AGAIN_MS) < AGAIN_MS) return;
    this.asked.set(number, performance.now());
    const { status, json } = await request(`${this.address}/${number}.json`);
    const piece = json && this.read(json);
    if (!piece) {
      if (status < 400 || status >= 500) setTimeout(() => this.came(), AGAIN_MS); // whoever still needs it asks again
      return;
    }
    if (this.kept.size >= MOST_KEPT) this.kept.delete(this.kept.keys().next().value);
    this.kept.set(number, piece);
    this.asked.delete(number);
    this.came();
  }

  read(json) {
    try {
      return this.made(json);
    } catch (error) { // an answer that is no piece
      console.warn(error);
      return null;
    }
  }
}

/** The values of a time: of each row and of each stream the newest one, as the run panel is told them. */
export function valuesAt(piece, overview, ids, t) {
  const rows = {};
  const streams = {};
  const seen = {};
  for (const [number, { t: times, v, s }] of Object.entries(piece.series)) {
    const at = last(times, t);
    if (at < 0) continue;
    const [row, name, kind] = overview.series[number];
    const [when, text] = [times[at], piece.words[v[at]]];
    const id = ids[row];
    if (!name) {
      if (id) Object.assign((rows[id] ??= { v: "", at: null, n: 1 }), { failed: text, failedAt: when });
      continue;
    }
    if (id && !(rows[id]?.at > when)) Object.assign((rows[id] ??= { n: 1 }), { v: text, at: when });
    if (!(streams[name]?.at > when)) streams[name] = { v: text, at: when, n: 1, kind };
    if (s?.[at] && kind === "sensor") seen[name] = { t: when, at: s[at] };
  }
  for (const entry of Object.values(rows)) entry.e = stillFailed(entry) ? entry.failed : "";
  return { rows, streams, seen };
}

const stillFailed = ({ at, failed, failedAt }) => failed !== undefined && !(at !== null && at > failedAt + ERROR_SHOWN);

// The robot's pose and the places of things at any time: between two poses they are on their way.

/** The whole poses of a piece, from lines that tell what changed. */
export function poses(lines) {
  let state = { joints: {}, things: {}, looks: {}, saying: "" };
  const made = lines.map((line) => {
    const old = line.full ? { joints: {}, things: {}, looks: {} } : state;
    const things = { ...old.things, ...line.things };
    for (const [name, at] of Object.entries(things)) if (at === null) delete things[name];
    state = {
      ...state, ...line, joints: { ...old.joints, ...line.joints }, things, looks: { ...old.looks, ...line.looks },
    };
    return state;
  });
  return { times: made.map(({ t }) => t), made };
}

/** The pose of a time. */
export function poseAt({ times, made }, t) {
  const number = Math.max(0, last(times, t));
  const [from, to] = [made[number], made[number + 1]];
  if (!from) return undefined;
  const began = to && to.t - from.t > LONGEST_GAP ? to.t - POSE_EVERY : from.t;
  const part = to ? Math.min(Math.max((t - began) / (to.t - began || 1), 0), 1) : 0;
  if (!part) return from;
  const between = (a, b) => (a === undefined ? b : b === undefined ? a : a + (b - a) * part);
  const places = (a, b) => (a && b ? a.map((v, i) => (Math.abs(b[i] - v) > 1 ? v : between(v, b[i]))) : a ?? b);
  const joints = {};
  for (const name of Object.keys(from.joints)) joints[name] = between(from.joints[name], to.joints[name]);
  const things = {};
  for (const name of Object.keys(from.things)) things[name] = places(from.things[name], to.things[name]);
  return { ...from, joints, things, base: places(from.base, to.base) };
}
