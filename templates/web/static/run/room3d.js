// The room around the robot: a pale floor with lines, a rug, soft shadows, light, and the things of the scene.
// It looks like the film of a run (rrp_sheets/sim/camera.py and figures.py).

import * as THREE from "/vendor/js/three.module.js";

const MOST_SHADOWS = 12;
const LOOKS = {
  light: { wall: [236, 238, 240], ground: [206, 205, 202], rug: [176, 194, 204], edge: [226, 232, 236], line: 0.87, shade: 1 },
  dark: { wall: [27, 31, 35], ground: [50, 54, 58], rug: [44, 62, 74], edge: [86, 106, 120], line: 1.35, shade: 1.6 },
};

export class Room {
  constructor(scene) {
    this.scene = scene;
    const colour = () => ({ value: new THREE.Color() });
    this.paint = new THREE.ShaderMaterial({
      uniforms: {
        wall: colour(), ground: colour(), rug: colour(), edge: colour(), line: { value: 1 }, shade: { value: 1 },
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
    this.sky.intensity = dark ? 1.4 : 1.75;
  }

  /** Soft shadows on the floor: (x, y, radius, darkness). */
  shadow(list) {
    const places = this.paint.uniforms.shadows.value;
    places.forEach((place, i) => (i < list.length ? place.set(...list[i]) : place.set(0, 0, 1, 0)));
  }
}

const VERTEX = `
varying vec3 place;
void main() {
  place = (modelMatrix * vec4(position, 1.0)).xyz;
  gl_Position = projectionMatrix * viewMatrix * vec4(place, 1.0);
}`;

const FRAGMENT = `
varying vec3 place;
uniform vec3 wall, ground, rug, edge;
uniform float line, shade;
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
  gl_FragColor = vec4(mix(wall, colour, exp(-max(away - 1.2, 0.0) / 5.0)), 1.0);
}`;

/** A thing of the scene: a ball, or a person whose face is at the place. */
export function thing(name, kind, height, model) {
  const isBall = kind ? /ball/i.test(kind) : /ball/i.test(name);
  return isBall ? ball(name, model) : person(name, height);
}

function ball(name, { scene }) {
  const words = name.toLowerCase();
  const named = Object.keys(scene.colours).filter((colour) => words.includes(colour)).sort((a, b) => b.length - a.length);
  const colour = new THREE.Color().setRGB(...(scene.colours[named[0]] ?? scene.colours.grey), THREE.SRGBColorSpace);
  const made = new THREE.Mesh(
    new THREE.SphereGeometry(scene.ball / 2, 32, 20), new THREE.MeshStandardMaterial({ color: colour, roughness: 0.35 }),
  );
  made.userData = { ball: true, radius: scene.ball / 2 };
  return made;
}

const CLOTHES = [[0.42, 0.6, 0.62], [0.76, 0.64, 0.46], [0.6, 0.52, 0.68], [0.5, 0.62, 0.46]];
const HAIR = [[0.34, 0.25, 0.2], [0.62, 0.5, 0.36], [0.2, 0.18, 0.18], [0.5, 0.34, 0.26]];
const SKIN = [0.93, 0.78, 0.68];
const HEAD = 0.095; // m, radius

function person(name, height) {
  const number = [...name].reduce((sum, letter) => (sum * 31 + letter.codePointAt(0)) % 9973, 7) % CLOTHES.length;
  const made = new THREE.Group(); // its origin is the middle of the face; it looks along x
  const add = (radii, colour, offset) => {
    const part = new THREE.Mesh(new THREE.SphereGeometry(1, 24, 16), matt(colour));
    part.scale.set(...radii);
    part.position.set(...offset);
    made.add(part);
  };
  const neck = height - 0.7 * HEAD;
  const wide = Math.min(0.17, 0.09 + 0.09 * height);
  const outline = [
    [0, 0], [wide, 0], [wide * 1.02, 0.03], [wide * 0.86, neck * 0.35], [wide * 0.66, neck * 0.68],
    [wide * 0.56, neck * 0.86], [wide * 0.36, neck * 0.97], [0.03, neck + 0.01], [0.001, neck + 0.01],
  ].map(([x, y]) => new THREE.Vector2(x, y));
  const robe = new THREE.Mesh(new THREE.LatheGeometry(outline, 32), matt(CLOTHES[number]));
  robe.rotation.x = Math.PI / 2;
  robe.position.z = -height;
  made.add(robe);
  for (const side of [1, -1]) {
    add([0.033, 0.033, neck * 0.19], CLOTHES[number], [0.02, side * wide * 0.8, neck * 0.7 - height]);
    add([0.03, 0.026, 0.034], SKIN, [0.03, side * wide * 0.86, neck * 0.51 - height]);
    add([0.008, 0.01, 0.014], [0.18, 0.15, 0.15], [HEAD * 0.88, side * 0.032, 0.012]);
    add([0.012, 0.01, 0.02], SKIN, [0, side * HEAD * 0.93, 0]);
  }
  add([HEAD * 0.94, HEAD * 0.9, HEAD], SKIN, [0, 0, 0]);
  add([HEAD * 0.98, HEAD * 0.98, HEAD * 0.92], HAIR[number], [-0.02, 0, 0.024]);
  add([0.014, 0.01, 0.013], [0.88, 0.7, 0.6], [HEAD * 0.93, 0, -0.012]);
  add([0.007, 0.026, 0.007], [0.72, 0.45, 0.43], [HEAD * 0.84, 0, -0.044]);
  made.userData = { ball: false, radius: 0.1 };
  return made;
}

function matt(colour) {
  return new THREE.MeshStandardMaterial({ color: new THREE.Color().setRGB(...colour, THREE.SRGBColorSpace), roughness: 0.9 });
}
