"""Charts of muscle activity: who works, what joints get, what room is left, how stiff the hand is.

`Instant` gathers one arm at the instant of greatest effort; charts of it are horizontal bars, one
a muscle or a joint, first on top.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from posture_ik.arrays import Array
from posture_ik.muscle import Activity
from posture_ik.muscle.activity import ARMS, Hold
from posture_ik.muscle.reflex import JointStiffness
from posture_ik.posture import Posture
from posture_ik.show.courses import over_time, short_name
from posture_ik.show.effort import RAMP, hardest, muscle_name
from posture_ik.show.moving import packed
from posture_ik.show.plots import Figure, axis, layout

#: Colours of the muscles' groups, in the order of the arm.
_GROUPS = (
    *("#1d5fae", "#2a9d8f", "#8a5aa8", "#5d7f2a", "#b35a0c"),
    *("#c0392b", "#3f4a56", "#a0367f", "#c98610"),
)
#: Where a torque, or a stiffness, comes from.
TORQUES = {"passive": "#9aa7b3", "active": "#2f6fb0", "reserve": "#c0392b"}
PARTS = {"active": "#2f6fb0", "passive": "#9aa7b3", "reflexive": "#2a9d8f", "geometric": "#e07a1f"}
#: The ways to hold the same torques.
WAYS = {"softest": "#2a9d8f", "as held": "#1c2733", "stiffest": "#c0392b"}
#: Planes of the end-point ellipses: the two axes, and which way they point.
PLANES = {
    "side": ((0, 2), "From the side", ("forward", "up")),
    "top": ((0, 1), "From the top", ("forward", "left")),
    "front": ((1, 2), "From the front", ("left", "up")),
}
_SCALE = [
    [i / (len(RAMP) - 1), "rgb({:.0f},{:.0f},{:.0f})".format(*(255 * c for c in stop))]
    for i, stop in enumerate(RAMP)
]
_DIVERGING = [[0.0, "#a8480a"], [0.25, "#eeb27c"], [0.5, "#ffffff"], [0.75, "#8fb8e0"]]
_DIVERGING += [[1.0, "#1d5fae"]]
#: A heat map has at most about so many columns.
_COLUMNS = 300


@dataclass(frozen=True)
class Instant:
    """One arm at one instant, and the softest and stiffest way to give the same torques."""

    side: str
    ways: Mapping[str, Hold]

    @classmethod
    def of(cls, activity: Activity, side: str, step: int) -> Instant:
        """Look at the `right` or `left` arm at a step."""
        held = activity.hold(side, step)
        ends = {
            name: _as_if(activity, side, step, activation).hold(side, step)
            for name, activation in (("softest", held.softest), ("stiffest", held.stiffest))
        }
        return cls(side, {name: ends.get(name, held) for name in WAYS})

    @property
    def held(self) -> Hold:
        """As it is."""
        return self.ways["as held"]


def _as_if(activity: Activity, side: str, step: int, activation: Array) -> Activity:
    """The same with other activations (25,) of the same torques of one arm at one step."""
    arms = list(activity.recruitments[step])
    i = list(ARMS).index(side)
    arms[i] = replace(arms[i], activation=np.clip(activation, 0.0, 1.0))
    all_steps = list(activity.recruitments)
    all_steps[step] = (arms[0], arms[1])
    return replace(activity, recruitments=tuple(all_steps))


def group_colours(activity: Activity) -> dict[str, str]:
    """A colour a group of muscles, in the order of the arm."""
    groups = dict.fromkeys(activity.muscles.group)
    return dict(zip(groups, _GROUPS, strict=True))


def _by_group(activity: Activity, side: str) -> list[int]:
    """The muscles of one arm, group by group."""
    groups = list(group_colours(activity))
    return sorted(
        range(len(activity.muscles.names))[ARMS[side][0]],
        key=lambda i: groups.index(activity.muscles.group[i]),
    )


def _names(activity: Activity, index: Sequence[int]) -> list[str]:
    return [muscle_name(activity.muscles.names[i]) for i in index]


def _joints(activity: Activity, side: str) -> list[str]:
    return [short_name(dof) for dof in activity.paths.dofs[ARMS[side][1]]]


def activation_chart(activity: Activity, side: str) -> Figure:
    """Activation of each muscle of an arm at the instant of greatest effort; a tick at its most.

    The number is the most.
    """
    index, step = _by_group(activity, side), hardest(activity)
    colours, names = group_colours(activity), _names(activity, index)
    now, most = activity.activation[step, index], activity.activation[:, index].max(axis=0)
    bars = _bars(names, now, [colours[activity.muscles.group[i]] for i in index], "activation")
    bars["customdata"] = _plain(activity.force[step, index])
    bars["hovertemplate"] = "%{y}: activation %{x:.3f}, %{customdata:.0f} N<extra></extra>"
    data = [bars]
    if not isinstance(activity.shown, Posture):
        peaks = _marks(names, most, "line-ns-open", "#1c2733", "most at any time")
        data.append(peaks | {"hovertemplate": "%{y}: at most %{x:.3f}<extra></extra>"})
    told = [
        {
            "x": max(float(most[k]), 0.0),
            "y": names[k],
            "text": f"{most[k]:.2f}",
            "showarrow": False,
            "xanchor": "left",
            "xshift": 7,
            "font": {"size": 11},
        }
        for k in range(len(names))
        if most[k] >= 5e-3
    ]
    scale = axis("activation") | {"range": [0.0, 1.12]}
    scale |= {"tickvals": [0, 0.25, 0.5, 0.75, 1]}
    return _rows(data, scale, annotations=told)


def course_chart(activity: Activity, side: str) -> Figure:
    """Activation of each muscle of an arm over time, as a heat map."""
    index = _by_group(activity, side)
    every = max(1, len(activity.time) // _COLUMNS)
    time, values = activity.time[::every], activity.activation[::every, index].T
    names = _names(activity, index)
    heat = {
        "type": "heatmap",
        "x0": float(time[0]),
        "dx": float(time[1] - time[0]) if len(time) > 1 else 1.0,
        "y": names,
        "z": {"dtype": "f4", "bdata": packed(values), "shape": f"{len(names)}, {len(time)}"},
        "zmin": 0.0,
        "zmax": 1.0,
        "colorscale": _SCALE,
        "ygap": 1,
        "colorbar": _colour_bar("activation"),
        "hovertemplate": "%{y} at %{x:.2f} s: %{z:.3f}<extra></extra>",
    }
    when = float(activity.time[hardest(activity)])
    line = {"type": "line", "x0": when, "x1": when, "yref": "paper", "y0": 0, "y1": 1}
    line |= {"line": {"color": "#c0392b", "width": 1.5, "dash": "dot"}}
    scale = axis("time, s") | {"zeroline": False, "range": [float(time[0]), float(time[-1])]}
    return _rows([heat], scale, shapes=[line])


def torque_chart(activity: Activity, side: str) -> Figure:
    """Where each joint's torque comes from at the instant of greatest effort."""
    step, joints = hardest(activity), ARMS[side][1]
    values = dict(zip(TORQUES, torques_at(activity, step)[1:, joints], strict=True))
    return _stacked(
        _joints(activity, side), values, TORQUES, activity.demand[step, joints], "asked", "N m"
    )


