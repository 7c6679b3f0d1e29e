// Looking around a scene: drag, wheel or pinch, keys. It frames what it is told to until somebody turns it by hand.

import * as THREE from "/vendor/js/three.module.js";

const FRONT = { azimuth: -0.5, elevation: 0.2 }; // rad: from the robot's right front, a little from above
const ELSEWHERE = [-0.5, 0.8, -0.8, 1.05, 0.5, -1.05, 0, 0.3, -1.6, 1.6]; // rad: where else to look from when the robot is hidden, or somebody left out
const BROAD = 0.35; // m: half as wide as somebody is
const ASIDE = -1.05; // rad: when persons sit before the robot, they and it are seen from the side
const NEAREST = 0.45;
const FARTHEST = 6; // m
const WIDEST = 2.4; // m away at most by itself, if the picture is not narrow: the robot must stay large enough
const COMPANY = 1.15; // that much farther away, so that somebody is in the picture too
const STEP = 0.12; // rad, of an arrow key
const TURN = 0.008; // rad per pixel
const EASE = 260; // ms, of a third of the way to a new view

export class Orbit {
  constructor(element, camera, changed) {
    this.camera = camera;
    this.changed = changed;
    this.target = new THREE.Vector3(0.03, 0, 0.3);
    this.distance = 1.5;
    this.pointers = new Map();
    this.held = false; // while something is dragged, the view stays as it is
    this.front();
    element.addEventListener("pointerdown", (event) => this.down(element, event));
    element.addEventListener("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
      element.addEventListener(name, (event) => this.pointers.delete(event.pointerId));
    }
    element.addEventListener("wheel", (event) => this.wheel(element, event), { passive: false });
    element.addEventListener("keydown", (event) => this.key(event));
    element.addEventListener("dblclick", () => this.front());
  }

  /** The view from the front; from then on it frames things by itself again. */
  front() {
    this.azimuth = FRONT.azimuth;
    this.other = null; // the side to look from when somebody stands in the way, or would not be in the picture
    this.elevation = FRONT.elevation;
    this.byHand = false;
    if (this.framed) this.settle(1);
    this.changed();
  }

  /** Frame these groups, each with `points` and whether it is `somebody`: the first always, the others in their order
   * while it can stay near enough. */
  frame(groups, base, aside, hiding = []) {
    if (this.base && this.byHand) this.target.add(base.clone().sub(this.base).setZ(0)); // it goes along
    this.base = base.clone();
    this.framed = groups;
    this.aside = aside;
    this.hiding = hiding;
  }

  /** How many of those who stand there (x, y) hide the robot, or what it has before it, seen from an azimuth. */
  hidden(azimuth) {
    const [ca, sa] = [Math.cos(azimuth), Math.sin(azimuth)];
    return [0, 0.5].reduce((sum, ahead) => sum + this.hiding.filter(([x, y]) => {
      const [dx, dy] = [x - this.base.x - ahead, y - this.base.y];
      return dx * ca + dy * sa > 0.1 && Math.abs(dx * sa - dy * ca) < BROAD;
    }).length, 0);
  }

  /** From where to look: the wanted side, or the one where it looks from, or the first one from which nobody hides the
   * robot and, as far as can be, everybody is in the picture. */
  side(wanted) {
    const sides = [wanted, this.other ?? wanted, ...ELSEWHERE].map((azimuth) => {
      return { azimuth, faults: 100 * this.hidden(azimuth) + this.framing(azimuth).missing };
    });
    const best = sides.reduce((found, one) => (one.faults < found.faults ? one : found)).azimuth;
    this.other = best === wanted ? null : best;
    return best;
  }

  /** The farthest by itself, in m: a narrow picture shows less, so from farther away. */
  get widest() {
    return WIDEST / Math.min(this.camera.aspect, 1);
  }

  /** What is framed from an azimuth (as `fit`), and how many persons are missing. */
  framing(azimuth) {
    const [{ points }, ...more] = this.framed;
    let best = this.fit(points, azimuth);
    let missing = more.filter(({ somebody }) => somebody).length;
    for (const [n, { somebody }] of more.entries()) {
      const wider = this.fit(this.framed.slice(0, n + 2).flatMap((group) => group.points), azimuth);
      if (wider.distance > this.widest * (somebody ? COMPANY : 1)) break;
      best = wider;
      missing -= somebody;
    }
    return { ...best, missing };
  }

