"""A run's folder: `posture.nc`, `prestrain.csv`, `problem.toml`, `model.urdf`, and back."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pinocchio as pin
import tomli_w
import xarray as xr

from posture_ik.body import build_body
from posture_ik.errors import BadResult
from posture_ik.exchange.urdf import write_urdf
from posture_ik.posture import Posture
from posture_ik.posture.statement import Statement
from posture_ik.problem import load_problem


def write_posture(posture: Posture, folder: Path) -> None:
    """Write a posture with all it takes to read it back into an existing folder."""
    write_urdf(posture.body, folder / "model.urdf")
    problem = posture.problem.model_dump(mode="json", exclude_none=True)
    if posture.problem.subject.urdf is not None:
        problem["subject"]["urdf"] = "model.urdf"
    (folder / "problem.toml").write_text(tomli_w.dumps(problem), encoding="utf-8")
    posture.to_dataset().to_netcdf(folder / "posture.nc", engine="h5netcdf")
    _write_prestrain(posture, folder / "prestrain.csv")


def _write_prestrain(posture: Posture, path: Path) -> None:
    """One row a degree of freedom: what its spring is displaced by and carries, local frame.

    `force` is what the spring exerts along the coordinate, `gravity_force` what the weight does
    (Pinocchio; 0 where it is not counted); a joint limit does -`limit`, the tasks do the rest.
    """
    model = posture.body.model
    weight = np.zeros(model.nv)
    if posture.problem.posture.gravity:
        weight = -pin.computeGeneralizedGravity(model, model.createData(), posture.q)
    rows = zip(
        posture.body.dofs,
        posture.displacement,
        posture.prestrain_force,
        posture.stiffness,
        posture.energies,
        posture.limit_multipliers,
        weight,
        strict=True,
    )
    columns = "dof unit displacement force_unit force stiffness energy_J limit gravity_force"
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(columns.split())
        for dof, displacement, *others in rows:
            unit, force_unit = ("m", "N") if dof.endswith("_axial") else ("rad", "N m")
            numbers = [f"{value:.12g}" for value in others]
            table.writerow([dof, unit, f"{displacement:.12g}", force_unit, *numbers])


def read_posture(folder: Path) -> Posture:
    """Read a posture back from a run's folder.

    Raises:
        BadResult: a file is missing, damaged, or does not belong with the others.
    """
    if not folder.is_dir():
        raise BadResult(folder, "there is no such folder; give one that `posture-ik run` wrote")
    for name in ("problem.toml", "posture.nc"):
        if not (folder / name).is_file():
            raise BadResult(folder / name, "is missing; write it with `posture-ik run`")
    problem = load_problem(folder / "problem.toml")
    statement = Statement.of(build_body(problem.subject), problem)
    try:
        with xr.open_dataset(folder / "posture.nc", engine="h5netcdf") as data:
            dofs = [str(name) for name in data["dof"].values]
            posture = Posture(
                statement=statement,
                q=data["q"].values,
                multipliers=data["multiplier"].values,
                limit_multipliers=data["limit_multiplier"].values,
                iterations=int(data.attrs["iterations"]),
                status=str(data.attrs["status"]),
                seconds=float(data.attrs["seconds"]),
            )
    except (OSError, KeyError, ValueError) as error:
        raise BadResult(folder / "posture.nc", f"is not a posture ({error})") from None
    if dofs != list(statement.body.dofs) or len(posture.multipliers) != statement.rows:
        raise BadResult(folder / "posture.nc", "does not belong to the problem.toml beside it")
    if not np.all(np.isfinite(posture.q)) or posture.primal_residual() > 1e-6:
        raise BadResult(
            folder / "posture.nc", "misses the tasks of the problem.toml beside it; run it anew"
        )
    return posture
