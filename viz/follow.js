// What follows the links wherever they go: the skin of the trunk, and a live drawing that still arrives.
"use strict";

function matrix(numbers, start) {
  return new THREE.Matrix4().compose(
    new THREE.Vector3().fromArray(numbers, start),
    new THREE.Quaternion().fromArray(numbers, start + 3),
    new THREE.Vector3(1, 1, 1),
  );
}

// The skin rides on the vertebrae: each point goes with the two that it lies between.
function skin_on(skin, paths) {
  const rest = floats(skin.rest), share = floats(skin.share), lower = bytes(skin.lower);
  const back = skin.levels.map((_, i) => matrix(floats(skin.poses), 7 * i).invert());
  return () => {
    const mesh = object("skin/<object>");
    if (!mesh.geometry) return;
    const at = mesh.geometry.attributes.position;
    const carried = [new THREE.Matrix4(), ...skin.levels.map((path, i) => {
      const node = object(paths[path]);
      return new THREE.Matrix4().compose(node.position, node.quaternion, node.scale).multiply(back[i]);
    })];
    const point = new THREE.Vector3(), above = new THREE.Vector3();
    for (let i = 0; i < at.count; i++) {
      point.fromArray(rest, 3 * i);
      above.copy(point).applyMatrix4(carried[lower[i] + 1]);
      point.applyMatrix4(carried[lower[i]]).lerp(above, share[i]);
      at.setXYZ(i, point.x, point.y, point.z);
    }
    at.needsUpdate = true;
    mesh.geometry.computeVertexNormals();
    mesh.geometry.computeBoundingSphere();
  };
}

// A live drawing arrives bit by bit, as it stands at the start.
function as_it_arrives(show) {
  if (commands) return;
  let asked = false;
  const take = viewer.handle_command.bind(viewer);
  viewer.handle_command = command => {
    take(command);
    if (!asked) requestAnimationFrame(() => { asked = false; show(); });
    asked = true;
  };
}
