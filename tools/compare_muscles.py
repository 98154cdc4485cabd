"""Compares our muscle paths with MuJoCo's on `myo-sim`'s arm and writes `docs/muscle_paths.md`.

    pip install mujoco myo-sim posture_ik && python tools/compare_muscles.py

Both arms stand in the same postures, spread evenly over the range in which the paths hold. Once
the scapula is frozen there as it is here, and what differs is the formula; once it follows the
humerus as myo-sim's own couplings have it, and what differs is the freezing.
"""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Any

import extract_arm
import mujoco
import numpy as np
from extract_muscles import DOUBTFUL, LEFT_OUT, MUSCLES
from scipy.spatial.transform import Rotation

from posture_ik.body import build_body
from posture_ik.muscle import Paths
from posture_ik.problem import Subject

POSTURES = 2000
SHOULDER = ("elv_angle_r", "shoulder_elv_r", "shoulder_rot_r")
OTHERS = tuple(theirs for theirs, *_ in extract_arm.JOINTS.values())
#: TRIlong without the point that ours leaves out.
FREED = "TRIlong_without_P1b"


def build() -> tuple[Any, Any]:
    """The compiled arm and its state as in `extract_arm`, with TRIlong's path also without P1b."""
    spec = extract_arm.spec()
    tendon = spec.add_tendon(name=FREED)
    tendon.wrap_site("TRIlong_TRIlong-P1_r")
    tendon.wrap_geom("TRIlonghh_ellipsoid_TRIlong", "")
    for i in range(2, 6):
        tendon.wrap_site(f"TRIlong_TRIlong-P{i}_r")
    return extract_arm.compiled(spec)


