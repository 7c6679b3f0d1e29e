// The time of the run that is shown: moved with the slider and its keys, or played.

import { put } from "../../elements.js";
import { clock } from "../../run/time.js";
import { t } from "../../texts.js";

const STEP = 0.1; // s, of an arrow key
const PAGE = 5; // s
const SPOKEN = 1000; // ms between two tellings to a screen reader while it plays
const TYPES = "input:not([type=range]), select, textarea";

export class Player {
  /** `show(t)` shows a time and says whether it could; `turned(playing)` is told when it starts and stops to play. */
  constructor(root, seconds, show, turned) {
    Object.assign(this, { seconds, show, turned });
    this.slider = root.querySelector("#time");
    this.play = root.querySelector("#play");
    this.pace = root.querySelector("#pace");
    this.now = root.querySelector("#now");
    this.t = 0;
    this.playing = false;
    this.spoken = 0;
    this.slider.max = String(seconds || 1);
    put(root.querySelector("#whole"), clock(seconds));
    this.play.disabled = false;
    this.play.addEventListener("click", () => this.toggle());
    this.slider.addEventListener("input", () => this.go(Number(this.slider.value)));
    this.slider.addEventListener("keydown", (event) => this.key(event));
    document.addEventListener("keydown", (event) => this.space(event));
    addEventListener("hashchange", () => this.bookmark());
    this.pace.addEventListener("change", () => this.playing && this.turned(true));
  }

  get speed() {
    return Number(this.pace.value);
  }

  /** Show another time. */
  go(seconds, { quietly = false } = {}) {
    this.t = Math.min(Math.max(seconds, 0), this.seconds);
    this.slider.value = String(this.t);
    this.tell();
    this.show(this.t);
    if (this.playing && !quietly) this.turned(true);
    if (!quietly) this.remember();
  }

  tell() {
    put(this.now, clock(this.t));
    if (this.playing && performance.now() - this.spoken < SPOKEN) return;
    this.spoken = performance.now();
    this.slider.setAttribute("aria-valuetext", t("{now} of {whole}", { now: clock(this.t), whole: clock(this.seconds) }));
  }

  key(event) {
    const ways = {
      ArrowRight: STEP, ArrowUp: STEP, ArrowLeft: -STEP, ArrowDown: -STEP, PageUp: PAGE, PageDown: -PAGE,
      Home: -Infinity, End: Infinity,
    };
    const way = ways[event.key];
    if (way === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const tenths = Math.abs(way) === STEP ? Math.round(this.t / STEP) * STEP : this.t;
    this.go(tenths + way);
  }

  // also where one has just clicked a moment; a button that is not of this player keeps its own key
  space(event) {
    if (event.key !== " " || event.ctrlKey || event.target.closest?.(`${TYPES}, button, summary, a`)) return;
    event.preventDefault();
    this.toggle();
  }

  toggle() {
    if (this.playing) this.stop();
    else this.start();
  }

  start() {
    if (this.t >= this.seconds - 0.01) this.go(0);
    this.turn(true);
    let before = performance.now();
    const step = () => {
      if (!this.playing) return;
      const now = performance.now();
      const passed = Math.min((now - before) / 1000, 0.5); // a page that was hidden does not leap
      before = now;
      const next = Math.min(this.t + passed * this.speed, this.seconds);
      if (this.show(next)) this.go(next, { quietly: true }); // else it waits for what is being loaded
      if (next >= this.seconds) this.stop();
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  stop() {
    this.turn(false);
    this.tell();
    this.remember();
  }

  turn(playing) {
    this.playing = playing;
    this.play.setAttribute("aria-pressed", String(playing));
    put(this.play.querySelector("span"), playing ? t("Pause") : t("Play"));
    const use = this.play.querySelector("use");
    use.setAttribute("href", use.getAttribute("href").replace(/#.*/, playing ? "#i-pause" : "#i-run"));
    this.turned(playing);
  }

  /** The address tells the time, so that it can be sent to somebody. */
  remember() {
    clearTimeout(this.later);
    const shown = Math.ceil(this.t * 1000 - 0.001) / 1000; // not before the moment where one is
    this.later = setTimeout(() => history.replaceState(null, "", `#t=${shown}`), 250);
  }

  /** The time that the address tells, if any. */
  bookmark() {
    const found = /^#t=(\d+(?:\.\d+)?)$/.exec(location.hash);
    if (found) this.go(Number(found[1]));
    return Boolean(found);
  }
}
