// The places where the robot feels a touch: shown under the pointer, touched by a click or as long as the button is held, and by
// the keyboard. A drag that begins on one turns the view (stage3d.js).

import * as THREE from "../vendor/js/three.module.js";
import { act } from "../api.js";
import { make, put } from "../elements.js";
import { t } from "../texts.js";
import { STEADY } from "./drag3d.js";

const BESIDE = 20; // px beside the robot that are still it
const HOLDS = 250; // ms after which a touch lasts as long as it is held
const AGAIN = 800; // ms between two tellings that it goes on: without them it ends after a second
const presses = ({ key }) => ["Enter", " "].includes(key);

export class Touch {
  /** `stage` has the robot, the camera and the canvas; its model tells where the zones are. */
  constructor(stage) {
    this.stage = stage;
    this.on = false;
    this.press = null; // { zone, x, y, timer, held }
    this.shown = null; // the zone under the pointer
    this.missed = null; // where a press began that is on no zone, or true once it was a click
    this.zones = stage.model.touch.map(({ zone, label, link, xyz }) => ({ zone, label, link: stage.body.links.get(link), at: new THREE.Vector3(...xyz), mark: mark(label) }));
    this.hint = make("p", { className: "touch-hint", id: "touch-hint" });
    this.box = make("div", { className: "zones" }, ...this.zones.map((one) => one.mark), this.hint);
    const { canvas } = stage;
    canvas.setAttribute("aria-describedby", this.hint.id);
    canvas.parentElement.append(this.box);
    canvas.addEventListener("pointerdown", (event) => event.button === 0 && this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel", "pointerleave"]) {
      canvas.addEventListener(name, (event) => {
        this.end(event.type === "pointerup");
        if (event.type === "pointerup" && this.missed?.x !== undefined) this.miss(event);
        if (event.type === "pointerleave") this.show(null);
      });
    }
    for (const one of this.zones) {
      one.mark.addEventListener("keydown", (event) => {
        if (!presses(event)) return;
        event.preventDefault();
        if (!event.repeat) this.begin(one, {});
      });
      one.mark.addEventListener("keyup", (event) => presses(event) && this.end(true));
      one.mark.addEventListener("focus", () => this.explain());
      one.mark.addEventListener("blur", () => {
        this.end(false);
        this.explain();
      });
      one.mark.addEventListener("click", () => touch(one.zone, "once")); // by a screen reader
    }
    this.allow(false);
  }

  allow(on) {
    this.on = on;
    if (!on) {
      this.end(false);
      this.show(null);
    }
    for (const { mark: button } of this.zones) button.disabled = !on;
    this.hint.hidden = !on;
    this.explain();
  }

  /** A press on a zone touches it; of one beside the zones it is told that the robot feels nothing there. */
  down(event) {
    const one = this.under(event);
    this.missed = one || !this.on ? null : { x: event.clientX, y: event.clientY };
    this.begin(one, event);
  }

  /** The press on no zone has ended: as a click, unless it turned the view. */
  miss({ clientX, clientY }) {
    this.missed = Math.hypot(clientX - this.missed.x, clientY - this.missed.y) <= STEADY || null;
    this.explain();
  }

  /** Tell in the corner of the picture how the zone under the pointer or with the focus is touched, or that there are some. */
  explain() {
    const one = this.shown ?? this.zones.find((each) => each.mark === document.activeElement);
    const zones = this.zones.map(({ label }) => label).join(", ");
    put(this.hint, one ? t("{zone}: click to touch, hold to keep touching", { zone: one.label })
      : this.missed === true ? t("The robot feels nothing there. It feels: {zones}", { zones }) : t("Click the robot to touch it"));
  }

  begin(one, { clientX, clientY }) {
    if (!one || !this.on || this.press) return;
    this.press = { one, x: clientX, y: clientY, timer: setTimeout(() => this.hold(), HOLDS) };
  }

  move({ clientX, clientY, buttons, pointerType }) {
    if (this.press && Math.hypot(clientX - this.press.x, clientY - this.press.y) > STEADY) this.end(false);
    else if (!this.press && !buttons && pointerType === "mouse") this.show(this.on ? this.under({ clientX, clientY }) : null);
  }

  hold() {
    const { one, held } = this.press;
    this.press.held = true;
    this.show(one);
    one.mark.classList.add("held");
    touch(one.zone, held ? "on" : "begin");
    this.press.timer = setTimeout(() => this.hold(), AGAIN);
  }

  /** The pointer or key is let go: a short press is a click. */
  end(touches) {
    const { press } = this;
    if (!press) return;
    this.press = null;
    clearTimeout(press.timer);
    press.one.mark.classList.remove("held");
    if (press.held) touch(press.one.zone, "end");
    else if (touches) touch(press.one.zone, "once");
  }

  /** Show this zone under the pointer. */
  show(one) {
    if (one === this.shown) return;
    this.shown = one;
    if (one) this.missed = null;
    for (const each of this.zones) each.mark.classList.toggle("under", each === one);
    this.stage.canvas.classList.toggle("on-zone", Boolean(one));
    this.explain();
  }

  /** The zone under a pointer, of the part of the robot that is in front. */
  under({ clientX, clientY }) {
    const box = this.stage.canvas.getBoundingClientRect();
    const [front] = this.stage.rayTo({ clientX, clientY }).intersectObject(this.stage.body.base, true);
    const links = new Set(this.stage.body.links.values());
    let first = true; // the link itself; what hangs on the trunk is not the chest
    for (let node = front?.object; node && node !== this.stage.body.base; node = node.parent) {
      if (!links.has(node)) continue;
      const found = this.zones.find(({ link }) => link === node);
      if (found && (first || node.parent !== this.stage.body.base)) return found;
      first = false;
    }
    const far = ({ mark: { style } }) => Math.hypot(clientX - box.left - parseFloat(style.left), clientY - box.top - parseFloat(style.top));
    const near = this.zones.map((one) => [far(one), one]).sort(([a], [b]) => a - b)[0];
    return !front && near && near[0] < BESIDE ? near[1] : null;
  }

  /** Put the marks where the zones are in the picture. */
  place() {
    const { camera, canvas } = this.stage;
    for (const { link, at, mark: button } of this.zones) {
      const place = link.localToWorld(at.clone()).project(camera);
      button.style.left = `${((place.x + 1) / 2 * canvas.clientWidth).toFixed(1)}px`;
      button.style.top = `${((1 - place.y) / 2 * canvas.clientHeight).toFixed(1)}px`;
    }
  }
}

/** Tell the run of a touch: `once`, or that one begins, goes `on`, and ends. One after the other, as they happened. */
let told = Promise.resolve();
function touch(zone, step) {
  told = told.then(() => act("touch", { zone, step }));
}

function mark(label) {
  const button = make("button", { type: "button", className: "zone", ariaLabel: t("Touch: {zone}", { zone: label }) }, make("span", label));
  button.setAttribute("aria-describedby", "touch-hint");
  return button;
}
