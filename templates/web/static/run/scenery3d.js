// The surroundings of the robot: room, things, people. The room is a pale floor with lines, a rug, soft shadows, light. It looks like
// the film of a run (rrp_sheets/sim/camera.py).

import * as THREE from "../vendor/js/three.module.js";

const MOST_SHADOWS = 24;
const DARKEST = 0.3; // of the light of a bright room
const LOOKS = {
  light: { wall: [236, 238, 240], ground: [206, 205, 202], rug: [176, 194, 204], edge: [226, 232, 236], line: 0.87, shade: 1 },
  dark: { wall: [27, 31, 35], ground: [50, 54, 58], rug: [44, 62, 74], edge: [86, 106, 120], line: 1.35, shade: 1.6 },
};

// of things: lengths in m; colours of red, green and blue
const WOOD = [0.8, 0.68, 0.52];
const LEG = [0.64, 0.54, 0.42];
const PLASTER = [0.8, 0.82, 0.8];
const TOP = 0.025; // a table's, how thick
const THIN = 0.035; // a table's legs, how thick
const MAKE = { ball, cup, box, table, wall }; // by kind

// of people, the same
const CLOTHES = [[0.42, 0.6, 0.62], [0.76, 0.64, 0.46], [0.6, 0.52, 0.68], [0.5, 0.62, 0.46]];
const TROUSERS = [[0.44, 0.46, 0.52], [0.5, 0.46, 0.42], [0.4, 0.44, 0.44], [0.52, 0.5, 0.54]];
const HAIR = [[0.34, 0.25, 0.2], [0.62, 0.5, 0.36], [0.2, 0.18, 0.18], [0.5, 0.34, 0.26]];
const SKIN = [0.93, 0.78, 0.68];
const SHOE = [0.34, 0.33, 0.33];
const HEAD = 0.105; // m, half its height
const STANDS = 0.85; // m: a face higher than that belongs to somebody who stands
const AROUND = 32; // parts of a drawn head's outline

// of the room
const VERTEX = `
varying vec3 place;
void main() {
  place = (modelMatrix * vec4(position, 1.0)).xyz;
  gl_Position = projectionMatrix * viewMatrix * vec4(place, 1.0);
}`;

const FRAGMENT = `
varying vec3 place;
uniform vec3 wall, ground, rug, edge;
uniform float line, shade, part;
uniform vec4 shadows[${MOST_SHADOWS}];
float stripe(float c, float blur) {
  float off = abs(c / 0.5 - floor(c / 0.5 + 0.5)) * 0.5;
  return clamp(1.0 - off / blur, 0.0, 1.0) * 0.006 / (blur + 0.004);
}
void main() {
  float away = distance(cameraPosition, place);
  float blur = length(fwidth(place.xy)) + 0.004;
  float lines = max(stripe(place.x, blur), stripe(place.y, blur));
  vec3 colour = ground * mix(1.0, line, min(lines, 1.0));
  float radius = length(place.xy);
  float border = clamp(1.0 - abs(radius - 0.79) / (0.012 + blur), 0.0, 1.0);
  colour = mix(colour, mix(rug, edge, border), clamp((0.85 - radius) / blur + 0.5, 0.0, 1.0));
  for (int i = 0; i < ${MOST_SHADOWS}; i++) {
    vec2 off = place.xy - shadows[i].xy;
    colour *= 1.0 - min(0.9, shade * shadows[i].w * exp(-dot(off, off) / (2.0 * shadows[i].z * shadows[i].z)));
  }
  gl_FragColor = vec4(part * mix(wall, colour, exp(-max(away - 1.2, 0.0) / 5.0)), 1.0);
}`;

