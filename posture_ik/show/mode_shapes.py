"""Mode shapes as numbers for the 3D page: how everything swings about its place in each mode."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import meshcat
import meshcat.geometry as g
import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.body.scaling import Scale
from posture_ik.body.spine import inertias
from posture_ik.muscle import Activity
from posture_ik.problem import SPINE, FoamBack, LawBack, RigidBack
from posture_ik.show.looks import Look
from posture_ik.show.moving import backrest_of, packed, riding, seven
from posture_ik.show.tubes import riders
from posture_ik.vibration import Mode, Vibration
from posture_ik.vibration.shapes import link_motions
from posture_ik.vibration.system import Complex

#: Modes shown, at most, and up to which frequency, Hz.
_MOST, _HIGHEST = 20, 20.0
#: A rotation counts as far as it moves a point at this distance, m: about a vertebra's reach.
_REACH = 0.1
#: The viscera are drawn as balls of water that weigh as much, kg/m³.
_DENSITY = 1000.0
_VISCUS = 0xB5655D


def mode_shapes(
    vibration: Vibration, looks: Sequence[Look], activity: Activity | None
) -> dict[str, Any]:
    """Everything that the page needs to show the modes of a person.

    `places` (p, 7) holds where each path of the drawing stands at rest, position and quaternion;
    `swing` of a mode (p, 2, 6) the real and imaginary parts of its displacement and rotation,
    world axes, scaled so that the largest displacement is 1 m.

    Args:
        vibration: whose modes.
        looks: the shapes of the person.
        activity: of the muscles that are drawn too.
    """
    riding_muscles = riders(activity) if activity else None
    links = {look.link for look in looks} | set(riding_muscles["links"] if riding_muscles else ())
    posture, stability = vibration.posture, vibration.stability
    placed, motions = _moving(vibration, sorted(links.union(SPINE)))
    shapes = np.array([motions[path] for path in placed])
    kinds = {"undamped": vibration.undamped, "damped": vibration.damped}
    return {
        "model": vibration.asked.model.removeprefix("lumped:").replace("_", "-"),
        "back": _back(vibration.problem.seat.backrest),
        "alarm": "" if stability.stable else f"The posture is {stability}.",
        "kinds": {
            kind: [_shown(mode, shapes) for mode in _oscillating(modes)]
            for kind, modes in kinds.items()
            if placed
        },
        "paths": list(placed),
        "places": packed(seven(list(placed.values()))) if placed else "",
        "skin": riding(posture, list(placed)) if placed else None,
        "muscles": riding_muscles,
    }


def _back(backrest: RigidBack | FoamBack | LawBack | None) -> str:
    match backrest:
        case RigidBack():
            return "held by a rigid backrest"
        case FoamBack():
            return "against a backrest of foam"
        case LawBack():
            return "against a backrest that stiffens as it is pressed"
    return "free: the model has no backrest"


def draw_viscera(visualizer: meshcat.Visualizer, vibration: Vibration) -> None:
    """Draw the viscera that swing, each in its place."""
    frames = vibration.posture.frames
    for name, mass in _viscera(vibration).items():
        ball = g.Sphere((3.0 * mass / (4.0 * np.pi * _DENSITY)) ** (1 / 3))
        glass = g.MeshPhongMaterial(color=_VISCUS, opacity=0.5, depthWrite=False, shininess=8)
        place = visualizer[f"viscera/{name}"]
        place.set_object(ball, glass)
        place.set_transform(frames[name].homogeneous)


def _viscera(vibration: Vibration) -> dict[str, float]:
    """Mass of each viscus that has a motion of its own, kg."""
    of = inertias(Scale.of(vibration.posture.body.subject))
    own = {name.replace(" ", "_").rpartition("_")[0] for name in vibration.system.coordinates}
    return {name: of[name].mass for name in of if name in own and name not in SPINE}


def _moving(
    vibration: Vibration, links: Sequence[str]
) -> tuple[dict[str, pin.SE3], dict[str, Array]]:
    """Where everything that may move stands, and its motion (6, n), by its path in the drawing."""
    posture, system = vibration.posture, vibration.system
    grips = {f"levers/{name}": f"lever_{name}_grip" for name in posture.levers}
    drawn = {f"person/{link}": link for link in links}
    drawn |= {f"viscera/{name}": name for name in _viscera(vibration)}
    drawn |= {path: grip for path, grip in grips.items() if grip in posture.frames}
    found = link_motions(vibration, list(drawn.values()))
    if not found:
        return {}, {}
    placed = {path: posture.frames[link] for path, link in drawn.items()}
    motions = {path: found[link] for path, link in drawn.items()}
    here, back = pin.SE3.Identity(), backrest_of(posture)
    ports = [port.name for port in system.outputs]
    for layer, path, pose in (
        ("cushion", "seat/pan", here),
        ("seat", "seat/stem", here),
        ("seat", "seat/backrest", back),
    ):
        if f"{layer} acceleration z" in ports:
            placed[path], motions[path] = pose, np.zeros((6, len(system.coordinates)))
            motions[path][2] = system.Y[2, ports.index(f"{layer} acceleration z")]
    return placed, motions


def _oscillating(modes: Sequence[Mode]) -> list[Mode]:
    return [m for m in modes if m.eigenvalue.imag > 0.0 and m.frequency <= _HIGHEST][:_MOST]


def _shown(mode: Mode, shapes: Array) -> dict[str, Any]:
    motions = scaled(shapes @ mode.shape)
    return {
        "frequency": mode.frequency,
        "damping": mode.damping_ratio,
        "symmetry": mode.symmetry,
        "words": mode.words,
        "swing": packed(np.stack([motions.real, motions.imag], axis=1)),
    }


def scaled(motions: Complex) -> Complex:
    """Motions (p, 6), made so large that the largest displacement in a cycle is 1 m, at its start.

    Args:
        motions: displacement, m, and rotation, rad, of p bodies as complex amplitudes.
    """
    arms = np.concatenate([motions[:, :3], _REACH * motions[:, 3:]])
    # |Re(z exp(iθ))| reaches the larger singular value of [Re z, Im z].
    largest = np.linalg.norm(np.stack([arms.real, arms.imag], axis=-1), ord=2, axis=(1, 2))
    most = int(np.argmax(largest))
    turn = np.angle(np.sum(arms[most] ** 2)) / 2
    unit: Complex = motions * np.exp(-1j * turn) / largest[most]
    return unit
