"""What is largest in a motion, where and when: rows for the tables of its report."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.posture import Motion
from posture_ik.show.courses import STILL, groups_of, in_peoples_units, short_name
from posture_ik.show.moving import FOLLOWED
from posture_ik.show.played import Moving
from posture_ik.show.plots import joint_name
from posture_ik.show.words import direction, number, units

Row = dict[str, Any]


def speeds(motion: Moving) -> dict[str, Array]:
    """Speed of the head and of the hands, (T,), m/s, by name."""
    model = motion.body.model
    data = model.createData()
    frames = [frame for frame in FOLLOWED if model.existFrame(frame)]
    found = np.zeros((len(motion.time), len(frames)))
    for step, (q, v) in enumerate(zip(motion.q, motion.v, strict=True)):
        pin.forwardKinematics(model, data, q, v)
        for k, frame in enumerate(frames):
            index = model.getFrameId(frame)
            found[step, k] = np.linalg.norm(pin.getFrameVelocity(model, data, index).linear)
    return {FOLLOWED[frame]: speed for frame, speed in zip(frames, found.T, strict=True)}


def cards(motion: Moving, lasts: str) -> list[Row]:
    """Key numbers: how long, and in a word why, how fast, how strong."""
    time = motion.time
    cards = [
        {
            "name": "Lasts",
            "value": number(time[-1] - time[0]),
            "unit": "s",
            "more": lasts,
        }
    ]
    fast = speeds(motion)
    name = max(fast, key=lambda name: float(fast[name].max()), default="")
    if name:
        cards.append(
            {
                "name": f"Fastest: {name}",
                "value": number(fast[name].max()),
                "unit": "m/s",
                "more": f"at {_when(motion, fast[name])}",
            }
        )
    turning = [i for i, dof in enumerate(motion.body.dofs) if not dof.endswith("_axial")]
    torque = np.abs(motion.tau[:, turning])
    joint = turning[int(np.argmax(torque.max(axis=0)))]
    cards.append(
        {
            "name": "Largest torque",
            "value": number(torque.max()),
            "unit": "N m",
            "more": f"{_full_name(motion, joint)} at {_when(motion, motion.tau[:, joint])}",
        }
    )
    both = (("force", motion.forces, "N"), ("moment", motion.moments, "N m"))
    for kind, values, unit in both if motion.wrench_labels else ():
        sizes = np.linalg.norm(values, axis=2)
        place = int(np.argmax(sizes.max(axis=0)))
        cards.append(
            {
                "name": f"Largest {kind}",
                "value": number(sizes.max()),
                "unit": unit,
                "more": f"at the {motion.wrench_labels[place]}, {_when(motion, sizes[:, place])}",
            }
        )
    return cards


def _when(motion: Moving, values: Array) -> str:
    """When something (T,) is largest."""
    return f"{motion.time[np.argmax(np.abs(values))]:.3f} s"


def _full_name(motion: Moving, index: int) -> str:
    dof = motion.body.dofs[index]
    return f"{joint_name(dof)}{direction(dof)}"


def peaks(motion: Moving) -> list[Row]:
    """For each group and what it does: the joint that moves most, is fastest, carries most."""
    dofs = motion.body.dofs
    moved, fast = in_peoples_units(dofs, motion.q), in_peoples_units(dofs, motion.v)
    rows = []
    for (group, turn), index in groups_of(dofs).items():
        span, speed = np.ptp(moved[:, index], axis=0), np.abs(fast[:, index]).max(axis=0)
        torque = np.abs(motion.tau[:, index]).max(axis=0)
        if max(span.max(), torque.max()) < STILL:
            continue
        most, quickest, strongest = (index[int(np.argmax(x))] for x in (span, speed, torque))
        _, unit, force, _ = units(dofs[index[0]])
        moves = span.max() >= STILL
        low, high = moved[:, most].min(), moved[:, most].max()
        rows.append(
            {
                "group": group,
                "turn": turn,
                "most": short_name(dofs[most]) if moves else "",
                "range": f"{number(low)} to {number(high)} {unit}" if moves else "still",
                "fastest": short_name(dofs[quickest]) if moves else "",
                "speed": f"{number(speed.max())} {unit}/s" if moves else "",
                "speed_at": _when(motion, fast[:, quickest]) if moves else "",
                "strongest": short_name(dofs[strongest]),
                "torque": f"{number(torque.max())} {force}",
                "torque_at": _when(motion, motion.tau[:, strongest]),
            }
        )
    return rows


def force_peaks(motion: Moving) -> list[Row]:
    """The largest force and moment at each place, and when."""
    rows = []
    for k, name in enumerate(motion.wrench_labels):
        force = np.linalg.norm(motion.forces[:, k], axis=1)
        moment = np.linalg.norm(motion.moments[:, k], axis=1)
        rows.append(
            {
                "place": name,
                "force": force.max(),
                "force_at": _when(motion, force) if force.max() > 1e-6 else "",
                "least": force.min(),
                "moment": moment.max(),
                "moment_at": _when(motion, moment) if moment.max() > 1e-6 else "",
                "least_moment": moment.min(),
            }
        )
    return rows


def limits(motion: Motion) -> list[Row]:
    """Joints that reach a limit: for what share of the time, and what the limit carries at most."""
    held = motion.limit_load != 0.0
    rows = []
    for i in np.flatnonzero(held.any(axis=0)):
        _, _, force, _ = units(motion.body.dofs[i])
        load = motion.limit_load[:, i]
        rows.append(
            {
                "joint": _full_name(motion, int(i)),
                "share": f"{100 * held[:, i].mean():.0f} %",
                "from": f"{motion.time[np.argmax(held[:, i])]:.3f} s",
                "load": f"{number(np.abs(load).max())} {force}",
                "at": _when(motion, load),
            }
        )
    return rows
