// The robot in 3D: a picture of the simulated world that one can turn, and facts beside it. Where the browser
// cannot draw it, a text says so.

import { act, request, takesActions } from "../api.js";
import { make, put } from "../elements.js";
import { listed, t } from "../texts.js";

const EMPTY = t("This browser cannot draw the robot in 3D. The robot’s eye, the live values and the log show what it does.");
const TURN = t("Drag to look around");
const MOVE = t("Drag an object to move it, drag elsewhere to look around");
const FARTHEST = t("It cannot move farther this way.");
const LATER = t("Drag to look around. In a run, drag objects too");

let known = []; // the things of the scene
/** The name of a thing in the language of its workbook. */
const titled = (thing) => known.find(({ name }) => name === thing)?.title ?? thing;

/** Fill `#robot3d`. */
export async function robot3d(root) {
  root.classList.add("robot3d");
  root.replaceChildren();
  const canvas = document.createElement("canvas");
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  describe(canvas);
  const caption = document.createElement("p");
  caption.className = "caption";
  caption.textContent = TURN;
  const front = document.createElement("button");
  front.type = "button";
  front.className = "button plain small";
  front.textContent = t("Front");
  front.title = t("From the front");
  front.setAttribute("aria-label", t("Front view"));
  const room = document.createElement("div");
  room.className = "room";
  room.append(canvas);
  const foot = document.createElement("div");
  foot.className = "foot";
  foot.append(caption, front);
  root.append(room, foot);
  const heard = { run: {}, live: null, fresh: true }; // also what comes before there is anything to draw it on
  let stage = null;
  const words = () => {
    const on = takesActions(heard.run.phase);
    stage?.drag.allow(on);
    stage?.touch.allow(on);
    caption.textContent = on && known.length ? MOVE : TURN;
  };
  const hand = {
    limits: ways.map(([, least, most]) => [least, most]),
    held(name) { caption.textContent = name ? t("{thing}: drag it to where it should be", { thing: titled(name) }) : LATER; },
    moved(name, at, most) {
      move(name, at);
      const [ahead, aside, up] = at.map((metres) => Math.abs(metres).toFixed(2));
      const places = { thing: titled(name), ahead, aside, up };
      const place = at[1] < 0 ? t("{thing}: {ahead} m ahead of where the robot starts, {aside} m to its right, {up} m above the floor.", places)
        : t("{thing}: {ahead} m ahead of where the robot starts, {aside} m to its left, {up} m above the floor.", places);
      caption.textContent = most ? `${place} ${FARTHEST}` : place;
    },
    dropped: () => words(),
    drawn: () => above(root, stage),
    chosen: (thing) => document.dispatchEvent(new CustomEvent("rrp:chosen", { detail: { thing } })),
  };
  const show = () => {
    if (!stage || !heard.live) return;
    stage.take(heard.live, heard.fresh);
    heard.fresh = false;
    describe(canvas, heard.live, stage.model);
  };
  document.addEventListener("rrp:run", ({ detail }) => {
    if (detail.id !== heard.run.id) heard.fresh = true;
    heard.run = detail;
    known = detail.things ?? [];
    stage?.know(known);
    if (!stage?.drag.grip || !takesActions(detail.phase)) words();
  });
  document.addEventListener("rrp:live", ({ detail }) => {
    if (!detail.robot) return;
    heard.live = detail.robot;
    heard.fresh ||= Boolean(detail.full);
    show();
  });
  try {
    stage = await open(canvas, hand);
  } catch (error) {
    console.warn(error);
    const instead = document.createElement("p");
    instead.className = "quiet";
    instead.textContent = EMPTY;
    root.replaceChildren(instead);
    root.parentElement.classList.add("flat"); // the picture of its eye is large instead
    return;
  }
  front.addEventListener("click", () => stage.orbit.front());
  describe(canvas, {}, stage.model);
  stage.know(known);
  words();
  show();
  root.dataset.ready = "";
}

// what it says stands above its head
function above(root, stage) {
  const head = stage?.touch.zones.find(({ zone }) => zone === "Head")?.mark.style;
  if (!head) return;
  const { style } = root.parentElement;
  style.setProperty("--head-x", head.left);
  style.setProperty("--head-y", head.top);
}

