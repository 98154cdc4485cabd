"""Charts of a posture as plotly figures: plain dictionaries of data and layout.

Each chart is drawn by the page's own copy of plotly.js, so nothing here needs plotly itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from posture_ik.posture import Posture
from posture_ik.show.paper import Array
from posture_ik.show.person import region

#: Colours of the regions, as in the style sheet.
COLOURS = {
    "cervical": "#2f6fb0",
    "thoracic": "#2a9d8f",
    "lumbar": "#e07a1f",
    "pelvis": "#8a5aa8",
    "arms": "#7a8794",
    "levers": "#3f4a56",
}
_INK, _SOFT, _GRID, _RANGE, _LIMIT = "#1c2733", "#55626f", "#e6eaee", "#dfe5ea", "#c0392b"

#: Turns below this (deg) are not worth a chart.
_STILL = 0.01

Figure = dict[str, Any]


@dataclass(frozen=True)
class Bars:
    """A chart: one quantity, one bar for each of some degrees of freedom.

    Attributes:
        name, meaning: the title, and what it says in one sentence.
        unit, ends: the unit, and what the negative and the positive direction mean.
        index: the degrees of freedom in the order of the model, (k,).
        labels: what each bar is called, (k,).
        values: one a bar, (k,), in `unit`.
        range: lower and upper end of the joint range, (2, k), where the quantity has one.
    """

    name: str
    meaning: str
    unit: str
    ends: tuple[str, str]
    index: list[int]
    labels: list[str]
    values: Array
    range: Array | None = None


_TURNS = {
    "rx": ("Lateral bending", ("left", "right")),
    "ry": ("Flexion", ("back", "forward")),
    "rz": ("Axial rotation", ("right", "left")),
}


def spine_bars(posture: Posture) -> list[Bars]:
    """Each turn in which the spine moves, the moments with them, then stretch and axial force.

    A direction in which no joint of the spine turns by a hundredth of a degree is left out.
    """
    moving = [
        suffix
        for suffix in _TURNS
        if np.max(np.abs(posture.displacement[_level_dofs(posture, suffix)])) > np.radians(_STILL)
    ] or ["ry"]
    turned = "How far each joint turned from its rest."
    pulled = "The moment with which each joint pulls back towards its rest."
    longer = "How much longer or shorter each joint became along the spine."
    pushed = "The force with which each joint pushes or pulls along the spine."
    return [
        *(_moved(posture, suffix, *_TURNS[suffix], turned) for suffix in moving),
        *(
            _carried(posture, suffix, f"{_TURNS[suffix][0]} moment", _TURNS[suffix][1], pulled)
            for suffix in moving
        ),
        _moved(posture, "axial", "Stretch", ("shorter", "longer"), longer),
        _carried(posture, "axial", "Axial force", ("pulls", "pushes"), pushed),
    ]


def arm_bars(posture: Posture) -> list[Bars]:
    """Turn and moment of each joint of the arms and of each lever that follows a hand.

    Nothing where all of them stay at rest.
    """
    arms = _level_dofs(posture, "arms")
    if not arms or np.max(np.abs(posture.displacement[arms])) < np.radians(_STILL):
        return []
    levers = any(region(posture.body.dofs[i]) == "levers" for i in arms)
    whose = "arm joints and levers" if levers else "arm joints"
    return [
        _moved(
            *(posture, "arms", f"Turn of the {whose}", ("", "")),
            "How far each turned from its rest.",
        ),
        _carried(
            *(posture, "arms", f"Moment of the {whose}", ("", "")),
            "The moment with which each pulls back towards its rest.",
        ),
    ]


def _level_dofs(posture: Posture, suffix: str) -> list[int]:
    """The spine's degrees of freedom of one kind, seat first; with `arms` all others."""
    dofs = posture.body.dofs
    if suffix == "arms":
        return [i for i in reversed(range(len(dofs))) if region(dofs[i]) in ("arms", "levers")]
    return [i for i, dof in enumerate(dofs) if dof.endswith(f"_{suffix}")]


def _labels(posture: Posture, index: list[int]) -> list[str]:
    return [joint_name(posture.body.dofs[i]) for i in index]


def _moved(posture: Posture, suffix: str, name: str, ends: tuple[str, str], meaning: str) -> Bars:
    """How far joints moved from rest, with their range; deg or mm."""
    index = _level_dofs(posture, suffix)
    factor, unit = (1000.0, "mm") if suffix == "axial" else (180.0 / np.pi, "deg")
    limits = np.array([posture.body.lower, posture.body.upper]) - posture.q_ergo
    values = factor * posture.displacement[index]
    labels = _labels(posture, index)
    return Bars(name, meaning, unit, ends, index, labels, values, factor * limits[:, index])


def _carried(posture: Posture, suffix: str, name: str, ends: tuple[str, str], meaning: str) -> Bars:
    """What springs exert, N or N m."""
    index = _level_dofs(posture, suffix)
    unit = "N" if suffix == "axial" else "N m"
    values = posture.prestrain_force[index]
    return Bars(name, meaning, unit, ends, index, _labels(posture, index), values)


