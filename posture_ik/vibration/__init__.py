"""Vibration about a posture: linear models, their modes and frequency responses."""

from posture_ik.vibration.linear import linearise
from posture_ik.vibration.modes import (
    Mode,
    Stability,
    damped_modes,
    stability,
    undamped_modes,
)
from posture_ik.vibration.response import (
    absorbed_power,
    apparent_mass,
    frequency_response,
    impedance,
    transmissibility,
)
from posture_ik.vibration.state_space import state_space
from posture_ik.vibration.system import LinearSystem, Port

__all__ = [
    "LinearSystem",
    "Mode",
    "Port",
    "Stability",
    "absorbed_power",
    "apparent_mass",
    "damped_modes",
    "frequency_response",
    "impedance",
    "linearise",
    "stability",
    "state_space",
    "transmissibility",
    "undamped_modes",
]
