"""The posture a seated person takes: tasks, minimum energy, certificate."""

from posture_ik.posture.motion import Motion, move
from posture_ik.posture.result import ActiveLimit, Certificate, Posture, Wrench
from posture_ik.posture.solve import solve_posture

__all__ = ["ActiveLimit", "Certificate", "Motion", "Posture", "Wrench", "move", "solve_posture"]
