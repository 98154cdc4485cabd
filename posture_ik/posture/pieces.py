"""What a posture tells of itself, piece by piece: forces, springs, limits, certificate."""

from __future__ import annotations

from typing import NamedTuple

from posture_ik.arrays import Array


class Wrench(NamedTuple):
    """What acts on the person, in the world's axes: force (N) at a point (m) and moment (N m)."""

    label: str
    force: Array
    moment: Array
    point: Array


class Prestrain(NamedTuple):
    """Relative displacement (n,) m or rad and force (n,) N or N m of each joint's spring."""

    displacement: Array
    force: Array


class ActiveLimit(NamedTuple):
    """A joint at its limit and what the limit carries: N for a stretch, N m for a turn."""

    dof: str
    side: str
    value: float
    load: float


class Certificate(NamedTuple):
    """The numbers that say whether a posture can be trusted, and the verdict.

    `primal`: largest miss of a task or overrun of a limit (m, rad). `dual`: largest component of
    the Lagrangian's gradient in the springs' norm, relative to the largest spring force (at least
    1 √J). `curvature`: least eigenvalue of the Hessian on the directions left free, in the
    springs' norm: 1 for springs alone, above 0 for a minimum. `rank`: independent equations among
    those that hold, of `held`.
    """

    primal: float
    dual: float
    curvature: float
    rank: int
    held: int

    @property
    def holds(self) -> bool:
        """Whether tasks are met to 1e-9, the gradient vanishes to 1e-8, and it is a minimum."""
        return self.primal <= 1e-9 and self.dual <= 1e-8 and self.curvature > 0.0
