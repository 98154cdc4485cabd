"""The muscles of both arms: their data and their paths."""

from posture_ik.muscle.path import Paths
from posture_ik.muscle.table import Muscles

__all__ = ["Muscles", "Paths"]
