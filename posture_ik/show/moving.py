"""A motion as numbers for the 3D page's player: where everything is at each shown instant."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.body.laws import scale_of
from posture_ik.kinematics import frame_poses
from posture_ik.posture import Posture, Wrench
from posture_ik.problem import SPINE
from posture_ik.show.arrows import arrows, size, turns
from posture_ik.show.looks import Look
from posture_ik.show.played import Moving, Sampled
from posture_ik.show.scene import Handles, handles_of, leaning, tinted
from posture_ik.show.skin import back_of, ride, skin
from posture_ik.show.strain import Part, colour, full_scale

#: Shown instants a second, and the least and most in all; the page moves smoothly between them.
_A_SECOND, _LEAST, _MOST = 60.0, 61, 900
#: Frames whose way through the world is drawn, and what people call them.
FOLLOWED = {"Head": "head", "grip_r": "right hand", "grip_l": "left hand"}
#: What stays within this (m) has no way worth drawing.
_STILL = 5e-3


def shown_steps(time: Array) -> npt.NDArray[np.int64]:
    """Which steps of a motion a page shows, (f,): at most 60 a second, or 61; first and last too.

    Args:
        time: of every step, (T,), s.
    """
    count = max(int((time[-1] - time[0]) * _A_SECOND) + 1, _LEAST)
    count = min(len(time), count, _MOST)
    wanted = np.linspace(time[0], time[-1], max(count, 2))
    return np.unique(np.searchsorted((time[1:] + time[:-1]) / 2, wanted))


def wrenches_at(motion: Moving, step: int) -> list[Wrench]:
    """What acts on the person at a step, the seat last."""
    return [
        Wrench(label, motion.forces[step, k], motion.moments[step, k], motion.points[step, k])
        for k, label in enumerate(motion.wrench_labels)
    ]


def largest_wrenches(motion: Moving) -> list[Wrench]:
    """The largest force and the largest moment of everything that acts during a motion."""
    found = []
    for k, label in enumerate(motion.wrench_labels):
        forces, moments = motion.forces[:, k], motion.moments[:, k]
        force = forces[np.argmax(np.linalg.norm(forces, axis=1))]
        moment = moments[np.argmax(np.linalg.norm(moments, axis=1))]
        found.append(Wrench(label, force, moment, motion.points[0, k]))
    return found


def peak_parts(motion: Moving, parts: Mapping[str, Part]) -> dict[str, Part]:
    """The same parts with the most strain energy they hold at any shown instant."""
    energies = np.array([motion.postures[i].energies for i in shown_steps(motion.time)])
    return {
        link: part._replace(energy=float(energies[:, part.dofs].sum(axis=1).max()))
        for link, part in parts.items()
    }


def followed(motion: Moving) -> dict[str, Array]:
    """Where the head and the hands go, (T, 3), m, by name; those that stay are left out."""
    ways = {
        name: np.array([posture.frames[frame].translation for posture in motion.postures])
        for frame, name in FOLLOWED.items()
        if frame in motion.postures[0].frames
    }
    return {name: way for name, way in ways.items() if np.ptp(way, axis=0).max() > _STILL}


def round_times(time: Array, most: int = 8) -> Array:
    """Round instants of a motion, s: from its start, at most `most` intervals."""
    span = float(time[-1] - time[0])
    steps = [m * 10.0**e for e in range(-3, 4) for m in (1, 2, 5)]
    step = next(step for step in steps if span <= most * step)
    return np.asarray(time[0] + step * np.arange(int(span / step + 1e-9) + 1))


def animation(motion: Moving, looks: Sequence[Look], parts: Mapping[str, Part]) -> dict[str, Any]:
    """Everything that the page's player needs to show any instant of a motion.

    Args:
        motion: what to show.
        looks: the shapes of the person.
        parts: the joints they hang on, with the most energy they hold, J.
    """
    steps = shown_steps(motion.time)
    postures = [motion.postures[i] for i in steps]
    placed = _placed(postures, handles(motion, steps), looks)
    energies = np.array([posture.energies for posture in postures])
    instants = motion.time[steps]
    ticks = round_times(instants)
    return {
        "span": [float(instants[0]), float(instants[-1])],
        "time": packed(instants),
        "paths": list(placed),
        "poses": packed(np.swapaxes([seven(poses) for poses in placed.values()], 0, 1)),
        "tints": _tints(energies, looks, parts),
        "skin": riding(postures[0], list(placed)),
        "wrenches": _wrenches(motion, steps),
        "energy": packed(energies.sum(axis=1)),
        "ways": [
            {
                "name": name,
                "points": packed(way[steps]),
                "ticks": [
                    [f"{t:g} s", *(float(np.interp(t, motion.time, x)) for x in way.T)]
                    for t in ticks
                ],
            }
            for name, way in followed(motion).items()
        ],
    }


def packed(values: npt.ArrayLike, kind: str = "<f4") -> str:
    """Numbers as base64 of their bytes, row by row; floats of 4 bytes unless told."""
    return base64.b64encode(np.ascontiguousarray(values, kind).tobytes()).decode("ascii")


def handles(motion: Moving, steps: Sequence[int] | npt.NDArray[np.int64]) -> list[Handles]:
    """Where the levers stand at some steps: as the postures have them, or where a reach ends."""
    held = [-1] * len(steps) if isinstance(motion, Sampled) else steps
    return [handles_of(motion.postures[i]) for i in held]


def _placed(
    postures: Sequence[Posture], held: Sequence[Handles], looks: Sequence[Look]
) -> dict[str, list[pin.SE3]]:
    """The pose of everything that moves, at each instant, by its path in the drawing."""
    links = dict.fromkeys((*SPINE, *(look.link for look in looks)))
    placed = {f"person/{link}": [p.frames[link] for p in postures] for link in links}
    placed |= {f"levers/{name}": [now[name] for now in held] for name in held[0]}
    if len({posture.problem.seat.recline_deg for posture in postures}) > 1:
        placed["seat/backrest"] = [backrest_of(posture) for posture in postures]
    return placed


def backrest_of(posture: Posture) -> pin.SE3:
    """Where the backrest stands that touches the back."""
    body = posture.body
    reference = frame_poses(body.model, body.q_reference)
    girth = scale_of(body.subject).length["thoracic"][0]
    return leaning(posture, back_of(skin(reference, posture.frames, girth), reference, girth))


def seven(poses: Sequence[pin.SE3]) -> Array:
    """Position (m) and quaternion (x, y, z, w), (f, 7); one sign, so that a page may blend them."""
    rows = np.array([pin.SE3ToXYZQUAT(pose) for pose in poses])
    flips = np.where(np.sum(rows[1:, 3:] * rows[:-1, 3:], axis=1) < 0.0, -1.0, 1.0)
    rows[1:, 3:] *= np.cumprod(flips)[:, None]
    return rows


def _tints(energies: Array, looks: Sequence[Look], parts: Mapping[str, Part]) -> dict[str, Any]:
    """The colour of each shape that shows what its joint carries, 0 to 255."""
    full = full_scale(parts)
    shown = [look for look in looks if tinted(look, parts)]
    carried = [energies[:, parts[look.link].dofs].sum(axis=1) for look in shown]
    rgb = [
        [colour(float(e[f]), full, look.rgba[:3]) for e, look in zip(carried, shown, strict=True)]
        for f in range(len(energies))
    ]
    return {
        "paths": [f"person/{look.link}/{look.name}" for look in shown],
        "rgb": packed(np.round(255 * np.array(rgb)), "u1"),
    }


def riding(posture: Posture, paths: Sequence[str]) -> dict[str, Any]:
    """How the skin rides on the vertebrae, for the page to carry it along."""
    body = posture.body
    reference = frame_poses(body.model, body.q_reference)
    rest, lower, share = ride(reference, scale_of(body.subject).length["thoracic"][0])
    return {
        "rest": packed(rest.vertices),
        "lower": packed(lower, "u1"),
        "share": packed(share),
        "levels": [paths.index(f"person/{name}") for name in SPINE],
        "poses": packed(seven([reference[name] for name in SPINE])),
    }


def _wrenches(motion: Moving, steps: npt.NDArray[np.int64]) -> dict[str, Any]:
    """What acts at each instant: force (3), moment (3), point (3), and how they are drawn.

    `drawn` holds where an arrow starts, where it ends, and the moment's axis times the radius of
    its ring; a force or moment too small to be drawn has no length. `lengths` and `radii` are
    those of the shapes in the drawing, by name.
    """
    largest = largest_wrenches(motion)
    force = max((float(np.linalg.norm(w.force)) for w in largest), default=0.0)
    moment = max((float(np.linalg.norm(w.moment)) for w in largest), default=0.0)
    drawn = np.zeros((len(steps), len(largest), 9))
    loads = []
    for f, i in enumerate(steps):
        now = wrenches_at(motion, int(i))
        drawn[f, :, :3] = drawn[f, :, 3:6] = motion.points[i]
        order = list(motion.wrench_labels)
        for arrow in arrows(now, force):
            drawn[f, order.index(arrow.name), :3] = arrow.tail
        for turn in turns(now, moment):
            drawn[f, order.index(turn.name), 6:] = turn.axis * turn.radius
        loads.append([[size(w.force), size(w.moment)] for w in now])
    lengths = {
        arrow.name: float(np.linalg.norm(arrow.tip - arrow.tail)) for arrow in arrows(largest)
    }
    return {
        "names": list(motion.wrench_labels),
        "drawn": packed(drawn),
        "loads": loads,
        "lengths": lengths,
        "radii": {turn.name: turn.radius for turn in turns(largest)},
    }
