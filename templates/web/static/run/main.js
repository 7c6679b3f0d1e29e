// A run as this page sees it. The server's messages come in here and go on as events of the document, which every
// part of the page listens to: `rrp:run` (phase and settings), `rrp:live` (values), `rrp:log` (new lines),
// `rrp:elsewhere` (a run of another workbook).

import { bar } from "./bar.js";
import { log } from "./log.js";
import { robot } from "./robot.js";
import { scene, session } from "./session.js";
import { timeline } from "./timeline.js";
import { views } from "./views.js";
import { follow, values } from "./values.js";

const book = document.getElementById("runbar").dataset.book;
const listen = document.getElementById("listen");
const none = { phase: "none", book: "" };
let state = none;
let last = 0; // the newest line of the log that is shown

bar(document.getElementById("runbar"));
const grid = document.querySelector("[role=grid].of-behaviour");
if (grid) values(grid);
if (grid) follow(grid, document.getElementById("run-follow"));
for (const [id, part] of Object.entries({ session, log, robot, scene, timeline, views })) {
  const root = document.getElementById(id === "robot" ? "robot-facts" : id);
  if (root) part(root);
}
// Views listen once their modules are there. Values wait for the small ones; the run's phase, and so Stop, waits for none.
const ready = Promise.allSettled(["eye", "speech", "plots", "drives"].map((name) => view(name)));
ready.then(() => tell("rrp:run", state));
let lately = null; // the newest of the robot, for its picture, which takes longest to come
view("robot3d", "robot").then(() => {
  tell("rrp:run", state);
  if (lately) tell("rrp:live", lately);
});

async function view(name, file = name) {
  const root = document.getElementById(name);
  if (root) (await import(`./${file}.js`))[name](root);
}

function tell(name, detail) {
  document.dispatchEvent(new CustomEvent(name, { detail }));
}

async function heard(event, data) {
  if (event === "run") return takeRun(data);
  if (event === "eye" && document.hidden) return undefined;
  await ready;
  if (data.run !== state.id) return undefined; // of a run before this one
  if (event === "live") {
    if (data.robot) takeRobot(data);
    tell("rrp:live", data);
  } else if (event === "eye") {
    tell("rrp:eye", data);
  } else if (event === "log") {
    const lines = data.lines.filter((line) => line.i > last);
    last = lines.at(-1)?.i ?? last;
    if (lines.length) tell("rrp:log", { lines });
  }
  return undefined;
}

/** Of the robot the server tells what has changed; the views hear all of it. */
function takeRobot(data) {
  const { robot, t } = lately ?? { robot: {}, t: 0 };
  if (data.full) lately = { t: data.t, robot: data.robot };
  else if (t <= data.t) lately = { t: data.t, robot: { ...robot, ...data.robot, joints: { ...robot.joints, ...data.robot.joints } } };
  data.robot = lately.robot;
}

function takeRun(told) {
  const mine = told.book === book && told.phase !== "none" ? told : none;
  if (mine.id !== state.id) {
    last = 0;
    lately = null;
  }
  state = mine;
  document.body.dataset.run = state.phase;
  document.body.dataset.mode = state.mode ?? "simulated";
  tell("rrp:run", state);
  tell("rrp:elsewhere", told.book !== book ? told : none);
}

for (const event of ["run", "live", "log", "eye"]) {
  listen.addEventListener(event, ({ detail }) => heard(event, JSON.parse(detail.data)));
}

document.addEventListener("visibilitychange", () => tell("rrp:run", state)); // what was not drawn meanwhile
