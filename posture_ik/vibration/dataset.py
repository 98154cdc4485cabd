"""Models, modes and responses as named arrays with units, without complex numbers.

netCDF knows none: each becomes two variables, `_real` and `_imag`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from posture_ik.problem import COMPONENTS
from posture_ik.vibration.modes import Mode
from posture_ik.vibration.system import LinearSystem

_ORDERS = ["displacement", "velocity", "acceleration"]


def in_parts(name: str, values: xr.DataArray) -> dict[str, xr.DataArray]:
    """The real and the imaginary part of complex numbers, by name."""
    said = values.attrs.get("long_name", name)
    return {
        f"{name}_{short}": part.assign_attrs(values.attrs, long_name=f"{said}, {word} part")
        for short, word, part in (
            ("real", "real", values.real),
            ("imag", "imaginary", values.imag),
        )
    }


def along_models(each: Sequence[xr.DataArray]) -> xr.DataArray:
    """The same of several models, along `model`; not a number where one has no such motion."""
    joined: xr.DataArray = xr.concat(each, "model", join="outer")
    motions = {
        dim: [motion for motion in COMPONENTS if motion in joined[dim]] for dim in joined.dims[2:]
    }
    return joined.sel(motions)


def matrices_of(system: LinearSystem) -> dict[str, xr.DataArray]:
    """M, C, K, and B, Y, D by order of the derivative (`posture_ik.vibration.system`)."""
    square = {"coordinate": list(system.coordinates), "along": list(system.coordinates)}
    ports = {
        "coordinate": list(system.coordinates),
        "input": [port.name for port in system.inputs],
        "output": [port.name for port in system.outputs],
    }
    by_ports = "by units of output, coordinate and input"
    given = {
        "mass": (system.mass, square, "kg, kg m or kg m²", "mass matrix M"),
        "damping": (system.damping, square, "N s/m, N s or N m s", "damping matrix C"),
        "stiffness": (system.stiffness, square, "N/m, N or N m", "stiffness matrix K"),
        "B": (system.B, _ordered(ports, "coordinate", "input"), by_ports, "B, inputs push"),
        "Y": (system.Y, _ordered(ports, "output", "coordinate"), by_ports, "Y, outputs see"),
        "D": (system.D, _ordered(ports, "output", "input"), by_ports, "D, inputs pass to outputs"),
    }
    return {
        name: xr.DataArray(values, coords, attrs={"units": unit, "long_name": said})
        for name, (values, coords, unit, said) in given.items()
    }


def _ordered(ports: Mapping[str, list[str]], *names: str) -> dict[str, list[str]]:
    return {"order": _ORDERS, **{name: ports[name] for name in names}}


def modes_of(kind: str, modes: Sequence[Mode]) -> dict[str, xr.DataArray]:
    """What is known of modes, along a dimension called as their kind, `undamped` or `damped`."""

    def listed(values: Sequence[object], unit: str, said: str, *more: str) -> xr.DataArray:
        attrs = {"units": unit, "long_name": f"{said} of the {kind} modes"}
        return xr.DataArray(np.array(values), dims=(kind, *more), attrs=attrs)

    eigenvalues = listed([mode.eigenvalue for mode in modes], "1/s", "eigenvalue")
    shapes = listed([mode.shape for mode in modes], "1/√kg or 1/(√kg m)", "shape", "coordinate")
    return {
        f"{kind}_frequency": listed([mode.frequency for mode in modes], "Hz", "frequency"),
        f"{kind}_damping_ratio": listed([m.damping_ratio for m in modes], "1", "damping ratio"),
        f"{kind}_symmetry": listed([mode.symmetry for mode in modes], "1", "symmetry"),
        f"{kind}_words": listed([mode.words for mode in modes], "1", "what moves"),
        f"{kind}_effective_mass": listed(
            [mode.effective_mass for mode in modes], "kg or kg m²", "effective mass", "input"
        ),
        **in_parts(f"{kind}_eigenvalue", eigenvalues),
        **in_parts(f"{kind}_shape", shapes),
    }