export class Room {
  constructor(scene) {
    this.scene = scene;
    const colour = () => ({ value: new THREE.Color() });
    this.paint = new THREE.ShaderMaterial({
      uniforms: {
        wall: colour(), ground: colour(), rug: colour(), edge: colour(), line: { value: 1 }, shade: { value: 1 }, part: { value: 1 },
        shadows: { value: Array.from({ length: MOST_SHADOWS }, () => new THREE.Vector4(0, 0, 1, 0)) },
      },
      vertexShader: VERTEX, fragmentShader: FRAGMENT,
    });
    const floor = new THREE.Mesh(new THREE.PlaneGeometry(60, 60), this.paint);
    scene.add(floor);
    this.sky = new THREE.HemisphereLight(0xffffff, 0xa8a6a2, 1.7);
    this.sky.position.set(0, 0, 1);
    this.sun = new THREE.DirectionalLight(0xffffff, 1.5);
    this.sun.position.set(0.9, -1.6, 2.5);
    scene.add(this.sky, this.sun);
  }

  theme(dark) {
    const look = LOOKS[dark ? "dark" : "light"];
    const uniforms = this.paint.uniforms;
    const rgb = (c) => new THREE.Color(...c.map((v) => v / 255));
    for (const name of ["wall", "ground", "rug", "edge"]) uniforms[name].value.copy(rgb(look[name]));
    uniforms.line.value = look.line;
    uniforms.shade.value = look.shade;
    this.scene.background = new THREE.Color().setRGB(...look.wall.map((v) => v / 255), THREE.SRGBColorSpace);
    this.bright = { sky: dark ? 1.4 : 1.75, sun: 1.5, wall: this.scene.background.clone() };
    this.light(this.share ?? 1);
  }

  /** Set the brightness of the room, 0 to 1; a dark one is still to be seen. */
  light(share) {
    this.share = share;
    const part = DARKEST + (1 - DARKEST) * share;
    this.sky.intensity = this.bright.sky * part;
    this.sun.intensity = this.bright.sun * part;
    this.scene.background.copy(this.bright.wall).multiplyScalar(part);
    this.paint.uniforms.part.value = part;
  }

  /** Soft shadows on the floor: (x, y, radius, darkness). */
  shadow(list) {
    const places = this.paint.uniforms.shadows.value;
    places.forEach((place, i) => (i < list.length ? place.set(...list[i]) : place.set(0, 0, 1, 0)));
  }
}

/** The shadows of the robot and of things, each x, y, its radius and how dark it is. */
export function shadows(body, things) {
  const place = new THREE.Vector3();
  const found = body.feet().map((foot) => {
    foot.getWorldPosition(place);
    return [place.x + 0.03, place.y, 0.055, 0.38 / (1 + 8 * Math.max(place.z - 0.05, 0))];
  });
  const base = body.base.position;
  found.push([base.x - 0.03, base.y + 0.03, 0.16, 0.22]);
  for (const { position: { x, y, z }, userData: { kind, radius } } of things) {
    if (kind === "ball") found.push([x - 0.1 * z, y + 0.1 * z, radius * (0.9 + z), 0.45 / (1 + 2 * z)]);
    else if (kind === "person") found.push([x, y, 0.18, 0.45]);
    else if (kind !== "wall") found.push([x, y, radius * 1.3, (kind === "table" ? 0.25 : 0.4) / (1 + 4 * z)]);
  }
  return found;
}

// The things around the robot: balls, cups, boxes, tables, walls, people. They look like those of a run's film
// (rrp_sheets/sim/shapes.py, things.py, people.py). Lengths in metres.

/** A thing as the world tells that it looks; until it has told, as its name and kind do. */
export function thing(name, look, height, model) {
  const kind = look?.kind ?? (/ball/i.test(name) ? "ball" : "person");
  const made = kind === "person" ? person(name, look?.height ?? height, look, model) : (MAKE[kind] ?? ball)(look ?? {}, name, model.scene);
  Object.assign(made.userData, { kind, ball: kind === "ball", look: JSON.stringify(look ?? null) });
  return made;
}

/** True when a thing still looks as it was drawn. */
export const same = (object, look) => !look || object.userData.look === JSON.stringify(look);

function ball({ size, colour }, name, scene) {
  const radius = (size?.[0] ?? scene.ball) / 2;
  const words = name.toLowerCase();
  const named = Object.keys(scene.colours).filter((c) => words.includes(c)).sort((a, b) => b.length - a.length);
  const made = new THREE.Mesh(new THREE.SphereGeometry(radius, 32, 20), paint(rgb(colour || named[0] || "grey", scene), 0.35));
  made.userData = { radius, tall: 0 };
  return made;
}

