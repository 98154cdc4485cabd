"""Charts of vibration over frequency: what reaches the head, what the seat feels.

Every model has a line in its own colour; the one asked for is the widest and lies on top. Rings
are peaks that Cocco (2019) prints, where they are of the same seat and direction.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from posture_ik.problem import Subject
from posture_ik.show.moving import packed
from posture_ik.show.plots import Figure, axis, layout
from posture_ik.show.resonance import WAYS, Peak, model_name, peak_of, place_name
from posture_ik.show.words import number
from posture_ik.vibration import (
    Vibration,
    absorbed_power,
    apparent_mass,
    impedance,
    transmissibility,
)
from posture_ik.vibration.published import SEATS, peaks
from posture_ik.vibration.published import Peak as Published
from posture_ik.vibration.response import seen_frames

#: Colours of the models, the one asked for first.
_MODELS = ("#1d5fae", "#e07a1f", "#2a9d8f", "#8a5aa8", "#c0392b", "#5d7f2a", "#a0367f", "#55626f")
_PRINTED = "#1c2733"
#: Where those stand that the source prints of a person on a seat.
_TABLES = ("section_3_3", "section_6_1")
#: A line has at most about so many points; peaks are told from every frequency.
_POINTS = 800
#: What is smaller than this, in any unit, is said in words: left and right hardly differ.
NOTHING = 1e-3

#: Charts by what is chosen on the page, one button after the other.
Choice = dict[str, Any]


def model_colours(vibration: Vibration) -> dict[str, str]:
    """A colour each model."""
    names = list(vibration.responses)
    return {name: _MODELS[i % len(_MODELS)] for i, name in enumerate(names)}


def motion_charts(vibration: Vibration) -> Choice:
    """Motion of a link over the base's: {link: {its way: {the base's way: {magnitude, phase}}}}."""
    charts: Choice = {}
    printed = printed_peaks(vibration)
    for frame in seen_frames(vibration.response):
        parts = {
            name: transmissibility(data, frame, vibration.base)
            for name, data in vibration.responses.items()
            if frame in seen_frames(data)
        }
        first = parts[vibration.asked.model]
        for to, of in product(_ways(first, "to"), _ways(first, "from")):
            curves = _curves(parts, {"to": to, "from": of})
            peak = printed.get((f"{vibration.base} {of}", f"{frame} acceleration {to}", "1"))
            charts.setdefault(place_name(frame), {}).setdefault(_button(to), {})[_button(of)] = {
                "magnitude": _chart(vibration, curves, "", peak),
                "phase": _phase(vibration, curves),
            }
    return charts


def force_charts(vibration: Vibration) -> Choice:
    """Force over the base's motion: {where: {its way: {the base's way: {mass, phase, impedance}}}}.

    The force is that on the person, or on what else stands there.
    """
    charts: Choice = {}
    printed = printed_peaks(vibration)
    for place in sorted(_interfaces(vibration.response), key=vibration.base.__ne__):
        there = {
            name: data for name, data in vibration.responses.items() if place in _interfaces(data)
        }
        masses = {name: apparent_mass(data, place, vibration.base) for name, data in there.items()}
        resists = {name: impedance(data, place, vibration.base) for name, data in there.items()}
        first = masses[vibration.asked.model]
        for force, of in product(_ways(first, "force"), _ways(first, "motion")):
            pair, at = (
                {"force": force, "motion": of},
                (f"{vibration.base} {of}", f"{place} force {force}"),
            )
            mass, resistance = _curves(masses, pair), _curves(resists, pair)
            charts.setdefault(place_name(place), {}).setdefault(_button(force), {})[_button(of)] = {
                "mass": _chart(vibration, mass, "kg", printed.get((*at, "kg"))),
                "mass_phase": _phase(vibration, mass),
                "impedance": _chart(vibration, resistance, "N s/m", printed.get((*at, "N s/m"))),
            }
    return charts


def power_charts(vibration: Vibration) -> dict[str, Figure]:
    """Power that the base feeds in, by its direction: {power_x: ...}."""
    parts = {
        name: absorbed_power(data, vibration.base) for name, data in vibration.responses.items()
    }
    return {
        f"power_{way}": _chart(vibration, _curves(parts, {"opposed": way}), "W per (m/s²)²")
        for way in _ways(parts[vibration.asked.model], "opposed")
    }


def _ways(part: xr.DataArray, dim: str) -> list[str]:
    return [way for way in WAYS if way in part[dim]]


def _button(way: str) -> str:
    return f"{WAYS[way]} ({way})"


def _interfaces(data: xr.Dataset) -> list[str]:
    """Where forces are told."""
    names = [str(name) for name in data["output"].values]
    return [name.removesuffix(" force z") for name in names if name.endswith(" force z")]


def _curves(parts: Mapping[str, xr.DataArray], pair: Mapping[str, str]) -> dict[str, xr.DataArray]:
    """One direction of each model that has it."""
    return {
        name: part.sel(pair)
        for name, part in parts.items()
        if all(way in part[dim] for dim, way in pair.items())
    }


def printed_peaks(vibration: Vibration) -> dict[tuple[str, str, str], dict[str, Published]]:
    """Peaks that the source prints of the same person and seat, by input, output and unit."""
    problem = vibration.problem
    found: dict[tuple[str, str, str], dict[str, Published]] = {}
    sits = {"backrest": problem.seat.backrest, "cushion": problem.seat.cushion}
    if problem.seat.recline_deg or problem.subject != Subject():
        return {}
    for table in _TABLES:
        for name, peak in peaks(table).items():
            if {"backrest": None, "cushion": None} | SEATS[peak.seat] == sits:
                at = (peak.given, peak.read, peak.unit)
                found.setdefault(at, {})[name] = peak
    return found


def _chart(
    vibration: Vibration,
    curves: Mapping[str, xr.DataArray],
    unit: str,
    printed: Mapping[str, Published] | None = None,
) -> Figure:
    """Magnitudes over frequency, with the peak of the model asked for and the one printed."""
    sizes = {name: abs(curve) for name, curve in curves.items()}
    highest = max(float(size.max()) for size in sizes.values())
    figure = _lines(vibration, sizes, unit)
    figure["layout"]["yaxis"] |= {"rangemode": "tozero"}
    if highest < NOTHING:
        figure["layout"]["yaxis"] |= {"range": [0.0, 1.0]}
        figure["layout"]["annotations"] = [
            _middle(f"hardly anything: at most {highest:.1g} {unit}")
        ]
        return figure
    peak = peak_of(sizes[vibration.asked.model])
    printed = printed or {}
    top = 1.18 * max(highest, *(each.size for each in printed.values()), 0.0)
    figure["layout"]["yaxis"] |= {"range": [0.0, top]}
    figure["layout"]["annotations"] = [_told(peak)]
    for name, published in printed.items():
        colour = model_colours(vibration).get(published.model, _PRINTED)
        _mark(figure, name, published, colour)
    return figure


def _phase(vibration: Vibration, curves: Mapping[str, xr.DataArray]) -> Figure:
    """Phases over frequency without jumps, degrees; none where nothing answers."""
    turned = {
        name: xr.DataArray(np.degrees(np.unwrap(np.angle(curve))), coords=curve.coords)
        for name, curve in curves.items()
        if float(np.abs(curve).max()) >= NOTHING
    }
    figure = _lines(vibration, turned, "degrees")
    figure["layout"]["yaxis"] |= {"tick0": 0, "dtick": 90} if _spans(turned) < 900.0 else {}
    return figure


def _spans(curves: Mapping[str, xr.DataArray]) -> float:
    return max((float(curve.max() - curve.min()) for curve in curves.values()), default=0.0)


def _lines(vibration: Vibration, curves: Mapping[str, xr.DataArray], unit: str) -> Figure:
    frequency = vibration.response["frequency"].values
    every = max(1, len(frequency) // _POINTS)
    step = float(every * (frequency[1] - frequency[0])) if len(frequency) > 1 else 1.0
    colours, asked = model_colours(vibration), vibration.asked.model
    data = [
        {
            "type": "scatter",
            "mode": "lines" if len(frequency) > 1 else "markers",
            "name": model_name(name),
            "x0": float(frequency[0]),
            "dx": step,
            "y": {"dtype": "f4", "bdata": packed(curves[name].values[::every])},
            "line": {"color": colours[name], "width": 2.8 if name == asked else 1.7},
            "hovertemplate": "%{y:.3g}",
        }
        for name in sorted(curves, key=asked.__eq__)
    ]
    across = axis("frequency, Hz") | {"zeroline": False, "hoverformat": ".2f", "nticks": 11}
    look = layout(across | {"range": [0.0, float(frequency[-1])]})
    upward = axis(unit) | {"zeroline": True, "nticks": 7}
    return {"data": data, "layout": look | {"yaxis": upward, "hovermode": "x unified"}}


def _told(peak: Peak) -> Figure:
    """The peak of the model asked for, written where it is."""
    return {
        "x": peak.frequency,
        "y": peak.value,
        "text": f"{number(peak.value)} at {peak.frequency:.2f} Hz",
        "showarrow": True,
        "arrowwidth": 1,
        "arrowcolor": _MODELS[0],
        "arrowhead": 0,
        "ax": 34,
        "ay": -14,
        "xanchor": "left",
        "font": {"size": 12, "color": _MODELS[0]},
        "bgcolor": "rgba(255,255,255,0.75)",
    }


def _mark(figure: Figure, name: str, printed: Published, colour: str) -> None:
    """Add a peak that the source prints: a ring, or a line where it has no frequency."""
    if printed.frequency is None:
        line = {"type": "line", "xref": "paper", "x0": 0, "x1": 1}
        line |= {"y0": printed.size, "y1": printed.size}
        line |= {"line": {"color": colour, "width": 1.3, "dash": "dot"}}
        figure["layout"].setdefault("shapes", []).append(line)
        return
    ring = {"symbol": "circle-open", "size": 12, "color": colour, "line": {"width": 2}}
    figure["data"].append(
        {
            "type": "scatter",
            "mode": "markers",
            "name": f"Cocco 2019, {name}",
            "x": [printed.frequency],
            "y": [printed.size],
            "marker": ring,
            "hovertemplate": "%{y:.3g}",
        }
    )


def _middle(text: str) -> Figure:
    at = {"xref": "paper", "yref": "paper", "x": 0.5, "y": 0.5}
    return at | {"text": text, "showarrow": False, "font": {"size": 13, "color": "#55626f"}}
