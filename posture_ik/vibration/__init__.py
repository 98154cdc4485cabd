"""Vibration about a posture: linear models, their modes and frequency responses."""

from posture_ik.vibration.system import LinearSystem, Port

__all__ = ["LinearSystem", "Port"]