function cup({ size: [wide, , high], colour }, name, scene) {
  const r = wide / 2;
  const outline = [[0.001, 0], [r * 0.72, 0], [r * 0.76, high * 0.04], [r, high], [r * 0.93, high], [r * 0.68, high * 0.08], [0.001, high * 0.08]];
  const lathe = new THREE.LatheGeometry(outline.map(([x, y]) => new THREE.Vector2(x, y)), 32);
  const shape = new THREE.Mesh(lathe, paint(rgb(colour, scene), 0.5));
  shape.material.side = THREE.DoubleSide;
  shape.rotation.x = Math.PI / 2;
  return group([shape], r, high);
}

function box({ size, colour }, name, scene) {
  return group([block(size, rgb(colour, scene), [0, 0, size[2] / 2])], Math.min(size[0], size[1]) / 2, size[2]);
}

function wall({ size }) {
  return group([block(size, PLASTER, [0, 0, size[2] / 2])], size[0] / 2, size[2]);
}

function table({ size: [deep, wide, high] }) {
  const legs = [[1, 1], [1, -1], [-1, 1], [-1, -1]].map(([x, y]) => {
    const under = high - TOP;
    return block([THIN, THIN, under], LEG, [x * (deep / 2 - THIN), y * (wide / 2 - THIN), under / 2]);
  });
  return group([block([deep, wide, TOP], WOOD, [0, 0, high - TOP / 2]), ...legs], Math.min(deep, wide) / 2, high);
}

function group(parts, radius, tall) {
  const made = new THREE.Group();
  made.add(...parts);
  made.userData = { radius, tall };
  return made;
}

function block(size, colour, place) {
  const made = new THREE.Mesh(new THREE.BoxGeometry(...size), paint(colour, 0.9));
  made.position.set(...place);
  return made;
}

function rgb(colour, scene) {
  const hex = /^#([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})$/i.exec(colour ?? "");
  return hex ? hex.slice(1).map((two) => parseInt(two, 16) / 255) : scene.colours[colour] ?? scene.colours.grey;
}

function paint(colour, roughness) {
  return new THREE.MeshStandardMaterial({ color: new THREE.Color().setRGB(...colour, THREE.SRGBColorSpace), roughness });
}

// People, seated on the floor or standing, as rrp_sheets/sim/people.py makes them. The origin is the middle of the
// face; they look along x.

/** Somebody with the face at a height above the floor. */
function person(name, height, look, model) {
  const { seated, number } = look ?? {};
  const face = faceOf(look, model);
  const skin = face?.skin ?? SKIN;
  const letters = [...name].reduce((sum, letter) => (sum * 31 + letter.codePointAt(0)) % 9973, 7);
  const which = ((number ?? letters) + CLOTHES.length - 1) % CLOTHES.length;
  const made = new THREE.Group();
  const body = new THREE.Group(); // from the floor
  body.position.z = -height;
  made.add(body);
  const neck = height - 1.1 * HEAD;
  (seated ?? height < STANDS ? sit : stand)(body, neck, CLOTHES[which], TROUSERS[which], skin);
  if (face) head(made, look, model, round);
  else plain(made, HAIR[which]);
  made.userData = { radius: 0.1, tall: -height };
  return made;
}

function sit(body, neck, clothes, trousers, skin) {
  const wide = 0.27 * neck + 0.02;
  torso(body, clothes, 0.02, neck, wide);
  const thick = 0.105 * neck + 0.01;
  for (const side of [1, -1]) {
    const [hip, knee] = [[-0.02, side * 0.55 * wide, thick], [0.44 * neck, side * 1.35 * wide, thick * 1.05]];
    const ankle = [0.36 * neck, -side * 0.3 * wide, thick * 0.72];
    limb(body, hip, knee, thick * 1.15, thick * 0.92, trousers);
    limb(body, knee, ankle, thick * 0.85, thick * 0.62, trousers);
    round(body, [0.1 * neck, 0.06 * neck, 0.05 * neck], SHOE, [ankle[0], -side * 0.55 * wide, 0.04]);
    const [shoulder, elbow] = [[0, side * 0.88 * wide, neck * 0.84], [0.1 * neck, side * 1.18 * wide, neck * 0.46]];
    arm(body, clothes, shoulder, elbow, [0.4 * neck, side * 1.1 * wide, neck * 0.33], neck, skin);
  }
}

