// Shows the recorded drawing in meshcat's viewer and adds what a page needs: views, layers, labels, tips.
"use strict";

const THREE = MeshCat.THREE;
const pane = document.getElementById("pane");
const viewer = new MeshCat.Viewer(pane);

// The pane, not the window, gives the size.
const resize = viewer.set_3d_pane_size.bind(viewer);
viewer.set_3d_pane_size = () => resize(pane.clientWidth, pane.clientHeight);
new ResizeObserver(() => { viewer.set_3d_pane_size(); look(current); }).observe(pane);

// Numbers come as base64 of their bytes; three figures are enough to read.
const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0));
const floats = text => new Float32Array(bytes(text).buffer);
const three = value => String(Number(value.toPrecision(3)));

const object = path => viewer.scene_tree.find(["meshcat", ...path.split("/")]).object;

// Glass is clear face on and denser towards its outline, so that what lies inside stays legible.
function frost(material) {
  material.onBeforeCompile = shader => {
    shader.fragmentShader = shader.fragmentShader.replace("#include <output_fragment>",
      `#include <output_fragment>
       float rim = 1.0 - abs(dot(normalize(vViewPosition), normal));
       gl_FragColor.a = min(diffuseColor.a * (0.3 + 4.0 * rim * rim * rim), 0.9);`);
  };
}

const set_object = viewer.set_object.bind(viewer);
viewer.set_object = (path, shape) => {
  const material = shape.material;
  if (material && material.transparent && material.depthTest && !material.depthWrite) frost(material);
  set_object(path, shape);
};

// The page looks for itself; the drawing's camera is for viewers that do not.
const handle = viewer.handle_command.bind(viewer);
viewer.handle_command = command => {
  if (!command.path.startsWith("/Cameras")) handle(command);
};

if (commands) {
  for (const command of commands) {
    viewer.handle_command_bytearray(bytes(command));
  }
} else {
  viewer.connect();
}

// Views: all there is to see in sight and in the middle, seen along a direction, z up.
const directions = { side: [0, -1, 0.04], front: [1, 0, 0.08], quarter: [0.72, -0.8, 0.26] };
const outline = posture.frame.map(point => new THREE.Vector3(...point));
let current = "side";

function look(name) {
  current = name;
  const away = new THREE.Vector3(...directions[name]).normalize();
  const right = new THREE.Vector3(0, 0, 1).cross(away).normalize();
  const up = away.clone().cross(right);
  const extent = axis => {
    const along = outline.map(point => point.dot(axis));
    return [Math.min(...along), Math.max(...along)];
  };
  const [[left, rightmost], [bottom, top], [far, near]] = [right, up, away].map(extent);
  const camera = viewer.camera;
  const tall = 0.86 * Math.tan(THREE.MathUtils.degToRad(camera.fov / 2));
  const wide = tall * pane.clientWidth / pane.clientHeight;
  const distance = Math.max((rightmost - left) / 2 / wide, (top - bottom) / 2 / tall) + (near - far) / 2;
  const centre = right.multiplyScalar((left + rightmost) / 2)
    .add(up.multiplyScalar((bottom + top) / 2)).add(away.clone().multiplyScalar((far + near) / 2));
  // The camera lives in three.js's own axes, y up.
  viewer.controls.target.copy(viewer.scene.localToWorld(centre.clone()));
  camera.position.copy(viewer.scene.localToWorld(centre.add(away.multiplyScalar(distance))));
  viewer.controls.update();
  viewer.set_dirty();
  for (const button of document.querySelectorAll("[data-view]")) {
    button.setAttribute("aria-pressed", button.dataset.view === name);
  }
}
viewer.camera.fov = 26;
viewer.controls.addEventListener("start", () => {
  for (const button of document.querySelectorAll("[data-view]")) button.setAttribute("aria-pressed", false);
});
for (const button of document.querySelectorAll("[data-view]")) {
  button.addEventListener("click", () => look(button.dataset.view === "reset" ? "side" : button.dataset.view));
}

// Layers
const layers = { ghost: ["ghost"], forces: ["forces"], skin: ["skin"], ribs: posture.ribs, ways: [] };
for (const box of document.querySelectorAll("[data-layer]")) {
  box.addEventListener("change", () => {
    for (const path of layers[box.dataset.layer]) object(path).visible = box.checked;
    if (box.dataset.layer === "forces") labels.hidden = !box.checked;
    if (box.dataset.layer === "ways") document.getElementById("ways").toggleAttribute("hidden", !box.checked);
    viewer.set_dirty();
  });
}

// Labels follow their points, and step aside where they would cover one another.
const labels = document.getElementById("labels");
const tags = posture.labels.map(label => {
  const tag = document.createElement("span");
  labels.append(tag);
  const written = { tag, name: label.name };
  write(written, { ...label, at: new THREE.Vector3(...label.at), start: new THREE.Vector3(...label.start) });
  return written;
});

