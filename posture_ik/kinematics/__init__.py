"""The CasADi twin of a `pin.Model`, and its dynamics."""

from posture_ik.kinematics.derivatives import torque_derivatives
from posture_ik.kinematics.dynamics import inverse_dynamics
from posture_ik.kinematics.joints import Motion, Pose
from posture_ik.kinematics.twin import Kinematics, frame_poses

__all__ = ["Kinematics", "Motion", "Pose", "frame_poses", "inverse_dynamics", "torque_derivatives"]
