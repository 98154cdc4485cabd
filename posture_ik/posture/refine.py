"""Solve a reach on finer and finer meshes, until integration confirms it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from posture_ik.arrays import Array
from posture_ik.posture.collocation import DEGREE, Mask, radau
from posture_ik.posture.mesh import LONGEST, Question, Solution, solve_on_mesh
from posture_ik.posture.trajectory import InfeasibleReach, Limb, Round, Trajectory

_ROUNDS = 12
_MOST_INTERVALS = 200
#: An interval's share of the duration times its overshoot above which it is split.
_OVERSHOOT = 1e-3
#: Activation to start from, off its bounds.
_SOME = 0.1
#: ... as long as that still changes the cost by more than this share.
_SETTLED = 3e-5


def refine(
    limb: Limb,
    question: Question,
    target: Array,
    tolerance: float,
    intervals: int,
    on_mesh: Callable[[int, int], None] | None = None,
) -> Trajectory:
    """Solve on finer and finer meshes until the defect is within the tolerance."""
    mesh = np.full(intervals, 1.0 / intervals)
    guess = _minimum_jerk(question, target, mesh)
    barrier = 0.1
    rounds: list[Round] = []
    while True:
        if on_mesh:
            on_mesh(len(rounds) + 1, len(mesh))
        solution = solve_on_mesh(question, mesh, guess, barrier)
        if not solution.converged or _endless(question, solution):
            raise InfeasibleReach(_why(question, solution))
        trajectory = _trajectory(limb, question, solution)
        defects, over = trajectory.defects(), _overshoots(trajectory, question)
        rounds.append(
            Round(
                len(mesh),
                solution.iterations,
                solution.cost,
                solution.duration,
                float(np.max(defects)),
                float(np.max(over)),
            )
        )
        rough = defects > tolerance
        settled = len(rounds) > 1 and abs(rounds[-1].cost / rounds[-2].cost - 1) < _SETTLED
        sharp = ~rough & (np.max(over, axis=1) * mesh > _OVERSHOOT) & (not settled)
        if not np.any(rough | sharp):
            break
        if len(rounds) == _ROUNDS or len(mesh) > _MOST_INTERVALS:
            raise InfeasibleReach(
                f"after {len(rounds)} meshes the motion integrated still leaves the one computed "
                f"by {np.max(defects):.1e}; ask for a larger tolerance, or for more smoothness"
            )
        mesh = _split(trajectory, question, rough, sharp, over)
        sample = trajectory.at(trajectory.duration * _places(mesh))
        scale = trajectory.duration
        physical = np.hstack([sample.q, sample.v, sample.a, sample.controls])
        guess = (physical * scale**question.points.powers).T, scale
        barrier = 1e-6
    at_end, p = trajectory.q[-1], question.parameters
    if np.any(question.points.overturn(at_end, p).full() > 1.0):
        raise InfeasibleReach("it ends with a frame half a turn from its task; start nearer to it")
    end = trajectory.shoot()[-1, : question.points.size]
    residual = question.points.end(end, p)[0].full().ravel()
    missed = np.where(question.points.one_sided[0], np.maximum(-residual, 0), np.abs(residual))
    return replace(
        trajectory,
        defect=rounds[-1].defect,
        overshoot=rounds[-1].overshoot,
        end_error=float(np.max(missed)),
        rounds=tuple(rounds),
    )


def _places(mesh: Array) -> Array:
    """Every collocation point in scaled time, (k d,)."""
    edges = np.cumsum(mesh) - mesh
    places: Array = (edges[:, None] + mesh[:, None] * radau()[0]).ravel()
    return places


def _minimum_jerk(question: Question, target: Array, mesh: Array) -> tuple[Array, float]:
    """Where to start: straight to the target with the bell-shaped speed of Flash & Hogan (1985)."""
    s, way = _places(mesh), target - question.start
    shapes = (
        s**3 * (10 - 15 * s + 6 * s**2),
        30 * s**2 * (1 - s) ** 2,
        60 * s * (1 - s) * (1 - 2 * s),
    )
    q, u, w = (np.outer(way, shape) for shape in shapes)
    controls = [
        np.full((size, len(s)), value)
        for size, value in zip(question.points.parts[3:], (_SOME, 0.0, 0.0), strict=False)
    ]
    guess = np.vstack([question.start[:, None] + q, u, w, *controls])
    return guess, 1.0 if question.duration is None else question.duration


def _trajectory(
    limb: Limb,
    question: Question,
    solution: Solution,
) -> Trajectory:
    """Give a solution physical units, and a value at the start."""
    duration, n = solution.duration, question.points.size
    physical = solution.z.T / duration**question.points.powers
    q, v, a, controls = np.split(physical, [n, 2 * n, 3 * n], axis=1)
    points = radau()[0]
    back = np.prod([[-c / (p - c) if c != p else 1.0 for c in points] for p in points], axis=1)
    q, v, a = (
        np.vstack([first, rest])
        for first, rest in ((question.start, q), (0 * question.start, v), (back @ a[:DEGREE], a))
    )
    controls = np.vstack([back @ controls[:DEGREE], controls])
    lagging = len(question.activation)
    controls[0, :lagging] = question.activation
    tau = question.points.torque.map(len(q))(q.T, v.T, a.T, question.parameters).full().T
    tau[0] = back @ tau[1 : DEGREE + 1]
    time = duration * np.append(0.0, _places(solution.mesh))
    return Trajectory(
        limb=limb,
        mesh=solution.mesh,
        time=time,
        q=q,
        v=v,
        a=a,
        tau=tau,
        actuators=question.actuators,
        controls=controls,
        cost=solution.cost,
        status=solution.status,
        iterations=solution.iterations,
        primal=solution.primal,
        dual=solution.dual,
        defect=np.nan,
        overshoot=np.nan,
        end_error=np.nan,
        rounds=(),
    )


def _overshoots(trajectory: Trajectory, question: Question) -> Array:
    """Largest overrun of each joint's limits within each interval, relative, (k, n)."""
    mesh, fine = trajectory.mesh, np.linspace(0.0, 1.0, 4 * DEGREE + 1)
    places = (np.cumsum(mesh) - mesh)[:, None] + mesh[:, None] * fine
    sample = trajectory.at(trajectory.duration * np.clip(places.ravel(), 0.0, 1.0))
    low, high = question.lower, question.upper
    shares = [np.maximum(low - sample.q, sample.q - high) / (high - low)]
    for values, limit in ((sample.v, question.speed), (sample.tau, question.torque)):
        if limit is not None:
            shares.append(np.abs(values) / limit - 1.0)
    worst = np.maximum(np.max(shares, axis=0), 0.0)
    by_interval: Array = worst.reshape(len(mesh), len(fine), -1).max(axis=1)
    return by_interval


