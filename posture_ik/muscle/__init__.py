"""The muscles of the arms: what they are, where they run, who pulls how hard."""

from posture_ik.muscle.activity import ARMS, Activity, solve_activation
from posture_ik.muscle.path import Paths
from posture_ik.muscle.reach import reach
from posture_ik.muscle.table import Muscles

__all__ = ["ARMS", "Activity", "Muscles", "Paths", "reach", "solve_activation"]