async function open(canvas, hand) {
  const [{ Stage }, { ok, status, json }] = await Promise.all([import("./stage3d.js"), request("/robot/model.json")]);
  if (!ok) throw new Error(`no model: ${status}`);
  return new Stage(canvas, json, hand);
}

// what a screen reader tells; it changes seldom enough to be asked for, and is never announced by itself
function describe(canvas, { things = {}, saying = "" } = {}, { name = t("The robot") } = {}) {
  const seen = Object.entries(things).map(([thing, [x, y]]) => t("{thing} {n} m away", { thing: titled(thing), n: Math.hypot(x, y).toFixed(1) }));
  const parts = [t("{robot} in 3D", { robot: name }), saying && t("it says “{text}”", { text: saying }), seen.length ? listed(seen) : t("nothing near it")];
  const words = t("{what}. Arrow keys turn, plus and minus zoom, 0 is the front.", { what: parts.filter(Boolean).join("; ") });
  if (canvas.getAttribute("aria-label") !== words) canvas.setAttribute("aria-label", words);
}

// Facts about the robot beside its picture: which way it looks, what is around it.

const degrees = (angle) => Math.round(Math.abs((angle * 180) / Math.PI));
/** Which way the head is turned: positive angles are to the left, and down. */
const turned = (yaw, pitch) => t("{across}, {along}", {
  across: yaw < 0 ? t("{n}° right", { n: degrees(yaw) }) : t("{n}° left", { n: degrees(yaw) }),
  along: pitch < 0 ? t("{n}° up", { n: degrees(pitch) }) : t("{n}° down", { n: degrees(pitch) }),
});

const hues = [[15, t("red")], [45, t("orange")], [70, t("yellow")], [165, t("green")], [200, t("turquoise")], [255, t("blue")], [290, t("violet")], [340, t("magenta")], [361, t("red")]];

/** A word for a colour of three parts from 0 to 1. */
function colour([red, green, blue]) {
  const most = Math.max(red, green, blue);
  const span = most - Math.min(red, green, blue);
  if (most < 0.08) return t("off");
  const shade = (name) => (most < 0.5 ? t("dim {colour}", { colour: name }) : name);
  if (span < 0.15 * most) return shade(t("white"));
  const turn = most === red ? ((green - blue) / span + 6) % 6 : most === green ? (blue - red) / span + 2 : (red - green) / span + 4;
  return shade(hues.find(([limit]) => turn * 60 < limit)[1]);
}

export function robot(root) {
  const facts = new Map();

  document.addEventListener("rrp:run", ({ detail }) => {
    if (detail.phase === "none") {
      facts.clear();
      root.replaceChildren();
    }
  });
  document.addEventListener("rrp:live", ({ detail }) => {
    const seen = detail.robot;
    if (!seen) return;
    const { HeadYaw: yaw, HeadPitch: pitch } = seen.joints;
    if (yaw !== undefined && pitch !== undefined) fact(t("Head"), turned(yaw, pitch));
    fact(t("Eyes"), colour(seen.eyes));
    dot(facts.get(t("Eyes")), seen.eyes);
    const names = Object.keys(seen.things).map(titled);
    fact(t("Around it"), names.length ? listed(names) : t("nobody, nothing"));
  });

  /** The colour itself beside its word. */
  function dot(place, parts) {
    const css = `rgb(${parts.map((part) => Math.round(part * 255)).join(" ")})`;
    place.classList.add("eye-colour");
    if (place.style.getPropertyValue("--shines") !== css) place.style.setProperty("--shines", css);
  }

  function fact(name, text) {
    if (!facts.has(name)) {
      const value = make("dd");
      root.append(make("div", {}, make("dt", { textContent: name }), value));
      facts.set(name, value);
    }
    put(facts.get(name), text);
    facts.get(name).title = text; // only its beginning may have room
  }
}

// Things that are moved by hand, with sliders or in the picture: where to, and telling it to the run.

/** The range of each way, in metres: of a thing before the robot that it can see or reach. */
export const ways = [[t("Forward"), 0.2, 2.5], [t("Left"), -1.5, 1.5], [t("Up"), 0, 1.5]];
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
