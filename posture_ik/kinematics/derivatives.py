"""First and second derivatives of inverse dynamics in closed form: O(n²) numbers, a few sums each.

Motions (angular, linear) and forces (moment, force) stand in the world's axes at its origin; x
crosses a motion with a motion, x* a motion with a force. With λ what carries joint j, s_j its
motion, I the inertias and S the motions under virtual rates mu, the virtual work of the torques is

    muᵀ tau = Σ_b S_bᵀ (I_b A_b + V_b x* I_b V_b).

A change of q_j, v_j or a_j changes alike all that j carries, as seen from there: S by sigma, V by
nu, A by alpha + nu x V, with

    q_j:  sigma = S_λ x s_j,  nu = V_λ x s_j,  alpha = A_λ x s_j - nu x V_λ,
    v_j:  sigma = 0,          nu = s_j,        alpha = 2 V_λ x s_j,
    a_j:  sigma = 0,          nu = 0,          alpha = s_j.

Derivatives are products of these with sums over what j carries, as in Singh, Russell & Wensing,
who give the first (2022) and the second (2024): here the second contracted with mu, which leaves a
matrix of a tensor.
"""

from __future__ import annotations

import operator
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import casadi as ca

from posture_ik.kinematics.twin import Kinematics


class _Change(NamedTuple):
    """What a change of one coordinate does to all that its joint carries, see above."""

    sigma: ca.SX
    nu: ca.SX
    alpha: ca.SX


class _Sums(NamedTuple):
    """Sums over what a joint carries, of I, A, V and S of its bodies.

    Attributes:
        inertia: I, (6, 6).
        coriolis: what nu adds to the force, (V x*) I - I (V x) + bar(I V), (6, 6).
        virtual: what nu adds to `work`, bar(I S) - (S x*) I + I (S x), (6, 6).
        force: I A + V x* I V, (6,).
        momentum: I S, (6,).
        work: coriolisᵀ S, (6,).
    """

    inertia: ca.SX
    coriolis: ca.SX
    virtual: ca.SX
    force: ca.SX
    momentum: ca.SX
    work: ca.SX


