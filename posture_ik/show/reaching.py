"""A reach in words: what was asked, what it cost, and how far it can be trusted."""

from __future__ import annotations

from typing import Any

import numpy as np

from posture_ik.posture import Trajectory
from posture_ik.problem import TrajectoryBlock, task_label
from posture_ik.show.plots import Figure, axis, joint_name, layout
from posture_ik.show.words import (
    BODY_RESTS_ON,
    PICTURES_REST_ON,
    direction,
    number,
    power,
    units,
    who,
)

#: What a trajectory may miss: equations and limits, the gradient, its tasks when integrated
#: (m or rad), its limits between the points (share), and the torques of its muscles (N m).
MOST = {"primal": 1e-8, "dual": 1e-6, "end_error": 1e-3, "overshoot": 0.05, "imbalance": 1e-6}
#: A muscle that is never more active than this is left out of the chart.
_IDLE = 0.005


#: What is least, in words.
_COSTS = {
    "effort": ["least effort"],
    "time": ["least time"],
    "activation": ["muscles drive the joints", "least activation"],
}


def block_of(found: Trajectory) -> TrajectoryBlock:
    """How the reach was asked for."""
    return found.problem.trajectory or TrajectoryBlock()


def asked(found: Trajectory) -> list[str]:
    """What the problem says."""
    block = block_of(found)
    arms = {joint[-2:] for joint in found.limb.joints}
    joints = f"{len(found.limb.joints)} joints move"
    if len(arms) == 1 and len(found.limb.joints) == 7:
        joints = f"the {'right' if arms == {'_r'} else 'left'} arm moves"
    limits = [
        f"{name} limited{f' to {number(limit)} {unit}' if isinstance(limit, float) else ''}"
        for name, limit, unit in (("torque", block.torque, "N m"), ("speed", block.speed, "rad/s"))
        if limit is not None
    ]
    along = ", ".join(task_label(task) for task in block.along)
    return [
        who(found.problem.subject),
        *_COSTS[block.cost],
        *(["activations change no faster than muscles can"] if block.activation_dynamics else []),
        *([f"in {block.duration:g} s"] if block.duration is not None else []),
        *limits,
        joints,
        "at the end " + ", ".join(task_label(task) for task in found.problem.task),
        *([f"all the way {along}"] if along else []),
        "with gravity",
    ]


def lasts(found: Trajectory) -> str:
    """Why it takes as long as it does."""
    block = block_of(found)
    if block.cost == "time":
        return "the least within the limits"
    return "as asked" if block.duration is not None else "the time that costs least"


def effort(found: Trajectory) -> dict[str, Any]:
    """The effort, as a key number."""
    return {
        "name": "Effort",
        "value": number(found.effort),
        "unit": "(N m)² s",
        "more": "integral of the squared torques of all joints that move",
    }


def checks(found: Trajectory) -> list[dict[str, Any]]:
    """What is checked anew on the result: its value, what it must be, what that means."""
    most = MOST | {"defect": block_of(found).tolerance}
    by_muscles = (
        ("imbalance", "Muscles beside inverse dynamics, N m", "with the reserve, the muscles give "
         "the torques that Pinocchio asks"),
    ) * (found.actuators is not None)  # fmt: skip
    rows = (
        ("primal", "Equations and limits, at the points", "the motion is one of this body, "
         "within its limits, and ends at rest on its tasks"),
        ("dual", "Gradient of the Lagrangian", "to first order, no small change of the "
         "motion costs less"),
        ("defect", "An interval integrated, m or rad", "between the points, too, the torques "
         "give this motion"),
        ("overshoot", "Limits between the points, share", "limits hold between the points "
         "to within five in a hundred"),
        ("end_error", "End, integrated from the start, m or rad", "these torques alone, without "
         "correction, bring the hand there"),
        *by_muscles,
    )  # fmt: skip
    return [
        {
            "what": what,
            "value": power(getattr(found, name)),
            "must": f"at most {power(most[name])}",
            "good": bool(getattr(found, name) <= most[name]),
            "means": means,
        }
        for name, what, means in rows
    ]


