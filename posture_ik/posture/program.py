"""The minimum-energy program of a posture (eqs 16-20, corrected) and its exact derivatives.

    minimise    E(theta) = ½ (theta - theta_ergo)ᵀ K (theta - theta_ergo)  [ - sum m g·c(theta) ]
    subject to  psi(theta) = alpha,   chi(theta) >= 0,   lower <= theta <= upper

It is solved in x = K^½ (theta - theta_ergo), in which the springs' Hessian is the identity.

Gravity and every constraint are linear in the pose of each body (see `tasks`), so the Lagrangian's
part beside the springs changes with frame b as c_b·p_b + C_b:R_b. With everything outside a
degree of freedom j gathered in

    F = sum c_b,    B = sum (p_b - o_j) c_bᵀ + sum_k r_bk C_bkᵀ,    m = vee(B)

(o_j the origin of its axis, r_bk and C_bk the columns of R_b and C_b), its first derivative is
w_j·m + a_j·F, and, because an inner rotation i turns all that lies outside it as one rigid body,
its second derivatives are semiseparable:

    H_ij = w_i · y_j  for i inside or equal to j,   y_j = w_j x m + (Bᵀ - tr(B) 1) w_j + a_j x F.

Where a constraint joins two bodies, a hand and a lever, c_b and C_b of the one depend on the pose
of the other; what that adds to H is J_aᵀ D J_b + J_bᵀ Dᵀ J_a, with D the mixed second derivative
in the two poses and J their Jacobians.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import ClassVar, NamedTuple

import casadi as ca
import numpy as np

from posture_ik.errors import PostureIKError
from posture_ik.kinematics import Kinematics, Pose
from posture_ik.posture.tasks import Constraint


class Load(NamedTuple):
    """Coefficients of r functions on a pose: rows c_b (r, 3) and C_b by columns (r, 9)."""

    joint: int
    pose: Pose
    force: ca.SX
    couple: ca.SX


class Program:
    """The program's symbolic graph, shared by all bodies and targets of one structure.

    Attributes:
        size: number n of degrees of freedom.
        one_sided: which of the m rows are chi >= 0 rather than psi = alpha, bool (m,).
        nlp: `x`, `p`, `f`, `g` as CasADi's `nlpsol` takes them.
        derivatives: `grad_f`, `jac_g`, `hess_lag` as CasADi functions for `nlpsol`.
        evaluate: (theta, p, lambda) -> residual (m,), its Jacobian (m, n), gradient (n,) and
            Hessian (n, n) of the Lagrangian, all with respect to x; gravity's potential ().
        residual: (theta, p) -> residual (m,) alone; p ends with `targets` numbers alpha.
        jacobian: (theta, p) -> its Jacobian (m, n) with respect to theta.
        overturn: (theta, p) -> 1 - cos(phi) of every orientation held in full;
            `overturn_of_x` is the same as SX in x and p.
        wrenches: (theta, p, (lambda, 1)) -> force, moment and point (9, number of frames held) of
            each constraint on each of its frames, world axes, at the frame.
    """

    _known: ClassVar[dict[tuple[object, ...], Program]] = {}

    @classmethod
    def of(
        cls, kinematics: Kinematics, constraints: Sequence[Constraint], gravity: bool
    ) -> Program:
        """Give the program of a body's structure and its constraints, built once for all."""
        key = (kinematics, gravity, *(constraint.structure() for constraint in constraints))
        if key not in cls._known:
            cls._known[key] = cls(kinematics, constraints, gravity)
        return cls._known[key]

    def __init__(
        self, kinematics: Kinematics, constraints: Sequence[Constraint], gravity: bool
    ) -> None:
        self.size = n = len(kinematics.motions)
        if kinematics.q.numel() != n:
            raise PostureIKError(
                "the posture needs joints with one coordinate per degree of freedom; "
                "write continuous, spherical and floating joints as hinges and slides."
            )
        rows = [len(constraint.rows) for constraint in constraints]
        one_sided = np.array([constraint.one_sided for constraint in constraints], dtype=bool)
        self.one_sided = np.repeat(one_sided, np.array(rows, dtype=int))

        theta, stiffness, ergonomic = kinematics.q, ca.SX.sym("K", n), ca.SX.sym("ergo", n)
        targets = [ca.SX.sym("alpha", constraint.target.size) for constraint in constraints]
        p = ca.vertcat(kinematics.parameters, stiffness, ergonomic, *targets)
        objective_weight, multipliers = ca.SX.sym("w"), ca.SX.sym("lambda", sum(rows))

        pairs = list(zip(constraints, targets, strict=True))
        poses = {f: kinematics.pose(f) for constraint in constraints for f in constraint.frames}
        residual = ca.vertcat(*[c.residual(poses, target) for c, target in pairs])
        overturn = ca.vertcat(*[c.overturn(poses, target) for c, target in pairs])
        potential = kinematics.potential_energy() if gravity else ca.SX(0)
        # Gravity is one more row, after the m of the tasks, with the objective's weight.
        m = sum(rows)
        holding = _task_loads(kinematics, constraints, targets, m + 1)
        loads = holding + (_gravity_loads(kinematics, m + 1) if gravity else [])
        weights = ca.vertcat(multipliers, objective_weight)
        scale = ca.sqrt(stiffness)
        slopes_of_theta = _slopes(kinematics, loads, m + 1)
        slopes = slopes_of_theta / ca.repmat(scale.T, m + 1)
        curvature = _curvature(kinematics, loads, weights, scale)
        curvature += _joining(kinematics, constraints, targets, multipliers, scale)
        x_of_theta = scale * (theta - ergonomic)
        outputs = [potential, residual, slopes[:m, :], slopes[m, :].T, curvature, overturn]

        at_theta = ca.substitute([curvature], [objective_weight], [ca.SX(1)])[0]
        self.evaluate = ca.Function(
            "evaluate",
            [theta, p, multipliers],
            [
                residual,
                ca.densify(slopes[:m, :]),
                x_of_theta + slopes.T @ ca.vertcat(multipliers, 1),
                ca.densify(ca.SX.eye(n) + ca.triu2symm(at_theta)),
                potential,
            ],
        )
        self.targets = sum(target.numel() for target in targets)
        self.residual = ca.Function("residual", [theta, p], [residual])
        self.jacobian = ca.Function("jacobian", [theta, p], [ca.densify(slopes_of_theta[:m, :])])
        self.overturn = ca.Function("overturn", [theta, p], [overturn])
        wrenches = ca.densify(ca.horzcat(*[_wrench(load, weights) for load in holding]))
        self.wrenches = ca.Function("wrenches", [theta, p, weights], [wrenches])

        x = ca.SX.sym("x", n)
        in_theta = ca.Function("in_theta", [theta, p, weights], outputs)
        falling, g, jacobian, weight, bend, away = in_theta(ergonomic + x / scale, p, weights)
        f = ca.sumsqr(x) / 2 + falling
        self.nlp = {"x": x, "p": p, "f": f, "g": g}
        self.overturn_of_x = away
        bent = ca.substitute(bend, objective_weight, ca.SX(1))
        self.kkt = ca.Function(
            "kkt",
            [x, p, multipliers],
            [g, ca.densify(jacobian), x + weight, ca.densify(ca.SX.eye(n) + ca.triu2symm(bent))],
        )
        self.derivatives = {
            "grad_f": ca.Function("grad_f", [x, p], [f, x + weight]),
            "jac_g": ca.Function("jac_g", [x, p], [g, jacobian]),
            "hess_lag": ca.Function(
                "hess_lag",
                [x, p, objective_weight, multipliers],
                [objective_weight * ca.SX.eye(n) + bend],
            ),
        }