function stand(body, neck, clothes, trousers, skin) {
  const wide = 0.115 * neck + 0.045;
  torso(body, clothes, 0.51 * neck, neck, wide);
  for (const side of [1, -1]) {
    const thick = 0.052 * neck + 0.012;
    const [hip, knee, ankle] = [0.55, 0.29, 0.05].map((part) => [0, side * 0.5 * wide, part * neck]);
    limb(body, hip, knee, thick * 1.15, thick * 0.88, trousers);
    limb(body, knee, ankle, thick * 0.86, thick * 0.66, trousers);
    round(body, [0.075 * neck, 0.035 * neck, 0.03 * neck], SHOE, [0.03 * neck, side * 0.52 * wide, 0.03 * neck]);
    const [shoulder, elbow] = [[0, side * 0.92 * wide, neck * 0.91], [-0.01 * neck, side * 1.22 * wide, neck * 0.7]];
    arm(body, clothes, shoulder, elbow, [0.04 * neck, side * 1.24 * wide, neck * 0.51], 0.62 * neck, skin);
  }
}

function torso(body, clothes, low, neck, wide) {
  const tall = neck - low;
  const outline = [
    [0.001, 0], [0.8, 0.005], [0.9, 0.06], [0.84, 0.25], [0.8, 0.42], [0.9, 0.66], [0.94, 0.8], [0.82, 0.89], [0.46, 0.955],
  ].map(([r, z]) => [r * wide, z * tall]);
  const made = turned([...outline, [0.042, tall * 0.98], [0.001, tall * 0.98]], clothes, 28);
  made.scale.x = 0.68;
  made.position.z = low;
  body.add(made);
}

function arm(body, clothes, shoulder, elbow, hand, size, skin) {
  const thick = 0.058 * size + 0.008;
  limb(body, shoulder, elbow, thick, thick * 0.86, clothes);
  limb(body, elbow, hand, thick * 0.8, thick * 0.62, skin);
  round(body, [thick * 0.85, thick * 0.75, thick], skin, hand);
}

// a head without a drawn face
function plain(made, hair) {
  round(made, [0.036, 0.036, 0.05], SKIN, [0, 0, -1.1 * HEAD]);
  round(made, [HEAD * 0.94, HEAD * 0.9, HEAD], SKIN, [0, 0, 0]);
  round(made, [HEAD * 0.98, HEAD * 0.98, HEAD * 0.92], hair, [-0.02, 0, 0.024]);
  for (const side of [1, -1]) {
    round(made, [0.008, 0.01, 0.014], [0.18, 0.15, 0.15], [HEAD * 0.88, side * 0.032, 0.012]);
    round(made, [0.012, 0.01, 0.02], SKIN, [0, side * HEAD * 0.93, 0]);
  }
  round(made, [0.014, 0.01, 0.013], [0.88, 0.7, 0.6], [HEAD * 0.93, 0, -0.012]);
  round(made, [0.007, 0.026, 0.007], [0.72, 0.45, 0.43], [HEAD * 0.84, 0, -0.044]);
}

/** Part of an arm or a leg, from one place to another. */
function limb(body, start, end, thick, thin, colour) {
  const way = new THREE.Vector3(...end).sub(new THREE.Vector3(...start));
  const long = way.length();
  const outline = [[0.001, -thick * 0.9], [thick * 0.7, -thick * 0.6], [thick, 0], [thin, long], [thin * 0.7, long + thin * 0.6], [0.001, long + thin * 0.9]];
  const made = turned(outline, colour, 16);
  made.position.set(...start);
  made.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), way.normalize());
  body.add(made);
}

