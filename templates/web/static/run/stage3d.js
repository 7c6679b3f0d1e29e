// The drawn world, and the view on it. The robot moves from state to state, things come and go. It is drawn only when something
// has changed.

import { OrbitControls } from "../vendor/js/OrbitControls.js";
import * as THREE from "../vendor/js/three.module.js";
import { hasCalm } from "../preferences.js";
import { Body, turn } from "./body3d.js";
import { Drag } from "./drag3d.js";
import { Touch } from "./touch3d.js";
import { Room, same, shadows, thing } from "./scenery3d.js";

const MOST_PIXELS = 1.5; // per CSS pixel: more costs a weak laptop its 60 pictures a second and shows little
const HIGHEST = 1.25; // m: what is higher need not be in the picture
const NEAR = 2.3; // m from the robot: things farther away need not be in the picture
const LONGEST = 300; // ms, of the way from one state to the next
const AWAY = 2.62; // rad: how far somebody who looks away turns
const HELD = 1200; // ms after it was let go a thing is where one put it; by then the world has told that it is there
const SLOW = 28; // ms between two pictures: more than that often, and the picture is drawn coarser
const TOO_SLOW = 100; // ms for one picture: more than that, and the page rests before the next one
const LONGEST_REST = 250; // ms: some pictures a second are drawn even then

// of the view
const FRONT = -0.5; // rad: from the robot's right front
const ELEVATION = 0.2; // rad: a little from above
const [STEEPEST, LOWEST] = [0.12, 1.62]; // rad from straight above, to which one can turn
const ELSEWHERE = [-0.5, 0.8, -0.8, 1.05, 0.5, -1.05, 0, 0.3, -1.6, 1.6]; // rad: other sides, for when the robot is hidden, or somebody left out
const BROAD = 0.35; // m: half as wide as somebody is
const ASIDE = -1.05; // rad: when persons sit before the robot, they and it are seen from the side
const NEAREST = 0.45; // m
const FARTHEST = 6; // m
const WIDEST = 2.4; // m away at most by itself, if the picture is not narrow: the robot must stay large enough
const COMPANY = 1.15; // that much farther away, so that somebody is in the picture too
const KEY_TURN = 0.12; // rad, of an arrow key
const KEY_ZOOM = 0.85; // of the distance is left by plus
const DRAG_TURN = 0.008; // rad per pixel
const WHEEL_SPEED = 2.4; // of the wheel, which takes 5 % a notch at 1
const EASE = 260; // ms, of a third of the way to a new view