def _task_loads(
    kinematics: Kinematics,
    constraints: Sequence[Constraint],
    targets: Sequence[ca.SX],
    count: int,
) -> list[Load]:
    """Differentiate psi (count,) with respect to the poses it is linear in, frame by frame."""
    loads = []
    start = 0
    for constraint, target in zip(constraints, targets, strict=True):
        poses, numbers, actual = _free_poses(kinematics, constraint)
        residual = constraint.residual(poses, target)
        for frame in constraint.frames:
            force, couple = ca.SX(count, 3), ca.SX(count, 9)
            rows = slice(start, start + len(constraint.rows))
            slope = ca.substitute(ca.jacobian(residual, numbers[frame]), *actual)
            force[rows, :], couple[rows, :] = slope[:, :3], slope[:, 3:]
            loads.append(Load(kinematics.joint_of(frame), kinematics.pose(frame), force, couple))
        start += len(constraint.rows)
    return loads


def _free_poses(
    kinematics: Kinematics, constraint: Constraint
) -> tuple[dict[str, Pose], dict[str, ca.SX], tuple[ca.SX, ca.SX]]:
    """Symbols for the poses of a constraint's frames.

    As poses; as their numbers, p then R by columns (12,); as all numbers, and what they stand for.
    """
    poses = {f: Pose(ca.SX.sym("R", 3, 3), ca.SX.sym("p", 3)) for f in constraint.frames}
    numbers = {f: _numbers(pose) for f, pose in poses.items()}
    actual = ca.vertcat(*[_numbers(kinematics.pose(f)) for f in constraint.frames])
    return poses, numbers, (ca.vertcat(*numbers.values()), actual)


