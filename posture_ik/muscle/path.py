"""How long the muscles of a body's arms are, and how that changes as its joints turn.

A body's arms are the reference arm grown in all directions alike, the left one mirrored, so
that both sides are one graph, evaluated at the angles of each: lengths and slopes grow alike.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from threading import get_ident
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import numpy.typing as npt

from posture_ik.arrays import Array
from posture_ik.body import Body
from posture_ik.body.arms import ARM_JOINTS, SIDES, size
from posture_ik.body.laws import scale_of
from posture_ik.body.tables import numbers, read_table
from posture_ik.errors import PostureIKError
from posture_ik.kinematics import frame_poses
from posture_ik.muscle.arm import CHAIN, DATA, MARKS, ArmGraph, elements
from posture_ik.muscle.course import course, places

#: Names of the 14 arm joints: the right arm's, then the left's.
ARM_DOFS = tuple(f"{joint}_{side}" for side in SIDES for joint in ARM_JOINTS)
#: How far from its place in the reference arm a link may lie, m.
_MISPLACED = 1e-6


def require_arms(body: Body) -> None:
    """Make sure that a body has both arms.

    Raises:
        PostureIKError: If not.
    """
    missing = [dof for dof in ARM_DOFS if dof not in body.dofs]
    if missing:
        raise PostureIKError(
            f"the muscles are those of both arms, but this body has no joint {missing[0]!r}; "
            "take a body with all 14 arm joints."
        )


@dataclass(frozen=True, eq=False)
class Paths:
    """The paths of the 50 muscles of a body's arms, the right arm's before the left's.

    Attributes:
        body: Whose.
        dofs: Names of the 14 arm joints, the columns of the jacobian.
        rows: Their indices in `body.dofs`, (14,).
        scale: The arms' size over the reference arm's.
        lower: Where the paths hold from, (14,), rad.
        upper: Where the paths hold to, (14,), rad.
    """

    body: Body
    dofs: tuple[str, ...]
    rows: npt.NDArray[np.intp]
    scale: float
    lower: Array
    upper: Array

    @classmethod
    def of(cls, body: Body) -> Paths:
        """The paths of a body.

        Raises:
            PostureIKError: If the body lacks an arm, or its arms are not those of this package in
                its subject's size, so that the muscles would not fit them.
        """
        require_arms(body)
        ranges = read_table(DATA / "arm_range.csv")
        degrees = [numbers(ranges[joint], "lower_deg", "upper_deg") for joint in ARM_JOINTS]
        lower, upper = np.tile(np.radians(degrees), (len(SIDES), 1)).T
        rows = np.array([body.dofs.index(dof) for dof in ARM_DOFS])
        paths = cls(body, ARM_DOFS, rows, size(scale_of(body.subject)), lower, upper)
        paths._check_fit()
        return paths

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        """Lengths of the muscles and their slopes.

        Args:
            q: Configuration of the body (n,), m and rad.

        Returns:
            Lengths (50,), m, and their jacobian dl/dq (50, 14), m/rad, whose negative holds the
            moment arms.
        """
        kept = _kept(_lengths, get_ident())
        kept.inputs[0][:], kept.inputs[1][:] = q[self.rows], self.scale
        kept.run()
        lengths, jacobian = kept.outputs
        return lengths.copy(), jacobian.reshape(len(self.dofs), -1).T.copy()

    def curvature(self, q: Array, weights: Array) -> Array:
        """Second derivatives of the lengths, summed: with w constant, the slope of Jᵀ w.

        Args:
            q: Configuration of the body (n,), m and rad.
            weights: w, one a muscle, such as its force, (50,).

        Returns:
            sum of w_i d²l_i/dq², (14, 14), symmetric.
        """
        kept = _kept(_curvature, get_ident())
        kept.inputs[0][:], kept.inputs[1][:] = q[self.rows], self.scale
        kept.inputs[2][:] = weights
        kept.run()
        return kept.outputs[0].reshape(len(self.dofs), -1).copy()

    def outside(self, q: Array) -> tuple[str, ...]:
        """Names of the joints outside the range over which the paths hold.

        There a muscle may pass a bone on its wrong side, and its length and moment arms may jump.

        Args:
            q: Configuration of the body (n,), m and rad.
        """
        angles = q[self.rows]
        out = (angles < self.lower) | (angles > self.upper)
        return tuple(dof for dof, is_out in zip(self.dofs, out, strict=True) if is_out)

    def polylines(self, q: Array) -> tuple[Array, ...]:
        """The muscles as broken lines to draw, arcs sampled.

        Args:
            q: Configuration of the body (n,), m and rad.

        Returns:
            For each muscle its points (k, 3) in the world's axes, m.
        """
        return tuple(line for line, _ in self._drawn(q))

    def carriers(self, q: Array) -> tuple[tuple[str, ...], ...]:
        """For each muscle the links (k,) of the body that carry the points of its broken line."""
        return tuple(links for _, links in self._drawn(q))

    def _drawn(self, q: Array) -> Iterator[tuple[Array, tuple[str, ...]]]:
        poses = frame_poses(self.body.model, q)
        for side in SIDES:
            where = places(poses, side, self.scale)
            for path in elements().values():
                found = course(path, where)
                # The trunk of the reference arm is placed by the body's thorax.
                links = [(link.replace("trunk", "thorax"), len(points)) for link, points in found]
                carriers = (f"{link}_{side}" for link, count in links for _ in range(count))
                yield np.concatenate([points for _, points in found]), tuple(carriers)

    def _check_fit(self) -> None:
        """Compare where the links are with where the reference arm has them, at one posture."""
        q = self.body.q_reference.copy()
        q[self.rows] = 0.3
        poses = frame_poses(self.body.model, q)
        expected = _marks()(q[self.rows][: len(ARM_JOINTS)]).full().T
        for side in SIDES:
            for link in ("thorax", *list(CHAIN)[1:]):
                if f"{link}_{side}" not in poses:
                    raise PostureIKError(
                        f"the muscles need a link '{link}_{side}', which this body has not; "
                        "take a body whose arms are those of an exported URDF."
                    )
            where = places(poses, side, self.scale)
            trunk = where.pop("trunk")
            found = np.concatenate([trunk.back(place.out(MARKS)) for place in where.values()])
            missed = np.linalg.norm(found - expected, axis=1) * self.scale
            if missed.max() > _MISPLACED:
                link = list(where)[int(missed.argmax()) // len(MARKS)]
                raise PostureIKError(
                    f"link {link}_{side} lies up to {1000 * missed.max():.3g} mm off its place in "
                    f"the arm of a person of {self.body.subject.stature:g} m, which the muscles "
                    "are made for; give the subject's stature of that URDF, or keep its arms."
                )


@cache
def _graph() -> ArmGraph:
    return ArmGraph()


@cache
def _marks() -> ca.Function:
    return ca.Function("marks", [_graph().angles], [_graph().marks()])


@cache
def arm_lengths() -> ca.Function:
    """(angles (14,), size) -> lengths (50,) and their jacobian (50, 14), sparse."""
    graph = _graph()
    arm = ca.Function("arm", [graph.angles], [graph.lengths, graph.slopes])
    angles, scale = ca.SX.sym("angles", len(ARM_DOFS)), ca.SX.sym("scale")
    lengths, slopes = zip(*map(arm, ca.vertsplit(angles, len(ARM_JOINTS))), strict=True)
    outputs = [scale * ca.vertcat(*lengths), scale * ca.diagcat(*slopes)]
    return ca.Function("lengths", [angles, scale], ca.cse(outputs))


@cache
def _lengths() -> ca.Function:
    """The same with all of the jacobian, for `Paths.evaluate`."""
    symbols = arm_lengths().sx_in()
    lengths, jacobian = arm_lengths()(*symbols)
    return ca.Function("lengths", symbols, [lengths, ca.densify(jacobian)])


@cache
def _curvature() -> ca.Function:
    """(angles, size, weights) -> sum of weights_i d²l_i/dq² (14, 14)."""
    graph = _graph()
    arm = ca.Function("arm", [graph.angles, graph.weights], [graph.curvature])
    angles, scale = ca.SX.sym("angles", len(ARM_DOFS)), ca.SX.sym("scale")
    weights = ca.SX.sym("weights", len(SIDES) * graph.weights.numel())
    sides = [
        arm(*side)
        for side in zip(
            ca.vertsplit(angles, len(ARM_JOINTS)),
            ca.vertsplit(weights, graph.weights.numel()),
            strict=True,
        )
    ]
    outputs = [ca.densify(scale * ca.diagcat(*sides))]
    return ca.Function("curvature", [angles, scale, weights], ca.cse(outputs))


class _Kept(NamedTuple):
    """A function with its inputs and outputs as vectors, and what runs it on them."""

    inputs: list[Array]
    outputs: list[Array]
    run: Callable[[], None]
    buffer: Any  # must live as long as what runs it


@cache
def _kept(function: Callable[[], ca.Function], thread: int) -> _Kept:
    """One set a thread: this keeps clear of conversions at each call."""
    buffer: Any
    buffer, run = function().buffer()
    inputs = [np.zeros(function().nnz_in(i)) for i in range(function().n_in())]
    outputs = [np.zeros(function().nnz_out(i)) for i in range(function().n_out())]
    for i, vector in enumerate(inputs):
        buffer.set_arg(i, vector.data)
    for i, vector in enumerate(outputs):
        buffer.set_res(i, vector.data)
    return _Kept(inputs, outputs, run, buffer)
