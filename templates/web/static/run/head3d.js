// The heads of people, as rrp_sheets/sim/heads.py makes them: a shape with a drawn face on its front, and hair.
// The origin is the middle of the face, which looks along x.

import * as THREE from "/vendor/js/three.module.js";

const AROUND = 32;

/** The drawn face of a person, if there is one: its outline and colours. */
export const faceOf = (look, model) => model.scene.heads?.faces[look?.face];

/** Put a head on somebody; `add` adds an ellipsoid: radii, colour, place. */
export function head(made, look, model, add) {
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