export class Stage {
  /** `hand` may move things: `limits` and what is told of it, see drag3d.js. */
  constructor(canvas, model, hand) {
    this.canvas = canvas;
    this.hand = hand;
    this.model = model;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, powerPreference: "low-power" });
    this.pixels = Math.min(window.devicePixelRatio || 1, MOST_PIXELS);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(30, 1, 0.05, 60);
    this.room = new Room(this.scene);
    this.body = new Body(model);
    this.scene.add(this.body.base);
    this.things = new Map(); // name → { object, from, to }
    this.kinds = {};
    this.shown = { joints: { ...model.rest } };
    this.drawn = 0; // pictures so far
    this.seen = true;
    this.late = 0;
    const again = () => this.ask();
    model.scene.again = again;
    this.ray = new THREE.Raycaster();
    this.drag = new Drag(this, hand.limits, hand);
    this.touch = new Touch(this);
    this.orbit = new Orbit(canvas, this.camera, again);
    this.paint();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.paint());
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    new IntersectionObserver(([entry]) => { this.seen = entry.isIntersecting; this.ask(); }).observe(canvas);
    document.addEventListener("visibilitychange", again);
    canvas.addEventListener("webglcontextrestored", again);
    this.aim();
    this.resize();
    this.orbit.settle(1);
  }

  /** The ray through a pointer; with `edge` (of the way from the middle) never beyond that. */
  rayTo({ clientX, clientY }, edge = 1) {
    const box = this.canvas.getBoundingClientRect();
    const within = (v) => Math.min(Math.max(v, -edge), edge);
    const point = new THREE.Vector2(within((clientX - box.left) / box.width * 2 - 1), within(1 - (clientY - box.top) / box.height * 2));
    this.ray.setFromCamera(point, this.camera);
    return this.ray;
  }

  paint() {
    this.room.theme(matchMedia("(prefers-color-scheme: dark)").matches);
    this.drag.colour(getComputedStyle(this.canvas).color);
    this.ask();
  }

  resize() {
    const { clientWidth: wide, clientHeight: high } = this.canvas.parentElement;
    if (!wide || !high) return;
    this.renderer.setPixelRatio(this.pixels);
    this.renderer.setSize(wide, high, false);
    this.camera.aspect = wide / high;
    this.camera.updateProjectionMatrix();
    this.orbit.settle(1);
    this.ask();
  }

  /** The kind of each thing by its name, as the scene says. */
  know(things) {
    this.kinds = Object.fromEntries(things.map(({ name, kind }) => [name, kind]));
  }

  /** A newer state of the world; it is reached smoothly, `atOnce` when it is the first of a run. */
  take({ joints, base, eyes, things, looks, light }, atOnce = false) {
    const now = performance.now();
    const gap = Math.min(Math.max(now - (this.newest ?? 0), 16), LONGEST);
    this.newest = now;
    this.way = atOnce || hasCalm() ? 1 : gap; // ms until it is reached: as long as the last one took to come
    this.began = now;
    this.from = { joints: { ...this.shown.joints }, position: this.body.base.position.clone(), turned: this.body.base.quaternion.clone() };
    this.to = { joints: joints ?? this.shown.joints, position: this.from.position.clone(), turned: this.from.turned.clone() };
    if (base) {
      this.to.position.set(base[0], base[1], base[2]);
      this.to.turned.setFromEuler(turn(base.slice(3)));
    }
    if (eyes) this.body.shine(eyes);
    if (light !== undefined && light !== this.room.share) this.room.light(light);
    if (things) this.put(things, looks ?? {});
    this.ask();
  }

  put(things, looks) {
    this.newest3d = { things, looks };
    for (const [name, { object, held }] of this.things) {
      if (name in things && (held || same(object, looks[name]))) continue;
      this.drag.gone(object);
      this.scene.remove(object);
      object.traverse((part) => { part.geometry?.dispose(); part.material?.dispose(); });
      this.things.delete(name);
    }
    for (const [name, at] of Object.entries(things)) {
      const to = new THREE.Vector3(...at);
      if (!this.things.has(name)) {
        const look = looks[name] ?? (this.kinds[name] === "person" ? { kind: "person" } : null);
        const object = thing(name, look, at[2], this.model);
        object.position.copy(to);
        this.scene.add(object);
        this.things.set(name, { object });
      }
      const entry = this.things.get(name);
      Object.assign(entry.object.userData, { away: Boolean(looks[name]?.away), turned: looks[name]?.turned ?? 0 });
      if (entry.held) continue;
      entry.from = entry.object.position.clone();
      if (entry.from.distanceTo(to) > 1) entry.from.copy(to); // it was put there, it did not fly
      entry.to = to;
    }
  }

  /** A thing is in somebody's hand: only that moves it, and the view stays. */
  hold(name) {
    const entry = this.things.get(name);
    clearTimeout(entry.timer);
    entry.held = true;
    this.orbit.held = true;
  }

  /** Put a held thing at a place. */
  shift(name, place) {
    const entry = this.things.get(name);
    entry.to = new THREE.Vector3(...place);
    entry.from = entry.to.clone();
    entry.object.position.copy(entry.to);
    this.face(entry.object);
    this.ask();
  }

  /** It is let go; soon it is again where the world says. */
  release(name) {
    const entry = this.things.get(name);
    this.orbit.held = false;
    this.orbit.byHand = true; // else the view would go away from where one put it
    this.ask();
    if (!entry) return;
    entry.timer = setTimeout(() => {
      entry.held = false;
      if (this.newest3d) this.take(this.newest3d);
    }, HELD);
  }

  // people look at the robot, or away
  face({ position, rotation, userData: { kind, away, turned } }) {
    rotation.z = kind === "person" ? Math.atan2(-position.y, -position.x) + (away ? AWAY : 0) : turned ?? 0;
  }

  /** Tell the view what should be in the picture. */
  aim() {
    const base = this.body.base.position;
    const height = this.model.height;
    const robot = [];
    for (const x of [-0.1, 0.14]) for (const y of [-0.17, 0.17]) for (const z of [0, height * 1.02]) robot.push(new THREE.Vector3(base.x + x, base.y + y, z));
    const far = ({ position }) => Math.hypot(position.x - base.x, position.y - base.y);
    const near = [...this.things.values()].map(({ object }) => object).filter((o) => o.userData.kind !== "wall" && far(o) < NEAR).sort((a, b) => far(a) - far(b));
    const around = ({ position: { x, y, z }, userData: { radius, tall, kind } }) => {
      const points = [];
      const heights = [Math.min(z, HIGHEST) - (tall > 0 ? 0 : radius), Math.min(z + (tall > 0 ? tall : radius), HIGHEST)];
      for (const dx of [-radius, radius]) for (const dy of [-radius, radius]) for (const at of heights) points.push(new THREE.Vector3(x + dx, y + dy, at));
      return { points, somebody: kind === "person" };
    };
    const groups = [{ points: robot, somebody: false }, ...near.map(around)];
    this.orbit.frame(groups, base, groups.some(({ somebody }) => somebody), this.hiding());
  }

  // those who can hide the robot
  hiding() {
    const tall = [...this.things.values()].filter(({ object }) => ["person", "wall"].includes(object.userData.kind));
    return tall.map(({ object: { position } }) => [position.x, position.y]);
  }

  /** Draw soon; where pictures take long, the page rests between them, so that it answers keys and clicks (Stop, above all). */
  ask() {
    if (this.asked || document.hidden || !this.seen) return;
    this.canvas.dataset.state = "moving";
    this.asked = true;
    if (this.rest) setTimeout(() => this.next(), this.rest);
    else this.next();
  }

  next() {
    requestAnimationFrame((time) => {
      this.asked = false;
      const more = this.step();
      this.measure(time, more);
      requestAnimationFrame((later) => { this.rest = later - time > TOO_SLOW ? Math.min(later - time, LONGEST_REST) : 0; });
      if (more) this.ask();
      else if (!this.asked) this.canvas.dataset.state = "still";
    });
  }

  // a slow machine gets a coarser picture
  measure(time, more) {
    this.late = this.last && time - this.last > SLOW ? this.late + 1 : Math.max(0, this.late - 1);
    this.last = more ? time : 0;
    if (this.late < 25 || this.pixels <= 0.75) return;
    this.late = 0;
    this.pixels = Math.max(0.75, this.pixels * 0.75);
    this.resize();
  }

  step() {
    let more = false;
    if (this.to) {
      const part = Math.min((performance.now() - this.began) / this.way, 1);
      const { joints } = this.to;
      for (const name of Object.keys(joints)) {
        const old = this.from.joints[name] ?? joints[name];
        this.shown.joints[name] = old + (joints[name] - old) * part;
      }
      this.body.pose(this.shown.joints);
      this.body.base.position.lerpVectors(this.from.position, this.to.position, part);
      this.body.base.quaternion.slerpQuaternions(this.from.turned, this.to.turned, part);
      for (const { object, from, to } of this.things.values()) {
        if (!to) continue;
        object.position.lerpVectors(from, to, part);
        this.face(object);
      }
      if (part >= 1) this.to = null;
      more = part < 1;
    }
    this.orbit.pointed = Boolean(this.drag.marked || this.touch.shown);
    this.aim();
    if (this.orbit.settle()) more = true;
    this.draw();
    return more;
  }

  draw() {
    this.scene.updateMatrixWorld();
    this.room.shadow(shadows(this.body, [...this.things.values()].map(({ object }) => object)));
    this.renderer.render(this.scene, this.camera);
    this.touch.place();
    this.hand.drawn?.();
    this.drawn += 1;
    this.canvas.dataset.drawn = this.drawn; // for the tests: how often it was drawn
  }
}

