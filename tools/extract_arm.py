"""Reads the arm of `myo-sim` and writes `posture_ik/body/data/arm_*.csv`.

    pip install mujoco myo-sim && python tools/extract_arm.py

The model is the MyoArm of myo-sim (Apache-2.0), a MuJoCo rendering of the upper limb of Saul et al.
(2014) and Holzbaur et al. (2005). Frames are those of its bodies: x forward, y up, z to the right
when the arm hangs. Scapula and clavicle are frozen where its own couplings put them at
`SHOULDER_ELEVATION`; the carpals, metacarpals and phalanges are lumped into one hand with the
fingers curled by `FINGER_FLEXION` as round a stick.
"""

from __future__ import annotations

import csv
import warnings
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

SHOULDER_ELEVATION = np.radians(35.0)
FINGER_FLEXION = np.radians(45.0)
#: From the knuckles' mean centre to the axis of a held stick, towards the palm, m (assumed).
KNUCKLE_TO_STICK = 0.025
#: Own inertia that the model gives a carpal or phalanx for its solver's sake, kg m², tenfold or
#: more of what such a bone can have; the hand keeps the bones' masses and where they lie, not this.
PLACEHOLDER_INERTIA = 1e-4

#: Our joint: myo-sim's joint, the body it moves and the body it hangs on.
JOINTS = {
    "elbow_flexion": ("elbow_flexion_r", "ulna_r", "humerus_r"),
    "pronation": ("pro_sup_r", "radius_r", "ulna_r"),
    "wrist_deviation": ("deviation_r", "lunate_r", "radius_r"),
    "wrist_flexion": ("flexion_r", "lunate_r", "lunate_r"),
}
BODIES = {"humerus": "humerus_r", "ulna": "ulna_r", "radius": "radius_r", "hand": "lunate_r"}
FRAMES = {"thorax": "torso", "clavicle": "clavicle_r", "scapula": "scapula_r"}
KNUCKLES = ("2proxph_r", "3proxph_r", "4proxph_r", "5proxph_r")
PROVENANCE = (
    "myo-sim {} (Apache-2.0), myoarm_r, after Saul et al. 2014 and Holzbaur et al. 2005; "
    "right arm, x forward, y up, z right; written by tools/extract_arm.py"
)


def spec() -> Any:
    """The arm as its authors compose it."""
    from myo_sim.build import compose

    return compose.build_spec("myoarm_r")


def compiled(spec: Any) -> tuple[Any, Any]:
    """An arm's model and its state: scapula, clavicle and fingers set, the other joints at 0."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = spec.compile()
    return model, rest(model)


def build() -> tuple[Any, Any]:
    """The compiled arm and its state."""
    return compiled(spec())


def followers(model: Any) -> dict[str, np.ndarray]:
    """Joints of scapula and clavicle, each a polynomial in the shoulder's elevation (ascending)."""
    return {
        model.joint(model.eq_obj1id[i]).name: model.eq_data[i][:5]
        for i in range(model.neq)
        if model.joint(model.eq_obj2id[i]).name == "shoulder_elv_r"
    }


def rest(model: Any) -> Any:
    """A state with scapula, clavicle and fingers set, the other joints at 0."""
    state = mujoco.MjData(model)
    for joint, polynomial in followers(model).items():
        state.joint(joint).qpos[0] = np.polyval(polynomial[::-1], SHOULDER_ELEVATION)
    for i in range(model.njnt):
        name = model.joint(i).name
        if name.startswith(("mcp", "pm", "md")) and "flexion" in name:
            state.joint(name).qpos[0] = FINGER_FLEXION
    mujoco.mj_kinematics(model, state)
    return state


def pose(state: Any, body: str, base: str) -> tuple[np.ndarray, np.ndarray]:
    """Rotation (3, 3) and position (3,) of a body in another body's frame."""
    at, on = state.body(body), state.body(base)
    R = on.xmat.reshape(3, 3).T
    return R @ at.xmat.reshape(3, 3), R @ (at.xpos - on.xpos)


