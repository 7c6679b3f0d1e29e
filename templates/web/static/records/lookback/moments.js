// The events of a run besides its values: as ticks over the time, as a list, and as sounds while it plays.

import { shownName } from "../../api.js";
import { icon, make } from "../../elements.js";
import { clock, EXACT } from "../../run/time.js";
import { t } from "../../texts.js";
import { last } from "./store.js";

const NEAR = 16; // px: ticks that are nearer are one
const ALMOST = 0.02; // s: a moment that is nearer is the one where one is
const HEARD = 15; // s: a sound that began longer ago is over
const KINDS = {
  error: ["error", "error", t("Error")], mark: ["mark", "flag", t("Mark")], edit: ["edit", "sheet", t("Edited")], button: ["hand", "button", t("Button")],
  press: ["hand", "button", t("Button")], send: ["hand", "send", t("Sent by hand")], switch: ["hand", "subscribe", t("Switched")],
  say: ["say", "say", t("Robot")], command: ["say", "gesture", t("Command")], person: ["person", "say", t("Person")], sound: ["say", "sound", t("Sound")], scene: ["hand", "ball", t("Scene, by hand")],
  put: ["hand", "ball", t("Moved by hand")], clamp: ["warning", "warning", t("Cut to its limit")], note: ["note", "mark", t("Note")],
  pause: ["note", "pause", t("Run")], resume: ["note", "run", t("Run")], step: ["note", "step", t("Run")], speed: ["note", "run", t("Run")],
};
const ORDER = ["error", "mark", "edit", "warning", "hand", "say", "person", "note"]; // which of several is shown
const of = (kind) => KINDS[kind] ?? ["note", "mark", kind];

const words = ({ kind, text, row, by, times }) => [
  t("{what}: {text}", { what: of(kind)[2], text }), by && t("by {name}", { name: shownName(by) }), row && `(${row})`, times > 1 && t("{n} times", { n: times }),
].filter(Boolean).join(" ");

export class Moments {
  constructor(list, ticks, told, leftOut, seconds, go) {
    Object.assign(this, { list, ticks, told, seconds, go });
    this.times = told.map((moment) => moment.t);
    this.stops = told.filter(({ kind }) => kind !== "note").map((moment) => moment.t); // notes come at camera rate
    this.here = -2;
    this.items = told.map((moment) => this.item(moment));
    const rest = leftOut ? [make("li", { className: "quiet", textContent: t("… and {n} more moments. The recording’s files run.xlsx and CSV have them all.", { n: leftOut }) })] : [];
    const none = make("li", { className: "quiet", textContent: t("Nothing was said or commanded, no row failed, and nobody marked a moment.") });
    list.replaceChildren(...(told.length ? [...this.items, ...rest] : [none]));
    new ResizeObserver(() => this.draw()).observe(ticks);
  }

  item(moment) {
    const [group, sign, word] = of(moment.kind);
    const more = [moment.by && t("by {name}", { name: shownName(moment.by) }), moment.row, moment.times > 1 && t("{n} times", { n: moment.times })].filter(Boolean);
    const what = make("span", {}, make("b", { textContent: `${word} ` }), moment.text, make("small", { textContent: more.map((part) => ` ${part}`).join(",") }));
    const button = make("button", { type: "button" }, make("time", { textContent: clock(moment.t, EXACT) }), icon(sign), what);
    button.addEventListener("click", () => this.go(moment.t));
    return make("li", { className: `of-${group}` }, button);
  }

  /** The ticks; those that lie together are one. */
  draw() {
    const wide = this.ticks.clientWidth;
    if (!wide) return;
    const found = [];
    for (const moment of this.told) {
      const began = found.at(-1)?.[0].t;
      if (began !== undefined && ((moment.t - began) / (this.seconds || 1)) * wide < NEAR) found.at(-1).push(moment);
      else found.push([moment]);
    }
    this.ticks.replaceChildren(...found.map((group) => {
      const shown = [...group].sort((a, b) => ORDER.indexOf(of(a.kind)[0]) - ORDER.indexOf(of(b.kind)[0]))[0];
      const tick = make("span", { className: `tick of-${of(shown.kind)[0]}` }, icon(of(shown.kind)[1]));
      tick.title = [`${clock(shown.t, EXACT)} ${words(shown)}`, group.length > 1 && t("and {n} more", { n: group.length - 1 })].filter(Boolean).join("\n");
      tick.style.left = `${(group[0].t / (this.seconds || 1)) * 100}%`;
      tick.addEventListener("click", () => this.go(shown.t));
      return tick;
    }));
  }

  /** The moment of a time is marked in the list. */
  show(seconds) {
    const here = last(this.times, seconds);
    if (here === this.here) return;
    this.items[this.here]?.removeAttribute("aria-current");
    this.here = here;
    const item = this.items[here];
    if (!item) return;
    item.setAttribute("aria-current", "true");
    const box = this.list.parentElement;
    const [top, bottom] = [item.offsetTop, item.offsetTop + item.offsetHeight]; // within the list: the page stays
    if (top < box.scrollTop) box.scrollTop = top;
    else if (bottom > box.scrollTop + box.clientHeight) box.scrollTop = bottom - box.clientHeight;
  }

  /** The time of the moment before a time, or of the one after it; notes are passed over. */
  next(seconds, way) {
    const here = last(this.stops, way > 0 ? seconds + ALMOST : seconds - ALMOST);
    return this.stops[way > 0 ? here + 1 : here];
  }

  /** The last sentence until a time. */
  said(seconds) {
    for (let n = last(this.times, seconds); n >= 0; n -= 1) if (this.told[n].kind === "say") return this.told[n];
    return null;
  }
}

/** Plays the sounds of the run. */
export class Sounds {
  constructor(told, files, button) {
    this.told = told.filter(({ sound }) => sound);
    this.files = files;
    this.playing = new Set();
    this.on = true;
    this.until = 0;
    button.hidden = !this.told.length;
    button.addEventListener("click", () => {
      this.on = !this.on;
      button.setAttribute("aria-pressed", String(this.on));
      button.querySelector("span").textContent = this.on ? t("Sound on") : t("Sound off");
      if (!this.on) this.stop();
    });
  }

  /** It is played from a time on: what was being said then goes on. */
  start(seconds, speed) {
    this.stop();
    this.speed = speed;
    this.until = seconds;
    for (const moment of this.told) if (moment.t < seconds && seconds - moment.t < HEARD) this.play(moment, seconds - moment.t);
  }

  stop() {
    for (const sound of this.playing) sound.pause();
    this.playing.clear();
  }

  /** It has come to a time. */
  show(seconds) {
    for (const moment of this.told) if (moment.t >= this.until && moment.t < seconds) this.play(moment, 0);
    this.until = Math.max(this.until, seconds);
  }

  play({ sound }, since) {
    if (!this.on) return;
    const audio = new Audio(this.files + encodeURIComponent(sound));
    this.playing.add(audio);
    audio.playbackRate = this.speed;
    const done = () => this.playing.delete(audio);
    audio.addEventListener("ended", done);
    audio.addEventListener("loadedmetadata", () => {
      if (since >= audio.duration) {
        audio.pause();
        done();
      } else if (since) audio.currentTime = since;
    });
    audio.play().catch(done); // a browser that plays nothing unasked
  }
}
