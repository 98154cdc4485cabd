"""Frequency responses of a linear model, three ways, and what is read out of them.

At s = iω the outputs answer to the inputs with

    H(s) = sum_k s^k Y_k X(s) + sum_k s^k D_k,    (s² M + s C + K) X(s) = sum_k s^k B_k.

- direct: solve at every frequency.
- modal: one eigenvalue problem A V = V diag(lambda) of the model in first order
  (`posture_ik.vibration.modes`); then X = V diag(1 / (s - lambda)) V⁻¹ B, and what the inputs
  carry along. Needs M positive definite.
- schur: reduce the pencil s E - A to triangular form once by QZ, and substitute back at every
  frequency. Needs neither M regular nor eigenvectors that span.

Whichever is taken, the answer is compared with the direct one at a few frequencies.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias, get_args

import numpy as np
import xarray as xr
from scipy.linalg import qz

from posture_ik.arrays import Array, one_thread
from posture_ik.errors import BadProblem, PostureIKError
from posture_ik.vibration.modes import poles
from posture_ik.vibration.system import Complex, LinearSystem, Port

Method: TypeAlias = Literal["modal", "schur", "direct"]

#: By how much the fast ways may miss the direct one, relative to the largest of its kind; what is
#: worse is solved directly. Usual are 1e-11. With shear springs of 1e10 N/m the direct one is
#: itself within no more than 1e-8 of the exact answer, and the modal one nearer.
TOLERANCE = 1e-7
CHECKS = 5
#: Rows of the triangular pencil that are substituted at a time.
_BLOCK = 8
_RESPONSE = {"units": "output_unit per input_unit", "long_name": "response of outputs to inputs"}
_AXES = tuple("xyz")
_MOTIONS = ("x", "y", "z", "rx", "ry", "rz")


def frequency_response(
    system: LinearSystem, frequencies: Sequence[float] | Array, method: Method = "modal"
) -> xr.Dataset:
    """How every output of a model answers to every input.

    Args:
        system: the model.
        frequencies: (F,), Hz, positive and ascending.
        method: `modal`, the fastest; `schur` or `direct`. A model without all masses is solved by
            `schur` where `modal` is asked, and one whose answer fails its check by `direct`.

    Returns:
        `response` (frequency, output, input), complex: outputs per unit of input; beside it, where
        the model has the ports, `stht`, `apparent_mass`, `impedance` and `absorbed_power` at the
        seat (see the functions of this module). Attributes `method`, as used; `miss`, the largest
        difference from the direct way over the largest response of the same units; `stable`, 1 or
        0: a model that falls still has a response, but no one will ever see it.

    Raises:
        BadProblem: the frequencies are not such.
        PostureIKError: the method is not one of the three, or the model's numbers are not finite.
    """
    if method not in get_args(Method):
        raise PostureIKError(f"response: no method {method!r}; valid are modal, schur, direct.")
    if not all(np.isfinite(part).all() for part in (*system[1:4], *system[6:])):
        raise PostureIKError("response: the model's matrices must be finite; check what it is of.")
    f = _checked(frequencies)
    s: Complex = (2j * np.pi * f).astype(complex)
    used: str = method
    with one_thread():
        if method == "modal" and not _has_all_masses(system):
            used = "schur"
        response = _WAYS[used](system, s)
        checks = np.unique(np.linspace(0, len(f) - 1, CHECKS).astype(int))
        miss = _miss(system, response[checks], _direct(system, s[checks]))
        if not miss <= TOLERANCE:
            used, response, miss = "direct", _direct(system, s), 0.0
    data = xr.Dataset(
        {"response": (("frequency", "output", "input"), response, _RESPONSE)},
        coords={
            "frequency": ("frequency", f, {"units": "Hz", "long_name": "frequency"}),
            "output": [port.name for port in system.outputs],
            "input": [port.name for port in system.inputs],
            "output_unit": ("output", [port.unit for port in system.outputs]),
            "input_unit": ("input", [port.unit for port in system.inputs]),
        },
        attrs={"method": used, "miss": miss, "stable": int(system.stable)},
    )
    known = {}
    if _seen(data, "Head") and _places(data, "seat", _AXES, "input"):
        known["stht"] = transmissibility(data)
    if _places(data, "seat force", _MOTIONS, "output") and _places(data, "seat", _MOTIONS, "input"):
        known["apparent_mass"] = apparent_mass(data)
        known["impedance"] = impedance(data)
        known["absorbed_power"] = absorbed_power(data)
    return data.assign(known)


def seen_frames(data: xr.Dataset) -> list[str]:
    """The links and masses whose motion is in a response, in its order."""
    ends = tuple(f" {motion}" for motion in _AXES)
    moved = [str(name).rpartition(" ")[0] for name in data["output"].values if name.endswith(ends)]
    whole = [name.removesuffix(" acceleration") for name in moved]
    return [name for name in dict.fromkeys(whole) if not name.endswith((" force", " velocity"))]


def transmissibility(data: xr.Dataset, frame: str = "Head", base: str = "seat") -> xr.DataArray:
    """Motion of a link over that of what moves it, (frequency, to, from): 3 x 3 where all are.

    Of displacements, velocities or accelerations alike.

    Raises:
        PostureIKError: the response lacks the link or what moves it.
    """
    of, power = _seen(data, frame) or (frame, 0)
    return _part(data, (of, _AXES), (base, _AXES), ("to", "from"), power, "1", "transmissibility")


def apparent_mass(data: xr.Dataset, at: str = "seat", base: str = "seat") -> xr.DataArray:
    """Force at an interface over acceleration, (frequency, force, motion): 6 x 6 where all are.

    `at` may be an interface or `total`. In kg, kg m and kg m².

    Raises:
        PostureIKError: the response lacks the interface or what moves.
    """
    unit, dims = "kg, kg m or kg m²", ("force", "motion")
    force, motion = (f"{at} force", _MOTIONS), (base, _MOTIONS)
    return _part(data, force, motion, dims, -2, unit, "apparent mass")


def impedance(data: xr.Dataset, at: str = "seat", base: str = "seat") -> xr.DataArray:
    """Force at an interface over velocity, as `apparent_mass`; N s/m, N s or N m s.

    Raises:
        PostureIKError: the response lacks the interface or what moves.
    """
    unit, dims = "N s/m, N s or N m s", ("force", "motion")
    force, motion = (f"{at} force", _MOTIONS), (base, _MOTIONS)
    return _part(data, force, motion, dims, -1, unit, "mechanical impedance")


def absorbed_power(data: xr.Dataset, base: str = "seat") -> xr.DataArray:
    """Mean power that a motion feeds into the person, (frequency, opposed), never negative.

    For an acceleration of 1 m/s² or rad/s² RMS along one motion: -Im(apparent mass) / ω, W, the
    apparent mass that of all that moves along (`total`, else the interface itself). Motions whose
    opposing force is not in the response are left out.

    Raises:
        PostureIKError: the response lacks the interface or what moves.
    """
    whole = base in ("seat", "floor") and _places(data, "total force", _MOTIONS, "output")
    mass = apparent_mass(data, "total" if whole else base, base)
    forces, motions = list(mass["force"].values), list(mass["motion"].values)
    both = [motion for motion in motions if motion in forces]
    rows, columns = ([names.index(motion) for motion in both] for names in (forces, motions))
    lost = -mass.values[:, rows, columns].imag
    return xr.DataArray(
        lost / (2 * np.pi * data["frequency"].values[:, None]),
        dims=("frequency", "opposed"),
        coords={"frequency": data["frequency"], "opposed": both},
        attrs={"units": "W per (m/s²)² or (rad/s²)²", "long_name": "absorbed power"},
    )


def _checked(frequencies: Sequence[float] | Array) -> Array:
    try:
        f = np.asarray(frequencies, dtype=float)
    except (TypeError, ValueError):
        raise BadProblem("frequencies", "give a list of numbers in Hz") from None
    if f.ndim != 1 or f.size == 0:
        raise BadProblem("frequencies", "there are none; give a list of one or more, in Hz")
    if not np.isfinite(f).all():
        i = int(np.argmin(np.isfinite(f)))
        raise BadProblem("frequencies", f"number {i + 1} is {f[i]}; give finite numbers, in Hz")
    if f.min() <= 0.0:
        i = int(np.argmax(f <= 0.0))
        raise BadProblem("frequencies", f"number {i + 1} is {f[i]:g} Hz; give numbers above zero")
    if np.any(np.diff(f) <= 0.0):
        i = int(np.argmax(np.diff(f) <= 0.0)) + 1
        raise BadProblem(
            "frequencies", f"number {i + 1}, {f[i]:g} Hz, is not above {f[i - 1]:g} Hz; sort them"
        )
    return f


def _places(data: xr.Dataset, of: str, kinds: Sequence[str], port: str) -> dict[str, int]:
    """Where the ports of an interface or link are, by kind, those there are."""
    place = {name: i for i, name in enumerate(data[port].values)}
    return {kind: place[f"{of} {kind}"] for kind in kinds if f"{of} {kind}" in place}


def _seen(data: xr.Dataset, frame: str) -> tuple[str, int] | None:
    """As what a link's motion is in the response: its position, or its acceleration over s²."""
    for of, power in ((frame, 0), (f"{frame} acceleration", -2)):
        if _places(data, of, _AXES, "output"):
            return of, power
    return None


