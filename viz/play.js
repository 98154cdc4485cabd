// Plays a motion: shows any instant of it, and answers the time bar and the keys.
"use strict";

const times = floats(motion.time);
const poses = floats(motion.poses), drawn = floats(motion.wrenches.drawn), energies = floats(motion.energy);
const rgb = bytes(motion.tints.rgb);
const last = times.length - 1;

const carry_skin = skin_on(motion.skin, motion.paths);

// Arrows and rings: shapes of the drawing, moved and stretched.
const vector = start => new THREE.Vector3().fromArray(drawn, start);
const mix = (i, j, part, start) => vector(i + start).lerp(vector(j + start), part);
const up = new THREE.Vector3(0, 1, 0), ahead = new THREE.Vector3(0, 0, 1);

function show_force(name, tail, tip, seen) {
  const node = object(`forces/${name}/force`), long = tip.distanceTo(tail);
  node.visible = seen;
  if (!seen) return;
  node.position.copy(tail);
  node.quaternion.setFromUnitVectors(up, tip.clone().sub(tail).normalize());
  const head = length => Math.min(0.055, 0.5 * length), full = motion.wrenches.lengths[name];
  const shaft = object(`forces/${name}/force/shaft`), point = object(`forces/${name}/force/head`);
  shaft.scale.y = (long - head(long)) / (full - head(full));
  shaft.position.y = (long - head(long)) / 2;
  point.scale.y = head(long) / head(full);
  point.position.y = long - head(long) / 2;
}

function show_moment(name, at, axis, seen) {
  const node = object(`forces/${name}/moment`);
  node.visible = seen;
  if (!seen) return;
  node.position.copy(at);
  node.scale.setScalar(axis.length() / motion.wrenches.radii[name]);
  node.quaternion.setFromUnitVectors(ahead, axis.clone().normalize());
}

const rows = document.querySelectorAll("#loads tbody tr");

function show_wrenches(frame, next, part) {
  const names = motion.wrenches.names, loads = motion.wrenches.loads[instant];
  names.forEach((name, k) => {
    const i = 9 * (names.length * frame + k), j = 9 * (names.length * next + k);
    const tip = mix(i, j, part, 3), tail = mix(i, j, part, 0), axis = mix(i, j, part, 6);
    // What is too small to be drawn at either end is not drawn between.
    const forced = [i, j].every(n => vector(n).distanceTo(vector(n + 3)) > 0);
    const turned = [i, j].every(n => vector(n + 6).length() > 0);
    if (name in motion.wrenches.lengths) show_force(name, tail, tip, forced);
    if (name in motion.wrenches.radii) show_moment(name, tip, axis, turned);
    const [force, moment] = loads[k];
    [force, moment].forEach((value, column) => { rows[k].cells[column + 1].textContent = value; });
    const tag = tags.find(tag => tag.name === name);
    if (!tag) return;
    const below = tip.clone().setZ(tip.z - axis.length());
    write(tag, {
      force: forced ? `${force} N` : "", moment: turned ? `${moment} N m` : "",
      at: forced ? tail : below, start: tip,
    });
  });
}

// The ways of head and hands, drawn over the picture with round times at them.
const sheet = document.getElementById("ways");
const element = (name, parent, style) => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  made.setAttribute("class", style);
  return parent.appendChild(made);
};
const ways = motion.ways.map(({ name, points, ticks }) => {
  const group = element("g", sheet, `way ${name.replace(" ", "-")}`), numbers = floats(points);
  return {
    points: Array.from(times, (_, i) => new THREE.Vector3().fromArray(numbers, 3 * i)),
    whole: element("polyline", group, "whole"),
    done: element("polyline", group, "done"),
    ticks: ticks.map(([text, ...point]) => {
      const tick = { point: new THREE.Vector3(...point), dot: element("circle", group, "tick"), text: element("text", group, "") };
      tick.dot.setAttribute("r", 3);
      tick.text.textContent = text;
      return tick;
    }),
    here: element("circle", group, "here"),
  };
});
for (const { here } of ways) here.setAttribute("r", 5);