def torque_derivatives(
    kinematics: Kinematics, velocity: ca.SX, acceleration: ca.SX, mu: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """Derivatives of `inverse_dynamics` of joints of one degree of freedom, in z = (q, v, a).

    Args:
        kinematics: the twin, whose `q` and `parameters` the result depends on.
        velocity: (n,), m/s or rad/s.
        acceleration: (n,), m/s² or rad/s².
        mu: what weighs the torques in the second derivative, (n,).

    Returns:
        d tau / dz (n, 3 n), and the upper triangle of d² (muᵀ tau) / dz² (3 n, 3 n).
    """
    n = len(kinematics.motions)
    motions = [
        ca.vertcat(m.angular, m.linear - ca.cross(m.angular, m.origin)) for m in kinematics.motions
    ]
    # What carries each degree of freedom, the innermost first: those of its own joint too.
    inner = [
        [i for i in kinematics.carried_by(joint) if i < k]
        for k, joint in enumerate(kinematics.carriers)
    ]
    rest = _zero(), ca.vertcat(ca.SX.zeros(3), -kinematics.gravity), _zero()
    states: list[tuple[ca.SX, ca.SX, ca.SX]] = []
    changes: list[tuple[_Change, _Change, _Change]] = []
    for k, s in enumerate(motions):
        V, A, S = states[inner[k][-1]] if inner[k] else rest
        nu = _cross(V) @ s
        q = _Change(_cross(S) @ s, nu, _cross(A) @ s - _cross(nu) @ V)
        changes.append((q, _Change(_zero(), s, 2 * nu), _Change(_zero(), _zero(), s)))
        A = A + s * acceleration[k] + nu * velocity[k]
        states.append((V + s * velocity[k], A, S + s * mu[k]))
    sums = _sums(kinematics, states, inner)

    jacobian, hessian = ca.SX.zeros(n, 3 * n), ca.SX.zeros(3 * n, 3 * n)
    for j, (s, of) in enumerate(zip(motions, sums, strict=True)):
        felt, swept = of.inertia @ s, of.coriolis.T @ s
        for i in (*inner[j], j):
            for kind, change in enumerate(changes[i]):
                jacobian[j, kind * n + i] = ca.dot(felt, change.alpha) + ca.dot(swept, change.nu)
        for kind, change in enumerate(changes[j]):
            pull = of.inertia @ change.alpha + of.coriolis @ change.nu
            if kind == 0:
                pull += _crossed(s, of.force)
            for i in inner[j]:
                jacobian[i, kind * n + j] = ca.dot(motions[i], pull)
        for kind, dual in enumerate(_duals(s, changes[j], of)):
            for i in (*inner[j], j):
                for other, change in enumerate(changes[i]):
                    row, column = sorted((other * n + i, kind * n + j))
                    hessian[row, column] = sum(map(ca.dot, dual, change), ca.SX(0))
    return ca.sparsify(jacobian), ca.sparsify(hessian)


def _duals(s: ca.SX, changes: tuple[_Change, ...], of: _Sums) -> Iterator[_Change]:
    """How the first derivative by each coordinate of a joint answers to sigma, nu and alpha."""
    for kind, (sigma, nu, alpha) in enumerate(changes):
        felt = of.inertia @ alpha + of.coriolis @ nu
        swept = of.coriolis.T @ sigma + of.virtual.T @ nu
        pushed = of.inertia @ sigma
        if kind == 0:  # the changes themselves turn with what carries the joint
            felt += _crossed(s, of.force)
            swept += 2 * _crossed(nu, of.momentum) + _crossed(s, of.work)
            pushed += _crossed(s, of.momentum)
        elif kind == 1:
            swept += 2 * _crossed(s, of.momentum)
        yield _Change(felt, swept, pushed)


def _sums(
    kinematics: Kinematics,
    states: Sequence[tuple[ca.SX, ca.SX, ca.SX]],
    inner: Sequence[Sequence[int]],
) -> list[_Sums]:
    """From the tips in: the sums of every degree of freedom."""
    last = {joint: k for k, joint in enumerate(kinematics.carriers)}
    none = _Sums(*[ca.SX(6, 6)] * 3, *[ca.SX(6, 1)] * 3)
    sums = [none] * len(states)
    for joint, inertia in kinematics.spatial_inertias():
        if not joint:  # fixed to the world
            continue
        V, A, S = states[last[joint]]
        of_v, of_s = inertia @ V, inertia @ S
        coriolis = _bar(of_v) - _cross(V).T @ inertia - inertia @ _cross(V)
        virtual = _bar(of_s) + _cross(S).T @ inertia + inertia @ _cross(S)
        force = inertia @ A + _crossed(V, of_v)
        sums[last[joint]] = _Sums(inertia, coriolis, virtual, force, of_s, coriolis.T @ S)
    for k in range(len(states) - 1, -1, -1):
        if inner[k]:
            outer = inner[k][-1]
            sums[outer] = _Sums(*map(operator.add, sums[outer], sums[k]))
    return sums


def _zero() -> ca.SX:
    return ca.SX(6, 1)


def _cross(motion: ca.SX) -> ca.SX:
    """The matrix of motion x, (6, 6)."""
    w, v = ca.skew(motion[:3]), ca.skew(motion[3:])
    return ca.blockcat([[w, ca.SX(3, 3)], [v, w]])


def _crossed(motion: ca.SX, force: ca.SX) -> ca.SX:
    """The force motion x* force, (6,)."""
    w, v, moment, push = motion[:3], motion[3:], force[:3], force[3:]
    return ca.vertcat(ca.cross(w, moment) + ca.cross(v, push), ca.cross(w, push))


def _bar(force: ca.SX) -> ca.SX:
    """The matrix that gives motion x* force of a motion, (6, 6)."""
    moment, push = ca.skew(force[:3]), ca.skew(force[3:])
    return -ca.blockcat([[moment, push], [push, ca.SX(3, 3)]])