def _part(
    data: xr.Dataset,
    outputs: tuple[str, Sequence[str]],
    inputs: tuple[str, Sequence[str]],
    dims: tuple[str, str],
    power: int,
    unit: str,
    what: str,
) -> xr.DataArray:
    """Some rows and columns of the response, times s to a power."""
    rows, columns = _places(data, *outputs, "output"), _places(data, *inputs, "input")
    for (of, kinds), found in ((outputs, rows), (inputs, columns)):
        if not found:
            raise PostureIKError(f"response: it has no {of} {kinds[0]!r} nor another of its kind.")
    s = 2j * np.pi * data["frequency"].values[:, None, None]
    values = data["response"].values[:, list(rows.values())][:, :, list(columns.values())]
    return xr.DataArray(
        values * s**power,
        dims=("frequency", *dims),
        coords={
            "frequency": data["frequency"],
            dims[0]: list(rows),
            dims[1]: list(columns),
        },
        attrs={"units": unit, "long_name": f"{what}, {inputs[0]} to {outputs[0]}"},
    )


def _has_all_masses(system: LinearSystem) -> bool:
    try:
        np.linalg.cholesky(system.mass)
    except np.linalg.LinAlgError:
        return False
    return True


def _miss(system: LinearSystem, found: Complex, direct: Complex) -> float:
    """Largest difference over the largest response of the same units; not a number counts."""
    worst = 0.0
    outputs, inputs = _by_unit(system.outputs), _by_unit(system.inputs)
    for rows in outputs.values():
        for columns in inputs.values():
            part = np.ix_(range(len(direct)), rows, columns)
            largest = float(np.max(np.abs(direct[part])))
            apart = float(np.max(np.abs(found[part] - direct[part])))
            worst = max(worst, apart / largest if largest else apart, key=_nan_last)
    return worst


