// Looking back at a run: one time, and everything as it was then. The state of a time goes to the parts of the run panel
// as the same events of the document that a run tells them: `rrp:run` and `rrp:live`.

import { request, why } from "../../api.js";
import { put } from "../../elements.js";
import { robot, robot3d } from "../../run/robot.js";
import { lastSaid, NOTHING, quoted, secondsAgo } from "../../run/speech.js";
import { views } from "../../run/views.js";
import { t } from "../../texts.js";
import { curves } from "./curves.js";
import { Eye } from "./eye.js";
import { Moments, Sounds } from "./moments.js";
import { Player } from "./player.js";
import { Sheets } from "./sheets.js";
import { Pieces, poseAt, poses, valuesAt } from "./store.js";

const root = document.getElementById("player");
const { url, run, files } = root.dataset;
const ids = JSON.parse(document.getElementById("row-ids").textContent);
const BEGINS = 0.2; // s after it was told to speak until its pose tells it too
const SAYS = 2; // s that a sentence is taken to last where the robot's pose does not tell

const tell = (name, detail) => document.dispatchEvent(new CustomEvent(name, { detail }));

async function begin() {
  views(document.getElementById("views"), "lookback-view");
  const { ok, status, text, json: told } = await request(`${url}/overview.json`);
  if (!told) throw new Error(why({ status, text }));
  if (!ok) throw new Error(told.trouble);
  const seconds = Math.max(told.seconds, Number(root.dataset.seconds));
  const view = new View(told, seconds);
  if (told.poses.length) robot3d(document.getElementById("robot3d")).then(() => view.again());
  document.getElementById("no-poses").hidden = told.poses.length > 0;
}

class View {
  constructor(told, seconds) {
    this.told = told;
    const came = () => this.again();
    this.pieces = new Pieces(told.pieces, `${url}/piece`, (piece) => piece, came);
    this.poses = new Pieces(told.poses, `${url}/poses`, poses, came);
    this.sheets = new Sheets(document.getElementById("main"), told.edits);
    this.eye = new Eye(document.getElementById("eye"), `${url}/picture`, told.pictures);
    robot(document.getElementById("robot-facts"));
    this.sounds = new Sounds(told.moments, files, document.getElementById("sound"));
    const go = (seconds) => this.player.go(seconds);
    this.moments = new Moments(document.getElementById("moments"), document.getElementById("ticks"), told.moments, told.left_out, seconds, go);
    this.said = document.getElementById("said");
    this.off = "";
    tell("rrp:run", this.state(0));
    this.player = new Player(root, seconds, (seconds) => this.show(seconds), (playing) => this.turned(playing));
    this.curves = curves(document.getElementById("curves"), seconds, go);
    for (const button of root.querySelectorAll("[data-jump]")) button.addEventListener("click", () => this.jump(Number(button.dataset.jump)));
    document.addEventListener("keydown", (event) => this.key(event));
    if (!this.player.bookmark()) this.player.go(0, { quietly: true });
  }

  state(seconds) {
    const off = {};
    for (const [when, behaviour, on] of this.told.switches) if (when <= seconds) off[behaviour] = !on;
    return { id: run, phase: "looking", t: seconds, behaviours: Object.entries(off).map(([name, is]) => ({ name, on: !is })) };
  }

  jump(way) {
    const seconds = this.moments.next(this.player.t, way);
    if (seconds !== undefined) this.player.go(seconds);
  }

  key(event) {
    const way = { ",": -1, ".": 1 }[event.key];
    if (way && !event.ctrlKey && !event.metaKey && !event.altKey && !event.target.closest?.("input:not([type=range]), select")) this.jump(way);
  }

  turned(playing) {
    if (playing) this.sounds.start(this.player.t, this.player.speed);
    else this.sounds.stop();
  }

  again() {
    if (this.player) this.show(this.player.t);
  }

  /** Show a time; false while it is being loaded. */
  show(seconds) {
    const piece = this.pieces.at(seconds);
    const pose = this.poses.at(seconds);
    this.pieces.ahead(seconds);
    if (this.told.poses.length) this.poses.ahead(seconds);
    root.toggleAttribute("aria-busy", piece === null);
    if (piece === null || pose === null) return false;
    const switched = this.state(seconds);
    if (JSON.stringify(switched.behaviours) !== this.off) {
      this.off = JSON.stringify(switched.behaviours);
      tell("rrp:run", switched);
    }
    const { rows, streams, seen } = piece ? valuesAt(piece, this.told, ids, seconds) : { rows: {}, streams: {}, seen: {} };
    for (const [id, from] of Object.entries(this.sheets.show(seconds, ids))) (rows[id] ??= { v: "", at: null, n: 1, e: "" }).from = from;
    const stood = pose && poseAt(pose, seconds);
    tell("rrp:live", { full: true, t: seconds, rows, streams, ...(stood ? { robot: stood } : {}) });
    this.eye.show(seconds, seen);
    this.moments.show(seconds);
    this.curves?.show(seconds);
    this.speak(seconds, stood?.saying);
    if (this.player?.playing) this.sounds.show(seconds);
    if (!this.wanted) {
      this.wanted = true;
      this.sheets.want();
    }
    return true;
  }

  /** Show the sentence that the robot says, or its last one. */
  speak(seconds, saying) {
    const before = this.moments.said(seconds);
    const just = before && seconds - before.t < (saying === undefined ? SAYS : BEGINS) ? before.text : "";
    const now = saying || just;
    this.said.classList.toggle("now", Boolean(now));
    this.said.classList.toggle("past", !now);
    this.said.classList.toggle("none", !now && !before);
    const [words, age] = this.said.children;
    put(words, now ? quoted(now.replace(/^[“"]|[”"]$/g, "")) : before ? lastSaid(before.text) : NOTHING);
    put(age, now || !before ? "" : secondsAgo(Math.round(seconds - before.t)));
  }
}

begin().catch((error) => {
  const note = document.getElementById("trouble");
  note.hidden = false;
  note.textContent = error.message || t("The recording cannot be read.");
});
