// How the robot and the things around it stood at any time: between two poses they are on their way.

import { last } from "./store.js";

const EVERY = 0.1; // s between two poses while something moves
const WAY = 0.15; // s: a longer gap means that nothing moved at first

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
  const began = to && to.t - from.t > WAY ? to.t - EVERY : from.t;
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