def _numbers(pose: Pose) -> ca.SX:
    return ca.densify(ca.vertcat(pose.position, ca.vec(pose.rotation)))


def _joining(
    kinematics: Kinematics,
    constraints: Sequence[Constraint],
    targets: Sequence[ca.SX],
    multipliers: ca.SX,
    scale: ca.SX,
) -> ca.SX:
    """Second derivatives of multipliersᵀ psi across two bodies, upper triangle of (n, n)."""
    n = len(kinematics.motions)
    total, start = ca.SX(n, n), 0
    for constraint, target in zip(constraints, targets, strict=True):
        poses, numbers, actual = _free_poses(kinematics, constraint)
        weights = multipliers[start : start + len(constraint.rows)]
        start += len(constraint.rows)
        work = ca.dot(weights, constraint.residual(poses, target))
        for first, second in combinations(constraint.frames, 2):
            mixed = ca.jacobian(ca.gradient(work, numbers[first]), numbers[second])
            if mixed.nnz():
                mixed = ca.substitute(mixed, *actual)
                before, behind = (_pose_rates(kinematics, f, scale) for f in (first, second))
                part = before.T @ mixed @ behind
                total += ca.triu(part + part.T)
    return total


def _pose_rates(kinematics: Kinematics, frame: str, scale: ca.SX) -> ca.SX:
    """Jacobian (12, n) of a pose's numbers with respect to theta divided by scale (n,)."""
    rotation, position = kinematics.pose(frame)
    rates = ca.SX(12, len(kinematics.motions))
    for k in kinematics.support(frame):
        w, a, origin = kinematics.motions[k]
        turned = [ca.cross(w, rotation[:, i]) for i in range(3)]
        rates[:, k] = ca.vertcat(a + ca.cross(w, position - origin), *turned) / scale[k]
    return rates


def _gravity_loads(kinematics: Kinematics, count: int) -> list[Load]:
    """The potential -sum m g·(p + R l) as the last of count rows on the joints' poses."""
    loads = []
    for joint, mass, lever in kinematics.bodies():
        force, couple = ca.SX(count, 3), ca.SX(count, 9)
        force[count - 1, :] = -mass * kinematics.gravity.T
        couple[count - 1, :] = -mass * ca.vec(kinematics.gravity @ lever.T).T
        loads.append(Load(joint, kinematics.joint_poses[joint], force, couple))
    return loads


