"""A linear model in python-control's first order form, for whoever designs on.

A motion comes in as its acceleration a, a force as it is: what a is integrated to, u' and u, become
states only where the model feels them. Of the rest,

    z' = A z + B_w w,    y = C z + D_w w,    w = (u, u', a),

with z the coordinates of the undamped modes, displacements times ω, and speeds. The smallest such
model (Gilbert 1963, SIAM J. Control 1:128) takes the residue C v wᵀ B of each eigenvalue, of all
equal ones together, and as many states of it as its rank.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.linalg import block_diag, eig, eigh

from posture_ik.arrays import Array, one_thread
from posture_ik.errors import PostureIKError
from posture_ik.vibration.system import Complex, LinearSystem

if TYPE_CHECKING:
    from control import StateSpace

#: What of the model counts as nothing, relative to its largest of the same kind: rounding.
_NOTHING = 1e-12
#: Eigenvalues this near to each other, relative to their size, are one; residues this small, in
#: what they add to the response, are none.
_EQUAL, _SMALL = 1e-8, 1e-11


class _Core(NamedTuple):
    """z' = A z + B w, y = C z + D w."""

    A: Array
    B: Array
    C: Array
    D: Array


def state_space(
    system: LinearSystem, inputs: Sequence[str], outputs: Sequence[str], minimal: bool = False
) -> StateSpace:
    """Write part of a model in first order.

    Args:
        system: the model; M positive definite.
        inputs: ports of it as `LinearSystem.of` takes them; of a motion the acceleration comes in.
        outputs: likewise.
        minimal: leave out what the inputs do not reach or the outputs do not show.

    Returns:
        python-control's `StateSpace`, inputs and outputs named; a motion's `<name> acceleration`.

    Raises:
        PostureIKError: no port is called so; M is not positive definite; an output follows a rate
            of a force.
    """
    # Slow to import, and only needed here.
    from control import ss

    system = system.of(inputs, outputs)
    moved = np.array([port.unit in ("m", "rad") for port in system.inputs])
    B = np.where(np.abs(system.B) > _NOTHING * _largest(system.B), system.B, 0.0)
    D = np.where(np.abs(system.D) > _NOTHING * _largest(system.D), system.D, 0.0)
    felt = np.any(B, axis=1) | np.any(D, axis=1)  # (3, p)
    if np.any(felt[1:, ~moved]):
        raise PostureIKError("state space: a force's own rate is felt; give it as a motion.")
    with one_thread():
        core = _core(system, B, D)
        if minimal:
            core = _smallest(core)
    return ss(
        *_integrated(core, felt, moved),
        inputs=[
            f"{port.name} acceleration" if motion else port.name
            for port, motion in zip(system.inputs, moved, strict=True)
        ],
        outputs=[port.name for port in system.outputs],
        name="person",
    )


def _largest(parts: Array) -> Array:
    """The largest number of each order, (3, 1, 1), of all ports."""
    largest: Array = np.abs(parts).max(axis=(1, 2), keepdims=True, initial=0.0)
    return np.where(largest > _NOTHING * largest.max(), largest, np.inf)


def _core(system: LinearSystem, B: Array, D: Array) -> _Core:
    """The model with w = (u, u', a), or (f, ., .) of forces."""
    try:
        squares, shapes = eigh(system.stiffness, system.mass)
    except np.linalg.LinAlgError:
        raise PostureIKError("state space: every coordinate needs a mass of its own.") from None
    n = len(squares)
    speed = np.sqrt(np.maximum(np.abs(squares), 1e-6))
    pull, drag = -squares / speed, -shapes.T @ system.damping @ shapes
    force = shapes.T @ np.hstack(list(B))  # (n, 3 p)
    place, rate, acceleration = (part @ shapes for part in system.Y)
    return _Core(
        np.block([[np.zeros((n, n)), np.diag(speed)], [np.diag(pull), drag]]),
        np.vstack([np.zeros_like(force), force]),
        np.hstack([place / speed + acceleration * pull, rate + acceleration @ drag]),
        np.hstack(list(D)) + acceleration @ force,
    )


