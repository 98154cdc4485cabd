"""The projections once more in the source's own coordinates, six a body (eqs 21-29).

Unknown are the twists V of all bodies, each in its own frame. A joint leaves free only its axis S,
so that the relative twist has no part along the five directions N orthogonal to S: the rows
phi_q V = 0 (eq 23), and across a joint phi_q A = N·(V x S v) (eq 28). Tasks are rows psi_q on the
bodies they hold, each the wrench of a unit multiplier. The mass matrix is block-diagonal and the
KKT matrix sparse:

    [ M      phi_qᵀ  psi_qᵀ ] [ V - V0 ]   [       0          ]
    [ phi_q                 ] [ lambda ] = [ b - phi_q V0     ]                    (eqs 22, 27)
    [ psi_q                 ] [   mu   ]   [ alpha' - psi_q V0 ]

Slower than joint coordinates by far, and it must give the same: a check of both. Its lambda are
the forces in the joints, which joint coordinates never see.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin
from scipy.linalg import block_diag, null_space
from scipy.sparse import block_array, csc_array
from scipy.sparse.linalg import splu

from posture_ik.arrays import Array
from posture_ik.posture.result import Posture
from posture_ik.problem import SPINE

#: Bodies beside the spine, by how their links' names begin.
_OTHERS = ("humerus_", "ulna_", "radius_", "hand_", "lever_")


class Projected(NamedTuple):
    """Twists or accelerations of the b bodies of a model, each in its own frame.

    Attributes:
        bodies: (b, 6), linear above angular, m/s and rad/s or per s² (spatial).
        joints: what keeps each body to its joints, (b, 6): force and moment for accelerations,
            their impulses for twists.
        multipliers: mu of the tasks' rows, (m,).
    """

    bodies: Array
    joints: Array
    multipliers: Array


class Maximal:
    """The bodies of a model under tasks at one instant.

    Args:
        posture: where they are, and the tasks.
        v: joint rates (n,), which the drift of the joints depends on.

    Attributes:
        jacobian: X (6 b, n), from joint rates to twists.
        drift: right-hand side (5 b,) of the joints' rows for accelerations (eq 28).
        coasting: accelerations (6 b,) that v brings without any of the joints'.
        tasks: rows psi_q (m, 6 b).
    """

    def __init__(self, posture: Posture, v: Array) -> None:
        model = posture.body.model
        data = model.createData()
        pin.forwardKinematics(model, data, posture.q, v, np.zeros(model.nv))
        pin.computeJointJacobians(model, data, posture.q)
        joints = range(1, model.njoints)
        count = len(joints)
        rows, self.drift = np.zeros((5 * count, 6 * count)), np.zeros(5 * count)
        blocks = []
        for i in joints:
            blocks.append(pin.getJointJacobian(model, data, i, pin.LOCAL))
            axis = blocks[-1][:, i - 1]  # every joint has one coordinate
            held = null_space(axis[None]).T
            here, inside = slice(5 * (i - 1), 5 * i), model.parents[i]
            rows[here, 6 * (i - 1) : 6 * i] = held
            if inside:
                rows[here, 6 * (inside - 1) : 6 * inside] = -held @ data.liMi[i].actionInverse
            self.drift[here] = held @ data.v[i].cross(pin.Motion(axis * v[i - 1])).vector
        self.jacobian = np.vstack(blocks)
        self.coasting = np.concatenate([data.a[i].vector for i in joints])
        self.tasks = _task_rows(posture, data)
        self._rows = csc_array(rows)
        self._held = csc_array(np.vstack([rows, self.tasks]))
        mass = csc_array(block_diag(*[model.inertias[i].matrix() for i in joints]))
        self._factor = splu(block_array([[mass, self._held.T], [self._held, None]]).tocsc())

    def project(self, guess: Array, joints: Array, tasks: Array) -> Projected:
        """The bodies' motion nearest to a guess that keeps joints and tasks.

        Args:
            guess: twists or accelerations (6 b,).
            joints: right-hand side of the joints' rows, (5 b,).
            tasks: that of the tasks' rows, (m,).
        """
        missed = np.concatenate([joints, tasks]) - self._held @ guess
        solution = self._factor.solve(np.concatenate([np.zeros(len(guess)), missed]))
        step, multipliers = np.split(solution, [len(guess)])
        forces, mu = np.split(multipliers, [len(joints)])
        wrenches = -(self._rows.T @ forces)
        return Projected((guess + step).reshape(-1, 6), wrenches.reshape(-1, 6), mu)


class Bodies(NamedTuple):
    """Motion of b bodies, vertebrae, arms and levers, by their origins, in the world's axes.

    Attributes:
        names: of their links.
        position: (T, b, 3), m; `orientation`: quaternions (T, b, 4), x y z w.
        velocity, acceleration: (T, b, 6), linear above angular; m/s, rad/s, per s² (classical).
    """

    names: tuple[str, ...]
    position: Array
    orientation: Array
    velocity: Array
    acceleration: Array


def bodies_in_motion(model: pin.Model, q: Array, v: Array, a: Array) -> Bodies:
    """A motion as multibody programs keep it, six coordinates a body; q, v, a are (T, n)."""
    links = [
        (index, frame.name)
        for index, frame in enumerate(model.frames)
        if frame.type == pin.FrameType.BODY
        and (frame.name in SPINE or frame.name.startswith(_OTHERS))
        and not frame.name.endswith("_grip")
    ]
    data = model.createData()
    poses = np.empty((len(q), len(links), 7))
    rates = np.empty((2, len(q), len(links), 6))
    for k in range(len(q)):
        pin.forwardKinematics(model, data, q[k], v[k], a[k])
        for i, (index, _) in enumerate(links):
            at = index, pin.LOCAL_WORLD_ALIGNED
            poses[k, i] = pin.SE3ToXYZQUAT(pin.updateFramePlacement(model, data, index))
            rates[0, k, i] = pin.getFrameVelocity(model, data, *at).vector
            rates[1, k, i] = pin.getFrameClassicalAcceleration(model, data, *at).vector
    names = tuple(name for _, name in links)
    return Bodies(names, poses[..., :3], poses[..., 3:], rates[0], rates[1])


def _task_rows(posture: Posture, data: pin.Data) -> Array:
    """Rows (m, 6 b) of the tasks on twists: the opposite of each unit multiplier's wrenches."""
    model, statement = posture.body.model, posture.statement
    names = [frame for constraint in posture.constraints for frame in constraint.frames]
    rows = np.zeros((statement.rows, 6 * (model.njoints - 1)))
    for k, row in enumerate(rows):
        unit = np.append(np.eye(statement.rows)[k], 0.0)
        wrenches = statement.program.wrenches(posture.q, statement.parameters, unit).full().T
        for name, (force, moment, point) in zip(names, wrenches.reshape(-1, 3, 3), strict=True):
            joint = model.frames[model.getFrameId(name, pin.FrameType.BODY)].parentJoint
            at = data.oMi[joint].actInv(pin.SE3(np.eye(3), point))
            row[6 * (joint - 1) : 6 * joint] -= at.act(pin.Force(force, moment)).vector
    return rows
