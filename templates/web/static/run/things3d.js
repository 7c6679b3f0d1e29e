// What stands around the robot: balls, cups, boxes, tables, walls, people. They look like those of a run's film
// (rrp_sheets/sim/figures.py, things.py, people.py). Lengths in metres.

import * as THREE from "/vendor/js/three.module.js";
import { person } from "./people3d.js";

const WOOD = [0.8, 0.68, 0.52];
const LEG = [0.64, 0.54, 0.42];
const PLASTER = [0.8, 0.82, 0.8];
const TOP = 0.025; // of a table
const THIN = 0.035; // its legs

/** A thing as the world tells that it looks; until it has told, as its name and kind do. */
export function thing(name, look, height, model) {
  const kind = look?.kind ?? (/ball/i.test(name) ? "ball" : "person");
  const made = kind === "person" ? person(name, look?.height ?? height, look, model) : (MAKE[kind] ?? ball)(look ?? {}, name, model.scene);
  Object.assign(made.userData, { kind, ball: kind === "ball", look: JSON.stringify(look ?? null) });
  return made;
}

/** Whether a thing still looks as it was drawn. */
export const same = (object, look) => !look || object.userData.look === JSON.stringify(look);

const MAKE = { ball, cup, box, table, wall };

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
