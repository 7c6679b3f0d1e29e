// The robot in 3D: a picture of the simulated world that one can turn. Where the browser cannot draw it, words say so.

import { move, ways } from "./moving.js";

const EMPTY = "This browser cannot draw the robot in 3D. The robot’s eye, the live values and the log tell what it does.";
const TURN = "Drag to look around";
const MOVE = "Drag a thing to move it, elsewhere to look around";
const LATER = "Things can be moved while it runs. Drag to look around";

/** Fill `#robot3d`. */
export async function robot3d(root) {
  root.classList.add("robot3d");
  root.replaceChildren();
  const canvas = document.createElement("canvas");
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  const caption = document.createElement("p");
  caption.className = "caption";
  caption.textContent = TURN;
  const front = document.createElement("button");
  front.type = "button";
  front.className = "button plain small";
  front.textContent = "Front";
  front.title = "From the front";
  front.setAttribute("aria-label", "Front view");
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
    const on = ["running", "paused"].includes(heard.run.phase);
    stage?.drag.allow(on);
    caption.textContent = on && heard.run.things?.length ? MOVE : TURN;
  };
  const hand = {
    limits: ways.map(([, least, most]) => [least, most]),
    held(name) { caption.textContent = name ? `${name}: drag it where it shall be` : LATER; },
    moved(name, at, most) {
      move(name, at);
      const where = ways.map(([way], i) => `${way.toLowerCase()} ${at[i].toFixed(2)}`).join(", ");
      caption.textContent = `${name}: ${where} m${most ? "; no farther this way" : ""}`;
    },
    dropped: () => words(),
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
    stage?.know(detail.things ?? []);
    if (!stage?.drag.grip || !["running", "paused"].includes(detail.phase)) words();
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
    return;
  }
  front.addEventListener("click", () => stage.orbit.front());
  describe(canvas, {}, stage.model);
  stage.know(heard.run.things ?? []);
  words();
  show();
  root.dataset.ready = "";
}

async function open(canvas, hand) {
  const [{ Stage }, answer] = await Promise.all([import("./stage3d.js"), fetch("/robot/model.json")]);
  if (!answer.ok) throw new Error(`no model: ${answer.status}`);
  return new Stage(canvas, await answer.json(), hand);
}

// what a screen reader tells; it changes seldom enough to be asked for, and is never announced by itself
function describe(canvas, { things = {}, saying = "" }, { name = "The robot" }) {
  const seen = Object.entries(things).map(([thing, [x, y]]) => `${thing} ${Math.hypot(x, y).toFixed(1)} m away`);
  const parts = [`${name} in 3D`, saying && `it says “${saying}”`, seen.length ? seen.join(", ") : "nothing near it"];
  const words = `${parts.filter(Boolean).join("; ")}. Arrow keys turn, plus and minus zoom, 0 is the front.`;
  if (canvas.getAttribute("aria-label") !== words) canvas.setAttribute("aria-label", words);
}
