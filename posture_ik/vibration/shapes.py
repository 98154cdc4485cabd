"""How the links of a person move as a model's coordinates do: what a picture of a mode needs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.problem import COMPONENTS, SPINE
from posture_ik.vibration.network import carry
from posture_ik.vibration.spine_elements import LOOSE
from posture_ik.vibration.system import LinearSystem
from posture_ik.vibration.vibrate import Vibration, model_of


def link_motions(vibration: Vibration, links: Sequence[str]) -> dict[str, Array]:
    """Small motions of links by the coordinates of the model, the seat's base at rest.

    What the model holds rigidly, and so has no coordinate, moves along. In the finite-element model
    a link that is no vertebra and no viscus goes rigidly with the vertebra that it hangs on, the
    arms with T2.

    Args:
        vibration: whose model.
        links: of its body, by name.

    Returns:
        By link (6, n): displacement of its origin and rotation, world axes, m or rad for one of
        each coordinate. Empty for a lumped model, whose masses stand for no link.

    Raises:
        PostureIKError: the body has no such link.
    """
    model = vibration.asked.model
    if model == "multibody":
        return _read(_seen(vibration, links), links)
    if model == "finite_element":
        return _of_vertebrae(vibration, links)
    return {}


def _seen(vibration: Vibration, links: Sequence[str]) -> LinearSystem:
    """The same model with the motions of these links as outputs."""
    name, problem = vibration.asked.model, vibration.problem
    return model_of(name, vibration.body, vibration.posture, problem, links)


def _of_vertebrae(vibration: Vibration, links: Sequence[str]) -> dict[str, Array]:
    frames, bodies = vibration.posture.frames, (*SPINE, *LOOSE)
    system = _seen(vibration, bodies)
    moving = _read(system, bodies)
    motions = {}
    for link in links:
        vertebra = link if link in bodies else _carrier(vibration.posture.body.model, link)
        # The legs and the levers stand on the floor.
        motions[link] = np.zeros((6, len(system.coordinates)))
        if vertebra is not None:
            offset = frames[link].translation - frames[vertebra].translation
            motions[link] = carry(offset) @ moving[vertebra]
    return motions


def _read(system: LinearSystem, links: Sequence[str]) -> dict[str, Array]:
    """What of the outputs `Head x` to `Head rz` are the coordinates' doing."""
    ports = [f"{link} {component}" for link in links for component in COMPONENTS]
    rows = system.of((), ports).Y[0]
    return dict(zip(links, rows.reshape(len(links), 6, -1), strict=True))


def _carrier(model: pin.Model, link: str) -> str | None:
    """The vertebra that a link hangs on, if any."""
    vertebrae = {model.frames[model.getFrameId(name)].parentJoint: name for name in SPINE}
    joint = model.frames[model.getFrameId(link)].parentJoint
    while joint and joint not in vertebrae:
        joint = model.parents[joint]
    return vertebrae.get(joint)
