"""One page that tells a colleague what moves: charts over time, peaks, certificate; offline.

A motion and a trajectory share it; what only one of them has is left out for the other.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from plotly.offline import get_plotlyjs

from posture_ik.arrays import Array
from posture_ik.files import write_whole
from posture_ik.posture import Motion, Trajectory
from posture_ik.problem.signals import Constant, Signal, Sine, Table
from posture_ik.show import reaching
from posture_ik.show.courses import (
    WAY_COLOURS,
    joint_courses,
    over_time,
    way_chart,
    wrench_charts,
)
from posture_ik.show.moving import FOLLOWED, followed
from posture_ik.show.peaks import Row, cards, force_peaks, limits, peaks, speeds
from posture_ik.show.person import draw_moments
from posture_ik.show.played import Moving, played
from posture_ik.show.plots import Figure
from posture_ik.show.words import BODY_RESTS_ON, PICTURES_REST_ON, number, power, template, who

#: The levels at which tasks hold, their units, and the most that each may miss, the two rates
#: relative to the fastest joint and the largest acceleration, at least 1.
LEVELS = (
    ("Position", "m or rad", 1e-9),
    ("Velocity", "m/s or rad/s", 1e-10),
    ("Acceleration", "m/s² or rad/s²", 1e-10),
)


def write_motion_report(shown: Motion | Trajectory, path: Path | str) -> None:
    """Write the report of a motion or trajectory as one HTML file that needs no network.

    Raises:
        UnwritableOutput: the file cannot be written.
    """
    page = render_motion_report(shown)
    write_whole(path, page)


def render_motion_report(shown: Motion | Trajectory) -> str:
    """Render the report as HTML, with styles, scripts and charts inside."""
    motion = played(shown)
    ways = followed(motion)
    own = _of_motion(shown) if isinstance(shown, Motion) else _of_reach(shown, motion)
    return template("motion.html").render(
        title=motion.problem.title,
        holds=all(check["good"] for check in own["checks"]),
        pictures=_pictures(motion, ways),
        ways={name: WAY_COLOURS[name] for name in ways},
        joints=joint_courses(motion),
        figures=_way_figures(motion, ways) | own.pop("figures"),
        plotly=get_plotlyjs(),
        **own,
    )


def _of_motion(motion: Motion) -> Row:
    """What the page says of a motion alone."""
    steps = f"{len(motion.time)} steps, {number(1000 * (motion.time[1] - motion.time[0]))} ms each"
    return {
        "asked": _asked(motion),
        "cards": cards(motion, steps),
        "verdict": "every task is met at every step, in position, velocity and acceleration",
        "wrenches": wrench_charts(motion),
        "forces": force_peaks(motion),
        "peaks": peaks(motion),
        "moves": [],
        "limits": limits(motion),
        "checks": _checks(motion),
        "redundant": motion.redundant,
        "rounds": [],
        "muscles": "",
        "assumptions": _assumptions(motion),
        "figures": {"residual": _residual_figure(motion)},
    }


def _of_reach(found: Trajectory, motion: Moving) -> Row:
    """What the page says of a trajectory alone; what holds the body firm is not computed."""
    return {
        "asked": reaching.asked(found),
        "cards": [*cards(motion, reaching.lasts(found)), reaching.effort(found)],
        "verdict": "the torques, integrated, bring the body there; the cost is stationary",
        "wrenches": {},
        "forces": [],
        "peaks": [],
        "moves": reaching.moves(found),
        "limits": [],
        "checks": reaching.checks(found),
        "redundant": (),
        "rounds": reaching.rounds(found),
        "muscles": reaching.muscles(found),
        "assumptions": reaching.assumptions(found),
        "figures": {"activation": reaching.activations(found)} if found.actuators else {},
    }


def _residual_figure(motion: Motion) -> Figure:
    """The largest miss of each level over time."""
    misses = np.maximum(np.abs(motion.residuals).max(axis=2), 1e-18)
    names = [f"{level.lower()}, {unit}" for level, unit, _ in LEVELS]
    return over_time(
        motion.time,
        dict(zip(names, misses.T, strict=True)),
        "largest miss",
        ["#1d5fae", "#0e7a6c", "#b35a0c"],
        log=True,
    )


def _way_figures(motion: Moving, ways: dict[str, Array]) -> dict[str, Figure]:
    """Paths and speeds of what goes somewhere, by name."""
    if not ways:
        return {}
    figures = {f"way_{view}": way_chart(motion, view) for view in ("side", "top")}
    moving = {name: speed for name, speed in speeds(motion).items() if name in ways}
    colours = [WAY_COLOURS[name] for name in moving]
    figures["speed"] = over_time(motion.time, moving, "m/s", colours)
    return figures


def telling_steps(motion: Moving, most: int = 5) -> list[int]:
    """Steps at which head and hands stand farthest from one another's places, in order of time.

    The first is the start; each more is the farthest from those chosen, while that is over 5 mm.
    """
    ahead = np.array([0.2, 0.0, 0.0])
    places = np.array(
        [
            [
                point
                for frame in FOLLOWED
                if frame in posture.frames
                for point in (posture.frames[frame].translation, posture.frames[frame].act(ahead))
            ]
            for posture in motion.postures
        ]
    )
    chosen = [0]
    while len(chosen) < most:
        away = np.linalg.norm(places[:, None] - places[chosen], axis=-1).max(axis=-1).min(axis=-1)
        if away.max() < 5e-3:
            break
        chosen.append(int(np.argmax(away)))
    return sorted(chosen)


def _pictures(motion: Moving, ways: dict[str, Array]) -> list[str]:
    steps = telling_steps(motion)
    titles = [f"{motion.time[i]:.2f} s" for i in steps]
    every = max(1, len(motion.time) // 60)
    short = {name: way[::every] for name, way in ways.items()}
    return draw_moments([motion.postures[i] for i in steps], titles, short)


def _asked(motion: Motion) -> list[str]:
    """What the problem says, in words."""
    problem = motion.problem
    signals = problem.motion.signal if problem.motion else ()
    return [
        who(problem.subject),
        *(describe(signal) for signal in signals),
        "holding " + ", ".join(constraint.label for constraint in motion.postures[0].constraints),
        "with gravity" if problem.posture.gravity else "without gravity",
    ]


def describe(signal: Signal) -> str:
    """What moves, and how: `seat recline from 0° to 45° between 0 and 2 s`."""
    name = signal.of.removeprefix("task.").removesuffix("_deg")
    name = name.replace(".", " ").replace("_", " ")
    unit = "°" if signal.of.endswith("_deg") else ""
    match signal:
        case Constant():
            return f"{name} stays at {signal.value:g}{unit}"
        case Sine():
            about = f" about {signal.offset:g}{unit}" if signal.offset else ""
            return f"{name} ±{signal.amplitude:g}{unit}{about} at {signal.frequency:g} Hz"
        case Table():
            low, high = min(signal.values), max(signal.values)
            return f"{name} between {low:g}{unit} and {high:g}{unit}, from a table"
        case _:
            return (
                f"{name} from {signal.initial:g}{unit} to {signal.final:g}{unit} "
                f"between {signal.start:g} and {signal.stop:g} s"
            )


def _checks(motion: Motion) -> list[Row]:
    """What each level misses at worst, where and when, and what it may."""
    labels = [f"{c.label} {row}" for c in motion.postures[0].constraints for row in c.rows]
    rates = (motion.q * 0.0, motion.v, motion.a)
    checks = []
    for level, (name, unit, most) in enumerate(LEVELS):
        misses = np.abs(motion.residuals[:, level])
        step, row = np.unravel_index(int(np.argmax(misses)), misses.shape)
        allowed = most * max(1.0, float(np.abs(rates[level]).max()))
        worst = float(misses[step, row])
        checks.append(
            {
                "what": name,
                "value": f"{power(worst)} {unit}",
                "where": f"{labels[row]}, at {motion.time[step]:.3f} s" if worst else "everywhere",
                "must": f"at most {power(allowed)}",
                "good": worst <= allowed,
            }
        )
    return checks


def _assumptions(motion: Motion) -> list[str]:
    """What the numbers rest on and a reader should know."""
    gravity = motion.problem.posture.gravity
    return [
        *BODY_RESTS_ON,
        "At every instant the person takes the posture of least strain energy; speeds and "
        "accelerations are its rates, projected onto the tasks.",
        "Torques are what the joints must supply beyond their springs and dampers, that is what "
        "muscles would; of all that meet the tasks, the least.",
        "Weight is counted."
        if gravity
        else "Weight is not counted: forces are those of motion and springs alone.",
        PICTURES_REST_ON,
    ]
