"""The vibration stage: the model a problem asks for, its modes, and how it answers to motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from posture_ik.body import Body
from posture_ik.muscle import Activity, solve_activation
from posture_ik.posture import Posture
from posture_ik.problem import Problem, VibrationBlock
from posture_ik.vibration.backrest import at_preload
from posture_ik.vibration.factors import Factors
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
        problem: what was asked; its `vibration` block counts, or the defaults of one.
        posture: about which.
        system: the model.
        response: how every output answers to every input (`frequency_response`).
        undamped, damped: modes, lowest first.
        stability: whether every motion dies away, and which does so least.
        beside: responses of the other models asked for, by name.
    """

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


def vibrate(
    body: Body, posture: Posture, problem: Problem, activity: Activity | None = None
) -> Vibration:
    """Find how a person vibrates about a posture.

    Args:
        body: who.
        posture: about which; the multibody model takes its shape, others where asked.
        problem: its `vibration`, `seat`, `subject`, `activation` and hands on levers count.
        activity: the muscles that hold the posture, found here if not given and the problem has
            `activation`.

    Returns:
        Model, modes and responses.

    Raises:
        PostureIKError: what is asked does not exist or cannot be (`linearise`, `load_lumped`).
    """
    asked = problem.vibration or VibrationBlock()
    frequencies = asked.frequencies.values
    if activity is None and problem.activation and "multibody" in (asked.model, *asked.beside):
        activity = solve_activation(body, posture, problem)
    system = model_of(asked.model, body, posture, problem, asked.frames, activity)
    others = {
        name: model_of(name, body, posture, problem, activity=activity) for name in asked.beside
    }
    return Vibration(
        problem,
        posture,
        system,
        frequency_response(system, frequencies),
        undamped_modes(system),
        damped_modes(system),
        stability(system),
        {name: frequency_response(other, frequencies) for name, other in others.items()},
    )


def model_of(
    name: str,
    body: Body,
    posture: Posture,
    problem: Problem,
    frames: Sequence[str] | None = None,
    activity: Activity | None = None,
) -> LinearSystem:
    """The model that `vibration.model` names.

    Raises:
        PostureIKError: there is no such model, or it cannot be built.
    """
    seat, asked = problem.seat, problem.vibration or VibrationBlock()
    if name == "multibody":
        return linearise(body, posture, problem, frames, discs=asked.discs, activity=activity)
    if name == "finite_element":
        return build_finite_element(
            problem.subject,
            float(np.radians(seat.recline_deg)),
            seat.backrest and at_preload(seat.backrest, posture),
            seat.cushion,
            factors=Factors.of(asked.parameters),
            posture=posture if asked.shape == "solved" else None,
            frames=("Head", "S1") if frames is None else frames,
            discs=asked.discs,
        )
    return build_lumped(load_lumped(name.removeprefix("lumped:")), seat.cushion)