// a shape turned on a lathe: (radius, height) from below to the top
function turned(outline, colour, around) {
  const shape = new THREE.LatheGeometry(outline.map(([x, y]) => new THREE.Vector2(x, y)), around);
  shape.rotateX(Math.PI / 2);
  return new THREE.Mesh(shape, matt(colour));
}

function round(body, radii, colour, place) {
  const made = new THREE.Mesh(new THREE.SphereGeometry(1, 24, 16), matt(colour));
  made.scale.set(...radii);
  made.position.set(...place);
  body.add(made);
}

function matt(colour) {
  return new THREE.MeshStandardMaterial({ color: new THREE.Color().setRGB(...colour, THREE.SRGBColorSpace), roughness: 0.9 });
}

// The heads of people, as rrp_sheets/sim/people.py makes them: a shape with a drawn face on its front, and hair.
// The origin is the middle of the face, which looks along x.

/** The drawn face of a person, if there is one: its outline and colours. */
const faceOf = (look, model) => model.scene.heads?.faces[look?.face];

/** Put a head on somebody; `add` adds an ellipsoid: radii, colour, place. */
function head(made, look, model, add) {
  const { size, front, back, nose, hair } = model.scene.heads;
  const face = faceOf(look, model);
  const skin = new THREE.MeshStandardMaterial({ map: picture(look.face, model), roughness: 0.9 });
  made.add(new THREE.Mesh(shape(face.outline, size, front, back, nose), skin));
  const wide = Math.max(...face.outline) * size;
  add(made, [0.4 * size, 0.4 * size, 0.6 * size], face.skin.map((c) => c * 0.82), [-0.22 * size, 0, -size]);
  for (const side of [1, -1]) add(made, [0.13 * size, 0.09 * size, 0.2 * size], face.skin, [-0.08 * size, side * wide * 0.99, 0.02 * size]);
  for (const [x, z, deep, across, high] of hair[face.style]) {
    add(made, [deep * size, across * wide, high * size], face.hair, [x * size, 0, z * size]);
  }
}

// each picture is fetched once; when it has come, the view is drawn again
function picture(number, { scene }) {
  scene.pictures ??= new Map();
  if (!scene.pictures.has(number)) {
    const made = new THREE.TextureLoader().load(`/robot/face/${number}.png`, () => scene.again?.());
    made.colorSpace = THREE.SRGBColorSpace;
    scene.pictures.set(number, made);
  }
  return scene.pictures.get(number);
}

// the picture lies on the front as if projected from before it; the back has its edge's colours
function shape(outline, size, front, back, [out, middle, half, high]) {
  const [points, places, faces] = [[], [], []];
  const rings = outline.length - 1;
  for (let ring = 0; ring <= rings; ring += 1) {
    const z = -Math.cos(Math.PI * ring / rings);
    const wide = Math.max(outline[ring], 1e-3);
    const round = Math.sqrt(Math.max(0, 1 - z * z));
    for (let step = 0; step <= AROUND; step += 1) {
      const turn = 2 * Math.PI * step / AROUND - Math.PI;
      const [ahead, aside] = [Math.cos(turn), Math.sin(turn)];
      const y = wide * aside;
      let x = ahead * (ahead > 0 ? front * Math.max(round, 1e-3) ** 0.75 : back * round);
      if (ahead > 0) x += out * Math.exp(-((y / half) ** 2) - ((z - middle) / high) ** 2);
      points.push(x * size, y * size, z * size);
      places.push(0.5 + 0.499 * (ahead > 0 ? y : Math.sign(aside) * wide), 0.5 + 0.499 * z);
    }
  }
  const row = AROUND + 1;
  for (let i = 0; i < rings; i += 1) {
    for (let k = i * row; k < i * row + AROUND; k += 1) faces.push(k, k + 1, k + 1 + row, k, k + 1 + row, k + row);
  }
  const made = new THREE.BufferGeometry();
  made.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  made.setAttribute("uv", new THREE.Float32BufferAttribute(places, 2));
  made.setIndex(faces);
  made.computeVertexNormals();
  return made;
}
