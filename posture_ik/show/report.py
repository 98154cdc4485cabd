"""One page that tells a posture to a colleague: pictures, charts, tables, certificate; offline."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from plotly.offline import get_plotlyjs
from scipy.spatial.transform import Rotation

from posture_ik.files import write_whole
from posture_ik.posture import Certificate, Posture, Wrench
from posture_ik.posture.tasks import Constraint, Gripped, Supported
from posture_ik.problem import SPINE
from posture_ik.show.person import draw_after, draw_before
from posture_ik.show.plots import COLOURS, arm_bars, bar_chart, energy_chart, joint_name, spine_bars
from posture_ik.show.words import (
    BODY_RESTS_ON,
    PICTURES_REST_ON,
    direction,
    number,
    power,
    template,
    units,
    who,
)

Row = dict[str, Any]

#: A spine that leaves the mid-plane by less than this (m, rad) is not worth a view from the front.
_SIDEWAYS = 5e-4


def write_report(posture: Posture, path: Path | str) -> None:
    """Write the report of a posture as one HTML file that needs no network.

    Raises:
        UnwritableOutput: the file cannot be written.
    """
    page = render_report(posture)
    write_whole(path, page)


def render_report(posture: Posture) -> str:
    """Render the report of a posture as HTML, with styles, scripts and charts inside."""
    spine, arms = spine_bars(posture), arm_bars(posture)
    figures = [energy_chart(posture), *(bar_chart(posture, bars) for bars in (*spine, *arms))]
    return template("report.html").render(
        posture=posture,
        subject=posture.problem.subject,
        asked=_asked(posture),
        pictures=_pictures(posture),
        spine=spine,
        arms=arms,
        figures=figures,
        regions=COLOURS,
        forces=(*posture.wrenches, posture.seat),
        total=_total(posture),
        weight=_weight(posture),
        limits=[_limit(posture, i) for i in range(len(posture.active_limits))],
        joints=[_joint(posture, i) for i in range(len(posture.body.dofs))],
        checks=_checks(posture.certificate, posture.redundant),
        tasks=_tasks(posture),
        assumptions=_assumptions(posture),
        plotly=get_plotlyjs(),
    )


def _pictures(posture: Posture) -> list[str]:
    """Before and after from the side; from the front too where the person left the mid-plane."""
    moved = [posture.frames[name].translation[1] for name in SPINE]
    turned = posture.frames["Head"].rotation[1, 0]
    views = [draw_before(posture, "side"), draw_after(posture, "side")]
    if max(*np.abs(moved), abs(turned)) > _SIDEWAYS:
        views.append(draw_after(posture, "front"))
    return views


def _asked(posture: Posture) -> list[str]:
    """What the problem says, in words."""
    subject, block = posture.problem.subject, posture.problem.posture
    stiffness = (
        f"{block.stiffness} springs"
        if isinstance(block.stiffness, str)
        else "tissue springs, changed for "
        + ", ".join(f"{joint_name(dof)}{direction(dof)}" for dof in block.stiffness)
        + ","
    )
    rest = {"reference": "in the reference shape", "middle": "in the middle of the joint ranges"}
    return [
        who(subject),
        f"backrest {posture.problem.seat.recline_deg:g}° back",
        "holding " + ", ".join(constraint.label for constraint in posture.constraints),
        f"{stiffness} at rest {rest[block.ergonomic]}",
        "with gravity" if block.gravity else "without gravity",
    ]


def _total(posture: Posture) -> Wrench:
    """All that acts on the person from outside but weight, moved to the origin: N, N m."""
    acting = (*posture.wrenches, posture.seat)
    force = np.sum([w.force for w in acting], axis=0)
    moment = np.sum([w.moment + np.cross(w.point, w.force) for w in acting], axis=0)
    return Wrench("sum", force, moment, np.zeros(3))


def _weight(posture: Posture) -> float:
    """The weight that the posture counts, N."""
    if not posture.problem.posture.gravity:
        return 0.0
    model = posture.body.model
    mass = sum(model.inertias[joint].mass for joint in model.subtrees[1])  # without levers
    return float(mass * np.linalg.norm(model.gravity.linear))


def _limit(posture: Posture, index: int) -> Row:
    limit = posture.active_limits[index]
    factor, unit, force, _ = units(limit.dof)
    return {
        "joint": f"{joint_name(limit.dof)}{direction(limit.dof)}",
        "side": limit.side,
        "value": f"{number(factor * limit.value)} {unit}",
        "load": f"{number(limit.load)} {force}",
    }


def _joint(posture: Posture, index: int) -> Row:
    dof = posture.body.dofs[index]
    factor, unit, force, stiffness = units(dof)
    return {
        "joint": dof,
        "value": factor * posture.displacement[index],
        "lower": factor * (posture.body.lower[index] - posture.q_ergo[index]),
        "upper": factor * (posture.body.upper[index] - posture.q_ergo[index]),
        "unit": unit,
        "stiffness": posture.stiffness[index] / factor,
        "stiffness_unit": stiffness,
        "force": posture.prestrain_force[index],
        "force_unit": force,
        "energy": 1000.0 * posture.energies[index],
    }


def _checks(certificate: Certificate, redundant: tuple[str, ...]) -> list[Row]:
    """Each check as a row: what, its number, what it must be, whether it is, and what it means."""
    return [
        {
            "what": "Primal residual",
            "value": f"{power(certificate.primal)} m or rad",
            "must": "at most 10⁻⁹",
            "good": certificate.primal <= 1e-9,
            "means": "every task is met, and every joint is within its range",
        },
        {
            "what": "Dual residual",
            "value": f"{power(certificate.dual)} (relative)",
            "must": "at most 10⁻⁸",
            "good": certificate.dual <= 1e-8,
            "means": "all forces balance: springs, weight, tasks and limits",
        },
        {
            "what": "Least curvature",
            "value": f"{_curvature(certificate)} (1 for springs alone)",
            "must": "above 0",
            "good": certificate.curvature > 0.0,
            "means": "any small move that keeps the tasks costs energy: a minimum, no saddle",
        },
        {
            "what": "Independent equations",
            "value": f"{certificate.rank} of {certificate.held}",
            "must": "all, for unique forces",
            "good": certificate.rank == certificate.held,
            "means": "no two tasks ask the same thing, so the holding forces are unique"
            if not redundant
            else f"others imply {', '.join(redundant)}: they share what they carry in any way",
        },
    ]


def _curvature(certificate: Certificate) -> str:
    return number(certificate.curvature) if np.isfinite(certificate.curvature) else "nothing free"


def _tasks(posture: Posture) -> list[Row]:
    """Each task with its target in words, and the miss and the multiplier of each equation."""
    start = 0
    tasks = []
    for constraint, (label, misses) in zip(
        posture.constraints, posture.residuals().items(), strict=True
    ):
        multipliers = posture.multipliers[start : start + len(misses)]
        start += len(misses)
        rows = [
            {
                "row": row,
                "miss": f"{power(miss)} {_row_unit(constraint, row)}",
                "multiplier": number(multiplier),
                "unit": "N m" if _row_unit(constraint, row) == "rad" else "N",
            }
            for row, miss, multiplier in zip(constraint.rows, misses, multipliers, strict=True)
        ]
        tasks.append({"label": label, "target": _target(constraint, posture), "rows": rows})
    return tasks


def _row_unit(constraint: Constraint, row: str) -> str:
    return "rad" if row.startswith("r") and not isinstance(constraint, Supported) else "m"


def _target(constraint: Constraint, posture: Posture) -> str:
    """What a task asks for, in words and people's units."""
    if isinstance(constraint, Gripped):
        lever = constraint.frames[1].removesuffix("_grip")
        angles = ", ".join(
            f"{dof.removeprefix(lever + '_').replace('_', '-')} {np.degrees(value):.1f}°"
            for dof, value in zip(posture.body.dofs, posture.q, strict=True)
            if dof.startswith(f"{lever}_")
        )
        return f"closed around {lever.replace('_', ' ')}, which follows to {angles}"
    if isinstance(constraint, Supported):
        forward, _, up = constraint.target[:3]
        lean = np.degrees(np.arctan2(up, forward))
        return f"in front of a plane leaning {lean:.1f}° back"
    held = []
    if any(not row.startswith("r") for row in constraint.rows):
        place = ", ".join(number(value) for value in constraint.target[:3])
        held.append(f"position ({place}) m")
    if any(row.startswith("r") for row in constraint.rows):
        axes = constraint.target[3:12].reshape(3, 3).T
        angles = Rotation.from_matrix(axes).as_euler("xyz", degrees=True)
        turned = ", ".join(f"{angle + 0.0:.1f}" for angle in angles)
        held.append(f"turned ({turned})° about x, y, z")
    return "; ".join(held)


def _assumptions(posture: Posture) -> list[str]:
    """What the numbers rest on and a reader should know."""
    block = posture.problem.posture
    lines = [
        *BODY_RESTS_ON,
        "Muscles are not counted: forces are what passive tissue and supports carry.",
        (
            "Weight is counted, so the posture is a static equilibrium."
            if block.gravity
            else "Weight is not counted: forces are those that bend the spine, on top of what "
            "weight would add."
        ),
        PICTURES_REST_ON,
    ]
    for constraint in posture.constraints:
        if constraint.label == "backrest":
            lines.append("The backrest holds the mean pose of its vertebrae, and may push or pull.")
        elif isinstance(constraint, Supported):
            lines.append("The backrest is a flat, rigid plane without friction that only pushes.")
    return lines
