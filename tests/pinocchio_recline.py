"""The reclined problem written a second time, on Pinocchio alone, for SciPy to solve."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from scipy.optimize import OptimizeResult, minimize

import posture_ik as pik


class PinocchioRecline:
    """A sliding backrest and the head's orientation: residual (8,) and Jacobian (8, n)."""

    def __init__(self, body: pik.Body, problem: pik.Problem) -> None:
        self.model, self.data = body.model, body.model.createData()
        self.names = list(problem.task[0].bodies)  # type: ignore[union-attr]
        self.back = [self.model.getFrameId(name) for name in self.names]
        self.head = self.model.getFrameId("Head")
        pin.framesForwardKinematics(self.model, self.data, body.q_reference)
        angle = -np.radians(problem.seat.recline_deg)
        self.turn = pin.SE3(pin.utils.rotate("y", angle), np.zeros(3))
        goals = [self.turn * self.data.oMf[i] for i in self.back]
        self.goals = [goal.copy() for goal in goals]
        self.mean = np.mean([goal.translation for goal in goals], axis=0)
        self.arms = [goal.translation - self.mean for goal in goals]
        self.length = np.mean([np.linalg.norm(arm) for arm in self.arms])

    def residual(self, q: np.ndarray) -> np.ndarray:
        pin.framesForwardKinematics(self.model, self.data, q)
        poses = [self.data.oMf[i] for i in self.back]
        mean = self.turn.rotation.T @ (np.mean([p.translation for p in poses], axis=0) - self.mean)
        moment, weight = np.zeros(3), 0.0
        for arm, goal, pose in zip(self.arms, self.goals, poses, strict=True):
            relative = pose.rotation @ goal.rotation.T
            axial = pin.unSkew((relative - relative.T) / 2)
            moment += np.cross(arm, pose.translation) + self.length**2 * axial
            weight += arm @ arm + self.length**2
        head = self.data.oMf[self.head].rotation
        gaze = pin.unSkew((head - head.T) / 2)
        turned = self.turn.rotation.T @ moment / weight
        return np.concatenate([mean[:2], turned, gaze])  # z is free: the back slides

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        pin.computeJointJacobians(self.model, self.data, q)
        pin.framesForwardKinematics(self.model, self.data, q)
        mean, moment, weight = np.zeros((3, len(q))), np.zeros((3, len(q))), 0.0
        for frame, arm, goal in zip(self.back, self.arms, self.goals, strict=True):
            jacobian = self._frame_jacobian(frame)
            relative = self.data.oMf[frame].rotation @ goal.rotation.T
            mean += jacobian[:3] / len(self.back)
            moment += pin.skew(arm) @ jacobian[:3]
            moment += self.length**2 * self._axial_rate(relative) @ jacobian[3:]
            weight += arm @ arm + self.length**2
        turned = self.turn.rotation.T
        head = self._axial_rate(self.data.oMf[self.head].rotation)
        gaze = head @ self._frame_jacobian(self.head)[3:]
        return np.vstack([(turned @ mean)[:2], turned @ moment / weight, gaze])

    def _frame_jacobian(self, frame: int) -> np.ndarray:
        return pin.getFrameJacobian(self.model, self.data, frame, pin.LOCAL_WORLD_ALIGNED)

    @staticmethod
    def _axial_rate(rotation: np.ndarray) -> np.ndarray:
        """The axial part of [w] R is ½ (tr(R) 1 - R) w."""
        return (np.trace(rotation) * np.eye(3) - rotation) / 2

    def minimise(
        self, stiffness: np.ndarray, rest: np.ndarray, lower: np.ndarray, upper: np.ndarray
    ) -> tuple[np.ndarray, OptimizeResult]:
        """SLSQP from rest in the springs' norm, which it needs; the posture and SciPy's result."""
        scale = np.sqrt(stiffness)
        found = minimize(
            lambda x: x @ x / 2,
            np.zeros(len(rest)),
            jac=lambda x: x,
            bounds=list(zip(scale * (lower - rest), scale * (upper - rest), strict=True)),
            constraints={
                "type": "eq",
                "fun": lambda x: 10 * self.residual(rest + x / scale),
                "jac": lambda x: 10 * self.jacobian(rest + x / scale) / scale,
            },
            method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 500},
        )
        return rest + found.x / scale, found
