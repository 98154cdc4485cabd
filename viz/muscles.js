// The muscles of the arms: a tube each, coloured by activation, drawn anew at any instant.
"use strict";

const muscle_times = floats(muscles.time), muscle_radii = floats(muscles.radii);
const muscle_points = new Int16Array(bytes(muscles.points).buffer);
const muscle_activation = floats(muscles.activation), muscle_force = floats(muscles.force);
const SIDES = 8;
let muscle_frame = 0;

function shade(share) {
  const at = Math.min(Math.max(share, 0), 1) * (muscles.ramp.length - 1), i = Math.min(Math.floor(at), muscles.ramp.length - 2);
  const mixed = muscles.ramp[i].map((c, k) => c + (at - i) * (muscles.ramp[i + 1][k] - c));
  return new THREE.Color(...mixed);
}

// Rings of points, joined; where they lie is told at each instant.
const muscle_meshes = muscles.names.map((name, k) => {
  const faces = [];
  for (let i = 0; i + 1 < muscles.count; i++) for (let j = 0; j < SIDES; j++) {
    const a = SIDES * i + j, b = SIDES * i + (j + 1) % SIDES;
    faces.push(a, b, a + SIDES, b, b + SIDES, a + SIDES);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * SIDES * muscles.count), 3));
  geometry.setIndex(faces);
  const mesh = new THREE.Mesh(geometry, new THREE.MeshPhongMaterial({ specular: 0x202020, shininess: 18 }));
  mesh.castShadow = true;
  viewer.set_object(["meshcat", "muscles", String(k)], mesh);
  return mesh;
});

// A belly in the middle, tendons at the ends.
const belly = share => 0.3 + 0.7 * Math.sin(Math.PI * share) ** 1.5;

// `carry`, if given, puts each point, by its number among all, elsewhere than at that time.
function show_muscles(time, carry) {
  let frame = 0;
  while (frame + 2 < muscle_times.length && muscle_times[frame + 1] <= time) frame++;
  const next = Math.min(frame + 1, muscle_times.length - 1);
  const part = next === frame ? 0 : Math.min(Math.max((time - muscle_times[frame]) / (muscle_times[next] - muscle_times[frame]), 0), 1);
  muscle_frame = part < 0.5 ? frame : next;
  const count = muscles.count, many = muscles.names.length;
  const points = Array.from({ length: count }, () => new THREE.Vector3());
  const way = new THREE.Vector3(), out = new THREE.Vector3(), across = new THREE.Vector3();
  muscle_meshes.forEach((mesh, k) => {
    const i = 3 * count * (many * frame + k), j = 3 * count * (many * next + k);
    points.forEach((point, p) => point.fromArray(
      [0, 1, 2].map(c => muscles.grain * ((1 - part) * muscle_points[i + 3 * p + c] + part * muscle_points[j + 3 * p + c]))));
    if (carry) points.forEach((point, p) => carry(point, count * k + p));
    const at = mesh.geometry.attributes.position;
    // Each ring turns as little as it can from the one before.
    way.subVectors(points[1], points[0]).normalize();
    out.set(Math.abs(way.y) < 0.9 ? 0 : 1, Math.abs(way.y) < 0.9 ? 1 : 0, 0);
    points.forEach((point, p) => {
      way.subVectors(points[Math.min(p + 1, count - 1)], points[Math.max(p - 1, 0)]).normalize();
      out.addScaledVector(way, -out.dot(way)).normalize();
      across.crossVectors(way, out);
      const radius = muscle_radii[k] * belly(p / (count - 1));
      for (let s = 0; s < SIDES; s++) {
        const cos = radius * Math.cos(2 * Math.PI * s / SIDES), sin = radius * Math.sin(2 * Math.PI * s / SIDES);
        at.setXYZ(SIDES * p + s, point.x + cos * out.x + sin * across.x, point.y + cos * out.y + sin * across.y, point.z + cos * out.z + sin * across.z);
      }
    });
    at.needsUpdate = true;
    mesh.geometry.computeVertexNormals();
    mesh.geometry.computeBoundingSphere();
    mesh.material.color.copy(shade(muscle_activation[many * muscle_frame + k]));
  });
}

layers.muscles = ["muscles"];
pointed.push({ path: "muscles", tell: node => {
  const k = muscle_meshes.indexOf(node), i = muscles.names.length * muscle_frame + k;
  return k < 0 ? null : {
    title: muscles.names[k], lines: [`activation ${muscle_activation[i].toFixed(2)}, ${muscle_force[i].toFixed(0)} N`],
  };
} });
show_muscles(muscle_times[0]);
