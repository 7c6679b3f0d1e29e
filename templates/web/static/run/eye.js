// The picture of the robot's camera, drawn as it comes with the page's events, with the detections of its sensors in it.
// The robot's eye is open only while a page shows it.

import { ask, isUnderWay } from "../api.js";
import { element, put } from "../elements.js";
import { t } from "../texts.js";

const FRESH = 0.5; // s: an older detection is not shown
const AGAIN = 1000; // ms
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
  const picture = document.createElement("canvas");
  picture.setAttribute("role", "img");
  picture.ariaLabel = EMPTY;
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
  let number = 0; // of the newest picture that was taken, be it like the one before
  let taken = 0; // when (ms)
  let next = null; // the newest that was not drawn yet
  let drawing = false;
  let seconds = 0;
  let inSight = false;
  let told = false; // the server knows that the eye is shown here
  let telling = false;
  let connection = 0; // each knows nothing of those before it
  let lost = false; // the connection
  let notBefore = 0; // ms

  const going = () => isUnderWay(phase);
  const forget = () => {
    seen.clear();
    number = taken = 0;
    next = null;
    overlay.replaceChildren();
    reveal(false);
  };
  const reveal = (on) => {
    picture.hidden = !on;
    overlay.classList.toggle("shown", on);
    nothing.hidden = on;
  };

  // One picture after the other: a slow browser draws fewer, not later ones.
  const draw = async () => {
    if (drawing || !next) return;
    drawing = true;
    const [data, run] = [next, id];
    next = null;
    try {
      const bitmap = await createImageBitmap(await bytes(data));
      if (run === id) {
        Object.assign(picture, { width: bitmap.width, height: bitmap.height });
        picture.getContext("2d").drawImage(bitmap, 0, 0);
        picture.dataset.drawn = Number(picture.dataset.drawn ?? 0) + 1;
        reveal(true);
        tick();
      }
      bitmap.close();
    } catch (error) { // what is seen stays
      console.warn(error);
    }
    drawing = false;
    requestAnimationFrame(draw);
  };
  const look = async () => {
    const wanted = going() && inSight && !document.hidden;
    if (telling || lost || wanted === told || !going() || performance.now() < notBefore) return;
    telling = true;
    const before = connection;
    const answer = await ask("look", { client: document.getElementById("listen").dataset.client, on: wanted });
    telling = false;
    if (answer.message) notBefore = performance.now() + AGAIN; // no run any more, or no answer
    else if (before === connection) told = wanted;
    look();
  };
  const anew = () => {
    connection += 1;
    told = false;
  };
  const tick = () => {
    const old = performance.now() - taken;
    put(age, phase === "running" && taken && !picture.hidden && old > OLD ? oldBy(Math.floor(old / 1000)) : "");
    look();
  };
  setInterval(tick, LOOK);
  document.addEventListener("visibilitychange", () => {
    if (document.hidden) anew(); // its connection is closed
    tick();
  });
  document.addEventListener("rrp:connection", ({ detail }) => {
    anew();
    lost = detail.lost;
    tick();
  });
  new IntersectionObserver((entries) => {
    inSight = entries.at(-1).isIntersecting;
    tick();
  }).observe(frame);

  document.addEventListener("rrp:run", ({ detail }) => {
    if (detail.id !== id) forget();
    id = detail.id;
    if (phase === "paused" && detail.phase === "running") taken = performance.now(); // nothing moved
    phase = detail.phase;
    if (detail.camera?.hfov) Object.assign(lens, detail.camera);
    const high = Math.round((WIDE * Math.tan(lens.vfov / 2)) / Math.tan(lens.hfov / 2));
    overlay.setAttribute("viewBox", `0 0 ${WIDE} ${high}`);
    frame.style.aspectRatio = `${WIDE} / ${high}`;
    frame.style.setProperty("--ratio", WIDE / high);
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
    if (picture.ariaLabel !== sees(words)) picture.ariaLabel = sees(words);
    if (detail.eye && detail.eye !== number) {
      number = detail.eye;
      taken = performance.now() - (detail.eye_age ?? 0) * 1000;
    }
    tick();
  });
  document.addEventListener("rrp:eye", ({ detail }) => {
    next = detail.jpeg;
    taken = performance.now() - detail.age * 1000;
    draw();
  });
}

/** The bytes of a JPEG in base64. */
function bytes(text) {
  return new Blob([Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0))], { type: "image/jpeg" });
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