  /** From where these points just fill the picture: the middle to look at, and the distance. */
  fit(points, azimuth = this.azimuth) {
    const middle = new THREE.Box3().setFromPoints(points).getCenter(new THREE.Vector3());
    const [right, up, back] = this.axes(azimuth);
    const high = Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2)) * 0.92;
    const wide = high * this.camera.aspect;
    let distance = NEAREST;
    for (const point of points) {
      const off = point.clone().sub(middle);
      distance = Math.max(distance, Math.max(Math.abs(off.dot(right)) / wide, Math.abs(off.dot(up)) / high) + off.dot(back));
    }
    return { middle, distance };
  }

  /** A part of the way to the framed view, as much as fits the time since the last one; whether there is any left. */
  settle(part) {
    const now = performance.now();
    const since = Math.min(now - (this.settled ?? now), 200);
    this.settled = now;
    if (this.byHand || this.held || !this.framed) return false;
    part ??= 1 - Math.exp(-since / EASE);
    const all = this.framed.flatMap(({ points }) => points);
    const beside = this.aside && this.fit(all, ASIDE).distance <= WIDEST;
    const turn = this.side(beside ? ASIDE : FRONT.azimuth) - this.azimuth;
    this.azimuth += turn * part;
    const { middle, distance } = this.framing(this.azimuth);
    const way = Math.abs(distance - this.distance) + middle.distanceTo(this.target) + Math.abs(turn);
    if (way < 0.004) return false;
    this.target.lerp(middle, part);
    this.distance += (distance - this.distance) * part;
    return true;
  }

  axes(azimuth = this.azimuth) {
    const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(this.elevation), Math.sin(this.elevation)];
    return [new THREE.Vector3(-sa, ca, 0), new THREE.Vector3(-ca * se, -sa * se, ce), new THREE.Vector3(ca * ce, sa * ce, se)];
  }

  place() {
    const back = this.axes()[2];
    this.camera.position.copy(this.target).addScaledVector(back, this.distance);
    this.camera.position.z = Math.max(this.camera.position.z, 0.03);
    this.camera.up.set(0, 0, 1);
    this.camera.lookAt(this.target);
  }

  turn(right, up) {
    this.azimuth -= right;
    this.elevation = Math.min(Math.max(this.elevation + up, -0.05), 1.45);
    this.byHand = true;
    this.changed();
  }

  zoom(factor) {
    this.distance = Math.min(Math.max(this.distance * factor, NEAREST), FARTHEST);
    this.byHand = true;
    this.changed();
  }

  down(element, event) {
    element.focus({ preventScroll: true });
    element.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  move(event) {
    const old = this.pointers.get(event.pointerId);
    if (!old) return;
    const spread = () => {
      const [a, b] = [...this.pointers.values()];
      return Math.hypot(a.x - b.x, a.y - b.y) || 1;
    };
    const now = { x: event.clientX, y: event.clientY };
    if (this.pointers.size === 1) {
      this.turn((now.x - old.x) * TURN, (now.y - old.y) * TURN);
      this.pointers.set(event.pointerId, now);
    } else if (this.pointers.size === 2) {
      const before = spread();
      this.pointers.set(event.pointerId, now);
      this.zoom(before / spread());
    }
  }

  // the page scrolls under the pointer unless the picture was chosen first
  wheel(element, event) {
    if (document.activeElement !== element && !event.ctrlKey) return;
    event.preventDefault();
    this.zoom(Math.exp(event.deltaY * (event.deltaMode ? 0.04 : 0.0012)));
  }

  key(event) {
    const keys = {
      ArrowLeft: () => this.turn(-STEP, 0), ArrowRight: () => this.turn(STEP, 0),
      ArrowUp: () => this.turn(0, STEP), ArrowDown: () => this.turn(0, -STEP),
      "+": () => this.zoom(0.85), "=": () => this.zoom(0.85), "-": () => this.zoom(1 / 0.85),
      0: () => this.front(), Home: () => this.front(),
    };
    const act = !event.ctrlKey && !event.metaKey && !event.altKey && keys[event.key];
    if (!act) return;
    event.preventDefault();
    event.stopPropagation();
    act();
  }
}