def _nan_last(value: float) -> float:
    return np.inf if np.isnan(value) else value


def _by_unit(ports: Sequence[Port]) -> dict[str, list[int]]:
    groups: dict[str, list[int]] = {}
    for i, port in enumerate(ports):
        groups.setdefault(port.unit, []).append(i)
    return groups


def _powers(s: Complex, parts: Array | Complex) -> Complex:
    """Sum of s^k parts_k, (F, *parts.shape[1:]), over the k that are not zero."""
    total = np.zeros((len(s), *parts.shape[1:]), dtype=complex)
    for k, part in enumerate(parts):
        if np.any(part):
            total += s[:, None, None] ** k * part
    return total


def _read(system: LinearSystem, s: Complex, X: Complex, places: Complex | None = None) -> Complex:
    """H (F, r, p) of the coordinates X (n, F p), or of what `places` takes to them."""
    shape = (len(s), len(system.inputs))
    total = _powers(s, system.D)
    for k, part in enumerate(system.Y):
        rows = np.flatnonzero(np.any(part, axis=1))
        if len(rows):
            seen = part[rows] if places is None else part[rows] @ places
            read = (seen @ X).reshape(len(rows), *shape).swapaxes(0, 1)
            total[:, rows] += s[:, None, None] ** k * read
    return total


