"""One page that tells what the arms' muscles do: who works, what is missing, what room is left."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from plotly.offline import get_plotlyjs

from posture_ik.files import write_whole
from posture_ik.muscle import Activity
from posture_ik.muscle.activity import ARMS
from posture_ik.muscle.reflex import SHORT_RANGE, JointStiffness
from posture_ik.posture import Posture
from posture_ik.show.courses import short_name
from posture_ik.show.effort import (
    COSTS,
    certified,
    hardest,
    held,
    held_joints,
    muscle_name,
    peak_of,
)
from posture_ik.show.muscle_charts import (
    PARTS,
    PLANES,
    TORQUES,
    WAYS,
    Instant,
    activation_chart,
    course_chart,
    ellipse_charts,
    group_colours,
    moment_arm_chart,
    room_chart,
    stiffness_chart,
    torque_chart,
    torque_courses,
    torques_at,
)
from posture_ik.show.plots import Figure, joint_name
from posture_ik.show.words import number, power, template, who

Row = dict[str, Any]

#: The laws of force in words.
LAWS_IN_WORDS = {
    "pennestri": "Hill's law as Pennestrì et al. (2007) write it",
    "de_groote": "Hill's law with the curves of De Groote et al. (2016) and pennation",
}
#: What the certificate may miss: as `Certificate.holds` has it.
_MOST = 1e-8


def write_activation_report(activity: Activity, path: Path | str) -> None:
    """Write the report of muscle activity as one HTML file that needs no network.

    Raises:
        UnwritableOutput: the file cannot be written.
    """
    page = render_activation_report(activity)
    write_whole(path, page)


def render_activation_report(activity: Activity) -> str:
    """Render the report as HTML, with styles, scripts and charts inside."""
    step, moves = hardest(activity), not isinstance(activity.shown, Posture)
    instants = {side: Instant.of(activity, side, step) for side in held(activity)}
    return template("activation.html").render(
        title=activity.problem.title,
        asked=_asked(activity),
        moves=moves,
        when=f"at {activity.time[step]:.2f} s, the instant of greatest effort" if moves else "",
        shortfalls=_shortfalls(activity),
        cards=_cards(activity),
        holds=certified(activity),
        resting=[side for side in ARMS if side not in instants],
        held=[side for side in ("left", "right") if side in instants],
        groups=group_colours(activity),
        torque_colours=TORQUES,
        part_colours=PARTS,
        way_colours=WAYS,
        planes={plane: words for plane, (_, words, _) in PLANES.items()},
        torques=_torques(activity),
        room={side: _room(instant) for side, instant in instants.items()},
        joints={side: _joints(activity, instant) for side, instant in instants.items()},
        endpoint={side: _endpoint(instant) for side, instant in instants.items()},
        checks=_checks(activity),
        outside=[joint_name(dof) for dof in activity.outside],
        assumptions=_assumptions(activity),
        figures=_figures(activity, instants, moves),
        courses=torque_courses(activity, list(instants)) if moves else {},
        plotly=get_plotlyjs(),
    )


def _figures(activity: Activity, instants: dict[str, Instant], moves: bool) -> dict[str, Figure]:
    """All charts that stand still, by name."""
    figures = {}
    for side, instant in instants.items():
        figures[f"activation_{side}"] = activation_chart(activity, side)
        figures[f"torque_{side}"] = torque_chart(activity, side)
        figures[f"arms_{side}"] = moment_arm_chart(activity, side)
        if moves:
            figures[f"course_{side}"] = course_chart(activity, side)
        figures[f"room_{side}"] = room_chart(activity, instant)
        figures[f"stiffness_{side}"] = stiffness_chart(activity, instant)
        if not _folds(instant):
            for plane, figure in ellipse_charts(instant).items():
                figures[f"ellipse_{plane}_{side}"] = figure
    return figures


def _asked(activity: Activity) -> list[str]:
    """What the problem says, in words."""
    asked = activity.asked
    lines = [who(activity.problem.subject), COSTS[asked.cost]]
    if asked.co_contraction:
        lines.append(f"all drawn towards an activation of {asked.co_contraction:g}")
    for side, force in asked.hand_force.items():
        given = ", ".join(number(value) for value in force)
        lines.append(f"force on the {side} hand ({given}) N forward, left, up")
    return lines


def _shortfalls(activity: Activity) -> list[Row]:
    """Joints whose reserve stands in: how much is missing, of what, and when."""
    rows = []
    for joint, _ in activity.shortfalls:
        torque, time = peak_of(activity, joint)
        step = int(np.argmin(np.abs(activity.time - time)))
        asked = float(activity.demand[step, activity.paths.dofs.index(joint)])
        rows.append(
            {
                "joint": joint_name(joint),
                "missing": f"{number(abs(torque))} N m",
                "asked": f"{number(abs(asked))} N m",
                "at": f"{time:.2f} s",
            }
        )
    return rows


def _cards(activity: Activity) -> list[Row]:
    """Key numbers: the muscle that works hardest, the largest torque, the largest load."""
    cards = []
    for side, (here, joints) in ARMS.items():
        if side not in held(activity):
            name, more = f"{side.capitalize()} arm", "holds nothing; nothing is asked of it"
            cards.append({"name": name, "value": "rests", "unit": "", "more": more})
            continue
        values = activity.activation[:, here]
        step, muscle = np.unravel_index(int(np.argmax(values)), values.shape)
        name = activity.muscles.names[here][int(muscle)]
        force = activity.force[step, here][int(muscle)]
        cards.append(
            {
                "name": f"Works hardest, {side}",
                "value": f"{100 * values[step, muscle]:.0f}",
                "unit": "%",
                "more": f"{muscle_name(name)}, {number(force)} N{_at(activity, int(step))}",
            }
        )
        asked = np.abs(activity.demand[:, joints])
        step, joint = np.unravel_index(int(np.argmax(asked)), asked.shape)
        cards.append(
            {
                "name": f"Largest torque, {side}",
                "value": number(asked[step, joint]),
                "unit": "N m",
                "more": short_name(activity.paths.dofs[joints][int(joint)])
                + _at(activity, int(step)),
            }
        )
    loads = np.linalg.norm(activity.hand_force, axis=2)
    if loads.max() > 1e-6:
        step, hand = np.unravel_index(int(np.argmax(loads)), loads.shape)
        varies = np.ptp(loads[:, hand]) > 1e-6
        cards.append(
            {
                "name": "Largest load on a hand",
                "value": number(loads[step, hand]),
                "unit": "N",
                "more": f"{list(ARMS)[int(hand)]} hand"
                + (_at(activity, int(step)) if varies else ""),
            }
        )
    return cards


def _at(activity: Activity, step: int) -> str:
    return "" if isinstance(activity.shown, Posture) else f", at {activity.time[step]:.2f} s"


def _torques(activity: Activity) -> list[Row]:
    """Torques of each joint at the instant of greatest effort, and the largest reserve at all."""
    now = torques_at(activity, hardest(activity))
    rows = []
    for i, dof in held_joints(activity):
        asked, passive, active, reserve = now[:, i]
        most, time = peak_of(activity, dof)
        rows.append(
            {
                "joint": joint_name(dof),
                "values": [_plain(x) for x in (asked, passive, active, passive + active, reserve)],
                "reserve": bool(reserve),
                "most": _plain(most),
                "at": f"{time:.2f} s" if most else "",
            }
        )
    return rows


def _plain(value: float) -> str:
    """Hundredths, so that columns can be compared; 0 where there are none."""
    return f"{value:.2f}".replace("-", "−") if abs(value) >= 5e-3 else "0"


def _room(instant: Instant) -> list[Row]:
    """What each way to hold the same torques makes of effort and stiffness."""
    return [
        {
            "way": way,
            "effort": number(float(np.sum(hold.recruitment.activation**2))),
            "stiffness": number(float(np.trace(hold.stiffness.total))),
            "hand": [number(value) for value in hold.endpoint.principal]
            if hold.endpoint.idle > 0.0
            else ["folds by itself"],
        }
        for way, hold in instant.ways.items()
    ]


def _joints(activity: Activity, instant: Instant) -> list[Row]:
    """Stiffness of each joint by part, with its damping."""
    hold = instant.held
    parts = [np.diag(getattr(hold.stiffness, part)) for part in JointStiffness._fields]
    columns = [*parts, np.diag(hold.stiffness.total), np.diag(hold.damping.total)]
    names = [short_name(dof) for dof in activity.paths.dofs[ARMS[instant.side][1]]]
    return [
        {"joint": name, "values": [_plain(column[i]) for column in columns]}
        for i, name in enumerate(names)
    ]


def _endpoint(instant: Instant) -> Row:
    """The stiffness at the hand along its own axes, and whether it holds by itself."""
    found = instant.held.endpoint
    return {
        "rows": [
            {
                "which": which,
                "value": number(float(value)),
                "way": ", ".join(f"{x + 0.0:.2f}".replace("-", "−") for x in way),
            }
            for which, value, way in zip(
                ("least", "middle", "greatest"), found.principal, found.axes.T, strict=True
            )
        ],
        "gives": bool(found.principal[0] < 0.0),
        "folds": _folds(instant),
    }


def _folds(instant: Instant) -> bool:
    """Whether the arm as held folds up by itself, so that its hand has no stiffness to tell."""
    return bool(instant.held.endpoint.idle <= 0.0)


def _checks(activity: Activity) -> list[Row]:
    """Each check as a row: what, its number, what it must be, whether it is, and what it means."""
    primal, dual, gap = activity.worst_certificate()
    missing = float(np.abs(activity.reserve).max())
    return [
        {
            "what": "Torque balance",
            "value": f"{power(primal)} N m",
            "must": "at most 10⁻⁸",
            "good": primal <= _MOST,
            "means": "muscles and reserve together give every torque asked, within their bounds",
        },
        {
            "what": "Dual residual",
            "value": f"{power(dual)} (relative)",
            "must": "at most 10⁻⁸",
            "good": dual <= _MOST,
            "means": "no muscle could do more or less at a lower cost",
        },
        {
            "what": "Duality gap",
            "value": f"{power(gap)} (relative)",
            "must": "at most 10⁻⁸",
            "good": gap <= _MOST,
            "means": "no activations at all cost less: this is the one optimum",
        },
        {
            "what": "Largest reserve",
            "value": f"{number(missing)} N m",
            "must": "0",
            "good": not activity.shortfalls,
            "means": "muscles alone give every torque asked",
        },
        {
            "what": "Joints outside the paths' range",
            "value": str(len(activity.outside)),
            "must": "0",
            "good": not activity.outside,
            "means": "every muscle passes the bones on its right side",
        },
    ]


def _assumptions(activity: Activity) -> list[str]:
    """What the numbers rest on and a reader should know."""
    asked = activity.asked
    short = asked.short_range
    lines = [
        f"Muscle force: {LAWS_IN_WORDS[asked.law]}; tendons do not stretch.",
        f"Of all activations that give the torques, those where {COSTS[asked.cost]}. How "
        "a nervous system shares the work is not known; this is the common guess."
        + (
            f" All are drawn towards {asked.co_contraction:g}, which changes no torque."
            if asked.co_contraction
            else " It leaves antagonists at rest, so true activations are likely higher."
        ),
        "The springs that chose the posture are left out: they are no tissue and carry nothing.",
        "Weight and inertia of the arm are always counted here, gravity too where the posture was "
        "found without it. An arm that holds nothing rests on the thigh: nothing is asked of it.",
        "A lever that follows the hand loads it with what its spring, damper, weight and inertia "
        "take, as the least force at the grip; a grip's own moment is not counted.",
        "25 muscle elements an arm, of a man of median size (Saul et al. 2014, after Holzbaur et "
        "al. 2005); lengths grow with stature, forces with weight. There is no pronator quadratus, "
        "and the hand is one body: fingers and grip strength are not counted.",
        "Shoulder blade and collar-bone stand still on the trunk. Where they would move with the "
        "arm, moment arms at the shoulder differ by 2 to 11 mm (rms), at worst by 40 mm.",
        "Paths follow the arm of myo-sim, with its flaws mended: the long head of triceps without "
        "the point that ties it to the wrong bone, triceps without the cylinder it passes on the "
        "far side, and muscle strengths from the publications themselves.",
        (
            f"Stiffness of active muscle is that of its first few tenths of a per cent of stretch, "
            f"{SHORT_RANGE:g} forces a fibre length (Cui et al. 2008)."
            if short
            else "Stiffness of active muscle is the slope of its force over length; for small, "
            "fast stretches, as in vibration, it is higher: set short_range = true."
        ),
        "Stiffness is that of the arm about the posture held: of muscles, weight and the load on "
        "the hand. The lever's own stiffness is not in it.",
    ]
    reflex = asked.reflex
    if reflex.proportional or reflex.derivative:
        lines.append(
            f"Reflexes answer at once, with gains of {reflex.proportional:g} per fibre length and "
            f"{reflex.derivative:g} per top speed; the delay of the nerves is left out."
        )
    else:
        lines.append("No reflex is counted: its gains are set to 0.")
    return lines
