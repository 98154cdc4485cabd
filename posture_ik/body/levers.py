"""Control levers that follow the hand: bodies on springs, hinged beside the person.

A lever adds a degree of freedom for each angle that follows, `lever_<name>_fore_aft` about y and
then `lever_<name>_lateral` about x, counted from the vertical, the link `lever_<name>` at its pivot
and `lever_<name>_grip` in the middle of its grip, z along the handle. It weighs as a uniform rod
from pivot to grip.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np
import pinocchio as pin

from posture_ik.body import Body
from posture_ik.problem import Lever

#: Thickness of the rod, m: it only keeps the inertia about its own axis above zero.
_RADIUS = 0.01

# A body with its levers is the same object each time, since what is read off a model is kept by it.
_known: WeakKeyDictionary[Body, dict[tuple[tuple[str, Lever], ...], Body]] = WeakKeyDictionary()


def with_levers(body: Body, levers: Mapping[str, Lever]) -> Body:
    """A body and, behind its own degrees of freedom, those of the levers that follow.

    Args:
        body: who, perhaps with these levers already, as a posture has it.
        levers: by name; those of which no angle follows are left out.
    """
    following = tuple((name, lever) for name, lever in levers.items() if lever.follows)
    if all(body.model.existFrame(f"lever_{name}") for name, _ in following):
        return body
    known = _known.setdefault(body, {})
    if following not in known:
        known[following] = _add(body, dict(following))
    return known[following]


def _add(body: Body, levers: Mapping[str, Lever]) -> Body:
    model = body.model.copy()
    springs: list[float] = []
    dampers: list[float] = []
    rest: list[float] = []
    for name, lever in levers.items():
        joint, placement = 0, pin.SE3(np.eye(3), np.array(lever.pivot))
        for angle, axis, hinge in (
            ("fore_aft", "y", pin.JointModelRY()),
            ("lateral", "x", pin.JointModelRX()),
        ):
            value, throw = np.radians([getattr(lever, f"{angle}_deg"), lever.throw_deg])
            if angle not in lever.follows:
                placement = placement * pin.SE3(pin.utils.rotate(axis, value), np.zeros(3))
                continue
            limits = np.array([value - throw]), np.array([value + throw])
            free = np.array([np.inf])
            joint = model.addJoint(
                joint, hinge, placement, f"lever_{name}_{angle}", free, free, *limits
            )
            placement = pin.SE3.Identity()
            springs.append(lever.stiffness)
            dampers.append(lever.damping)
            rest.append(value)
        rod = pin.Inertia.FromCylinder(lever.mass, _RADIUS, lever.length)
        rod.lever = np.array([0.0, 0.0, lever.length / 2])
        handle = pin.utils.rotate("y", np.radians(lever.handle_deg))
        grip = placement * pin.SE3(handle, np.array([0.0, 0.0, lever.length]))
        kind = pin.FrameType.BODY
        model.addFrame(pin.Frame(f"lever_{name}", joint, 0, placement, kind, rod))
        model.addFrame(pin.Frame(f"lever_{name}_grip", joint, 0, grip, kind))
    return replace(
        body,
        model=model,
        stiffness=np.append(body.stiffness, springs),
        damping=np.append(body.damping, dampers),
        q_reference=np.append(body.q_reference, rest),
    )