function write(written, { force, moment, at, start }) {
  written.tag.replaceChildren(written.name);
  for (const [kind, text] of [["force", force], ["moment", moment]]) {
    if (!text) continue;
    const value = document.createElement("b");
    value.className = kind;
    value.textContent = text;
    written.tag.append(" ", value);
  }
  written.tag.hidden = !force && !moment;
  written.forced = Boolean(force);
  Object.assign(written, { at, start });
}

function on_screen(point) {
  const seen = viewer.scene.localToWorld(point.clone()).project(viewer.camera);
  return [(seen.x + 1) / 2 * pane.clientWidth, (1 - seen.y) / 2 * pane.clientHeight];
}

function place_labels() {
  const placed = [];
  for (const { tag, forced, at, start } of tags) {
    if (tag.hidden) continue;
    const [x0, y0] = on_screen(start), [x1, y1] = on_screen(at);
    const w = tag.offsetWidth, h = tag.offsetHeight, away = Math.hypot(x1 - x0, y1 - y0) || 1;
    // Beyond an arrow's tail; to the left of a ring.
    let x = forced ? x1 + (x1 - x0) / away * (w / 2 + 6) - w / 2 : x0 - away - w - 6;
    let y = forced ? y1 + (y1 - y0) / away * (h / 2 + 6) - h / 2 : y0 - h / 2;
    x = Math.min(Math.max(x, 4), pane.clientWidth - w - 4);
    y = Math.min(Math.max(y, 4), pane.clientHeight - h - 4);
    for (const other of placed) {
      if (x < other.x + other.w && other.x < x + w && y < other.y + other.h && other.y < y + h) y = other.y + other.h + 2;
    }
    placed.push({ x, y, w, h });
    tag.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
  }
}
const render = viewer.render.bind(viewer);
viewer.render = () => { render(); place_labels(); };

// Tips: the joint below the part under the pointer, and what it does and carries at that instant.
const moved = floats(posture.moved);
let instant = 0;
const joules = energy => energy < 1e-9 ? "0 J" : energy < 0.1 ? `${three(1e3 * energy)} mJ` : `${three(energy)} J`;

function carried({ dofs }) {
  let energy = 0;
  const lines = dofs.map(i => {
    const { does, stretch, stiffness } = posture.dofs[i], by = moved[instant * posture.dofs.length + i];
    energy += stiffness * by * by / 2;
    return stretch ? `${does} ${(1e3 * by).toFixed(2)} mm, ${(stiffness * by).toFixed(1)} N`
      : `${does} ${THREE.MathUtils.radToDeg(by).toFixed(2)}°, ${(stiffness * by).toFixed(2)} N m`;
  });
  return { energy, lines };
}
const tip = document.getElementById("tip");
const ray = new THREE.Raycaster();

// What can be pointed at: where it is drawn, and what to tell of a node there, if anything.
const pointed = [{ path: "person", tell: ({ name }) => {
  if (!posture.parts[name]) return null;
  const { energy, lines } = carried(posture.parts[name]);
  return { title: `${posture.parts[name].joint}: ${joules(energy)}`, lines };
} }];

function told_at(x, y) {
  ray.setFromCamera(new THREE.Vector2(2 * x / pane.clientWidth - 1, 1 - 2 * y / pane.clientHeight), viewer.camera);
  const hits = pointed.filter(({ path }) => object(path).visible)
    .flatMap(({ path, tell }) => ray.intersectObject(object(path), true).map(hit => ({ ...hit, tell })));
  // What is seen through glass comes before the glass.
  const glass = hit => Number(hit.object.material.transparent);
  for (const { object: shape, tell } of hits.sort((a, b) => glass(a) - glass(b) || a.distance - b.distance)) {
    for (let node = shape; node && node.visible; node = node.parent) {
      const found = tell(node);
      if (found) return found;
    }
  }
  return null;
}

pane.addEventListener("pointermove", event => {
  const frame = pane.getBoundingClientRect(), x = event.clientX - frame.left, y = event.clientY - frame.top;
  const found = event.buttons ? null : told_at(x, y);
  tip.hidden = !found;
  if (!found) return;
  const name = document.createElement("strong");
  name.textContent = found.title;
  tip.replaceChildren(name, ...found.lines.map(line => {
    const row = document.createElement("small");
    row.textContent = line;
    return row;
  }));
  tip.style.left = `${Math.min(x + 16, pane.clientWidth - tip.offsetWidth - 8)}px`;
  tip.style.top = `${Math.min(y + 14, pane.clientHeight - tip.offsetHeight - 8)}px`;
});
pane.addEventListener("pointerleave", () => { tip.hidden = true; });

viewer.set_3d_pane_size();
look("side");
