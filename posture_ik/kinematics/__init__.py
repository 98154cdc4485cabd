"""The CasADi twin of a `pin.Model`, and its dynamics."""

from posture_ik.kinematics.derivatives import torque_derivatives
from posture_ik.kinematics.dynamics import inverse_dynamics
from posture_ik.kinematics.joints import Motion, Pose
from posture_ik.kinematics.twin import Kinematics, data_of, frame_poses, weightless

__all__ = [
    "Kinematics",
    "Motion",
    "Pose",
    "data_of",
    "frame_poses",
    "inverse_dynamics",
    "torque_derivatives",
    "weightless",
]
