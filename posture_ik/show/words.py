"""How pages put numbers, joints and people into words, and the templates that use them."""

from __future__ import annotations

import jinja2
import numpy as np

from posture_ik.problem import Subject
from posture_ik.resources import resource

#: What every number of the body rests on, and what its pictures do.
BODY_RESTS_ON = (
    "Each joint is a set of linear springs between rigid vertebrae: one along the spine, three "
    "turns (published tables); shear is taken as rigid.",
    "Where each joint sits between its two vertebrae is not published; it was identified from "
    "the body's modes of vibration.",
    "Joint ranges are means of published measurements, applied as hard limits.",
    "The springs of the arms are assumed; they only choose among equal arm poses.",
)
PICTURES_REST_ON = (
    "Skin, ribs and limbs in the pictures are drawn for the eye and carry no numbers."
)
_EXPONENT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def template(name: str) -> jinja2.Template:
    """A page of `viz/`, which may write numbers with the filters `number` and `power`."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(resource("viz")),
        autoescape=jinja2.select_autoescape(),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.policies["json.dumps_kwargs"] = {"sort_keys": False}  # order says something
    environment.filters |= {"number": number, "power": power}
    return environment.get_template(name)


def who(subject: Subject) -> str:
    """A person in words."""
    return (
        f"{subject.gender.capitalize()}, {subject.age:g} years, {subject.weight:g} kg, "
        f"{subject.stature:.2f} m"
    )


def number(value: float) -> str:
    """Three significant figures without an exponent; what is below a millionth is 0."""
    if abs(value) < 1e-6:
        return "0"
    digits = max(0, 2 - int(np.floor(np.log10(abs(value)))))
    return f"{value:.{digits}f}".replace("-", "−")


def power(value: float) -> str:
    """Two significant figures as a power of ten, for what ought to be nearly nothing."""
    if value == 0.0:
        return "0"
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{mantissa} × 10{str(int(exponent)).translate(_EXPONENT)}"


def units(dof: str) -> tuple[float, str, str, str]:
    """For a degree of freedom: its factor and unit for people, of its force, of its stiffness."""
    if dof.endswith("_axial"):
        return 1000.0, "mm", "N", "N/mm"
    return float(np.degrees(1.0)), "deg", "N m", "N m/deg"


def direction(dof: str) -> str:
    """Which way a degree of freedom of the spine goes, in words; an arm's name says it already."""
    words = {"axial": "stretch", "rx": "lateral bending", "ry": "flexion", "rz": "axial rotation"}
    suffix = dof.rpartition("_")[2]
    return f" {words[suffix]}" if suffix in words else ""