// Looking around a scene: drag, wheel or pinch, keys. It frames what it is told to until somebody turns it by hand.

export class Orbit extends OrbitControls {
  constructor(element, camera, changed) {
    camera.up.set(0, 0, 1); // the controls read it once
    super(camera, element);
    Object.assign(element.style, { touchAction: "", cursor: "" }); // as the style sheet says: a finger may scroll the page
    Object.assign(this, { enablePan: false, minDistance: NEAREST, maxDistance: FARTHEST, minPolarAngle: STEEPEST, maxPolarAngle: LOWEST });
    this.distance = 0; // this and the azimuth are of the framed view
    this.changed = changed;
    this.held = false; // while something is dragged, the view stays as it is
    this.pointed = false; // and while the pointer is on something that can be pressed
    this.front();
    this.addEventListener("change", () => {
      camera.position.z = Math.max(camera.position.z, 0.03); // not below the floor
      this.byHand = true;
      changed();
    });
    const first = { capture: true }; // before the controls
    element.addEventListener("pointerdown", () => {
      element.focus({ preventScroll: true });
      this.rotateSpeed = DRAG_TURN * element.clientHeight / (2 * Math.PI); // at 1 the height of the picture is a whole turn
      Object.assign(this, { enableZoom: true, zoomSpeed: 1 }); // two fingers stay on what they are on
    }, first);
    element.addEventListener("wheel", ({ ctrlKey }) => {
      // the page scrolls under the pointer unless the picture was chosen first
      Object.assign(this, { enableZoom: ctrlKey || document.activeElement === element, zoomSpeed: WHEEL_SPEED });
    }, first);
    element.addEventListener("keydown", (event) => this.key(event));
    element.addEventListener("dblclick", () => this.front());
  }

