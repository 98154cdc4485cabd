"""Inverse dynamics of the CasADi twin: Newton and Euler from the root out, d'Alembert back.

All quantities stand in the world's axes and are taken at the world's origin. Body i has the
angular velocity w_i, the velocity v_i of its point that passes the origin, and the spatial
accelerations α_i, a_i of both (their plain time derivatives). With S_k the motion of degree of
freedom k and p(i) the body inside,

    V_i = V_p(i) + Σ S_k v_k,    A_i = A_p(i) + Σ S_k a_k + V x Σ S_k v_k,    A_0 = -gravity,

(Featherstone 2008, §5.3), V in the cross product being that of what carries the joint. The force
at each centre of mass c, m (a + α x c + w x (v + w x c)), and the moment about it are then summed
over all that lies on and outside a joint, and projected on its motions.
"""

from __future__ import annotations

from collections.abc import Iterator

import casadi as ca

from posture_ik.kinematics.joints import Joint
from posture_ik.kinematics.twin import Kinematics

_RATES = {"translation": 3, "planar": 3, "spherical": 3, "freeflyer": 6}


def inverse_dynamics(kinematics: Kinematics, velocity: ca.SX, acceleration: ca.SX) -> ca.SX:
    """Generalised forces that give a motion under gravity, M(q) a + b(q, v): Pinocchio's `rnea`.

    Args:
        kinematics: the twin, whose `q` and `parameters` the result depends on.
        velocity: (nv,), m/s or rad/s.
        acceleration: (nv,), m/s² or rad/s².

    Returns:
        (nv,), N or N m, without springs, dampers or friction.
    """
    zero = ca.SX.zeros(3)
    spin, drift = [zero], [zero]
    turn, pull = [zero], [-kinematics.gravity]
    motions = [
        (motion.angular, motion.linear - ca.cross(motion.angular, motion.origin))
        for motion in kinematics.motions
    ]
    k = 0
    for parent, joint in zip(kinematics.parents[1:], kinematics.structure.joints, strict=True):
        w, v, alpha, a = (each[parent] for each in (spin, drift, turn, pull))
        for size in _stages(joint):
            rates = range(k, k + size)
            dw = sum((motions[i][0] * velocity[i] for i in rates), zero)
            dv = sum((motions[i][1] * velocity[i] for i in rates), zero)
            alpha += ca.cross(w, dw) + sum((motions[i][0] * acceleration[i] for i in rates), zero)
            a += ca.cross(v, dw) + ca.cross(w, dv)
            a += sum((motions[i][1] * acceleration[i] for i in rates), zero)
            w, v = w + dw, v + dv
            k += size
        for each, value in zip((spin, drift, turn, pull), (w, v, alpha, a), strict=True):
            each.append(value)

    force, moment = [zero] * len(spin), [zero] * len(spin)
    for i, mass, lever, inertia in kinematics.inertias:
        rotation, position = kinematics.joint_poses[i]
        c = position + rotation @ lever
        w, alpha = rotation.T @ spin[i], rotation.T @ turn[i]
        speed = drift[i] + ca.cross(spin[i], c)
        force[i] = mass * (pull[i] + ca.cross(turn[i], c) + ca.cross(spin[i], speed))
        moment[i] = rotation @ (inertia @ alpha + ca.cross(w, inertia @ w))
        moment[i] += ca.cross(c, force[i])
    for i in range(len(spin) - 1, 0, -1):
        parent = kinematics.parents[i]
        force[parent] = force[parent] + force[i]
        moment[parent] = moment[parent] + moment[i]
    return ca.vertcat(
        *[
            ca.dot(angular, moment[joint]) + ca.dot(linear, force[joint])
            for (angular, linear), joint in zip(motions, kinematics.carriers, strict=True)
        ]
    )


def _stages(joint: Joint) -> Iterator[int]:
    """Degrees of freedom of a joint, part by part: each part rides on the one before it."""
    for _, part in joint.parts:
        yield from _stages(part)
    if not joint.parts:
        yield _RATES.get(joint.kind, 1)
