"""A linear model with named coordinates, inputs and outputs: what every kind of model becomes.

    M x'' + C x' + K x = B_0 u + B_1 u' + B_2 u''
    y = Y_0 x + Y_1 x' + Y_2 x'' + D_0 u + D_1 u' + D_2 u''

An input is a motion (m or rad) or a force (N or N m), an output a motion, its rate or acceleration,
or a force. Derivatives stand beside both because a seat that moves pulls through springs (B_0),
dampers (B_1) and what rides on it (B_2), and because accelerations and forces are read out of x''.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.linalg import eigvals

from posture_ik.arrays import Array
from posture_ik.errors import PostureIKError, nearest

#: Arrays of complex numbers, in double precision.
Complex: TypeAlias = npt.NDArray[np.complex128]


class Port(NamedTuple):
    """An input or an output: its name, such as `seat z` or `Head acceleration z`, and unit."""

    name: str
    unit: str


class LinearSystem(NamedTuple):
    """A linear model of n coordinates, p inputs and r outputs.

    Attributes:
        coordinates: name of each coordinate, as in `Body.dofs` where it is a joint's, n of them.
        mass, damping, stiffness: M, C, K, (n, n), SI.
        inputs: p of them; `outputs`: r.
        B: (3, n, p), by order of the input's derivative.
        Y: (3, r, n), by order of the coordinates' derivative.
        D: (3, r, p), by order of the input's derivative.
    """

    coordinates: tuple[str, ...]
    mass: Array
    damping: Array
    stiffness: Array
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    B: Array
    Y: Array
    D: Array

    @property
    def stable(self) -> bool:
        """Whether no motion grows; `posture_ik.vibration.stability` tells which does."""
        try:
            # Springs that push back and dampers that take power: that is enough.
            np.linalg.cholesky(self.stiffness)
            np.linalg.cholesky(self.damping)
        except np.linalg.LinAlgError:
            zero, eye = np.zeros_like(self.mass), np.eye(len(self.mass))
            first = np.block([[zero, eye], [-self.stiffness, -self.damping]])
            second = np.block([[eye, zero], [zero, self.mass]])
            values = eigvals(first, second)
            finite = values[np.isfinite(values)]
            return bool(np.all(finite.real <= rounding(finite)))
        return True

    def of(self, inputs: Sequence[str], outputs: Sequence[str]) -> LinearSystem:
        """The same model seen through some of its ports, in the order named.

        A name that is no port's own stands for all that begin with it: `seat` for `seat x` to
        `seat rz`.

        Raises:
            PostureIKError: no port is called so.
        """
        ins, outs = _found(self.inputs, inputs, "input"), _found(self.outputs, outputs, "output")
        return self._replace(
            inputs=tuple(self.inputs[i] for i in ins),
            outputs=tuple(self.outputs[i] for i in outs),
            B=self.B[:, :, ins],
            Y=self.Y[:, outs],
            D=self.D[:, outs][:, :, ins],
        )


def rounding(eigenvalues: Complex) -> Array:
    """How far right of zero eigenvalues may lie that stand for no growth, 1/s."""
    limit: Array = 1e-8 * np.maximum(1.0, np.abs(eigenvalues))
    return limit


def _found(ports: Sequence[Port], names: Sequence[str], kind: str) -> list[int]:
    known = [port.name for port in ports]
    found: list[int] = []
    for name in names:
        if name in known:
            found.append(known.index(name))
            continue
        group = [i for i, port in enumerate(known) if port.startswith(f"{name} ")]
        if not group:
            raise PostureIKError(f"the model has no {kind} called {name!r}; {nearest(name, known)}")
        found += group
    return found
