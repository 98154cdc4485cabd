"""What resonance, apparent mass and the head's motion hang on."""

from posture_ik.sensitivity.parameters import Parameter
from posture_ik.sensitivity.result import Response, Sensitivity
from posture_ik.sensitivity.study import sensitivity

__all__ = ["Parameter", "Response", "Sensitivity", "sensitivity"]
