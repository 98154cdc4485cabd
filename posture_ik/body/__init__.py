"""Who sits: a subject's scaled tables as a Pinocchio model with springs in its joints."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.body.geometry import BodyGeometry
from posture_ik.body.load import load_model, read_urdf
from posture_ik.body.model import model_of
from posture_ik.body.shapes import visuals
from posture_ik.body.urdf import write_urdf
from posture_ik.errors import BadURDF
from posture_ik.problem import Subject

__all__ = ["Body", "build_body"]


@dataclass(frozen=True, eq=False)
class Body:
    """A seated person's body. Arrays run over its n degrees of freedom, in the model's order.

    Attributes:
        subject: Who.
        model: Pinocchio's model; origin on the seat under the buttocks, x forward, y left, z up.
        own_urdf: The URDF of one's own that it was built from, if any.
        stiffness: (n,), N/m for a slide (`_axial`), N m/rad for a hinge.
        damping: (n,), N s/m or N m s/rad.
        q_reference: (n,), the reference shape: the spine of table 8, hands on the thighs.
    """

    subject: Subject
    model: pin.Model
    own_urdf: str | None
    stiffness: Array
    damping: Array
    q_reference: Array

    @cached_property
    def urdf(self) -> str:
        """The body as a URDF; mesh file names are relative to the file."""
        if self.own_urdf is not None:
            return self.own_urdf
        geometry = BodyGeometry.of(self.subject)
        return write_urdf(geometry, visuals(geometry.nodes, geometry.scale))

    @cached_property
    def dofs(self) -> tuple[str, ...]:
        """Names of the degrees of freedom: of the model's joints."""
        return tuple(self.model.names)[1:]

    @cached_property
    def lower(self) -> Array:
        """Lower limits (n,), m or rad."""
        return np.array(self.model.lowerPositionLimit)

    @cached_property
    def upper(self) -> Array:
        """Upper limits (n,), m or rad."""
        return np.array(self.model.upperPositionLimit)


def build_body(subject: Subject, urdf: Path | None = None) -> Body:
    """Build a subject's body.

    Args:
        subject: Who; the tables are scaled to them (`posture_ik.body.laws`).
        urdf: A URDF of one's own, of the same joint names, instead of the scaled reference body (as
            `subject.urdf`). Its geometry, masses and limits count; stiffness, damping and reference
            shape come from the subject by joint name. The arms may be left out.

    Returns:
        The body, with 103 degrees of freedom in the spine and 7 in each arm.

    Raises:
        BadURDF: If the given URDF is not a seated person of this naming.
    """
    geometry = BodyGeometry.of(subject)
    path, text = urdf or subject.urdf, None
    if path is None:
        model = model_of(geometry)
    else:
        text = read_urdf(path)
        model = load_model(text, path)
        _check_limits(model, geometry, path)
    dofs = tuple(model.names)[1:]
    return Body(
        subject,
        model,
        text,
        np.array([geometry.stiffness[dof] for dof in dofs]),
        np.array([geometry.damping[dof] for dof in dofs]),
        np.array([geometry.reference[dof] for dof in dofs]),
    )


def _check_limits(model: pin.Model, geometry: BodyGeometry, path: Path) -> None:
    """Make sure that the reference shape is within the limits of a URDF of one's own."""
    dofs = tuple(model.names)[1:]
    for dof, lower, upper in zip(
        dofs, model.lowerPositionLimit, model.upperPositionLimit, strict=True
    ):
        if not lower <= geometry.reference[dof] <= upper:
            raise BadURDF(
                path,
                f"the limits {lower:.4g} to {upper:.4g} of joint {dof!r} leave out its reference "
                f"value {geometry.reference[dof]:.4g}.",
            )