  /** The view from the front; from then on it frames things by itself again. */
  front() {
    this.azimuth = FRONT;
    this.other = null; // the side to look from when somebody stands in the way, or would not be in the picture
    this.byHand = false;
    if (this.framed) this.settle(1);
    this.changed();
  }

  /** Frame these groups, each with `points` and whether it is `somebody`: the first always, the others in their order
   * while it can stay near enough. */
  frame(groups, base, aside, hiding = []) {
    if (this.base && (this.byHand || this.pointed)) { // it goes along
      const way = base.clone().sub(this.base).setZ(0);
      for (const place of [this.target, this.object.position]) place.add(way);
    }
    this.base = base.clone();
    this.framed = groups;
    this.aside = aside;
    this.hiding = hiding;
  }

  /** The number of those who stand there (x, y) that hide the robot, or what it has before it, seen from an azimuth. */
  hidden(azimuth) {
    const [ca, sa] = [Math.cos(azimuth), Math.sin(azimuth)];
    return [0, 0.5].reduce((sum, ahead) => sum + this.hiding.filter(([x, y]) => {
      const [dx, dy] = [x - this.base.x - ahead, y - this.base.y];
      return dx * ca + dy * sa > 0.1 && Math.abs(dx * sa - dy * ca) < BROAD;
    }).length, 0);
  }

  /** The azimuth to look from: the wanted side, or the one where it looks from, or the first one from which nobody hides the
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
    return WIDEST / Math.min(this.object.aspect, 1);
  }

  /** The frame from an azimuth (as `fit`), and the number of persons who are missing in it. */
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

  /** The view in which these points just fill the picture: the middle to look at, and the distance. */
  fit(points, azimuth) {
    const middle = new THREE.Box3().setFromPoints(points).getCenter(new THREE.Vector3());
    const [right, up, back] = this.axes(azimuth);
    const high = Math.tan(THREE.MathUtils.degToRad(this.object.fov / 2)) * 0.92;
    const wide = high * this.object.aspect;
    let distance = NEAREST;
    for (const point of points) {
      const off = point.clone().sub(middle);
      distance = Math.max(distance, Math.max(Math.abs(off.dot(right)) / wide, Math.abs(off.dot(up)) / high) + off.dot(back));
    }
    return { middle, distance };
  }

  /** A part of the way to the framed view, as much as fits the time since the last one; true if there is any left. */
  settle(part) {
    const now = performance.now();
    const since = Math.min(now - (this.settled ?? now), 200);
    this.settled = now;
    if (this.byHand || this.held || this.pointed || !this.framed) return false;
    part ??= 1 - Math.exp(-since / EASE);
    const all = this.framed.flatMap(({ points }) => points);
    const beside = this.aside && this.fit(all, ASIDE).distance <= WIDEST;
    const turn = this.side(beside ? ASIDE : FRONT) - this.azimuth;
    this.azimuth += turn * part;
    const { middle, distance } = this.framing(this.azimuth);
    const way = Math.abs(distance - this.distance) + middle.distanceTo(this.target) + Math.abs(turn);
    const more = way >= 0.004;
    if (more) {
      this.target.lerp(middle, part);
      this.distance += (distance - this.distance) * part;
    }
    this.object.position.copy(this.target).addScaledVector(this.axes(this.azimuth)[2], this.distance);
    this.object.lookAt(this.target);
    return more;
  }

  /** Right, up and back of the framed view from an azimuth. */
  axes(azimuth) {
    const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(ELEVATION), Math.sin(ELEVATION)];
    return [new THREE.Vector3(-sa, ca, 0), new THREE.Vector3(-ca * se, -sa * se, ce), new THREE.Vector3(ca * ce, sa * ce, se)];
  }

  key(event) {
    const keys = {
      ArrowLeft: () => this.rotateLeft(-KEY_TURN), ArrowRight: () => this.rotateLeft(KEY_TURN),
      ArrowUp: () => this.rotateUp(KEY_TURN), ArrowDown: () => this.rotateUp(-KEY_TURN),
      "+": () => this.dollyIn(KEY_ZOOM), "=": () => this.dollyIn(KEY_ZOOM), "-": () => this.dollyOut(KEY_ZOOM),
      0: () => this.front(), Home: () => this.front(),
    };
    const act = !event.ctrlKey && !event.metaKey && !event.altKey && keys[event.key];
    if (!act) return;
    event.preventDefault();
    event.stopPropagation();
    act();
  }
}
