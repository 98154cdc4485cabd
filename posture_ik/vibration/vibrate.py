"""The vibration stage: the model a problem asks for, its modes, and how it answers to motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from posture_ik.body import Body
from posture_ik.errors import BadProblem, nearest
from posture_ik.muscle import Activity, solve_activation
from posture_ik.posture import Posture
from posture_ik.problem import SPINE, Problem, VibrationBlock
from posture_ik.vibration.backrest import at_preload
from posture_ik.vibration.dataset import along_models, in_parts, matrices_of, modes_of
from posture_ik.vibration.factors import Factors
from posture_ik.vibration.finite_element import build_finite_element
from posture_ik.vibration.linear import linearise
from posture_ik.vibration.lumped import build_lumped, load_lumped
from posture_ik.vibration.modes import Mode, Stability, damped_modes, undamped_modes
from posture_ik.vibration.response import (
    absorbed_power,
    apparent_mass,
    frequency_response,
    seen_frames,
    transmissibility,
)
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
        return base_of(self.problem)

    @property
    def responses(self) -> dict[str, xr.Dataset]:
        """The responses of all models by name, the one asked for first."""
        return {self.asked.model: self.response} | self.beside

    def to_dataset(self) -> xr.Dataset:
        """Everything that a reader of `response.nc` needs, named and with units.

        netCDF knows no complex numbers: they are two variables, `_real` and `_imag`. Other models
        stand beside the one asked for along `model`, not a number where one has no such motion.
        """
        each = list(self.responses.values())
        head = along_models([transmissibility(data, "Head", self.base) for data in each])
        mass = along_models([apparent_mass(data, self.base, self.base) for data in each])
        power = along_models([absorbed_power(data, self.base) for data in each])
        result = xr.Dataset(
            {
                **in_parts("response", self.response["response"]),
                **in_parts("transmissibility", head),
                **in_parts("apparent_mass", mass),
                "absorbed_power": power,
                **matrices_of(self.system),
                **modes_of("undamped", self.undamped),
                **modes_of("damped", self.damped),
            }
        )
        return result.assign_coords(
            model=list(self.responses),
            method=("model", [data.method for data in each]),
            miss=("model", [data.miss for data in each]),
            stable=("model", [data.stable for data in each]),
        ).assign_attrs(
            title=self.problem.title,
            model=self.asked.model,
            base=self.base,
            method=self.response.method,
            miss=self.response.miss,
            stable=int(self.stability.stable),
            stability=str(self.stability),
        )


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
    if activity is None and problem.activation and "multibody" in (asked.model, *asked.beside):
        activity = solve_activation(body, posture, problem)
    frames = None if asked.frames is None else tuple(dict.fromkeys(("Head", *asked.frames)))
    shared = None if frames is None else tuple(frame for frame in frames if frame in SPINE)
    systems = {
        name: model_of(name, body, posture, problem, shared, activity) for name in asked.beside
    }
    systems[asked.model] = model_of(asked.model, body, posture, problem, frames, activity)
    for name, system in systems.items():
        _check_moves(name, system, base_of(problem))
    responses = {
        name: frequency_response(system, asked.frequencies.values)
        for name, system in systems.items()
    }
    system, response = systems[asked.model], responses.pop(asked.model)
    _check_frames(asked, seen_frames(response))
    damped = damped_modes(system)
    return Vibration(
        body,
        problem,
        posture,
        system,
        response,
        undamped_modes(system),
        damped,
        Stability.of(damped),
        responses,
    )


def model_of(
    name: str,
    body: Body,
    posture: Posture,
    problem: Problem,
    frames: Sequence[str] | None = None,
    activity: Activity | None = None,
    factors: Factors | None = None,
) -> LinearSystem:
    """The model that `vibration.model` names, with factors in place of its parameters' if given.

    Raises:
        PostureIKError: there is no such model, or it cannot be built.
    """
    seat, asked = problem.seat, problem.vibration or VibrationBlock()
    if name == "multibody":
        return linearise(
            body, posture, problem, frames, discs=asked.discs, activity=activity, factors=factors
        )
    if name == "finite_element":
        return build_finite_element(
            problem.subject,
            float(np.radians(seat.recline_deg)),
            seat.backrest and at_preload(seat.backrest, posture),
            seat.cushion,
            factors=factors or Factors.of(asked.parameters),
            posture=posture if asked.shape == "solved" else None,
            frames=("Head", "S1") if frames is None else frames,
            discs=asked.discs,
        )
    return build_lumped(load_lumped(name.removeprefix("lumped:")), seat.cushion)


def base_of(problem: Problem) -> str:
    """What moves in a problem, as the inputs name it: `seat`, `floor` or `backrest`."""
    asked = problem.vibration or VibrationBlock()
    return "floor" if asked.input == "seat" and problem.seat.cushion is not None else asked.input


def _check_moves(name: str, system: LinearSystem, base: str) -> None:
    if not any(port.name.startswith(f"{base} ") for port in system.inputs):
        moved = dict.fromkeys(port.name.rpartition(" ")[0] for port in system.inputs)
        raise BadProblem(
            "vibration.input",
            f"the model {name!r} has no {base} that could move; what moves there is "
            f"{' or '.join(moved)}.",
        )


def _check_frames(asked: VibrationBlock, known: Sequence[str]) -> None:
    for frame in asked.frames or ():
        if frame not in known:
            raise BadProblem(
                "vibration.frames",
                f"the model {asked.model!r} tells no motion of {frame!r}; {nearest(frame, known)}",
            )
