"""Stiffness and damping that muscles give an arm: tissue, activation and reflexes (eqs 33, 34).

About a held posture a reflex adds delta a = Kp delta x + Kd delta v to the activation, with
x = l/l0 and v = l'/v0 of the muscle law, at once (quasi-steady: no delay of the nerves). Then a
muscle's force changes by (eq 34)

    delta f = (f_l + f_a Kp/l0) delta l + (f_l' + f_a Kd/v0) delta l'.

With path lengths l(q), L = dl/dq and the torques tau = -Lᵀ f, an arm has

    K = -d tau/dq  = Lᵀ diag(k) L + sum_i f_i d²l_i/dq²,
    D = -d tau/dq' = Lᵀ diag(c) L,

both symmetric, as each muscle's force depends on its own length alone. The last term of K is of
the moment arms that change under load; it may be negative. K holds about rest: in motion the rate
too varies with the posture, d l'/dq = sum_j d²l/dq dq_j q'_j, which is left out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from posture_ik.arrays import Array
from posture_ik.errors import PostureIKError
from posture_ik.muscle.hill import Fibres, Force, working_length

#: Short-range stiffness of active fibres, in forces per fibre length: Cui et al. (2008), J.
#: Biomech. 41:1945, from muscles of the cat; Hu et al. (2011), J. Neurophysiol. 105:1633, with it
#: foretell the end-point stiffness of the human arm.
SHORT_RANGE = 23.4
#: A hand that moves less than this share of its farthest in some direction cannot move there.
_STRETCHED = 1e-9


class MuscleStiffness(NamedTuple):
    """Change of each muscle's force with its length, (m,), N/m: of activation, tissue, reflex."""

    active: Array
    passive: Array
    reflexive: Array


class MuscleDamping(NamedTuple):
    """Change of each muscle's force with its rate, (m,), N s/m: of activation and reflex."""

    active: Array
    reflexive: Array


class JointStiffness(NamedTuple):
    """Stiffness of the joints, (n, n) each, N m/rad, by where it comes from."""

    active: Array
    passive: Array
    reflexive: Array
    geometric: Array

    @property
    def total(self) -> Array:
        """K = -d tau/dq, (n, n), N m/rad."""
        return self.active + self.passive + self.reflexive + self.geometric


class JointDamping(NamedTuple):
    """Damping of the joints, (n, n) each, N m s/rad, by where it comes from."""

    active: Array
    reflexive: Array

    @property
    def total(self) -> Array:
        """D = -d tau/dq', (n, n), N m s/rad."""
        return self.active + self.reflexive


class Endpoint(NamedTuple):
    """Stiffness felt at the hand: what it takes to hold it displaced, with the joints free to give.

    `stiffness` (3, 3), N/m, world axes; `principal` (3,), N/m, ascending, along the columns of
    `axes` (3, 3). `idle`, N m/rad, is the least stiffness left to the joints while the hand is
    held (infinite where none can move): below 0 the arm folds up by itself.
    """

    stiffness: Array
    principal: Array
    axes: Array
    idle: float

    def ellipse(self, plane: tuple[int, int], count: int = 73) -> Array:
        """Forces over unit displacements all round in a plane of two world axes, (count, 2), N/m.

        The ellipse of Mussa-Ivaldi et al. (1985), J. Neurosci. 5:2732; the hand moves within the
        plane, and the force across it is left out.
        """
        angle = np.linspace(0.0, 2 * np.pi, count)
        ellipse: Array = np.column_stack([np.cos(angle), np.sin(angle)])
        return ellipse @ self.stiffness[np.ix_(plane, plane)]


def muscle_stiffness(
    muscles: Fibres, force: Force, proportional: float = 0.0, *, short_range: bool = False
) -> MuscleStiffness:
    """Stiffness of each muscle along its path, by part (eq 34).

    Args:
        muscles: whose they are.
        force: by either law, at the posture and activation held.
        proportional: Kp of the reflex, activation per l0 of stretch. The source gives no value.
        short_range: take the active part, instead of from the slope of the force-length curve,
            from the attached cross-bridges, 23.4 f_active/l0: the stiffness of the first few
            tenths of a per cent of stretch, which is what a vibrating arm shows. Tendons are
            rigid here; with their give it is less, most in muscles with long ones.
    """
    l0 = working_length(muscles)
    slope = force.d_length - force.d_passive
    active = SHORT_RANGE * (force.force - force.passive) / l0 if short_range else slope
    return MuscleStiffness(active, force.d_passive, force.d_activation * proportional / l0)


