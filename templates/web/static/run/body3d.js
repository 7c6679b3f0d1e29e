// A robot's model as three.js objects: links, joints and what they look like. Metres, radians, z is up, x is ahead.

import * as THREE from "../vendor/js/three.module.js";

const DARK_EYE = 0.12; // what an eye that is off looks like

export class Body {
  constructor(model) {
    this.model = model;
    this.base = new THREE.Group();
    this.links = new Map();
    this.joints = new Map(); // name → { node, fixed: its orientation at 0, axis }
    this.eyes = new THREE.MeshStandardMaterial({ color: 0x222222, emissive: 0xffffff, roughness: 0.4 });
    const meshes = Object.fromEntries(Object.entries(model.meshes).map(([name, mesh]) => [name, solid(mesh)]));
    const paints = new Map();
    for (const link of model.links) {
      const node = new THREE.Group();
      for (const visual of link.visuals) node.add(shape(visual, meshes, this.paint(link, visual, paints)));
      this.links.set(link.name, node);
    }
    for (const joint of model.joints) this.join(joint);
    const children = new Set(model.joints.map((j) => j.child));
    for (const [name, node] of this.links) if (!children.has(name)) this.base.add(node);
    this.shine([1, 1, 1]);
    this.rest();
  }

  paint(link, visual, paints) {
    if (this.model.eyes.includes(link.name)) return this.eyes;
    const key = visual.colour.join();
    if (!paints.has(key)) {
      const colour = new THREE.Color().setRGB(...visual.colour, THREE.SRGBColorSpace);
      paints.set(key, new THREE.MeshStandardMaterial({ color: colour, roughness: 0.55, metalness: 0 }));
    }
    return paints.get(key);
  }

  join({ name, parent, child, xyz, rpy, axis }) {
    const node = new THREE.Group();
    node.position.set(...xyz);
    node.quaternion.setFromEuler(turn(rpy));
    node.add(this.links.get(child));
    this.links.get(parent).add(node);
    this.joints.set(name, { node, fixed: node.quaternion.clone(), axis: new THREE.Vector3(...axis).normalize() });
  }

  /** Angles by joint name. */
  pose(angles) {
    for (const [name, angle] of Object.entries(angles)) this.set(name, angle);
    for (const [name, of] of Object.entries(this.model.follow)) if (of in angles) this.set(name, angles[of]);
  }

  set(name, angle) {
    const joint = this.joints.get(name);
    if (joint) joint.node.quaternion.copy(joint.fixed).multiply(spin.setFromAxisAngle(joint.axis, angle));
  }

  /** Red, green, blue, 0 to 1. */
  shine(rgb) {
    this.eyes.emissive.setRGB(...rgb.map((c) => DARK_EYE + (1 - DARK_EYE) * c), THREE.SRGBColorSpace);
  }

  /** The posture it starts in, with its feet flat on the floor at the origin. */
  rest() {
    this.stand(this.model.rest);
  }

  /** With these angles (others as they were) it stands with its feet flat on the floor at the origin. */
  stand(angles) {
    this.base.position.set(0, 0, 0);
    this.base.quaternion.identity();
    this.pose(angles);
    this.base.updateMatrixWorld(true);
    const foot = this.feet()[0];
    this.base.quaternion.copy(foot.getWorldQuaternion(new THREE.Quaternion()).invert());
    this.base.updateMatrixWorld(true);
    const place = foot.getWorldPosition(new THREE.Vector3());
    this.base.position.set(-place.x, 0, -new THREE.Box3().setFromObject(this.base).min.z);
    this.base.updateMatrixWorld(true);
  }

  /** The links it stands on: the two lowest ends when it stands upright. */
  feet() {
    if (!this.stands) {
      const parents = new Set(this.model.joints.map((j) => j.parent));
      const ends = [...this.links].filter(([name]) => !parents.has(name)).map(([, node]) => node);
      const height = (node) => node.getWorldPosition(new THREE.Vector3()).z;
      this.stands = ends.sort((a, b) => height(a) - height(b)).slice(0, 2);
    }
    return this.stands;
  }
}

const spin = new THREE.Quaternion();

/** Roll, pitch and yaw as URDF means them: about the fixed axes x, y, z. */
export function turn([roll, pitch, yaw]) {
  return new THREE.Euler(roll, pitch, yaw, "ZYX");
}

function solid({ points, normals, faces }) {
  const made = new THREE.BufferGeometry();
  made.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  made.setAttribute("normal", new THREE.Float32BufferAttribute(normals, 3));
  made.setIndex(faces);
  return rounded(made);
}

/** Each triangle as four, the new points lifted to where the normals say the surface bulges: smooth outlines. */
function rounded(geometry) {
  const at = geometry.getAttribute("position");
  const out = geometry.getAttribute("normal");
  const points = [...at.array];
  const normals = [...out.array];
  const faces = [];
  const halves = new Map();
  const vector = (attribute, i) => new THREE.Vector3().fromBufferAttribute(attribute, i);
  const half = (a, b) => {
    const key = a < b ? `${a},${b}` : `${b},${a}`;
    if (!halves.has(key)) {
      const [p, q, n, m] = [vector(at, a), vector(at, b), vector(out, a), vector(out, b)];
      const way = q.clone().sub(p);
      const middle = p.clone().add(q).multiplyScalar(0.5);
      middle.addScaledVector(n, -way.dot(n) / 8).addScaledVector(m, way.dot(m) / 8);
      const normal = n.clone().add(m).normalize();
      halves.set(key, points.length / 3);
      points.push(middle.x, middle.y, middle.z);
      normals.push(normal.x, normal.y, normal.z);
    }
    return halves.get(key);
  };
  const index = geometry.getIndex();
  for (let i = 0; i < index.count; i += 3) {
    const [a, b, c] = [index.getX(i), index.getX(i + 1), index.getX(i + 2)];
    const [d, e, f] = [half(a, b), half(b, c), half(c, a)];
    faces.push(a, d, f, d, b, e, f, e, c, d, e, f);
  }
  const made = new THREE.BufferGeometry();
  made.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  made.setAttribute("normal", new THREE.Float32BufferAttribute(normals, 3));
  made.setIndex(faces);
  return made;
}

function shape(visual, meshes, material) {
  const [a, b, c] = visual.size;
  const makers = {
    mesh: () => meshes[visual.mesh],
    box: () => new THREE.BoxGeometry(a, b, c),
    sphere: () => new THREE.SphereGeometry(a, 32, 20),
    cylinder: () => new THREE.CylinderGeometry(a, a, b, 32).rotateX(Math.PI / 2),
  };
  const made = new THREE.Mesh(makers[visual.shape](), material);
  if (visual.shape === "mesh") made.scale.set(a, b, c);
  made.position.set(...visual.xyz);
  made.quaternion.setFromEuler(turn(visual.rpy));
  return made;
}