def torques_at(activity: Activity, step: int | slice) -> Array:
    """Torques asked, passive, active and of the reserve, (4, ..., 14), N m."""
    asked, passive, reserve = (
        of[step] for of in (activity.demand, activity.passive, activity.reserve)
    )
    return np.array([asked, passive, asked - passive - reserve, reserve])


def torque_courses(activity: Activity, sides: Sequence[str]) -> dict[str, dict[str, Figure]]:
    """The same over time for some arms: {arm: {joint: chart}}."""
    courses = torques_at(activity, slice(None))
    colours = ["#1c2733", *TORQUES.values()]
    return {
        f"{side} arm".capitalize(): {
            name: over_time(
                activity.time,
                dict(zip(("asked", *TORQUES), courses[:, :, i], strict=True)),
                "N m",
                colours,
            )
            for name, i in zip(_joints(activity, side), range(14)[ARMS[side][1]], strict=True)
        }
        for side in sides
    }


def moment_arm_chart(activity: Activity, side: str) -> Figure:
    """Moment arms of an arm's muscles about its joints, mm, at the instant of greatest effort."""
    index, joints = _by_group(activity, side), ARMS[side][1]
    jacobian = activity.paths.evaluate(activity.q[hardest(activity)])[1]
    arms = -1000.0 * jacobian[index, joints]
    reach = float(np.abs(arms).max())
    heat = {
        "type": "heatmap",
        "x": _joints(activity, side),
        "y": _names(activity, index),
        "z": [_plain(row) for row in arms],
        "text": [[f"{arm:.0f}" if abs(arm) >= 0.5 else "" for arm in row] for row in arms],
        "texttemplate": "%{text}",
        "textfont": {"size": 11},
        "zmin": -reach,
        "zmax": reach,
        "colorscale": _DIVERGING,
        "showscale": False,
        "xgap": 1,
        "ygap": 1,
        "hovertemplate": "%{y}, %{x}: %{z:.1f} mm<extra></extra>",
    }
    return _rows([heat], axis("") | {"side": "top", "tickangle": -40, "nticks": 0, "title": {}})


