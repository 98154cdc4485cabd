"""Who pulls how hard: the activations that hold a posture or drive a motion (eq 32).

Seven joints of an arm, 25 muscles: of all activations a that give the torques asked,

    minimise  sum w (a - level)² + E ceiling² + price sum reserve²
    subject to  C a + reserve = demand,  0 <= a <= ceiling <= 1,

a strictly convex quadratic program with one answer. C is each muscle's torque at full activation;
`demand` is what inverse dynamics asks less what the muscles give at rest, so it holds for a static
posture and for a motion alike. Plain, w = 1, level = 0 and E = 0, it is eq 32; E > 0 makes the
hardest working muscle work as little as can be, and the squares decide only among equals.

The reserve stands in where muscles are too weak and nowhere else: it is asked for only once DAQP
has shown that no activation gives the demand. Then its price is high enough for the torque that
is missing to be, within some 1e-4 N m, the least there can be in the sense of squares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from math import isfinite
from typing import NamedTuple

import daqp
import numpy as np
import numpy.typing as npt

from posture_ik.arrays import Array
from posture_ik.errors import PostureIKError

#: The reserve that costs as much as a muscle at full activation, as a share of the largest torque
#: in capacity or demand: low enough to be a last resort, high enough to keep the program in scale.
_SHARE = 1e-4
#: E of the even share, tried in turn: the first so high that a higher ceiling buys no squares. A
#: demand near the limit of strength makes a vertex of the program, and DAQP may see none there;
#: lower ones round it, to 1e-4 of the ceiling and less, and at the very limit nothing is uneven.
_EVENNESS = (1e6, 1e4, 1e3, 0.0)
#: Muscles alone give a demand to this, N m; just beyond strength DAQP may stop a little short.
_MISS = 1e-8
#: Beside a torque that is missing, less than this is bargained for its price, N m.
_TRIFLE = 1e-4
_FREE = 1e30
#: DAQP's name for an equation, and the bits that turn 1 and -1 into its names for a row to start
#: from as active, at its upper (1) and at its lower bound (3).
_EQUAL, _ACTIVE = 5, 3


class Shortfall(NamedTuple):
    """A torque that muscles cannot give: what the reserve of a joint stands in for, N m."""

    joint: str
    torque: float

    def __str__(self) -> str:
        return f"{self.joint} lacks {self.torque:+.3g} N m"


class Certificate(NamedTuple):
    """The numbers that say whether activations are the optimum, and the verdict.

    `primal`: largest miss of a torque (N m), of a reserve from what its price would buy (N m), or
    overrun of a bound. `dual`: largest component of the Lagrangian's gradient, relative to its
    largest term. `gap`: between the objectives of the program and of its dual, relative to their
    largest term; a multiplier of the wrong sign, or beside a bound that is not met, shows here.
    """

    primal: float
    dual: float
    gap: float

    @property
    def holds(self) -> bool:
        """Whether all three are within 1e-8."""
        return max(self) <= 1e-8


@dataclass(frozen=True)
class Recruitment:
    """Activations of least cost, with what they leave undone and their certificate.

    Attributes:
        capacity, demand, weights, level: what was asked: C (n, m) N m, torques (n,) N m, w (m,).
        activation: a, (m,), between 0 and 1.
        reserve: torque (n,) that the muscles cannot give, N m; exactly 0 where they can.
        multipliers: of the joints' equations, (n,): a demand higher by 1 N m costs `-multipliers`
            more.
        bound_multipliers: of 0 <= a <= ceiling, (m,): positive where a muscle would give more if
            it could, negative where it is left at rest.
        ceiling: what no activation exceeds; 1 unless an even share was asked.
        evenness, price: E, and the price of the reserve per (N m)²; 0 where it does not enter.
        iterations: of DAQP.
        duals: all multipliers of the program as DAQP ordered it, to start the next from.
    """

    capacity: Array
    demand: Array
    weights: Array
    level: float
    activation: Array
    reserve: Array
    multipliers: Array
    bound_multipliers: Array
    ceiling: float
    evenness: float
    price: float
    iterations: int
    duals: Array = field(repr=False)

    @property
    def objective(self) -> float:
        """What is minimal; for the plain problem the sum of squared activations (eq 32)."""
        cost = float(self.weights @ (self.activation - self.level) ** 2)
        if self.evenness:
            cost += self.evenness * self.ceiling**2
        return cost + self.price * float(self.reserve @ self.reserve)

    @property
    def answered(self) -> bool:
        """Whether muscles alone give the demand."""
        return not self.price

    def shortfalls(self, joints: Sequence[str]) -> tuple[Shortfall, ...]:
        """Joints whose reserve stands in, worst first; `joints` names the rows, (n,)."""
        if self.answered:
            return ()
        lack = np.abs(self.reserve)
        told = lack >= min(_TRIFLE, np.max(lack))
        return tuple(
            Shortfall(joints[i], float(self.reserve[i])) for i in np.argsort(-lack) if told[i]
        )

    @cached_property
    def certificate(self) -> Certificate:
        """Whether this is the optimum, from the answer and its multipliers alone (KKT)."""
        a, y, z = self.activation, self.multipliers, self.bound_multipliers
        pressing = np.maximum(z, 0.0)
        primal = max(
            np.max(np.abs(self.capacity @ a + self.reserve - self.demand)),
            np.max(np.abs(self.reserve + y / (2 * self.price))) if self.price else 0.0,
            np.max(-a),
            np.max(a - self.ceiling),
            self.ceiling - 1.0,
            0.0,
        )
        pull = self.capacity.T @ y
        rows = [2 * self.weights * (a - self.level) + pull + z]
        if self.evenness:
            rows.append(np.array([2 * self.evenness * self.ceiling - np.sum(pressing)]))
        largest = max(1.0, np.max(np.abs(pull)))
        paid = np.array(
            [
                2 * self.weights * a @ (a - self.level),
                2 * self.evenness * self.ceiling**2,
                2 * self.price * self.reserve @ self.reserve,
                self.demand @ y,
                0.0 if self.evenness else np.sum(pressing),
            ]
        )
        return Certificate(
            float(primal),
            float(np.max(np.abs(np.concatenate(rows))) / largest),
            float(abs(np.sum(paid)) / max(1.0, np.max(np.abs(paid)))),
        )


def recruit(
    capacity: Array,
    demand: Array,
    weights: Array | None = None,
    *,
    level: float = 0.0,
    evenly: bool = False,
    start: Recruitment | None = None,
) -> Recruitment:
    """Find the activations of least cost that give the torques demanded.

    Args:
        capacity: torque of each muscle at full activation, active part alone, (n, m), N m:
            `-jacobian.T * force.d_activation`.
        demand: torque asked of the muscles' active part, (n,), N m: inverse dynamics' less the
            passive forces', that is plus `jacobian.T @ force.passive`.
        weights: w (m,), positive; 1 each by default, or `volumes` for the least active volume.
        level: activation towards which all are drawn: above 0, co-contraction. The torques stay;
            as it rises from 0 the activations move along the modes of `posture_ik.muscle.modes`.
        evenly: keep the highest activation lowest, the criterion of fatigue (Rasmussen et al.
            2001, J. Biomech. 34:409). Beyond strength there is nothing to even out, and it does
            not count.
        start: the answer of a moment before, to start from.

    Raises:
        PostureIKError: capacity or demand are not finite, or a weight is not positive.
    """
    if weights is not None and not np.all((weights > 0) & (weights < np.inf)):
        raise PostureIKError("activation: weights must be positive; give one above 0 per muscle.")
    answer = None
    for evenness in _EVENNESS if evenly else (0.0,):
        answer = answer or _by_muscles(capacity, demand, weights, level, evenness, start)
    if answer is None:
        # Not finite is not feasible either: it is told apart here, where time does not matter.
        if not np.isfinite(capacity).all() or not np.isfinite(demand).all():
            raise PostureIKError(
                "activation: capacity and demand must be finite; check lengths and torques."
            )
        plain = np.ones(capacity.shape[1]) if weights is None else weights
        answer = _with_reserve(capacity, demand, plain, level)
    if answer is None:
        raise PostureIKError("activation: the solver found no optimum; rescale the torques.")
    return answer


def volumes(peak_force: Array, optimal_length: Array) -> Array:
    """Weights (m,) by muscle volume, peak force times optimal length, of mean 1.

    Volume is cross-section times length, and cross-section goes with peak force.
    """
    volume = peak_force * optimal_length
    weights: Array = volume / np.mean(volume)
    return weights


class _Frame(NamedTuple):
    """What programs of one shape share: all but the capacity, the demand and the cost of a."""

    rows: Array
    upper: Array
    lower: Array
    hessian: Array
    slope: Array
    none: Array
    full: Array
    sense: npt.NDArray[np.int32]


@lru_cache(maxsize=16)
def _frame(n: int, m: int, evenness: float) -> _Frame:
    """Unknowns: activations, then where asked ceiling·√E, so that all have like curvature.

    Rows: the joints' equations, then a - ceiling <= 0. Bounds: of the unknowns, then of the rows.
    """
    size, count = (m + 1, n + m) if evenness else (m, n)
    rows = np.zeros((count, size))
    upper, lower = np.zeros(size + count), np.zeros(size + count)
    upper[:m] = 1.0
    if evenness:
        rows[n:, :m], rows[n:, m] = np.eye(m), -(evenness**-0.5)
        upper[:size], lower[size + n :] = _FREE, -_FREE
    sense = np.zeros(size + count, dtype=np.int32)
    sense[size : size + n] = _EQUAL
    none, full = np.zeros(m), np.ones(m)
    full.flags.writeable = False  # it goes out as the plain weights
    return _Frame(rows, upper, lower, 2 * np.eye(size), np.zeros(size), none, full, sense)


def _by_muscles(
    capacity: Array,
    demand: Array,
    weights: Array | None,
    level: float,
    evenness: float,
    start: Recruitment | None,
) -> Recruitment | None:
    """Solve the program without a reserve; None where no activation gives the demand."""
    n, m = capacity.shape
    frame = _frame(n, m, evenness)
    rows, upper, lower = frame.rows.copy(), frame.upper.copy(), frame.lower.copy()
    hessian, slope = frame.hessian, frame.slope
    size = slope.size
    rows[:n, :m] = capacity
    upper[size : size + n] = lower[size : size + n] = demand
    if weights is not None:
        hessian = hessian.copy()
        np.fill_diagonal(hessian[:m, :m], 2 * weights)
    if level:
        slope = slope.copy()
        slope[:m] = -2 * level * (1.0 if weights is None else weights)
    senses = [frame.sense]
    if start is not None and start.duals.size == upper.size:
        active = np.sign(start.duals).astype(np.int32) & _ACTIVE
        active[size : size + n] = _EQUAL
        # A start may hold more rows than can be active together: then begin again without.
        senses.insert(0, active)
    found = minimise(hessian, slope, rows, upper, lower, senses)
    if found is None:
        return None
    x, duals, iterations = found
    ceiling = float(x[m] * evenness**-0.5) if evenness else 1.0
    if ceiling > 1.0:  # not a bound of the program: with all muscles at both it is degenerate
        return None
    activation = np.minimum(np.maximum(x[:m], frame.none), frame.full)  # rounding, 1e-12 at most
    miss = demand - capacity @ activation
    if miss @ miss > _MISS**2:
        return None
    return Recruitment(
        capacity,
        demand,
        frame.full if weights is None else weights,
        level,
        activation,
        reserve=np.zeros(n),
        multipliers=duals[size : size + n],
        bound_multipliers=duals[:m] + duals[size + n :] if evenness else duals[:m],
        ceiling=ceiling,
        evenness=evenness,
        price=0.0,
        iterations=iterations,
        duals=duals,
    )


def _with_reserve(
    capacity: Array, demand: Array, weights: Array, level: float
) -> Recruitment | None:
    """Solve the program with a reserve, which any demand has.

    Unknowns are the activations and reserve·√price, torques in units of the largest: then no
    number of the program is far from 1, and it is solved to rounding however wild the demand.
    """
    n, m = capacity.shape
    unit = max(float(np.max(np.abs(capacity))), float(np.max(np.abs(demand)))) or 1.0
    rows = np.hstack([capacity / unit, _SHARE * np.eye(n)])
    right, free = demand / unit, np.full(n, _FREE)
    found = minimise(
        2 * np.diag(np.concatenate([weights, np.ones(n)])),
        np.concatenate([-2 * level * weights, np.zeros(n)]),
        rows,
        np.concatenate([np.ones(m), free, right]),
        np.concatenate([np.zeros(m), -free, right]),
        [np.repeat(np.array([0, _EQUAL], dtype=np.int32), [m + n, n])],
    )
    if found is None:
        return None
    x, duals, iterations = found
    activation = np.clip(x[:m], 0.0, 1.0)
    return Recruitment(
        capacity,
        demand,
        weights,
        level,
        activation,
        reserve=demand - capacity @ activation,
        multipliers=duals[m + n :] / unit,
        bound_multipliers=duals[:m],
        ceiling=1.0,
        evenness=0.0,
        price=(_SHARE * unit) ** -2,
        iterations=iterations,
        duals=duals,
    )


def minimise(
    hessian: Array,
    slope: Array,
    rows: Array,
    upper: Array,
    lower: Array,
    senses: Sequence[npt.NDArray[np.int32]],
) -> tuple[Array, Array, int] | None:
    """Minimise ½ xᵀ hessian x + slope·x within bounds and rows, by DAQP.

    Args:
        hessian: (k, k), positive definite.
        slope: (k,).
        rows: (r, k).
        upper: of x, then of the rows, (k + r,).
        lower: likewise.
        senses: kinds of the bounds and rows and which are active at the start, in DAQP's terms,
            (k + r,) each; tried in turn.

    Returns:
        x (k,), the multipliers of bounds and rows (k + r,), positive at an upper bound, and the
        number of iterations; None where no x meets them all.
    """
    for sense in senses:
        x, _, flag, info = daqp.solve(
            hessian,
            slope,
            rows,
            upper,
            lower,
            sense,
            primal_tol=1e-12,
            dual_tol=1e-12,
            eq_reduction=-1,
        )
        if flag == 1 and isfinite(x @ x):
            return x, info["lam"], info["iterations"]
    return None
