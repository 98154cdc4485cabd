"""Muscle activity in tables for the terminal, and as a record for machines."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from rich.console import Group
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from posture_ik.muscle import Activity
from posture_ik.muscle.activity import ARMS
from posture_ik.posture import Posture
from posture_ik.show.effort import (
    COSTS,
    certified,
    hardest,
    held,
    held_joints,
    muscle_name,
    peak_of,
)
from posture_ik.show.plots import joint_name

#: Muscles listed.
_MOST = 10


def activation_summary(activity: Activity) -> Group:
    """What a person wants to know first: whether muscles suffice, which work, what joints need."""
    asked = activity.asked
    head = Table(title=activity.problem.title, title_justify="left", show_header=False, box=None)
    head.add_column(style="dim")
    head.add_column()
    if not isinstance(activity.shown, Posture):
        head.add_row("motion", f"{activity.time[-1]:g} s in {len(activity.time)} steps")
    level = f", drawn towards {asked.co_contraction:g}" if asked.co_contraction else ""
    head.add_row("law of force", asked.law)
    head.add_row("chosen so that", COSTS[asked.cost] + level)
    for side in ARMS:
        if side not in held(activity):
            head.add_row(f"{side} arm", "holds nothing and rests: nothing is asked of its muscles")
    primal, dual, gap = activity.worst_certificate()
    verdict = (
        Text("holds", style="bold green")
        if certified(activity)
        else Text("fails", style="bold red")
    )
    head.add_row(
        "certificate",
        Text.assemble(
            verdict, f": torques to {primal:.0e} N m, gradient to {dual:.0e}, gap {gap:.0e}"
        ),
    )
    tables = (_muscles(activity), "", _torques(activity))
    return Group(*_shortfalls(activity), head, "", *tables, *_outside(activity))


def _shortfalls(activity: Activity) -> Iterator[Panel]:
    """What muscles cannot give, before all else."""
    if not activity.shortfalls:
        return
    lines = ["No activation gives the torques asked. A reserve stands in, which nobody has:"]
    for joint, _ in activity.shortfalls:
        torque, time = peak_of(activity, joint)
        when = "" if isinstance(activity.shown, Posture) else f" at {time:.2f} s"
        lines.append(f"  {joint_name(joint)} lacks {torque:+.3g} N m{when}")
    slower = "" if isinstance(activity.shown, Posture) else ", or move more slowly"
    lines.append(f"Lower the load or move the hand nearer{slower}.")
    yield Panel("\n".join(lines), title="MUSCLES FALL SHORT", style="bold red", expand=False)


def _muscles(activity: Activity) -> Table:
    """The muscles most active on either side, at their most."""
    most = "" if isinstance(activity.shown, Posture) else " at any time"
    table = Table(title=f"Most active muscles{most}", title_justify="left", box=None)
    table.add_column("muscle")
    for side in ARMS:
        table.add_column(side, justify="right")
        table.add_column("force / N", justify="right")
    # One row a muscle: its activation and force on the right and on the left.
    peaks, forces = (
        of.max(axis=0).reshape(len(ARMS), -1).T for of in (activity.activation, activity.force)
    )
    for i in np.argsort(-peaks.max(axis=1))[:_MOST]:
        both = [
            cell
            for peak, force in zip(peaks[i], forces[i], strict=True)
            for cell in ((f"{peak:.2f}", f"{force:.0f}") if peak >= 5e-3 else ("0", ""))
        ]
        table.add_row(muscle_name(activity.muscles.names[i]), *both)
    return table


def _torques(activity: Activity) -> Table:
    """Torques by joint at the instant of greatest effort."""
    step = hardest(activity)
    when = (
        ""
        if isinstance(activity.shown, Posture)
        else f", at {activity.time[step]:.2f} s, the instant of greatest effort"
    )
    table = Table(title=f"Torques, N m{when}", title_justify="left", box=None)
    table.add_column("joint")
    for name in ("asked", "passive", "active", "reserve"):
        table.add_column(name, justify="right")
    for i, dof in held_joints(activity):
        asked, passive, reserve = (
            float(of[step, i]) for of in (activity.demand, activity.passive, activity.reserve)
        )
        values = (asked, passive, asked - passive - reserve, reserve)
        style = "bold red" if reserve else ""
        table.add_row(joint_name(dof), *[_number(value) for value in values], style=style)
    return table


def _outside(activity: Activity) -> Iterator[Text]:
    if activity.outside:
        named = ", ".join(joint_name(dof) for dof in activity.outside)
        yield Text(
            f"\nOutside the range in which the muscles' paths hold: {named}. There a muscle may "
            "pass a bone on its wrong side; take its numbers with care.",
            style="yellow",
        )


def _number(value: float) -> str:
    return f"{value:.2f}" if abs(value) >= 5e-3 else "0"


def activation_record(activity: Activity) -> dict[str, object]:
    """The same for machines: plain numbers, SI units in the keys."""
    primal, dual, gap = activity.worst_certificate()
    muscles, joints = activity.muscles.names, activity.paths.dofs
    over_muscles = {"peak_activation": activity.activation, "peak_force_N": activity.force}
    over_joints = {
        "peak_demand_Nm": activity.demand,
        "peak_passive_Nm": activity.passive,
        "peak_reserve_Nm": activity.reserve,
    }
    return {
        "title": activity.problem.title,
        "steps": len(activity.time),
        "law": activity.asked.law,
        "cost": activity.asked.cost,
        "answered": not activity.shortfalls,
        "shortfalls": [
            {"joint": joint, "torque_Nm": torque, "time_s": peak_of(activity, joint)[1]}
            for joint, torque in activity.shortfalls
        ],
        "outside": list(activity.outside),
        "certificate": {
            "holds": certified(activity),
            "primal_residual": primal,
            "dual_residual": dual,
            "duality_gap": gap,
        },
        "hardest_s": float(activity.time[hardest(activity)]),
        **{
            name: dict(zip(names, np.abs(values).max(axis=0).tolist(), strict=True))
            for of, names in ((over_muscles, muscles), (over_joints, joints))
            for name, values in of.items()
        },
    }