def room_chart(activity: Activity, instant: Instant) -> Figure:
    """Each muscle from the softest to the stiffest way to give the same torques."""
    index = _by_group(activity, instant.side)
    names, first = _names(activity, index), ARMS[instant.side][0].start
    values = {
        way: hold.recruitment.activation[np.subtract(index, first)]
        for way, hold in instant.ways.items()
    }
    low, high = (reduce(list(values.values()), axis=0) for reduce in (np.min, np.max))
    span = _bars(names, high - low, "#dfe5ea", "") | {"base": _plain(low), "hoverinfo": "skip"}
    looks = {"softest": "circle", "as held": "line-ns-open", "stiffest": "diamond"}
    data = [span | {"showlegend": False}] + [
        _marks(names, values[way], looks[way], colour, way)
        | {"hovertemplate": f"%{{y}}, {way}: %{{x:.3f}}<extra></extra>"}
        for way, colour in WAYS.items()
    ]
    scale = axis("activation") | {"range": [-0.03, 1.05], "tickvals": [0, 0.25, 0.5, 0.75, 1]}
    return _rows(data, scale)


def stiffness_chart(activity: Activity, instant: Instant) -> Figure:
    """Stiffness of each joint against its own turn, by where it comes from."""
    stiffness = instant.held.stiffness
    values = {part: np.diag(getattr(stiffness, part)) for part in JointStiffness._fields}
    total, names = np.diag(stiffness.total), _joints(activity, instant.side)
    return _stacked(names, values, PARTS, total, "together", "N m/rad")


def ellipse_charts(instant: Instant) -> dict[str, Figure]:
    """Stiffness at the hand in the three planes, N/m, on equal axes and one scale.

    The stiffest way to hold would dwarf the others; one in which the arm folds up by itself has
    no ellipse.
    """
    curves = {
        plane: {
            way: hold.endpoint.ellipse(of, 121)
            for way, hold in instant.ways.items()
            if way != "stiffest" and hold.endpoint.idle > 0.0
        }
        for plane, (of, _, _) in PLANES.items()
    }
    sizes = [float(np.abs(curve).max()) for ways in curves.values() for curve in ways.values()]
    reach = 1.12 * max(sizes, default=1.0)
    charts = {}
    for plane, ways in curves.items():
        across, up = PLANES[plane][2]
        data = [
            {
                "type": "scatter",
                "mode": "lines",
                "name": way,
                "x": _plain(curve[:, 0]),
                "y": _plain(curve[:, 1]),
                "line": {
                    "color": WAYS[way],
                    "width": 3 if way == "as held" else 1.5,
                    "dash": "solid" if way == "as held" else "dash",
                },
                "hovertemplate": f"{way}: %{{x:.0f}}, %{{y:.0f}} N/m<extra></extra>",
            }
            for way, curve in ways.items()
        ]
        square = {"range": [-reach, reach], "constrain": "domain", "nticks": 5}
        charts[plane] = {
            "data": data,
            "layout": layout(axis(f"N/m {across}") | square)
            | {
                "yaxis": axis(f"N/m {up}") | square | {"scaleanchor": "x", "scaleratio": 1},
                "hovermode": "closest",
            },
        }
    return charts


def _stacked(
    names: list[str],
    values: Mapping[str, Array],
    colours: Mapping[str, str],
    total: Array,
    total_name: str,
    unit: str,
) -> Figure:
    """Bars in parts, one a joint, and a mark where they come to."""
    data = [
        _bars(names, values[part], colour, part)
        | {"hovertemplate": f"%{{y}}, {part}: %{{x:.3g}} {unit}<extra></extra>"}
        for part, colour in colours.items()
    ]
    mark = _marks(names, total, "line-ns-open", "#1c2733", total_name)
    told = f"%{{y}}, {total_name}: %{{x:.3g}} {unit}<extra></extra>"
    return _rows([*data, mark | {"hovertemplate": told}], axis(unit) | {"zerolinewidth": 1.5})


def _bars(names: list[str], values: Array, colour: str | list[str], name: str) -> Figure:
    return {
        "type": "bar",
        "orientation": "h",
        "name": name,
        "y": names,
        "x": _plain(values),
        "width": 0.66,
        "marker": {"color": colour},
    }


def _marks(names: list[str], values: Array, symbol: str, colour: str, name: str) -> Figure:
    tick = symbol.startswith("line")
    return {
        "type": "scatter",
        "mode": "markers",
        "name": name,
        "y": names,
        "x": _plain(values),
        "marker": {
            "symbol": symbol,
            "size": 13 if tick else 8,
            "color": colour,
            "line": {"width": 2.2 if tick else 0},
        },
    }


def _rows(data: list[Figure], xaxis: Figure, **more: object) -> Figure:
    """A chart of rows, the first on top."""
    look = layout(xaxis) | {"barmode": "relative", **more}
    last = len(data[0]["y"]) - 0.5
    look["yaxis"] = look["yaxis"] | {"range": [last, -0.5], "type": "category"}
    return {"data": data, "layout": look}


def _colour_bar(title: str) -> Figure:
    return {
        "orientation": "h",
        "thickness": 10,
        "len": 0.9,
        "y": -0.1,
        "yanchor": "top",
        "title": {"text": title, "side": "bottom", "font": {"size": 12}},
        "tickvals": [0, 0.25, 0.5, 0.75, 1],
    }


def _plain(values: Array) -> list[float]:
    return [float(value) for value in values]
