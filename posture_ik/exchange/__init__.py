"""Files of other programs and result folders, written and read back."""

from posture_ik.exchange.identification import write_identification
from posture_ik.exchange.mbdyn import write_mbdyn
from posture_ik.exchange.motion import (
    write_activation,
    write_motion,
    write_trajectory,
    write_vibration,
)
from posture_ik.exchange.nastran import DECKS, write_nastran
from posture_ik.exchange.results import read_posture, write_posture
from posture_ik.exchange.sensitivity import write_sensitivity
from posture_ik.exchange.urdf import write_urdf

__all__ = [
    "DECKS",
    "read_posture",
    "write_activation",
    "write_identification",
    "write_mbdyn",
    "write_motion",
    "write_nastran",
    "write_posture",
    "write_sensitivity",
    "write_trajectory",
    "write_urdf",
    "write_vibration",
]
