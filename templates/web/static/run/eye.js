// The picture of the robot's camera, renewed as it comes, with the detections of its sensors in it.

import { isUnderWay } from "../api.js";
import { element } from "../elements.js";
import { t } from "../texts.js";

const FRESH = 0.5; // s: an older detection is not shown
const AGAIN = 1000; // ms: asked at least so often, as the robot's eye is open only while somebody asks
const GIVEN_UP = 4000; // ms: what has not come by then is asked for anew
const LOOK = 250; // ms
const OLD = 2000; // ms: a picture that is older says so
const WIDE = 640; // of the overlay, in its own units
const LABEL = 28;
const EMPTY = t("The camera picture appears during a run");
const TITLE = t("Robot’s eye");
const oldBy = (n) => t("old by {n} s", { n });
const sees = (things) => t("What the robot’s camera sees: {things}", { things: things || t("nothing that its sensors look for") });

/** Fill `#eye`. */
export function eye(root) {
  const figure = document.createElement("figure");
  figure.className = "eye";
  const frame = document.createElement("div");
  frame.className = "frame";
  let [picture, coming] = ["img", "img"].map((name) => document.createElement(name)); // one is shown while one loads
  picture.alt = EMPTY;
  picture.hidden = true;
  const overlay = element("svg", { viewBox: `0 0 ${WIDE} 480`, "aria-hidden": "true" });
  const nothing = document.createElement("p");
  nothing.className = "quiet nothing";
  nothing.textContent = EMPTY;
  const caption = document.createElement("figcaption");
  const age = document.createElement("span");
  caption.append(TITLE, age);
  frame.append(nothing, picture, overlay);
  figure.append(frame, caption);
  root.replaceChildren(figure);

  const lens = { hfov: 0.98262, vfov: 0.76271 };
  const seen = new Map(); // sensor → { t, fields }
  let id;
  let phase = "none";
  let newest = { number: 0, at: 0 }; // picture told of, and when it was made (ms)
  let asked = newest; // the one that is being loaded
  let shown = newest;
  let asks = 0;
  let loading = false;
  let last = -Infinity; // ms: when a picture was asked for
  let seconds = 0;

  const going = () => isUnderWay(phase);
  const forget = () => {
    seen.clear();
    newest = asked = shown = { number: 0, at: 0 };
    overlay.replaceChildren();
    reveal(false);
  };
  const reveal = (on) => {
    picture.hidden = !on;
    overlay.classList.toggle("shown", on);
    nothing.hidden = on;
  };

  // One picture after the other: a slow browser gets fewer, not later ones. Every one has an address of its own, as a
  // browser shows one that it has without asking for it, and then nobody asks and no newer picture is made.
  const load = () => {
    const waited = performance.now() - last;
    if (document.hidden || !going() || (loading ? waited < GIVEN_UP : newest === asked && waited < AGAIN)) return;
    loading = true;
    last = performance.now();
    asked = newest;
    asks += 1;
    coming.src = `/run/eye.jpg?ask=${asks}&n=${asked.number}`;
  };
  const came = () => {
    loading = false;
    shown = asked;
    coming.alt = picture.alt;
    picture.replaceWith(coming);
    [picture, coming] = [coming, picture];
    reveal(true);
    tick();
  };
  for (const one of [picture, coming]) {
    one.addEventListener("load", came);
    one.addEventListener("error", () => { // none yet, or the network is away: what is seen stays, and it is asked again
      loading = false;
    });
  }
  const tick = () => {
    const old = performance.now() - shown.at;
    const told = phase === "running" && shown.number && old > OLD ? oldBy(Math.floor(old / 1000)) : "";
    if (age.textContent !== told) age.textContent = told;
    load();
  };
  setInterval(tick, LOOK);
  document.addEventListener("visibilitychange", tick);

  document.addEventListener("rrp:run", ({ detail }) => {
    if (detail.id !== id) forget();
    id = detail.id;
    if (phase === "paused" && detail.phase === "running") shown = { ...shown, at: performance.now() }; // nothing moved
    phase = detail.phase;
    if (detail.camera?.hfov) Object.assign(lens, detail.camera);
    const high = Math.round((WIDE * Math.tan(lens.vfov / 2)) / Math.tan(lens.hfov / 2));
    overlay.setAttribute("viewBox", `0 0 ${WIDE} ${high}`);
    frame.style.aspectRatio = `${WIDE} / ${high}`;
  });

  document.addEventListener("rrp:live", ({ detail }) => {
    if (detail.full) seen.clear();
    seconds = detail.t ?? seconds;
    for (const [sensor, fields] of Object.entries(detail.fields ?? {})) {
      if (fields && "x" in fields && "y" in fields) seen.set(sensor, { t: detail.streams?.[sensor]?.at ?? seconds, fields });
      else seen.delete(sensor);
    }
    for (const [sensor, entry] of seen) if (seconds - entry.t > FRESH) seen.delete(sensor);
    mark(overlay, seen, lens);
    const words = [...seen].map(([sensor, { fields }]) => label(sensor, fields)).join(", ");
    picture.alt = sees(words);
    if (detail.eye && detail.eye !== newest.number) {
      newest = { number: detail.eye, at: performance.now() - (detail.eye_age ?? 0) * 1000 };
    }
    tick();
  });
}

/** The boxes around what is seen; angles to the left of and below the picture's middle, rad. */
export function mark(overlay, seen, { hfov, vfov }) {
  const { width: wide, height: high } = overlay.viewBox.baseVal;
  const [fx, fy] = [wide / 2 / Math.tan(hfov / 2), high / 2 / Math.tan(vfov / 2)];
  const parts = [...seen].map(([sensor, { fields }]) => {
    const { x, y, width = 0.1, height = 0.1 } = fields;
    const left = wide / 2 - fx * Math.tan(x + width / 2);
    const right = wide / 2 - fx * Math.tan(x - width / 2);
    const top = high / 2 + fy * Math.tan(y - height / 2);
    const bottom = high / 2 + fy * Math.tan(y + height / 2);
    const group = element("g", { "data-sensor": sensor });
    const words = label(sensor, fields);
    const across = words.length * LABEL * 0.54 + 20;
    const at = Math.min(Math.max(left, 0), wide - across);
    const above = top - LABEL * 1.4 > 0 ? top - LABEL * 1.4 : Math.min(bottom, high - LABEL * 1.4);
    const name = element("text", { x: at + 10, y: above + LABEL, "font-size": LABEL });
    name.textContent = words;
    group.append(
      element("rect", { class: "seen", x: left, y: top, width: right - left, height: bottom - top }),
      element("rect", { class: "ground", x: at, y: above, width: across, height: LABEL * 1.4 }), name,
    );
    return group;
  });
  overlay.replaceChildren(...parts);
}

function label(sensor, { distance, name }) {
  const far = Number.isFinite(distance) ? `${sensor} ${distance.toFixed(2)} m` : sensor;
  return name ? `${far}: ${name}` : far;
}
