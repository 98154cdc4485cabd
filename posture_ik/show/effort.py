"""What pages and summary ask of muscle activity: names, the hardest instant, the arms that hold."""

from __future__ import annotations

import numpy as np

from posture_ik.arrays import Array
from posture_ik.body.tables import read_table
from posture_ik.muscle import Activity
from posture_ik.muscle.activity import ARMS
from posture_ik.muscle.arm import DATA
from posture_ik.problem import Hand

#: Colours from a muscle at rest to one at full activation, 0 to 1; darker throughout, and other
#: than those of strain energy.
RAMP = (
    (0.87, 0.92, 0.80),
    (0.55, 0.80, 0.42),
    (0.13, 0.60, 0.33),
    (0.00, 0.38, 0.34),
    (0.00, 0.17, 0.22),
)
#: What is least, in words.
COSTS = {
    "squares": "the sum of squared activations is least",
    "volume": "the sum of squared activations, weighted by muscle volume, is least",
    "fatigue": "the highest activation is as low as can be",
}
#: What each muscle is called, by its short name without a side.
NAMES = {muscle: row["name"] for muscle, row in read_table(DATA / "arm_muscles.csv").items()}


def muscle_name(muscle: str) -> str:
    """What people call a muscle: `anterior deltoid` for `DELT1_r`."""
    return NAMES[muscle.rpartition("_")[0]]


def hardest(activity: Activity) -> int:
    """The step of greatest effort: of most missing torque, else of most squared activation."""
    missing, effort = (np.sum(of**2, axis=1) for of in (activity.reserve, activity.activation))
    return int(np.lexsort((effort, missing))[-1])


def held(activity: Activity) -> tuple[str, ...]:
    """The sides whose arm holds something: a task has its hand, or a load is on it."""
    busy = {task.side for task in activity.problem.task if isinstance(task, Hand)}
    return tuple(side for side in ARMS if side in busy | set(activity.asked.hand_force))


def held_joints(activity: Activity) -> list[tuple[int, str]]:
    """Number and name of the joints of the arms that hold something."""
    joints = [i for side in held(activity) for i in range(14)[ARMS[side][1]]]
    return [(i, activity.paths.dofs[i]) for i in joints]


def peak_of(activity: Activity, dof: str) -> tuple[float, float]:
    """The largest reserve of a joint, with its sign, N m, and when, s."""
    course: Array = activity.reserve[:, activity.paths.dofs.index(dof)]
    step = int(np.argmax(np.abs(course)))
    return float(course[step]), float(activity.time[step])


def certified(activity: Activity) -> bool:
    """Whether the activations of every instant and arm are proven to be the optimum."""
    return all(arm.certificate.holds for arms in activity.recruitments for arm in arms)