def muscle_damping(muscles: Fibres, force: Force, derivative: float = 0.0) -> MuscleDamping:
    """Damping of each muscle along its path, by part (eq 34).

    Args:
        muscles: whose they are.
        force: by either law, at the posture and activation held.
        derivative: Kd of the reflex, activation per v0 of rate. The source gives no value.
    """
    return MuscleDamping(force.d_rate, force.d_activation * derivative / muscles.fastest)


def joint_stiffness(
    stiffness: MuscleStiffness, jacobian: Array, curvature: Array
) -> JointStiffness:
    """Stiffness of the joints by muscles.

    Args:
        stiffness: of the muscles.
        jacobian: L = dl/dq, (m, n).
        curvature: sum_i f_i d²l_i/dq² with the muscles' forces, (n, n), N m.
    """
    active, passive, reflexive = (jacobian.T @ (part[:, None] * jacobian) for part in stiffness)
    return JointStiffness(active, passive, reflexive, curvature)


def joint_damping(damping: MuscleDamping, jacobian: Array) -> JointDamping:
    """Damping of the joints by muscles; `jacobian` is L = dl/dq, (m, n)."""
    active, reflexive = (jacobian.T @ (part[:, None] * jacobian) for part in damping)
    return JointDamping(active, reflexive)


def trace_slope(
    muscles: Fibres, full: Force, jacobian: Array, bend: Array, *, short_range: bool = False
) -> Array:
    """How the trace of the joint stiffness grows with each activation, (m,), N m/rad.

    The stiffness is affine in the activations, so this holds wherever they stand.

    Args:
        muscles: whose they are.
        full: forces at full activation, a = 1.
        jacobian: L = dl/dq, (m, n).
        bend: trace of each path's d²l/dq², (m,), m.
        short_range: as in `muscle_stiffness`.
    """
    active = muscle_stiffness(muscles, full, short_range=short_range).active
    slope: Array = active * np.sum(jacobian**2, axis=1) + full.d_activation * bend
    return slope


def endpoint(stiffness: Array, jacobian: Array) -> Endpoint:
    """Stiffness at the hand from that of the joints.

    The hand is displaced by dx, and the joints take the least-energy way there: of dq with
    J dq = dx, the one where K dq is borne by the hand's force alone. Where K can be inverted this
    is (J K⁻¹ Jᵀ)⁻¹; it holds also for joints that nothing stiffens.

    Args:
        stiffness: K (n, n), N m/rad, symmetric: of the muscles, and of whatever else holds the
            joints. For a hand that bears a force F it should hold the term -d(Jᵀ F)/dq, F acting
            on the hand (McIntyre et al. 1996, Biol. Cybern. 75:353).
        jacobian: J of the hand's position, (3, n), m.

    Raises:
        PostureIKError: the hand cannot move in some direction, where its stiffness has no bound.
    """
    left, reach, right = np.linalg.svd(jacobian)
    if reach[-1] <= _STRETCHED * reach[0]:
        way = np.array2string(left[:, -1], precision=2, suppress_small=True)
        raise PostureIKError(
            f"end-point stiffness: the hand cannot move along {way}; bend the arm a little."
        )
    count = len(reach)
    there, idle = right[:count].T @ (left / reach).T, right[count:].T
    coupled = idle.T @ stiffness @ there
    left_over = idle.T @ stiffness @ idle
    give = np.linalg.pinv(left_over, hermitian=True)
    felt = there.T @ stiffness @ there - coupled.T @ give @ coupled
    felt = (felt + felt.T) / 2
    principal, axes = np.linalg.eigh(felt)
    least = float(np.min(np.linalg.eigvalsh(left_over), initial=np.inf))
    return Endpoint(felt, principal, axes, least)
