// Things of the scene that are dragged in the picture: a ball to where the pointer is, in the plane that faces the
// viewer; a person along the floor. Elsewhere a drag turns the view (stage3d.js).

import * as THREE from "../vendor/js/three.module.js";

const FINGER = 26;
const MOUSE = 12; // pixels beside a thing that are still it
export const STEADY = 4; // px that a pointer may move and still clicks
const DEEPER = 0.001; // of the way from the viewer to the thing, per pixel of the wheel
const EDGE = 0.94; // of the way from the middle of the picture to its edge

export class Drag {
  /** `stage` has the things, the camera and the view; `limits` are the least and most of x, y and z in metres; `told` has
   * `held(name)` (null: it cannot be moved now), `moved(name, place, whether it can go no farther)`, `dropped(name)`, and
   * `chosen(name)` for one that was only clicked (null: none of them was). */
  constructor(stage, limits, told) {
    Object.assign(this, { stage, limits, told, element: stage.canvas, camera: stage.camera });
    const { element } = this;
    this.on = false; // whether things can be moved now
    this.grip = null; // what is held: { name, object, pointer, plane, off, limits }
    this.lines = new Map(); // object → its outline's parts
    this.paint = outline();
    const first = { capture: true }; // before the view is turned
    element.addEventListener("pointerdown", (event) => this.down(event), first);
    element.addEventListener("pointermove", (event) => this.move(event), first);
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
      element.addEventListener(name, (event) => this.up(event), first);
    }
    element.addEventListener("pointerleave", () => this.grip || this.mark(null));
    element.addEventListener("wheel", (event) => this.wheel(event), { capture: true, passive: false });
    // a finger on a thing moves the thing and not the page
    element.addEventListener("touchstart", (event) => this.grip && event.preventDefault(), { passive: false });
  }

  /** Allow or forbid the moving of things. */
  allow(on) {
    this.on = on;
    if (on) return;
    this.drop();
    this.mark(null);
  }

  /** A thing has gone. */
  gone(object) {
    this.lines.delete(object);
    if (this.marked === object) this.mark(null);
    if (this.grip?.object === object) this.drop();
  }

  down(event) {
    if (this.grip) return this.second(event);
    if (event.button !== 0 || this.stage.orbit.state >= 0) return undefined; // a turn of the view goes on
    const name = this.under(event);
    if (!name) return this.told.chosen?.(null);
    if (!this.on) return this.told.held(null);
    event.stopImmediatePropagation();
    this.element.focus({ preventScroll: true });
    this.element.setPointerCapture(event.pointerId);
    const { object } = this.stage.things.get(name);
    const at = object.position.toArray();
    this.grip = {
      name, object, pointer: event.pointerId, at: object.position.clone(), begun: event, last: { x: event.clientX, y: event.clientY },
      fingers: { [event.pointerId]: event }, gap: 0,
      limits: this.limits.map(([least, most], i) => [Math.min(least, at[i]), Math.max(most, at[i])]), // it does not jump
    };
    this.take(event);
    this.mark(name);
    this.stage.hold(name);
    this.told.held(name);
    return undefined;
  }

  /** Take the thing where it is now: from the pointer to its middle stays as it is. */
  take(event) {
    const facing = this.camera.getWorldDirection(new THREE.Vector3());
    const { object } = this.grip;
    this.grip.plane = new THREE.Plane().setFromNormalAndCoplanarPoint(facing, object.position);
    this.grip.off = object.position.clone().sub(this.meet(event) ?? object.position);
  }

  /** The point where the pointer meets the plane of what is held. */
  meet(event) {
    this.aim(event);
    return this.ray.ray.intersectPlane(this.grip.plane, new THREE.Vector3());
  }

  move(event) {
    if (!this.grip) {
      if (event.pointerType === "mouse" && !event.buttons) this.mark(this.on ? this.under(event) : null);
      return;
    }
    event.stopImmediatePropagation();
    const { object, fingers } = this.grip;
    if (event.pointerId in fingers) fingers[event.pointerId] = event;
    if (this.grip.gap) return this.pinch();
    if (event.pointerId !== this.grip.pointer) return;
    const { begun } = this.grip;
    if (begun && Math.hypot(event.clientX - begun.clientX, event.clientY - begun.clientY) < STEADY) return;
    this.grip.begun = null; // it is dragged
    const wish = object.userData.ball ? this.meet(event)?.add(this.grip.off) : this.along(event);
    if (wish) this.go(wish);
  }

  /** A second finger: from now on both say how near the thing is. */
  second(event) {
    event.stopImmediatePropagation();
    const { object, fingers, gap } = this.grip;
    if (gap || !object.userData.ball) return;
    fingers[event.pointerId] = event;
    this.grip.gap = this.apart();
  }

  apart() {
    const [one, other] = Object.values(this.grip.fingers);
    return Math.max(Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY), 1);
  }

  // fingers apart: nearer, as if it were drawn larger
  pinch() {
    const apart = this.apart();
    const eye = this.camera.position;
    const share = Math.min(Math.max(this.grip.gap / apart, 0.8), 1.25);
    this.grip.gap = apart;
    this.go(this.grip.object.position.clone().sub(eye).multiplyScalar(share).add(eye));
  }

  up({ pointerId }) {
    if (pointerId === this.grip?.pointer) this.drop();
    else if (this.grip?.gap && pointerId in this.grip.fingers) {
      delete this.grip.fingers[pointerId];
      this.grip.gap = 0;
      this.take(this.grip.fingers[this.grip.pointer]);
    }
  }

  /** The next place of a person: aside as the pointer goes, and away from the viewer as it goes up, on the floor. */
  along(event) {
    const { at, last } = this.grip;
    const from = this.meet({ clientX: last.x, clientY: last.y });
    const to = this.meet(event);
    this.grip.last = { x: event.clientX, y: event.clientY };
    if (!from || !to) return null;
    const way = to.sub(from);
    const away = this.camera.getWorldDirection(new THREE.Vector3()).setZ(0).normalize();
    const right = new THREE.Vector3(away.y, -away.x, 0);
    const up = new THREE.Vector3(0, 1, 0).applyQuaternion(this.camera.quaternion);
    return at.addScaledVector(right, way.dot(right)).addScaledVector(away, way.dot(up)).clone();
  }

  go(wish) {
    const { name, limits } = this.grip;
    const wanted = wish.toArray();
    const place = wanted.map((v, i) => Math.min(Math.max(v, limits[i][0]), limits[i][1]));
    const most = place.some((v, i) => Math.abs(v - wanted[i]) > 0.005);
    this.stage.shift(name, place);
    this.told.moved(name, place, most);
  }

  // nearer and farther, under the pointer
  wheel(event) {
    if (!this.grip) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (!this.grip.object.userData.ball) return;
    const eye = this.camera.position;
    const pixels = Math.max(-120, Math.min(120, event.deltaY * (event.deltaMode ? 33 : 1)));
    this.go(this.grip.object.position.clone().sub(eye).multiplyScalar(1 - pixels * DEEPER).add(eye));
    this.take(event);
  }

  drop() {
    if (!this.grip) return;
    const { name, pointer, begun } = this.grip;
    this.grip = null;
    if (this.element.hasPointerCapture(pointer)) this.element.releasePointerCapture(pointer);
    this.stage.release(name);
    this.told.dropped(name);
    if (begun) this.told.chosen?.(name);
  }

  /** Aim at what is under the pointer: what is dragged stays in the picture. */
  aim(event) {
    this.ray = this.stage.rayTo(event, EDGE);
  }

  /** The name of the thing under the pointer or just beside it, that the robot does not hide. */
  under(event) {
    this.aim(event);
    const ray = this.ray.ray;
    const pixel = 2 * Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2)) / this.element.clientHeight; // at 1 m
    const slack = pixel * (event.pointerType === "touch" ? FINGER : MOUSE);
    let best = null;
    for (const [name, { object }] of this.stage.things) {
      const { radius, tall } = object.userData;
      const head = object.position;
      const foot = head.clone().setZ(head.z + (tall ?? 0)); // the other end of it
      const far = head.distanceTo(ray.origin);
      const beside = Math.max(Math.sqrt(ray.distanceSqToSegment(foot, head)) - radius, 0);
      if (beside < slack * far && (!best || beside < best.beside || (beside === best.beside && far < best.far))) best = { name, beside, far };
    }
    if (!best) return null;
    const [front] = this.ray.intersectObject(this.stage.body.base, true);
    return front && front.distance < best.far - 0.1 ? null : best.name;
  }

  /** Outline this thing, and show that it can be taken. */
  mark(name) {
    const object = name ? this.stage.things.get(name)?.object ?? null : null;
    if (object === (this.marked ?? null)) return;
    for (const part of this.lines.get(this.marked) ?? []) part.visible = false;
    this.marked = object;
    this.element.classList.toggle("on-thing", Boolean(object));
    if (object && !this.lines.has(object)) this.lines.set(object, wrap(object, this.paint));
    for (const part of this.lines.get(object) ?? []) part.visible = true;
    this.stage.ask();
  }

  /** The outline's colour. */
  colour(css) {
    this.paint.uniforms.colour.value.setStyle(css, THREE.LinearSRGBColorSpace);
  }
}

const LINE = 0.004; // of its width, as part of the distance

/** Put the outline around a thing; its parts, which can be hidden. */
function wrap(object, paint) {
  const meshes = [];
  object.traverse((part) => part.isMesh && meshes.push(part));
  return meshes.map((mesh) => {
    const line = new THREE.Mesh(mesh.geometry, paint);
    mesh.add(line);
    return line;
  });
}

/** The same shape, a little larger, of which only the inside is seen. */
function outline() {
  return new THREE.ShaderMaterial({
    side: THREE.BackSide,
    uniforms: { colour: { value: new THREE.Color() }, wide: { value: LINE } },
    vertexShader: `
uniform float wide;
void main() {
  vec4 place = modelViewMatrix * vec4(position, 1.0);
  place.xyz += normalize(normalMatrix * normal) * wide * -place.z;
  gl_Position = projectionMatrix * place;
}`,
    fragmentShader: "uniform vec3 colour; void main() { gl_FragColor = vec4(colour, 1.0); }",
  });
}
