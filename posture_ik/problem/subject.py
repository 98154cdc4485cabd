"""Who sits: checked and completed, whichever way a person is described."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field, field_validator, model_validator

from posture_ik.problem.block import Block


class Subject(Block):
    """Who sits: gender, age (years), weight (kg), stature (m).

    The defaults are the reference subject of the source's §3.2. `urdf` names a file of one's own
    in place of the scaled reference body, `scaling` the law by which it is scaled.
    """

    gender: Literal["male", "female"] = "male"
    age: float = Field(30.0, ge=18.0, le=99.0)
    weight: float = Field(80.0, gt=0.0)
    stature: float = 1.80
    scaling: Literal["thesis", "anthropometric"] = "anthropometric"
    urdf: Path | None = None

    @field_validator("stature")
    @classmethod
    def _stature_in_metres(cls, stature: float) -> float:
        if not 1.40 <= stature <= 2.10:
            hint = f" (did you mean {stature / 100:g} m?)" if 140 <= stature <= 210 else ""
            raise ValueError(f"the stature must lie between 1.40 and 2.10 m{hint}")
        return stature

    @model_validator(mode="after")
    def _weight_of_a_person(self) -> Subject:
        if not 14.0 <= self.body_mass_index <= 55.0:
            low, high = (bmi * self.stature**2 for bmi in (14.0, 55.0))
            raise ValueError(
                f"weight {self.weight:g} kg at {self.stature:g} m is a body mass index of "
                f"{self.body_mass_index:.1f}; it must lie between 14 and 55, that is "
                f"{low:.0f} to {high:.0f} kg"
            )
        return self

    @property
    def body_mass_index(self) -> float:
        """Weight over stature squared, kg/m²."""
        return self.weight / self.stature**2
