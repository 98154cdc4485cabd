// Plays the shape of a mode: everything swings about its place, once a second.
"use strict";

const places = floats(modes.places), carry_skin = skin_on(modes.skin, modes.paths);
const list = document.getElementById("modes"), words = document.getElementById("words");
const button = document.getElementById("play"), scrub = document.getElementById("scrub");
const told = document.getElementById("told"), amplitude = document.getElementById("amplitude");
const size = document.getElementById("size");
let swing = null, turn = 0, playing = false, ticked = null;
layers.viscera = ["viscera"];

// Muscles ride on the links that carry the corners of their paths.
const ride = muscles && {
  corners: floats(modes.muscles.corners), carriers: bytes(modes.muscles.carriers),
  before: new Int16Array(bytes(modes.muscles.before).buffer), share: floats(modes.muscles.share),
  links: modes.muscles.links.map(link => ({
    node: object(`person/${link}`), back: matrix(places, 7 * modes.paths.indexOf(`person/${link}`)).invert(),
  })),
};

function carry_muscles() {
  const carried = ride.links.map(({ node, back }) => new THREE.Matrix4()
    .compose(node.position, node.quaternion, node.scale).multiply(back));
  const corners = Array.from(ride.carriers, (link, i) => new THREE.Vector3()
    .fromArray(ride.corners, 3 * i).applyMatrix4(carried[link]));
  show_muscles(muscle_times[0], (point, n) => {
    point.lerpVectors(corners[ride.before[n]], corners[ride.before[n] + 1], ride.share[n]);
  });
}

// At `turn` degrees of the cycle, of largest displacements 1 m apart from rest: Re(phi exp(i angle)).
// The cycle starts at rest.
function show() {
  const angle = THREE.MathUtils.degToRad(turn - 90), large = Number(amplitude.value) / 100;
  const real = large * Math.cos(angle), imaginary = -large * Math.sin(angle);
  const by = new THREE.Vector3(), spin = new THREE.Quaternion();
  modes.paths.forEach((path, k) => {
    const moved = i => by.fromArray(swing, 12 * k + i).multiplyScalar(real)
      .add(new THREE.Vector3().fromArray(swing, 12 * k + 6 + i).multiplyScalar(imaginary));
    const node = object(path);
    node.position.fromArray(places, 7 * k).add(moved(0));
    const round = moved(3).length();
    spin.setFromAxisAngle(by.divideScalar(round || 1), round);
    node.quaternion.fromArray(places, 7 * k + 3).premultiply(spin);
  });
  carry_skin();
  if (muscles) carry_muscles();
  scrub.value = turn;
  told.textContent = `${Math.round(turn)}°`;
  size.textContent = `${amplitude.value} cm`;
  tip.hidden = true;
  viewer.set_dirty();
}

function choose(mode, row) {
  swing = floats(mode.swing);
  for (const other of list.querySelectorAll("button")) other.setAttribute("aria-pressed", other === row);
  words.textContent = `${mode.words[0].toUpperCase()}${mode.words.slice(1)}.`;
  show();
}

function offer(kind) {
  for (const choice of document.querySelectorAll("[data-kind]")) {
    choice.setAttribute("aria-pressed", choice.dataset.kind === kind);
  }
  const rows = modes.kinds[kind].map(mode => {
    const row = document.createElement("button"), tag = document.createElement("span");
    row.type = "button";
    tag.className = `tag ${mode.symmetry}`;
    tag.textContent = mode.symmetry;
    const damped = kind === "damped" ? [document.createElement("small")] : [];
    for (const ratio of damped) ratio.textContent = `ζ ${(100 * mode.damping).toFixed(0)} %`;
    row.append(`${mode.frequency.toFixed(2)} Hz`, ...damped, tag);
    row.addEventListener("click", () => { choose(mode, row); play(true); });
    return row;
  });
  list.replaceChildren(...rows.map(row => {
    const item = document.createElement("li");
    item.append(row);
    return item;
  }));
  if (rows.length) choose(modes.kinds[kind][0], rows[0]);
}
for (const choice of document.querySelectorAll("[data-kind]")) {
  choice.addEventListener("click", () => offer(choice.dataset.kind));
}

function step(now) {
  if (!playing) return;
  if (ticked !== null) turn = (turn + 360 * (now - ticked) / 1e3) % 360;
  ticked = now;
  show();
  requestAnimationFrame(step);
}

function play(on) {
  if (on && !playing) {
    ticked = null;
    requestAnimationFrame(step);
  }
  playing = on;
  button.setAttribute("aria-label", playing ? "Pause" : "Play");
  button.classList.toggle("playing", playing);
}

button.addEventListener("click", () => play(!playing));
scrub.addEventListener("input", () => { play(false); turn = Number(scrub.value); show(); });
amplitude.addEventListener("input", show);
document.addEventListener("keydown", event => {
  if (event.key !== " " || event.target.matches("button, [type=checkbox]")) return;
  play(!playing);
  event.preventDefault();
});

as_it_arrives(show);
offer(document.querySelector("[data-kind]").dataset.kind);
