// The room around the robot: a pale floor with lines, a rug, soft shadows, light. It looks like the film of a run
// (rrp_sheets/sim/camera.py).

import * as THREE from "/vendor/js/three.module.js";

const MOST_SHADOWS = 24;
const DARKEST = 0.3; // of the light of a bright room
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

  /** How bright the room is, 0 to 1; a dark one is still to be seen. */
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
