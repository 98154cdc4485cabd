"""Vibration about a posture: linear models, their modes and frequency responses."""

from posture_ik.vibration.factors import Factors
from posture_ik.vibration.finite_element import OpenValues, build_finite_element
from posture_ik.vibration.linear import linearise
from posture_ik.vibration.lumped import build_lumped, load_lumped, lumped_models
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
from posture_ik.vibration.vibrate import Vibration, vibrate

__all__ = [
    "Factors",
    "LinearSystem",
    "Mode",
    "OpenValues",
    "Port",
    "Stability",
    "Vibration",
    "absorbed_power",
    "apparent_mass",
    "build_finite_element",
    "build_lumped",
    "damped_modes",
    "frequency_response",
    "impedance",
    "linearise",
    "load_lumped",
    "lumped_models",
    "stability",
    "state_space",
    "transmissibility",
    "undamped_modes",
    "vibrate",
]
