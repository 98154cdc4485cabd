"""The vibration stage: the model a problem asks for, its modes, and how it answers to motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from posture_ik.body import Body
from posture_ik.posture import Posture
from posture_ik.problem import Problem, VibrationBlock
from posture_ik.vibration.finite_element import build_finite_element
from posture_ik.vibration.linear import linearise
from posture_ik.vibration.lumped import build_lumped, load_lumped
from posture_ik.vibration.modes import Mode, Stability, damped_modes, stability, undamped_modes
from posture_ik.vibration.response import frequency_response
from posture_ik.vibration.system import LinearSystem


@dataclass(frozen=True, eq=False)
class Vibration:
    """How a person vibrates about a posture.

    Attributes:
        body: who.
        problem: what was asked; its `vibration` block counts, or the defaults of one.
        posture: about which.
        system: the model.
        response: how every output answers to every input (`frequency_response`).
        undamped, damped: modes, lowest first.
        stability: whether every motion dies away, and which does so least.
        beside: responses of the other models asked for, by name.
    """

    body: Body
    problem: Problem
    posture: Posture
    system: LinearSystem
    response: xr.Dataset
    undamped: tuple[Mode, ...]
    damped: tuple[Mode, ...]
    stability: Stability
    beside: dict[str, xr.Dataset]

    @property
    def asked(self) -> VibrationBlock:
        """What the problem says about vibration."""
        return self.problem.vibration or VibrationBlock()

    @property
    def base(self) -> str:
        """What moves, as the inputs name it: `seat`, `floor` under a cushion, or `backrest`."""
        if self.asked.input == "seat" and self.problem.seat.cushion is not None:
            return "floor"
        return self.asked.input


def vibrate(body: Body, posture: Posture, problem: Problem) -> Vibration:
    """Find how a person vibrates about a posture.

    Args:
        body: who.
        posture: about which; only the multibody model takes its shape.
        problem: its `vibration`, `seat`, `subject` and hands on levers count.

    Returns:
        Model, modes and responses.

    Raises:
        PostureIKError: what is asked does not exist or cannot be (`linearise`, `load_lumped`).
    """
    asked = problem.vibration or VibrationBlock()
    frequencies = asked.frequencies.values
    system = model_of(asked.model, body, posture, problem)
    others = {name: model_of(name, body, posture, problem) for name in asked.beside}
    return Vibration(
        body,
        problem,
        posture,
        system,
        frequency_response(system, frequencies),
        undamped_modes(system),
        damped_modes(system),
        stability(system),
        {name: frequency_response(other, frequencies) for name, other in others.items()},
    )


def model_of(name: str, body: Body, posture: Posture, problem: Problem) -> LinearSystem:
    """The model that `vibration.model` names.

    Raises:
        PostureIKError: there is no such model, or it cannot be built.
    """
    seat = problem.seat
    if name == "multibody":
        frames = problem.vibration.frames if problem.vibration else None
        return linearise(body, posture, problem, frames)
    if name == "finite_element":
        recline = float(np.radians(seat.recline_deg))
        return build_finite_element(problem.subject, recline, seat.backrest, seat.cushion)
    return build_lumped(load_lumped(name.removeprefix("lumped:")), seat.cushion)
