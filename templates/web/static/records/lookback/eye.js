// The camera's picture of a time, with what its sensors had found in it.

import { element, put } from "../../elements.js";
import { mark } from "../../run/eye.js";
import { t } from "../../texts.js";
import { last } from "./store.js";

const FRESH = 0.5; // s: an older detection is not shown
const OLD = 1.5; // s: a picture that is older says so
const NONE = t("No pictures of the camera were kept in this run.");

const before = (seconds) => t("{n} s before", { n: seconds.toFixed(1) });

function saw(picture, things) {
  picture.dataset.seen = things;
  picture.alt = t("What the robot’s camera saw: {things}", { things: things || t("nothing that its sensors look for") });
}

export class Eye {
  constructor(root, address, times) {
    Object.assign(this, { address, times });
    this.frame = root.querySelector(".frame");
    this.caption = root.querySelector("figcaption span");
    this.nothing = root.querySelector(".nothing");
    this.picture = document.createElement("img");
    this.picture.hidden = true;
    this.picture.alt = "";
    this.overlay = element("svg", { viewBox: "0 0 640 480", "aria-hidden": "true" });
    this.frame.append(this.picture, this.overlay);
    this.lens = { hfov: 0.98262, vfov: 0.76271 };
    this.shown = -1;
    this.loading = false;
    if (!times.length) put(this.nothing, NONE);
    this.picture.addEventListener("load", () => this.came());
    this.picture.addEventListener("error", () => this.came());
  }

  show(seconds, seen) {
    this.t = seconds;
    this.wanted = last(this.times, seconds);
    this.load();
    const boxes = new Map(Object.entries(seen).filter(([, { t: when }]) => seconds - when <= FRESH).map(([name, { t: when, at }]) => {
      const [x, y, width, height, distance, who] = at;
      return [name, { t: when, fields: { x, y, width: width ?? 0.1, height: height ?? 0.1, distance, name: who } }];
    }));
    const on = this.wanted >= 0;
    this.picture.hidden = !on;
    this.nothing.hidden = on;
    this.overlay.classList.toggle("shown", on);
    mark(this.overlay, on ? boxes : new Map(), this.lens);
    const words = [...boxes.keys()].join(", ");
    if (this.picture.dataset.seen !== words) saw(this.picture, words);
    const old = on ? seconds - this.times[this.wanted] : 0;
    put(this.caption, old > OLD ? before(old) : "");
  }

  // one after the other: who moves the slider quickly gets fewer pictures, not later ones
  load() {
    if (this.loading || this.wanted < 0 || this.wanted === this.shown) return;
    this.loading = true;
    this.shown = this.wanted;
    this.picture.src = `${this.address}/${this.shown}.jpg`;
  }

  came() {
    this.loading = false;
    this.load();
  }
}
