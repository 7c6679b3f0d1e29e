// People, seated on the floor or standing, as rrp_sheets/sim/people.py makes them. The origin is the middle of the
// face; they look along x.

import * as THREE from "/vendor/js/three.module.js";
import { faceOf, head } from "./head3d.js";

const CLOTHES = [[0.42, 0.6, 0.62], [0.76, 0.64, 0.46], [0.6, 0.52, 0.68], [0.5, 0.62, 0.46]];
const TROUSERS = [[0.44, 0.46, 0.52], [0.5, 0.46, 0.42], [0.4, 0.44, 0.44], [0.52, 0.5, 0.54]];
const HAIR = [[0.34, 0.25, 0.2], [0.62, 0.5, 0.36], [0.2, 0.18, 0.18], [0.5, 0.34, 0.26]];
const SKIN = [0.93, 0.78, 0.68];
const SHOE = [0.34, 0.33, 0.33];
const HEAD = 0.105; // m, half its height
const STANDS = 0.85; // m: a face higher than that belongs to somebody who stands

/** Somebody with the face at a height above the floor. */
export function person(name, height, look, model) {
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