def activations(found: Trajectory) -> Figure:
    """Activation of each muscle that works, over time, as a heat map; the hardest at the top."""
    peaks = found.activation.max(axis=0)
    order = [int(i) for i in np.argsort(peaks) if peaks[i] > _IDLE]
    names = found.actuators.names if found.actuators else ()
    heat = {
        "type": "heatmap",
        "x": found.time.tolist(),
        "y": [names[i] for i in order],
        "z": found.activation[:, order].T.tolist(),
        "zmin": 0.0,
        "colorscale": [[0, "#ffffff"], [0.5, "#e8a33d"], [1, "#8c1d18"]],
        "ygap": 1,
        "colorbar": {"thickness": 12, "outlinewidth": 0, "nticks": 5},
        "hovertemplate": "%{y} at %{x:.3f} s: %{z:.3f}<extra></extra>",
    }
    return {"data": [heat], "layout": layout(axis("time, s") | {"zeroline": False})}


def muscles(found: Trajectory) -> str:
    """How hard the muscles work, and what they leave, in a sentence; nothing without muscles."""
    if found.actuators is None:
        return ""
    when, which = divmod(int(found.activation.argmax()), len(found.actuators.names))
    left = np.abs(found.reserve)
    joint = found.limb.joints[int(left.max(axis=0).argmax())]
    where = f"{joint_name(joint)}{direction(joint)}"
    return (
        f"The hardest working is {found.actuators.names[which]}, at "
        f"{number(100 * found.activation[when, which])} % at {number(found.time[when])} s. What "
        f"muscles leave undone is at most {power(left.max())} N m, at {where}."
    )


def rounds(found: Trajectory) -> list[dict[str, str]]:
    """The meshes tried."""
    return [
        {
            "intervals": str(each.intervals),
            "iterations": str(each.iterations),
            "cost": f"{each.cost:.6g}",
            "duration": f"{each.duration:.5g}",
            "defect": power(each.defect),
            "overshoot": power(each.overshoot),
        }
        for each in found.rounds
    ]


def moves(found: Trajectory) -> list[dict[str, str]]:
    """What each joint does: from, to, how fast and how strong at most, and its limits."""
    block, rows = block_of(found), []
    for i, joint in enumerate(found.limb.joints):
        factor, unit, force, _ = units(joint)
        most = [
            limit.get(joint) if isinstance(limit, dict) else limit
            for limit in (block.speed, block.torque)
        ]
        speed, torque = (
            None if each is None else each * f for each, f in zip(most, (factor, 1.0), strict=True)
        )
        rows.append(
            {
                "joint": f"{joint_name(joint)}{direction(joint)}",
                "from": f"{number(factor * found.q[0, i])} {unit}",
                "to": f"{number(factor * found.q[-1, i])} {unit}",
                "speed": f"{number(factor * abs(found.v[:, i]).max())} {unit}/s",
                "most_speed": "" if speed is None else f"{number(speed)} {unit}/s",
                "torque": f"{number(abs(found.tau[:, i]).max())} {force}",
                "most_torque": "" if torque is None else f"{number(torque)} {force}",
            }
        )
    return rows


_AT_WILL = (
    "Torques are what the joints must supply beyond their springs and dampers, that is what "
    "muscles would; they can change at once, as muscles cannot.",
)
_BY_MUSCLES = (
    "What acceleration costs beside the activations is a choice, and shapes the motion of light "
    "joints.",
    "Tendons are rigid, and no ligament holds a joint at the end of its range.",
    "A reserve torque stands by at every joint, priced so that it is next to nothing where muscles "
    "are strong enough.",
)


def assumptions(found: Trajectory) -> list[str]:
    """What the numbers rest on and a reader should know."""
    driven = found.actuators is not None
    return [
        *BODY_RESTS_ON[:-1],
        "The springs and dampers of the arms are assumed; "
        + (
            "those of the joints that move are left out, where muscles stand for the tissue."
            if driven
            else "what muscles must add is net of them."
        ),
        "At the start the person takes the posture of least strain energy under the tasks that "
        "the moving joints cannot change; all other joints stand firm, whatever that takes. The "
        "posture in report.html, where all joints give way, is another.",
        *(_BY_MUSCLES if driven else _AT_WILL),
        "The motion is a local optimum, found from a straight one of bell-shaped speed.",
        "Limbs may pass through one another, seat and levers: contact is not looked for.",
        PICTURES_REST_ON,
    ]