def _smallest(core: _Core) -> _Core:
    """Gilbert's realisation: of each eigenvalue as many states as its residue has rank."""
    values, vectors = eig(core.A)
    into = np.linalg.solve(vectors, core.B.astype(complex))
    out = core.C @ vectors
    inertia = np.maximum(np.abs(values.real), _NOTHING * np.abs(values))
    # What each adds at its own resonance, by output and input, in units of the most there is.
    peaks = np.abs(out[:, None, :] * into.T[None, :, :]) / inertia
    most = peaks.max(axis=2)
    rows, columns = most.max(axis=1), most.max(axis=0)
    rows, columns = np.where(rows > 0.0, rows, 1.0), np.where(columns > 0.0, columns, 1.0)
    weight = 1.0 / np.sqrt(rows)[:, None], 1.0 / np.sqrt(columns)[None, :]
    blocks, B, C = [], [], []
    for group in _groups(values):
        value = values[group].mean()
        left, sizes, right = np.linalg.svd(
            weight[0] * (out[:, group] @ into[group]) * weight[1], full_matrices=False
        )
        count = int(np.sum(sizes > _SMALL * np.abs(inertia[group].mean())))
        root = np.sqrt(sizes[:count])
        c, b = left[:, :count] * root / weight[0], root[:, None] * right[:count] / weight[1]
        if value.imag == 0.0:
            # The residue of a real eigenvalue is real; its factors may turn together.
            c, b = _real(c, b)
            blocks.append(value.real * np.eye(count))
            B.append(b)
            C.append(c)
        else:
            eye = np.eye(count)
            turn, decay = value.imag * eye, value.real * eye
            blocks.append(np.block([[decay, -turn], [turn, decay]]))
            B.append(np.vstack([b.real, b.imag]))
            C.append(2 * np.hstack([c.real, -c.imag]))
    return _Core(block_diag(*blocks), np.vstack(B), np.hstack(C), core.D)


def _real(c: Complex, b: Complex) -> tuple[Array, Array]:
    """Real factors of the real matrix c b."""
    turn = np.exp(-1j * np.angle(np.sum(c * c, axis=0)) / 2)
    return (c * turn).real, (b / turn[:, None]).real


def _groups(values: Complex) -> list[list[int]]:
    """Which eigenvalues are equal; of a conjugate pair the one that turns forward stands."""
    groups: list[list[int]] = []
    forward = [i for i in np.lexsort((values.imag, values.real)) if values[i].imag >= 0.0]
    for i in forward:
        for group in groups:
            same_kind = (values[i].imag == 0.0) == (values[group[0]].imag == 0.0)
            near = abs(values[i] - values[group[0]]) <= _EQUAL * abs(values[i])
            if same_kind and near:
                group.append(int(i))
                break
        else:
            groups.append([int(i)])
    return groups


def _integrated(core: _Core, felt: Array, moved: Array) -> tuple[Array, Array, Array, Array]:
    """Put before the core the integrators that make u' and u of an acceleration."""
    p = len(moved)
    size = len(core.A)
    B_w, D_w = (part.reshape(len(part), 3, p) for part in (core.B, core.D))
    order = np.where(moved, 2, 0)
    B = np.stack([B_w[:, order[j], j] for j in range(p)], axis=1)
    D = np.stack([D_w[:, order[j], j] for j in range(p)], axis=1)
    # Speeds where u or u' is felt, displacements where u is.
    speeds = [j for j in range(p) if moved[j] and (felt[0, j] or felt[1, j])]
    places = [j for j in speeds if felt[0, j]]
    a, b = len(speeds), len(places)
    A = np.zeros((size + a + b, size + a + b))
    A[:size, :size] = core.A
    A[:size, size : size + a] = B_w[:, 1, speeds]
    A[:size, size + a :] = B_w[:, 0, places]
    inputs = np.zeros((size + a + b, p))
    inputs[:size] = B
    for i, j in enumerate(speeds):
        inputs[size + i, j] = 1.0
    for i, j in enumerate(places):
        A[size + a + i, size + speeds.index(j)] = 1.0
    C = np.hstack([core.C, D_w[:, 1, speeds], D_w[:, 0, places]])
    return A, inputs, C, D
