"""Charts of a motion over time as plotly figures, and of the ways of head and hands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from posture_ik.arrays import Array
from posture_ik.show.moving import followed, packed, round_times
from posture_ik.show.person import region
from posture_ik.show.played import Moving
from posture_ik.show.plots import Figure, axis, joint_name, layout

#: Colours of the head and the hands, and of x, y, z and the size of a vector.
WAY_COLOURS = {"head": "#1d5fae", "right hand": "#0e7a6c", "left hand": "#b35a0c"}
_AXES = {"x": "#c0392b", "y": "#2a9d8f", "z": "#2f6fb0", "size": "#1c2733"}
#: Colours of what lies in a row, from its top to its bottom; all dark enough on white.
_ROW = ((56, 33, 110), (38, 92, 166), (22, 143, 137), (93, 158, 52), (201, 134, 16), (190, 52, 36))
#: Groups of joints that are charted together, by region or side of the arms.
_GROUPS = {
    "Neck": ("cervical",),
    "Thoracic": ("thoracic",),
    "Lumbar and seat": ("lumbar", "pelvis"),
    "Right arm": ("r",),
    "Left arm": ("l",),
    "Levers": ("levers",),
}
#: What a degree of freedom does, by the end of its name, and which way is positive.
_TURNS = {
    "ry": ("Flexion", "forward"),
    "rx": ("Lateral bending", "right"),
    "rz": ("Axial rotation", "left"),
    "axial": ("Stretch", "longer"),
    "arms": ("Turn", ""),
}
#: What moves less (deg or mm) and carries less (N or N m) than this is not charted.
STILL = 0.01
#: A line has at most about so many points; peaks are told from every step.
_POINTS = 600


def groups_of(dofs: Sequence[str]) -> dict[tuple[str, str], list[int]]:
    """Degrees of freedom by group and by what they do, head and shoulder first."""
    found: dict[tuple[str, str], list[int]] = {}
    for group, regions in _GROUPS.items():
        for kind, (name, _) in _TURNS.items():
            index = [
                i
                for i, dof in enumerate(dofs)
                if (dof[-1] if region(dof) == "arms" else region(dof)) in regions
                and ("arms" if region(dof) in ("arms", "levers") else dof.rpartition("_")[2])
                == kind
            ]
            if index:
                found[group, name] = index if kind == "arms" else index[::-1]
    return found


def short_name(dof: str) -> str:
    """A joint's name where its group is known: an arm's without its side."""
    return joint_name(dof).removeprefix("right ").removeprefix("left ")


def in_peoples_units(dofs: Sequence[str], values: Array) -> Array:
    """Coordinates or their rates (T, n) in deg and mm."""
    factors = [1000.0 if dof.endswith("_axial") else 180.0 / np.pi for dof in dofs]
    return np.asarray(values * factors)


def joint_courses(motion: Moving) -> dict[str, dict[str, dict[str, Figure]]]:
    """Charts of what each group of joints does and carries: {group: {turn: {angle, torque}}}.

    What neither moves nor carries is left out.
    """
    dofs = motion.body.dofs
    moved = in_peoples_units(dofs, motion.q)
    charts: dict[str, dict[str, dict[str, Figure]]] = {}
    ends = dict(_TURNS.values())
    for (group, turn), index in groups_of(dofs).items():
        carried = np.max(np.abs(motion.tau[:, index]))
        if max(np.ptp(moved[:, index], axis=0).max(), carried) < STILL:
            continue
        stretch = turn == "Stretch"
        end = f", positive {ends[turn]}" if ends[turn] else ""
        names = [short_name(dofs[i]) for i in index]
        colours = _row(len(index))
        charts.setdefault(group, {})[turn] = {
            "angle": over_time(
                motion.time,
                dict(zip(names, moved[:, index].T, strict=True)),
                f"{'mm' if stretch else 'deg'}{end}",
                colours,
            ),
            "torque": over_time(
                motion.time,
                dict(zip(names, motion.tau[:, index].T, strict=True)),
                f"{'N' if stretch else 'N m'}{end}",
                colours,
            ),
        }
    return charts


def _row(count: int) -> list[str]:
    """So many colours, in the order of a row."""
    at = np.linspace(0.0, 1.0, count)
    stops = np.linspace(0.0, 1.0, len(_ROW))
    channels = [np.interp(at, stops, channel) for channel in zip(*_ROW, strict=True)]
    return [f"rgb({r:.0f},{g:.0f},{b:.0f})" for r, g, b in zip(*channels, strict=True)]


def over_time(
    time: Array, lines: Mapping[str, Array], unit: str, colours: Sequence[str], log: bool = False
) -> Figure:
    """A chart of lines over time.

    Args:
        time: of every step, (T,), s; steps are equally long.
        lines: values (T,) by name.
        unit: what the values are in.
        colours: one a line.
        log: a scale of powers of ten.
    """
    every = max(1, len(time) // _POINTS)
    data = [
        {
            "type": "scatter",
            "mode": "lines",
            "name": name,
            "x0": float(time[0]),
            "dx": float(every * (time[1] - time[0])) if len(time) > 1 else 1.0,
            "y": _floats(values[::every]),
            "line": {"color": colour, "width": 2, "dash": _dash(name)},
            "hovertemplate": "%{y:.3g}" if not log else "%{y:.1e}",
        }
        for (name, values), colour in zip(lines.items(), colours, strict=True)
    ]
    return {"data": data, "layout": _time_layout(unit, log)}


def _floats(values: Array) -> dict[str, str]:
    """Numbers as plotly takes them packed."""
    return {"dtype": "f4", "bdata": packed(values)}


def _dash(name: str) -> str:
    """Hands often move alike: the left's line lets the right's be seen below it."""
    return "dash" if name == "left hand" else "solid"


def _time_layout(unit: str, log: bool) -> Figure:
    powers = {"type": "log", "exponentformat": "power", "dtick": 2}
    yaxis = axis(unit) | (powers if log else {})
    return layout(axis("time, s") | {"zeroline": False, "hoverformat": ".3f"}) | {
        "yaxis": yaxis,
        "hovermode": "x unified",
        "showlegend": True,
        "legend": {"orientation": "h", "y": -0.22, "font": {"size": 11}},
    }


def way_chart(motion: Moving, view: str) -> Figure:
    """How head and hands move from where they start, from the side or the top, equal axes in mm."""
    up, words = (2, "mm up") if view == "side" else (1, "mm to the left")
    ways = {name: 1000.0 * (way - way[0]) for name, way in followed(motion).items()}
    ticks = round_times(motion.time)
    every = max(1, len(motion.time) // _POINTS)
    # Times are written where there is room for them beside those written before.
    room = 0.13 * float(np.ptp(np.vstack(list(ways.values()))[:, (0, up)], axis=0).max())
    written: list[Array] = []
    data: list[Figure] = []
    for name, way in ways.items():
        at = np.array([np.interp(ticks, motion.time, x) for x in way.T]).T[:, (0, up)]
        text = []
        for time, point in zip(ticks, at, strict=True):
            free = all(np.linalg.norm(point - other) > room for other in written)
            text.append(f"{time:g} s" if free else "")
            written += [point] if free else []
        look = {"color": WAY_COLOURS[name]}
        data.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": name,
                "x": _floats(way[::every, 0]),
                "y": _floats(way[::every, up]),
                "line": look | {"width": 2.5, "dash": _dash(name)},
                "customdata": _floats(motion.time[::every]),
                "hovertemplate": "%{customdata:.2f} s: %{x:.1f}, %{y:.1f} mm",
            }
        )
        data.append(
            {
                "type": "scatter",
                "mode": "markers+text",
                "showlegend": False,
                "hoverinfo": "skip",
                "x": _floats(at[:, 0]),
                "y": _floats(at[:, 1]),
                "text": text,
                "textposition": "top right",
                "textfont": look | {"size": 11},
                "cliponaxis": False,
                "marker": {"color": "#fff", "size": 7, "line": look | {"width": 1.5}},
            }
        )
    square = axis(words) | {"scaleanchor": "x", "scaleratio": 1}
    return {
        "data": data,
        "layout": _time_layout("", False)
        | {"xaxis": axis("mm forward"), "yaxis": square, "hovermode": "closest"},
    }


def wrench_charts(motion: Moving) -> dict[str, dict[str, Figure]]:
    """Force and moment: the size of each, then each by its axes: {place: {force, moment}}."""
    names = motion.wrench_labels
    both = {"force": (motion.forces, "N"), "moment": (motion.moments, "N m")}
    charts = {
        "All": {
            kind: over_time(
                motion.time,
                dict(zip(names, np.linalg.norm(values, axis=2).T, strict=True)),
                unit,
                _row(len(names)),
            )
            for kind, (values, unit) in both.items()
        }
    }
    for k, name in enumerate(names):
        charts[name] = {
            kind: over_time(
                motion.time,
                {axis: values[:, k, i] for i, axis in enumerate("xyz")}
                | {"size": np.linalg.norm(values[:, k], axis=1)},
                unit,
                list(_AXES.values()),
            )
            for kind, (values, unit) in both.items()
        }
    return charts
