"""Vibration about a posture: linear models, their modes and frequency responses."""

from posture_ik.vibration.finite_element import OpenValues, build_finite_element
from posture_ik.vibration.lumped import LumpedModel, build_lumped, load_lumped, lumped_models
from posture_ik.vibration.seat import FOAM, RIGID, Backrest, Cushion
from posture_ik.vibration.system import LinearSystem, Port

__all__ = [
    "FOAM",
    "RIGID",
    "Backrest",
    "Cushion",
    "LinearSystem",
    "LumpedModel",
    "OpenValues",
    "Port",
    "build_finite_element",
    "build_lumped",
    "load_lumped",
    "lumped_models",
]
