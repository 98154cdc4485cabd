"""Who sits: checked and completed, whichever way a person is described."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from posture_ik import anthropometry
from posture_ik.anthropometry import Gender
from posture_ik.problem.block import Block

#: A person's age (years), stature (m) and body mass index (kg/m²) lie between these.
AGES, STATURES, BODY_MASS_INDICES = (18.0, 99.0), (1.40, 2.10), (14.0, 55.0)
#: What a number may have been meant in: its unit, and what that is in m or kg.
_LENGTHS = {"cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}
_WEIGHTS = {"g": 0.001, "lb": 0.45359237, "st": 6.35029318}
#: How far a measured mass may be from table 9's, as shares of the weight.
_MASSES = {"head_mass": (0.06, 0.26), "arm_mass": (0.025, 0.10)}


class Measured(Block):
    """What was measured of a person, in place of what is typical: lengths in m, masses in kg.

    Heights are above the seat. What is not given is what goes with what is.

    Attributes:
        sitting_height: Of the vertex.
        cervicale_height: Of the seventh cervical vertebra's tip.
        shoulder_height: Of the acromion.
        upper_arm_length: Acromion to the elbow's radiale.
        forearm_length: Radiale to the wrist's stylion.
        hand_length: Stylion to the tip of the middle finger.
        biacromial_breadth: Between the shoulders' acromia.
        chest_breadth: At the nipples.
        chest_depth: At the nipples.
        waist_breadth: At the navel.
        waist_depth: At the navel.
        hip_breadth: Sitting.
        buttock_depth: Standing.
        head_mass: Head with neck, as table 9 parts them.
        arm_mass: One arm, hand included.
    """

    sitting_height: float | None = Field(None, gt=0.0)
    cervicale_height: float | None = Field(None, gt=0.0)
    shoulder_height: float | None = Field(None, gt=0.0)
    upper_arm_length: float | None = Field(None, gt=0.0)
    forearm_length: float | None = Field(None, gt=0.0)
    hand_length: float | None = Field(None, gt=0.0)
    biacromial_breadth: float | None = Field(None, gt=0.0)
    chest_breadth: float | None = Field(None, gt=0.0)
    chest_depth: float | None = Field(None, gt=0.0)
    waist_breadth: float | None = Field(None, gt=0.0)
    waist_depth: float | None = Field(None, gt=0.0)
    hip_breadth: float | None = Field(None, gt=0.0)
    buttock_depth: float | None = Field(None, gt=0.0)
    head_mass: float | None = Field(None, gt=0.0)
    arm_mass: float | None = Field(None, gt=0.0)

    def lengths(self) -> dict[str, float]:
        """The lengths given, m, by name."""
        given = self.model_dump(exclude_none=True)
        return {name: value for name, value in given.items() if name not in _MASSES}


class Subject(Block):
    """Who sits: gender, age (years), weight (kg), stature (m).

    The defaults are the reference subject of the source's §3.2. In place of weight, `bmi` may give
    the body mass index (kg/m²); in place of gender, weight and stature, `percentile` may name a
    person such as "P5 female", in stature and in weight each, of ANSUR II. `measured` holds what is
    known besides; `scaling` is the law by which the reference body is scaled; `urdf` names a file
    of one's own in place of that body.

    How a person sits counts too: `thigh_on_seat` is the part of the thighs that the seat carries,
    and not the feet (0.58 makes up the 61.39 kg of table 9, of 80 kg); `tension` is the stiffness
    of the trunk over the reference subject's, more for muscles tensed and for weak vibration.
    """

    gender: Gender = "male"
    age: float = Field(30.0, ge=AGES[0], le=AGES[1])
    weight: float = Field(80.0, gt=0.0)
    stature: float = 1.80
    measured: Measured = Measured()
    thigh_on_seat: float = Field(0.58, ge=0.0, le=1.0)
    tension: float = Field(1.0, gt=0.0, le=10.0)
    scaling: Literal["thesis", "anthropometric"] = "anthropometric"
    urdf: Path | None = None

    @classmethod
    def percentile(cls, name: str, age: float = 30.0) -> Subject:
        """A person of a percentile of the survey, such as "P5 female", in stature and in weight.

        Raises:
            ValueError: If the name is not of this form, between P1 and P99.
        """
        return cls.model_validate({"percentile": name, "age": age})

    @model_validator(mode="before")
    @classmethod
    def _described_otherwise(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        rest = {key: value for key, value in data.items() if key not in ("percentile", "bmi")}
        if "percentile" in data:
            for key in ("gender", "stature", "weight", "bmi"):
                if key in data:
                    raise ValueError(f"percentile gives the {key} too; leave out one of the two")
            return _of_percentile(data["percentile"]) | rest
        if "bmi" in data:
            if "weight" in data:
                raise ValueError("bmi gives the weight too; leave out one of the two")
            stature = data.get("stature", cls.model_fields["stature"].default)
            rest["weight"] = _weight_of(data["bmi"], stature)
        return rest

    @field_validator("stature")
    @classmethod
    def _stature_in_metres(cls, stature: float) -> float:
        low, high = STATURES
        if not low <= stature <= high:
            raise ValueError(
                f"the stature must lie between {low:.2f} and {high:.2f} m"
                + _meant(stature, low, high, "m", _LENGTHS)
            )
        return stature

    @model_validator(mode="after")
    def _weight_of_a_person(self) -> Subject:
        least, most = BODY_MASS_INDICES
        if not least <= round(self.body_mass_index, 9) <= most:
            low, high = (bmi * self.stature**2 for bmi in (least, most))
            hint = _meant(self.weight, low, high, "kg", _WEIGHTS)
            if STATURES[0] <= self.weight <= STATURES[1]:
                hint = " (is it the stature?)"
            raise ValueError(
                f"weight {self.weight:g} kg at {self.stature:g} m is a body mass index of "
                f"{self.body_mass_index:.1f}; it must lie between {least:g} and {most:g}, that is "
                f"{low:.0f} to {high:.0f} kg{hint}"
            )
        return self

    @model_validator(mode="after")
    def _measured_of_this_person(self) -> Subject:
        if self.scaling != "anthropometric" and self.measured != Measured():
            raise ValueError(
                f"measured counts for nothing where scaling = {self.scaling!r}, one stretch of "
                'the whole body; leave it out, or take scaling = "anthropometric"'
            )
        lengths = self.measured.lengths()
        person = (self.gender, self.age, self.stature, self.weight)
        for name, (low, high) in (
            anthropometry.plausible_ranges(*person, lengths).items() if lengths else ()
        ):
            if not low <= lengths[name] <= high:
                with_others = " with what else is measured" if len(lengths) > 1 else ""
                raise ValueError(
                    f"measured.{name} = {lengths[name]:g} m; of this person{with_others} it must "
                    f"lie between {low:.3f} and {high:.3f} m"
                    + _meant(lengths[name], low, high, "m", _LENGTHS)
                )
        for name, shares in _MASSES.items():
            mass = getattr(self.measured, name)
            low, high = (share * self.weight for share in shares)
            if mass is not None and not low <= mass <= high:
                raise ValueError(
                    f"measured.{name} = {mass:g} kg; of a person of {self.weight:g} kg it must lie "
                    f"between {low:.2f} and {high:.2f} kg{_meant(mass, low, high, 'kg', _WEIGHTS)}"
                )
        return self

    @property
    def body_mass_index(self) -> float:
        """Weight over stature squared, kg/m²."""
        return self.weight / self.stature**2


def sample_people(n: int, seed: int, gender: Gender | None = None) -> list[Subject]:
    """Virtual people: age, stature, weight and what is measured of them, jointly as in the survey.

    Those whom a `Subject` may not be (too short, too heavy ...) are drawn again.

    Args:
        n: How many.
        seed: Of the draw; the same seed gives the same people.
        gender: Of all of them; if not given, each is a man or a woman by even chance.
    """
    random = np.random.default_rng(seed)
    women = {"male": 0, "female": n}[gender] if gender else int(random.binomial(n, 0.5))
    counts: dict[Gender, int] = {"male": n - women, "female": women}
    people = [person for who, count in counts.items() for person in _draw(who, count, random)]
    return [people[i] for i in random.permutation(n)]


def _draw(gender: Gender, count: int, random: np.random.Generator) -> Iterator[Subject]:
    """People of one gender, as many as counted."""
    (short, tall), (thin, thick) = STATURES, BODY_MASS_INDICES
    while count > 0:
        drawn = anthropometry.sample_measures(gender, count, random)
        stature, weight = drawn["stature"], drawn["weight"]
        bmi = weight / stature**2
        allowed = (stature >= short) & (stature <= tall) & (bmi >= thin) & (bmi <= thick)
        for i in np.flatnonzero(allowed):
            known = {
                name: float(x[i]) for name, x in drawn.items() if name in Measured.model_fields
            }
            yield Subject(
                gender=gender,
                age=max(float(drawn["age"][i]), AGES[0]),
                weight=float(weight[i]),
                stature=float(stature[i]),
                measured=Measured(**known),
            )
        count -= int(allowed.sum())


def _of_percentile(name: Any) -> dict[str, Any]:
    """Gender, stature and weight of a percentile such as "P5 female"."""
    found = re.fullmatch(r"P(\d+(?:\.\d+)?) (male|female)", str(name))
    if found is None or not 1.0 <= float(found[1]) <= 99.0:
        raise ValueError(
            f"percentile = {name!r} must be one from P1 to P99 and a gender, such as 'P5 female'"
        )
    gender: Gender = "male" if found[2] == "male" else "female"
    stature, weight = (
        anthropometry.percentile(gender, of, float(found[1])) for of in ("stature", "weight")
    )
    return {"gender": gender, "stature": stature, "weight": weight}


def _weight_of(bmi: Any, stature: Any) -> Any:
    """The weight (kg) of a body mass index, where the stature is a number at all."""
    low, high = BODY_MASS_INDICES
    if not isinstance(bmi, (int, float)) or not low <= bmi <= high:
        raise ValueError(f"bmi = {bmi!r} must be a number between {low:g} and {high:g} kg/m²")
    return bmi * stature**2 if isinstance(stature, (int, float)) else bmi


def _meant(value: float, low: float, high: float, unit: str, others: dict[str, float]) -> str:
    """A hint at the unit a number was probably meant in, if any makes it fit."""
    for other, factor in others.items():
        if low <= value * factor <= high:
            return f" (did you mean {value * factor:.4g} {unit}? {value:g} fits as {other})"
    return ""