def _split(
    trajectory: Trajectory, question: Question, rough: Mask, sharp: Mask, over: Array
) -> Array:
    """Halve rough intervals; cut sharp ones where the torque's mean says that it switches."""
    mesh = []
    weights = radau()[1][-1]
    for k, length in enumerate(trajectory.mesh):
        share = 0.5
        if sharp[k] and question.torque is not None:
            joint = int(np.argmax(over[k]))
            rows = slice(DEGREE * k + 1, DEGREE * (k + 1) + 1)
            tau = trajectory.tau[rows, joint] / question.torque[joint]
            share = (1.0 + np.sign(tau[0]) * weights @ tau) / 2
            share = min(max(share, 0.1), 0.9)
        mesh += [share * length, (1 - share) * length] if rough[k] or sharp[k] else [length]
    return np.array(mesh)


def _endless(question: Question, solution: Solution) -> bool:
    """Whether a free duration grew as far as it may."""
    return question.duration is None and solution.duration > 0.99 * LONGEST


def _why(question: Question, solution: Solution) -> str:
    """Say what may be done about a solve that failed."""
    if _endless(question, solution):
        return "the longer it takes, the less it costs; give a duration"
    within = f" in {question.duration:g} s" if question.duration is not None else ""
    return (
        f"IPOPT ended with {solution.status!r} looking for one{within} within the limits; "
        "give more time, or widen the limits on torque and speed"
    )