def theirs(
    model: Any, state: Any, angles: np.ndarray, moving: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Lengths (25,) and their slopes (25, 7) by our joints at our joint angles (7,).

    Args:
        model: Of `build`.
        state: Of `build`; it is changed.
        angles: Of the joints in our order, rad.
        moving: Whether the scapula follows the humerus.
    """
    flexion, abduction, rotation, *others = angles
    humerus = Rotation.from_euler("ZXY", [flexion, -abduction, rotation])
    axis, lift = model.joint(SHOULDER[0]).axis, model.joint(SHOULDER[1]).axis
    # Where the humerus is lifted in a plane: turns about axis, lift and axis again.
    frame = np.column_stack([lift, axis, np.cross(lift, axis)])
    there = Rotation.from_matrix(frame.T @ humerus.as_matrix() @ frame).as_euler("YXY")
    for _ in range(2):  # axis and lift are square to each other to five digits only
        turns = [
            Rotation.from_rotvec(t * a) for t, a in zip(there, (axis, lift, axis), strict=True)
        ]
        error = (humerus * (turns[0] * turns[1] * turns[2]).inv()).as_rotvec()
        rates = np.column_stack([axis, turns[0].apply(lift), (turns[0] * turns[1]).apply(axis)])
        there = there + np.linalg.solve(rates, error)
    for joint, angle in zip((*SHOULDER, *OTHERS), (*there, *others), strict=True):
        state.joint(joint).qpos[0] = angle
    state.joint("shoulder1_r2_r").qpos[0] = 0.0
    followers = {
        joint: np.polynomial.Polynomial(polynomial)
        for joint, polynomial in extract_arm.followers(model).items()
    }
    for joint, polynomial in followers.items():
        elevation = there[1] if moving else extract_arm.SHOULDER_ELEVATION
        state.joint(joint).qpos[0] = polynomial(elevation)
    mujoco.mj_fwdPosition(model, state)
    names = ["TRIlong" if name == FREED else name for name in tendons(model)]
    at = [names.index(muscle) for muscle in MUSCLES]

    lengths, slopes = state.ten_length[at].copy(), np.zeros((len(MUSCLES), 7))
    hinges = np.column_stack(
        [
            [0.0, 0.0, 1.0],
            Rotation.from_euler("Z", flexion).apply([-1.0, 0.0, 0.0]),
            Rotation.from_euler("ZX", [flexion, -abduction]).apply([0.0, 1.0, 0.0]),
        ]
    )
    shoulder = np.linalg.solve(rates, hinges)
    for k in range(7):
        state.qvel[:] = 0.0
        if k < 3:
            for joint, rate in zip(SHOULDER, shoulder[:, k], strict=True):
                state.joint(joint).qvel[0] = rate
            for joint, polynomial in followers.items() if moving else ():
                state.joint(joint).qvel[0] = polynomial.deriv()(there[1]) * shoulder[1, k]
        else:
            state.joint(OTHERS[k - 3]).qvel[0] = 1.0
        mujoco.mj_fwdVelocity(model, state)
        slopes[:, k] = state.ten_velocity[at]
    return lengths, slopes


def tendons(model: Any) -> list[str]:
    """Names of the tendons, less their ending; the freed TRIlong stands for the tied one."""
    names = [model.tendon(i).name.removesuffix("_tendon") for i in range(model.ntendon)]
    return ["TRIlong as it is" if name == "TRIlong" else name for name in names]


def postures(paths: Paths, count: int = POSTURES) -> np.ndarray:
    """Joint angles of the right arm (count, 7) over the range in which the paths hold, rad."""
    random = np.random.default_rng(1)
    return random.uniform(paths.lower[:7], paths.upper[:7], (count, 7))


def compare(moving: bool) -> tuple[np.ndarray, np.ndarray]:
    """Ours less theirs: lengths (postures, 25) and slopes (postures, 25, 7), m."""
    model, state = build()
    body = build_body(Subject())
    paths = Paths.of(body)
    lengths, slopes = [], []
    for angles in postures(paths):
        q = body.q_reference.copy()
        q[paths.rows[:7]] = angles
        ours = paths.evaluate(q)
        length, slope = theirs(model, state, angles, moving)
        lengths.append(ours[0][:25] / paths.scale - length)
        slopes.append(ours[1][:25, :7] / paths.scale - slope)
    return np.array(lengths), np.array(slopes)


def main() -> None:
    """Write the page."""
    frozen, free = compare(moving=False), compare(moving=True)
    lines = [
        "# Muscle paths against myo-sim",
        "",
        f"Ours less those of MuJoCo {mujoco.__version__} on the arm of myo-sim "
        f"{version('myo-sim')}, at {POSTURES} postures spread",
        "evenly over the range in which the paths hold (`posture_ik/muscle/data/arm_range.csv`),",
        "in mm: the root mean square and the worst of the length, and of the moment arms about the",
        "joint where they differ most. Written by `tools/compare_muscles.py`.",
        "",
        "*Frozen*: the scapula stands there as it does here, and what is left is the smooth",
        "switching. TRIlong is compared without the point P1b that we leave out.",
        "",
        "*Moving*: the scapula follows the humerus as in myo-sim; this is what freezing it costs.",
        "The moment arms then hold the work done on the scapula's own joints, which ours leave to",
        "the trunk.",
        "",
        "| muscle | length, frozen | arms, frozen | length, moving | arms, moving |",
        "| --- | --- | --- | --- | --- |",
    ]
    for i, muscle in enumerate(MUSCLES):
        cells = [muscle]
        for (lengths, slopes), digits in ((frozen, 4), (free, 1)):
            length, arms = 1000 * lengths[:, i], 1000 * slopes[:, i]
            rms = np.sqrt(np.mean(arms**2, axis=0)).max()
            for size, worst in (
                (np.sqrt(np.mean(length**2)), np.abs(length).max()),
                (rms, np.abs(arms).max()),
            ):
                cells.append(f"{size:.{digits}f}, {worst:.{digits}f}")
        lines.append(f"| {' | '.join(cells)} |")
    lines += ["", "## Left out of myo-sim's paths", ""]
    lines += [f"- {muscle}, `{element}`: {why}." for (muscle, element), why in LEFT_OUT.items()]
    lines += ["", "## Kept, with doubts", ""]
    lines += [f"- {muscle} {why}." for muscle, why in DOUBTFUL.items()]
    lines += [
        "",
        "Forces, fibre and tendon lengths are not read from myo-sim: the length ranges by which it",
        "scales them do not hold the paths of LAT1, PT, DELT2, ECRL and FCR, and its SUPSP carries",
        "the gain of SUP. They are those of Saul et al. 2014 (`arm_muscles.csv`), on which every",
        "fibre stays between 0.25 and 1.75 of its optimal length over the range.",
    ]
    page = Path(__file__).resolve().parents[1] / "docs" / "muscle_paths.md"
    page.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
