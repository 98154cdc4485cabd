"""The posture a seated person takes: tasks, minimum energy, certificate."""

from posture_ik.posture.control import reach
from posture_ik.posture.motion import Motion, move
from posture_ik.posture.pieces import ActiveLimit, Certificate, Prestrain, Wrench
from posture_ik.posture.result import Posture
from posture_ik.posture.solve import solve_posture
from posture_ik.posture.trajectory import InfeasibleReach, Trajectory

__all__ = [
    "ActiveLimit",
    "Certificate",
    "InfeasibleReach",
    "Motion",
    "Posture",
    "Prestrain",
    "Trajectory",
    "Wrench",
    "move",
    "reach",
    "solve_posture",
]