function place_ways() {
  const pairs = points => points.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ");
  const taken = [];
  for (const { points, whole, done, ticks, here } of ways) {
    const all = points.map(on_screen), now = on_screen(between(points));
    whole.setAttribute("points", pairs(all));
    done.setAttribute("points", pairs([...all.slice(0, before(clock) + 1), now]));
    here.setAttribute("cx", now[0]);
    here.setAttribute("cy", now[1]);
    for (const { point, dot, text } of ticks) {
      const [x, y] = on_screen(point);
      dot.setAttribute("cx", x);
      dot.setAttribute("cy", y);
      text.setAttribute("x", x + 7);
      text.setAttribute("y", y - 6);
      // Times that would cover one another are left to their dots.
      const free = taken.every(([a, b]) => Math.abs(a - x) > 40 || Math.abs(b - y) > 15);
      text.toggleAttribute("hidden", !free);
      if (free) taken.push([x, y]);
    }
  }
}
const draw_all = viewer.render;
viewer.render = () => { draw_all(); place_ways(); };

// Time
let clock = times[0], playing = false, speed = Number(document.getElementById("speed").value), ticked = null;

function before(time) {
  let low = 0, high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle; else high = middle;
  }
  return time >= times[last] ? last : low;
}
const share = frame => frame === last ? 0 : (clock - times[frame]) / (times[frame + 1] - times[frame]);
function between(points) {
  const frame = before(clock);
  return points[frame].clone().lerp(points[Math.min(frame + 1, last)], share(frame));
}

const scrub = document.getElementById("scrub"), told = document.getElementById("told");
const button = document.getElementById("play"), strain = document.querySelector("[data-fact='Strain energy']");

function show(time) {
  clock = Math.min(Math.max(time, times[0]), times[last]);
  const frame = before(clock), next = Math.min(frame + 1, last), part = share(frame);
  instant = part < 0.5 ? frame : next;
  const wide = 7 * motion.paths.length, blend = new THREE.Quaternion(), ahead = new THREE.Vector3();
  motion.paths.forEach((path, k) => {
    const node = object(path), i = wide * frame + 7 * k, j = wide * next + 7 * k;
    node.position.fromArray(poses, i).lerp(ahead.fromArray(poses, j), part);
    node.quaternion.fromArray(poses, i + 3).slerp(blend.fromArray(poses, j + 3), part);
  });
  motion.tints.paths.forEach((path, k) => {
    const material = object(`${path}/<object>`).material, i = 3 * (motion.tints.paths.length * instant + k);
    if (material) material.color.setRGB(rgb[i] / 255, rgb[i + 1] / 255, rgb[i + 2] / 255);
  });
  carry_skin();
  show_wrenches(frame, next, part);
  if (muscles) show_muscles(clock);
  strain.textContent = joules(energies[instant]);
  scrub.value = clock;
  scrub.setAttribute("aria-valuetext", `${clock.toFixed(2)} s`);
  told.textContent = `${clock.toFixed(2)} s`;
  tip.hidden = true;
  viewer.set_dirty();
}

function step(now) {
  if (!playing) return;
  const gone = ticked === null ? 0 : speed * (now - ticked) / 1e3, span = times[last] - times[0];
  ticked = now;
  show(times[0] + (clock - times[0] + gone) % span);
  requestAnimationFrame(step);
}

function play(on) {
  playing = on && last > 0;
  ticked = null;
  button.setAttribute("aria-label", playing ? "Pause" : "Play");
  button.classList.toggle("playing", playing);
  if (playing) requestAnimationFrame(step);
}

button.addEventListener("click", () => play(!playing));
scrub.addEventListener("input", () => { play(false); show(Number(scrub.value)); });
document.getElementById("speed").addEventListener("change", event => { speed = Number(event.target.value); });

// Space plays and pauses; arrows go by one shown instant, with Shift by ten.
document.addEventListener("keydown", event => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.matches("select")) return;
  const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (event.key === " " && !event.target.matches("button, [type=checkbox]")) play(!playing);
  else if (by) {
    const at = Math.min(Math.max(before(clock + 1e-6) + by * (event.shiftKey ? 10 : 1), 0), last);
    play(false);
    show(times[at]);
  } else if (event.key === "Home" || event.key === "End") {
    play(false);
    show(times[event.key === "Home" ? 0 : last]);
  } else return;
  event.preventDefault();
});

as_it_arrives(() => show(clock));
show(times[0]);