def frames(model: Any, state: Any) -> list[list[Any]]:
    """Links fixed to the trunk, in the hanging arm's axes at the glenohumeral centre."""
    rows = []
    for link, body in FRAMES.items():
        R, p = pose(state, body, "scapphant_r")
        rows.append([link, *p, *R.ravel()])
    knuckles = np.mean([pose(state, body, "lunate_r")[1] for body in KNUCKLES], axis=0)
    # x along the hand, y out of its back or palm to the left, z towards the thumb
    R = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    rows.append(["grip", *(knuckles - [0.0, 0.0, KNUCKLE_TO_STICK]), *R.ravel()])
    return rows


def joints(model: Any, state: Any) -> list[list[Any]]:
    """Centres and axes in the frame before; the shoulder as hinges about z, -x and y."""
    rows: list[list[Any]] = [
        ["shoulder_flexion", 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        ["shoulder_abduction", 0.0, 0.0, 0.0, -1.0, 0.0, 0.0],
        ["shoulder_rotation", 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    ]
    for joint, (theirs, body, base) in JOINTS.items():
        _, centre = pose(state, body, base)
        rows.append([joint, *centre, *model.joint(theirs).axis])
    return rows


def bodies(model: Any, state: Any) -> list[list[Any]]:
    """Mass, centre of mass in the link's frame and inertia about it along the link's axes."""
    rows = []
    for link, body in BODIES.items():
        parts = [body] if link != "hand" else descendants(model, body)
        base = state.body(body)
        R = base.xmat.reshape(3, 3)
        masses = np.array([model.body(part).mass[0] for part in parts])
        centres = np.array([R.T @ (state.body(part).xipos - base.xpos) for part in parts])
        centre = masses @ centres / masses.sum()
        inertia = np.zeros((3, 3))
        for part, mass, r in zip(parts, masses, centres - centre, strict=True):
            axes = R.T @ state.body(part).ximat.reshape(3, 3)
            own = model.body(part).inertia
            if link != "hand" or not np.allclose(own, PLACEHOLDER_INERTIA):
                inertia += axes @ np.diag(own) @ axes.T
            inertia += mass * (r @ r * np.eye(3) - np.outer(r, r))
        rows.append([link, masses.sum(), *centre, *inertia[np.triu_indices(3)]])
    return rows


def descendants(model: Any, root: str) -> list[str]:
    """A body and all that hangs on it."""
    family = {model.body(root).id}
    for i in range(model.nbody):
        if model.body_parentid[i] in family:
            family.add(i)
    return [model.body(i).name for i in sorted(family)]


TABLES = {
    "arm_frames": (
        frames,
        "fixed links: thorax, clavicle and scapula (frozen at 35 deg of shoulder elevation) from "
        "the glenohumeral centre; grip from the hand, assumed 25 mm palmar of the knuckles",
        "link,x_m,y_m,z_m,r11,r12,r13,r21,r22,r23,r31,r32,r33",
    ),
    "arm_joints": (
        joints,
        "joint centres and axes in the frame before, all frames parallel at zero; positive as "
        "named; the three shoulder hinges (abduction about -x) are ours",
        "joint,x_m,y_m,z_m,axis_x,axis_y,axis_z",
    ),
    "arm_bodies": (
        bodies,
        "masses, centres and inertias; hand lumped with fingers flexed 45 deg, without the 1e-4 "
        "kg m2 its small bones carry as placeholders",
        "link,mass_kg,x_m,y_m,z_m,ixx_kg_m2,ixy_kg_m2,ixz_kg_m2,iyy_kg_m2,iyz_kg_m2,izz_kg_m2",
    ),
}


def text(rows: Iterable[Iterable[Any]]) -> list[list[str]]:
    """Numbers rounded to 1e-12 (below is the compiler's noise), shortest form; no minus zero."""
    return [
        [v if isinstance(v, str) else repr(round(float(v), 12) + 0.0) for v in row] for row in rows
    ]


def main() -> None:
    """Write the three tables."""
    model, state = build()
    folder = Path(__file__).resolve().parents[1] / "posture_ik" / "body" / "data"
    for name, (read, what, columns) in TABLES.items():
        with (folder / f"{name}.csv").open("w", newline="") as file:
            file.write(f"# {PROVENANCE.format(version('myo-sim'))}; {what}\n{columns}\n")
            csv.writer(file, lineterminator="\n").writerows(text(read(model, state)))


if __name__ == "__main__":
    main()
