// Things that are moved by hand, with sliders or in the picture: where to, and telling it to the run.

import { act } from "./ask.js";

/** How far each way, in metres: a thing before the robot that it can see or reach. */
export const ways = [["Forward", 0.2, 2.5], ["Left", -1.5, 1.5], ["Up", 0, 1.5]];
const EVERY = 80; // ms between two tellings of where a thing is put

const waiting = new Map(); // thing → where it shall be, not yet told
let busy = false;

/** Put a thing somewhere. Of many places in a short time the newest is told, one after the other. */
export function move(thing, [x, y, z]) {
  const place = [x, y, z].map((v) => Math.round(v * 1000) / 1000);
  waiting.set(thing, place);
  document.dispatchEvent(new CustomEvent("rrp:moved", { detail: { thing, at: place } }));
  if (!busy) tell();
}

async function tell() {
  busy = true;
  while (waiting.size) {
    const [thing, [x, y, z]] = waiting.entries().next().value;
    waiting.delete(thing);
    const pause = new Promise((done) => { setTimeout(done, EVERY); });
    await Promise.all([act("put", { thing, x, y, z }), pause]);
  }
  busy = false;
}
