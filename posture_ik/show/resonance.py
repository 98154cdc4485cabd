"""What pages and summary ask of vibration: names, peaks, modes in reach, what to beware of."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from posture_ik.arrays import Array
from posture_ik.problem import Problem
from posture_ik.vibration import (
    Mode,
    Vibration,
    apparent_mass,
    load_lumped,
    transmissibility,
)

#: Directions in words, as they are shown.
WAYS = {"z": "vertical", "x": "fore-and-aft", "y": "lateral"}
_MODELS = {"multibody": "Multibody", "finite_element": "Finite elements"}
_PLACES = {"S1": "Pelvis", "grip_r": "Right hand", "grip_l": "Left hand", "total": "All together"}


class Peak(NamedTuple):
    """The largest of a curve: how much, at what frequency (Hz), and whether it is an end of it."""

    value: float
    frequency: float
    at_end: bool

    def __str__(self) -> str:
        more = ", the end of the range" if self.at_end else ""
        return f"at {self.frequency:.2f} Hz{more}"


def peak_of(curve: xr.DataArray) -> Peak:
    """The largest of the absolute values along `frequency`."""
    sizes = np.abs(curve.values)
    i = int(np.argmax(sizes))
    return Peak(float(sizes[i]), float(curve["frequency"][i]), i in (0, len(sizes) - 1))


def model_name(model: str) -> str:
    """What people call a model: a lumped one by its title."""
    return _MODELS.get(model) or load_lumped(model.removeprefix("lumped:")).title


def place_name(place: str) -> str:
    """What people call a link, or where a force acts."""
    return _PLACES.get(place, place.replace("_", " ").removesuffix(" grip").capitalize())


def axes_of(data: xr.DataArray) -> list[str]:
    """The directions of what moves that a response tells of, all or z alone."""
    return [axis for axis in WAYS if axis in data[data.dims[2]]]


def head_peaks(vibration: Vibration, model: str) -> dict[str, Peak]:
    """Peaks of the head's motion over the base's, by direction."""
    head = transmissibility(vibration.responses[model], "Head", vibration.base)
    return {axis: peak_of(head.sel({"to": axis, "from": axis})) for axis in axes_of(head)}


def mass_on_base(vibration: Vibration, model: str) -> xr.DataArray:
    """Apparent mass of what moves, kg: vertical, or of a backrest square to it."""
    base = vibration.base
    way = "x" if base == "backrest" else "z"
    return apparent_mass(vibration.responses[model], base, base).sel(force=way, motion=way)


def modes_in_range(vibration: Vibration, modes: tuple[Mode, ...]) -> list[Mode]:
    """The modes that oscillate, or grow, within the frequencies asked for."""
    most = float(vibration.response["frequency"][-1])
    return [
        mode
        for mode in modes
        if mode.frequency <= most and (mode.eigenvalue.imag > 0.0 or mode.eigenvalue.real > 1e-6)
    ]


def mass_shares(vibration: Vibration, mode: Mode) -> dict[str, float]:
    """Share of all that moves over the base which does so in a mode, by the base's direction.

    None where the base pushes through springs alone, as a backrest of foam does: it carries no
    mass.
    """
    place = {port.name: i for i, port in enumerate(vibration.system.inputs)}
    of_all: Array = np.sum([each.effective_mass for each in vibration.undamped], axis=0)
    return {
        axis: float(mode.effective_mass[i] / of_all[i])
        for axis in WAYS
        if (i := place.get(f"{vibration.base} {axis}")) is not None and of_all[i] > 0.0
    }


def seat_in_words(problem: Problem) -> str:
    """What one sits in and leans on."""
    seat = problem.seat
    kinds = {
        "rigid": "a rigid backrest",
        "foam": "a backrest of foam",
        "law": "a backrest that stiffens as it is pressed",
    }
    leans = "no backrest" if seat.backrest is None else kinds[seat.backrest.kind]
    return f"on a {'cushioned' if seat.cushion else 'rigid'} seat, {leans}"


def cautions(vibration: Vibration) -> list[str]:
    """What a reader might take for granted and is not so."""
    seat = vibration.problem.seat
    lumped = any(model.startswith("lumped:") for model in vibration.responses)
    if lumped and (seat.backrest is not None or seat.recline_deg):
        return [
            "Lumped models move up and down alone: neither backrest nor recline acts on them; "
            "compare them with care."
        ]
    return []