def joint_name(dof: str) -> str:
    """Write a joint as people do: L4–L5 for `L4_L5_ry`, right elbow flexion for the arm's."""
    if region(dof) == "levers":
        return dof.replace("_", " ").replace("fore aft", "fore-aft")
    if region(dof) == "arms":
        words, _, side = dof.rpartition("_")
        return f"{'right' if side == 'r' else 'left'} {words.replace('_', ' ')}"
    return dof.rpartition("_")[0].replace("buttocks", "seat").replace("_", "–")


def bar_chart(posture: Posture, bars: Bars) -> Figure:
    """Bars in the order of the body, head on top; joint ranges shaded, limits outlined."""
    dofs = [posture.body.dofs[i] for i in bars.index]
    reach = max(float(np.max(np.abs(bars.values))), 1e-9)
    data: list[Figure] = []
    if bars.range is not None:
        lower, upper = bars.range
        reach = max(reach, min(1.4 * reach, float(np.max(np.abs(bars.range)))))
        data.append(
            {
                "type": "bar",
                "orientation": "h",
                "y": bars.labels,
                "base": _plain(lower),
                "x": _plain(upper - lower),
                "width": 0.9,
                "marker": {"color": _RANGE},
                "hovertemplate": [
                    f"{label}: may go from {a:.2f} to {b:.2f} {bars.unit}<extra></extra>"
                    for label, a, b in zip(bars.labels, lower, upper, strict=True)
                ],
            }
        )
    held = {limit.dof for limit in posture.active_limits}
    data.append(
        {
            "type": "bar",
            "orientation": "h",
            "y": bars.labels,
            "x": _plain(bars.values),
            "width": 0.62,
            "marker": {
                "color": [COLOURS[region(dof)] for dof in dofs],
                "line": {"color": _LIMIT, "width": [2.5 if dof in held else 0 for dof in dofs]},
            },
            "text": [_short(value) for value in bars.values],
            "textposition": "outside",
            "textfont": {"size": 11, "color": _INK},
            "cliponaxis": False,
            "hovertemplate": f"%{{y}}: %{{x:.4g}} {bars.unit}<extra></extra>",
        }
    )
    negative, positive = bars.ends
    title = f"← {negative}   {bars.unit}   {positive} →" if negative else bars.unit
    scale = axis(title) | {"range": [-1.45 * reach, 1.45 * reach], "zerolinewidth": 1.5}
    return {"data": data, "layout": layout(scale) | {"barmode": "overlay"}}


def energy_chart(posture: Posture) -> Figure:
    """Strain energy by region, J and share of the whole."""
    shares = energy_by_region(posture)
    whole = sum(shares.values())
    names = [name for name in reversed(COLOURS) if name in shares]
    energies = [shares[name] for name in names]
    bars = {
        "type": "bar",
        "orientation": "h",
        "y": [name.capitalize() for name in names],
        "x": _plain(np.array(energies)),
        "width": 0.62,
        "marker": {"color": [COLOURS[name] for name in names]},
        "text": [
            f"{energy:.3g} J ({100.0 * energy / whole:.0f} %)" if energy > 1e-9 else "0 J"
            for energy in energies
        ],
        "textposition": "outside",
        "textfont": {"size": 13, "color": _INK},
        "cliponaxis": False,
        "hovertemplate": "%{y}: %{x:.4g} J<extra></extra>",
    }
    scale = axis("strain energy, J") | {"range": [0.0, 1.4 * max(*energies, 1e-9)]}
    return {"data": [bars], "layout": layout(scale)}


def energy_by_region(posture: Posture) -> dict[str, float]:
    """Strain energy of each region's springs, J."""
    levers = bool(posture.body.dofs[-1].startswith("lever_"))
    shares = {name: 0.0 for name in COLOURS if levers or name != "levers"}
    for dof, energy in zip(posture.body.dofs, posture.energies, strict=True):
        shares[region(dof)] += float(energy)
    return shares


def axis(title: str) -> Figure:
    """An axis with a title, that stays where it is."""
    return {
        "title": {"text": title, "font": {"size": 13}, "standoff": 8},
        "gridcolor": _GRID,
        "zerolinecolor": _SOFT,
        "nticks": 6,
        "fixedrange": True,
        "automargin": True,
    }


def layout(xaxis: Figure) -> Figure:
    """The look of every chart; bars stand one below the other."""
    return {
        "xaxis": xaxis,
        "yaxis": {"automargin": True, "fixedrange": True, "dtick": 1, "ticksuffix": " "},
        "font": {"family": "system-ui, sans-serif", "size": 12, "color": _INK},
        "margin": {"l": 10, "r": 16, "t": 8, "b": 10},
        "showlegend": False,
        "plot_bgcolor": "#fff",
        "paper_bgcolor": "#fff",
    }


def _plain(values: Array) -> list[float]:
    return [float(value) for value in values]


def _short(value: float) -> str:
    """At most three figures, and 0 for what would round to it."""
    size = abs(value)
    return f"{value:.{0 if size >= 99.5 else 1 if size >= 9.95 else 2}f}" if size >= 5e-3 else "0"