def _outward(
    kinematics: Kinematics, parts: Sequence[tuple[int, ca.SX]], zero: ca.SX
) -> list[ca.SX]:
    """Sum what lies on each joint and outside it, one sweep from the tips to the root."""
    sums = [zero] * len(kinematics.parents)
    for joint, part in parts:
        sums[joint] = sums[joint] + part
    for joint in range(len(sums) - 1, 0, -1):
        parent = kinematics.parents[joint]
        sums[parent] = sums[parent] + sums[joint]
    return sums


def _slopes(kinematics: Kinematics, loads: Sequence[Load], count: int) -> ca.SX:
    """First derivatives (count, n): forces and their moments about the world's origin, swept."""
    moments = []
    for load in loads:
        moment = load.force @ ca.skew(load.pose.position).T
        for k in range(3):
            moment += load.couple[:, 3 * k : 3 * k + 3] @ ca.skew(load.pose.rotation[:, k]).T
        moments.append((load.joint, moment))
    forces = [(load.joint, load.force) for load in loads]
    force = _outward(kinematics, forces, ca.SX(count, 3))
    swept = _outward(kinematics, moments, ca.SX(count, 3))
    columns = []
    for motion, joint in zip(kinematics.motions, kinematics.carriers, strict=True):
        at_origin = motion.linear - ca.cross(motion.angular, motion.origin)
        columns.append(swept[joint] @ motion.angular + force[joint] @ at_origin)
    return ca.horzcat(*columns)


def _curvature(
    kinematics: Kinematics, loads: Sequence[Load], multipliers: ca.SX, scale: ca.SX
) -> ca.SX:
    """Second derivatives of multipliersᵀ (the loads' functions), upper triangle of (n, n).

    With respect to theta divided by scale (n,).
    """
    forces, spreads = [], []
    for load in loads:
        c, couple = _contract(load, multipliers)
        forces.append((load.joint, c))
        spreads.append((load.joint, load.pose.position @ c.T + load.pose.rotation @ couple.T))
    force = _outward(kinematics, forces, ca.SX(3, 1))
    spread = _outward(kinematics, spreads, ca.SX(3, 3))
    reach = []
    for motion, joint in zip(kinematics.motions, kinematics.carriers, strict=True):
        gathered = spread[joint] - motion.origin @ force[joint].T
        reach.append(
            ca.cross(motion.angular, _vee(gathered))
            + gathered.T @ motion.angular
            - ca.trace(gathered) * motion.angular
            + ca.cross(motion.linear, force[joint])
        )
    n = len(kinematics.motions)
    inside = np.zeros((n, n))
    for j, joint in enumerate(kinematics.carriers):
        inside[[i for i in kinematics.carried_by(joint) if i <= j], j] = 1.0
    axes = ca.horzcat(*[motion.angular for motion in kinematics.motions]) / ca.repmat(scale.T, 3)
    reaches = ca.horzcat(*reach) / ca.repmat(scale.T, 3)
    return ca.sparsify((axes.T @ reaches) * ca.sparsify(ca.DM(inside)))


def _contract(load: Load, multipliers: ca.SX) -> tuple[ca.SX, ca.SX]:
    """c_b (3,) and C_b (3, 3) of the functions' sum weighted by multipliers."""
    return load.force.T @ multipliers, ca.reshape(load.couple.T @ multipliers, 3, 3)


def _vee(matrix: ca.SX) -> ca.SX:
    """Sum d x c for a matrix sum d cᵀ."""
    return ca.vertcat(
        matrix[1, 2] - matrix[2, 1], matrix[2, 0] - matrix[0, 2], matrix[0, 1] - matrix[1, 0]
    )


def _wrench(load: Load, multipliers: ca.SX) -> ca.SX:
    """Force and moment with which a constraint acts on a frame, and where, (9,)."""
    force, couple = _contract(load, multipliers)
    return ca.vertcat(-force, -_vee(load.pose.rotation @ couple.T), load.pose.position)
