// The outline of a thing that can be taken.

import * as THREE from "/vendor/js/three.module.js";

const LINE = 0.004; // of its width, as part of the distance

/** Put the outline around a thing; its parts, which can be hidden. */
export function wrap(object, paint) {
  const meshes = [];
  object.traverse((part) => part.isMesh && meshes.push(part));
  return meshes.map((mesh) => {
    const line = new THREE.Mesh(mesh.geometry, paint);
    mesh.add(line);
    return line;
  });
}

/** The same shape, a little larger, of which only the inside is seen. */
export function outline() {
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