def _direct(system: LinearSystem, s: Complex) -> Complex:
    driven = _powers(s, system.B)
    X = np.empty_like(driven)
    for i, at in enumerate(s):
        X[i] = np.linalg.solve(
            at**2 * system.mass + at * system.damping + system.stiffness, driven[i]
        )
    return _read(system, s, X.swapaxes(0, 1).reshape(X.shape[1], -1))


def _modal(system: LinearSystem, s: Complex) -> Complex:
    found = poles(system)
    n, push = len(found.shapes), found.shapes.T @ system.B
    # Counted from where the inputs would carry the coordinates at one pace, x = ride u + rest: a
    # base that moves pushes stiff springs with forces that all but cancel, and the slow poles
    # would feel their rounding.
    pace = float(np.mean(np.abs(s)))
    parts = np.array([found.stiffness, found.damping, np.eye(n)])
    powers = pace ** np.arange(3.0)
    ride = np.linalg.solve(np.tensordot(powers, parts, 1), np.tensordot(powers, push, 1))
    push -= parts @ ride
    given = np.vstack([np.zeros((n, push.shape[2] * 3)), np.hstack(list(push))])
    weights = np.linalg.solve(found.vectors, given).reshape(2 * n, 3, -1)
    driven = s[:, None] ** np.arange(3) @ weights  # (2 n, F, p)
    driven /= (s - found.values[:, None])[:, :, None]
    carried = system._replace(D=system.D + system.Y @ (found.shapes @ ride))
    return _read(carried, s, driven.reshape(2 * n, -1), found.places)


def _schur(system: LinearSystem, s: Complex) -> Complex:
    n = len(system.mass)
    # In a unit of time and of each coordinate in which no number is far from 1.
    pace = float(np.mean(np.abs(s)))
    weight = pace**2 * np.diag(system.mass) + np.abs(np.diag(system.stiffness))
    unit = 1.0 / np.sqrt(np.where(weight > 0.0, weight, 1.0))
    mass, damping, stiffness = (np.outer(unit, unit) * part for part in system[1:4])
    zero, eye = np.zeros((n, n)), np.eye(n)
    A = np.block([[zero, eye], [-stiffness, -pace * damping]])
    E = np.block([[eye, zero], [zero, pace**2 * mass]])
    AA, EE, Q, Z = qz(A, E, output="complex")
    driven = unit[:, None] * _powers(s, system.B)  # (F, n, p)
    right = (Q[n:].conj().T @ driven.swapaxes(0, 1).reshape(n, -1)).reshape(2 * n, len(s), -1)
    X, paces = np.empty_like(right), (s / pace)[:, None]
    for stop in range(2 * n, 0, -_BLOCK):
        at, behind = slice(max(stop - _BLOCK, 0), stop), slice(stop, 2 * n)
        size = at.stop - at.start
        rest = X[behind].reshape(2 * n - stop, len(s) * X.shape[2])
        known = right[at] + (AA[at, behind] @ rest).reshape(size, len(s), -1)
        known -= paces * (EE[at, behind] @ rest).reshape(size, len(s), -1)
        diagonal = paces[:, None] * EE[at, at] - AA[at, at]
        X[at] = np.linalg.solve(diagonal, known.swapaxes(0, 1)).swapaxes(0, 1)
    return _read(system, s, unit[:, None] * (Z[:n] @ X.reshape(2 * n, -1)))


_WAYS = {"modal": _modal, "schur": _schur, "direct": _direct}
