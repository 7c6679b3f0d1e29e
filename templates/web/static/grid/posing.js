// A Gestures sheet: Play shows the gesture of the chosen row on the robot's model, Pose writes its joints into a row.

import { ownName, randomId, refusal, request } from "../api.js";
import { hasCalm } from "../preferences.js";
import { t } from "../texts.js";
import { status } from "./spoken.js";

const bar = document.getElementById("pose-bar");
const view = document.getElementById("gesture-view");
const canvas = view.querySelector("canvas");
const time = document.getElementById("gesture-time");
const LONGEST_STEP = 200; // ms of a gesture from one picture to the next: a slow machine plays it slowly, not in jumps
const client = `pose-${randomId(6)}`;
let chosen = ""; // the id of the row where the cursor is
let shown = null; // the gesture that is played
let stage = null;
let going = 0;

document.addEventListener("rrp:row", () => {
  chosen = document.querySelector("#grid-scroll [aria-selected='true']")?.closest("tr")?.id ?? chosen;
});
document.getElementById("grid-scroll").addEventListener("focusin", ({ target }) => {
  chosen = target.closest("tbody tr")?.id || chosen;
});

bar.addEventListener("click", ({ target }) => {
  const action = target.closest("[data-pose]")?.dataset.pose;
  if (action === "play") play();
  if (action === "take") take();
});
view.addEventListener("click", ({ target }) => {
  const action = target.closest("[data-pose]")?.dataset.pose;
  if (action === "again") begin();
  if (action === "close") view.close();
});
view.addEventListener("close", () => cancelAnimationFrame(going));

async function play() {
  const answer = await get(`${bar.dataset.url}/gesture/${encodeURIComponent(bar.dataset.sheet)}/${encodeURIComponent(row())}`);
  if (answer.message) return status(answer.message, "error");
  shown = answer;
  document.getElementById("gesture-title").textContent = answer.name;
  canvas.setAttribute("aria-label", t("The robot making the gesture {name}", { name: answer.name }));
  view.showModal();
  return begin();
}

/** The row where the cursor is; the first one while there is no cursor. */
function row() {
  return chosen || document.querySelector("#grid-scroll tbody tr")?.id || "";
}

async function begin() {
  cancelAnimationFrame(going);
  try {
    stage ??= await open();
  } catch (error) {
    console.warn(error);
    time.textContent = t("This browser cannot draw the robot in 3D. Run the workbook to see the gesture in the film.");
    return;
  }
  view.dataset.ready = "";
  stage.resize();
  const { frames, rate, seconds } = shown;
  if (hasCalm()) return pictures();
  let at = 0;
  let last = performance.now();
  const step = () => {
    const now = performance.now();
    at = Math.min(at + Math.min(now - last, LONGEST_STEP) / 1000, seconds);
    last = now;
    draw(frames, at < seconds ? at * rate : frames.length - 1);
    time.textContent = t("{now} of {whole} s", { now: at.toFixed(1), whole: seconds.toFixed(1) });
    if (at < seconds && view.open) going = requestAnimationFrame(step);
    else delete view.dataset.playing;
  };
  view.dataset.playing = "";
  step();
  return undefined;
}

/** Show the keyframes, one after the other, to a person who wants no motion. */
function pictures() {
  const { frames, rate, times } = shown;
  let n = 0;
  const next = () => {
    draw(frames, times[n] * rate);
    time.textContent = t("Pose {number} of {all} (keyframe), at {seconds} s", { number: n + 1, all: times.length, seconds: times[n].toFixed(1) });
    n += 1;
    if (n < times.length && view.open) setTimeout(next, 1500);
  };
  next();
}

function draw(frames, place) {
  const first = Math.min(Math.floor(place), frames.length - 1);
  const [a, b] = [frames[first], frames[Math.min(first + 1, frames.length - 1)]];
  const angles = { ...stage.model.rest };
  for (const joint of Object.keys(a)) angles[joint] = a[joint] + (b[joint] - a[joint]) * (place - first);
  stage.body.stand(angles);
  canvas.dataset.angles = JSON.stringify(a);
  stage.ask();
}

async function open() {
  const [{ Stage }, model] = await Promise.all([import("../run/stage3d.js"), get("/robot/model.json")]);
  const nobody = () => {};
  return new Stage(canvas, model, { limits: [[0, 0], [0, 0], [0, 0]], held: nobody, moved: nobody, dropped: nobody });
}

async function take() {
  const answer = await get(`${bar.dataset.url}/pose`, { client, tag: "", name: ownName(), sheet: bar.dataset.sheet, row: row() });
  if (answer.message) status(answer.message, "error");
  else status(t("The angles of the robot’s joints are now in this keyframe. Undo brings the old ones back."));
}

async function get(url, body) {
  const { ok, status, json } = await request(url, { body });
  return ok ? json : { message: status === 404 ? t("This row no longer exists. Reload the page.") : refusal(status) };
}
