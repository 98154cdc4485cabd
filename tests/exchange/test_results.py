"""A run's folder says everything, in names others can read, and reads back the same."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import xarray as xr

import posture_ik as pik
from posture_ik.errors import BadResult


@pytest.fixture(scope="module")
def posture() -> pik.Posture:
    problem = pik.load_problem("reclined_15_gravity")
    return pik.solve_posture(pik.build_body(problem.subject), problem)


@pytest.fixture
def folder(posture: pik.Posture, tmp_path: Path) -> Path:
    pik.write_posture(posture, tmp_path)
    return tmp_path


def test_netcdf_holds_what_the_design_promises(posture: pik.Posture, folder: Path) -> None:
    with xr.open_dataset(folder / "posture.nc", engine="h5netcdf") as data:
        for name in ("q", "q_ergo", "stiffness", "prestrain_force"):
            assert data[name].dims == ("dof",)
            assert data[name].attrs["units"]
            assert data[name].attrs["long_name"]
        for name in ("residual", "multiplier"):
            assert data[name].dims == ("constraint",)
        assert data.attrs["energy"] == posture.energy
        assert data.attrs["kkt_residual"] < 1e-8
        assert data.attrs["status"] == posture.status
        assert list(data["dof"].values) == list(posture.body.dofs)
        expected = -data["stiffness"] * (data["q"] - data["q_ergo"])
        np.testing.assert_allclose(data["prestrain_force"], expected, rtol=1e-12)


def test_prestrain_is_a_row_a_joint_in_its_own_frame(posture: pik.Posture, folder: Path) -> None:
    with (folder / "prestrain.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["dof"] for row in rows] == list(posture.body.dofs)
    for row, force, displacement in zip(
        rows, posture.prestrain_force, posture.displacement, strict=True
    ):
        assert (row["unit"], row["force_unit"]) == (
            ("m", "N") if row["dof"].endswith("_axial") else ("rad", "N m")
        )
        assert float(row["force"]) == pytest.approx(force, rel=1e-10, abs=1e-12)
        assert float(row["displacement"]) == pytest.approx(displacement, rel=1e-10, abs=1e-12)


def test_prestrain_tells_the_weight_apart(posture: pik.Posture, folder: Path) -> None:
    """Weight's work by centres of mass: the force along a coordinate is -m g dz/dq."""
    with (folder / "prestrain.csv").open() as file:
        weight = [float(row["gravity_force"]) for row in csv.DictReader(file)]
    model = posture.body.model
    mass, up = pin.computeTotalMass(model), -model.gravity.linear
    rise = pin.jacobianCenterOfMass(model, model.createData(), posture.q).T @ up
    np.testing.assert_allclose(weight, -mass * rise, atol=1e-8)
    (lift,) = [w for w, dof in zip(weight, posture.body.dofs, strict=True) if dof == "L5_S1_axial"]
    assert lift < -100.0


def test_weight_not_counted_is_no_force(tmp_path: Path) -> None:
    problem = pik.load_problem("upright")
    pik.write_posture(pik.solve_posture(pik.build_body(problem.subject), problem), tmp_path)
    with (tmp_path / "prestrain.csv").open() as file:
        assert {float(row["gravity_force"]) for row in csv.DictReader(file)} == {0.0}


def test_the_model_opens_in_pinocchio_with_its_meshes(posture: pik.Posture, folder: Path) -> None:
    model = pin.buildModelFromUrdf(str(folder / "model.urdf"))
    assert model.names.tolist() == posture.body.model.names.tolist()
    shapes = pin.buildGeomFromUrdf(
        model, str(folder / "model.urdf"), pin.GeometryType.VISUAL, str(folder)
    )
    assert len(shapes.geometryObjects) > 50


def test_a_posture_reads_back_the_same(posture: pik.Posture, folder: Path) -> None:
    again = pik.read_posture(folder)
    np.testing.assert_array_equal(again.q, posture.q)
    assert again.certificate == pytest.approx(posture.certificate)
    for one, other in zip(again.wrenches, posture.wrenches, strict=True):
        np.testing.assert_allclose(one.force, other.force)


def test_a_run_with_ones_own_urdf_reads_back(posture: pik.Posture, tmp_path: Path) -> None:
    (tmp_path / "mine.urdf").write_text(posture.body.urdf)
    subject = pik.Subject(urdf=tmp_path / "mine.urdf")
    mine = pik.solve_posture(
        pik.build_body(subject), posture.problem.model_copy(update={"subject": subject})
    )
    (tmp_path / "run").mkdir()
    pik.write_posture(mine, tmp_path / "run")
    (tmp_path / "mine.urdf").unlink()
    assert pik.read_posture(tmp_path / "run").energy == pytest.approx(posture.energy, abs=1e-9)


def test_a_damaged_result_is_refused(folder: Path) -> None:
    (folder / "posture.nc").write_bytes(b"not netCDF")
    with pytest.raises(BadResult, match=r"posture\.nc: is not a posture"):
        pik.read_posture(folder)


def test_a_result_of_another_problem_is_refused(folder: Path) -> None:
    text = (folder / "problem.toml").read_text()
    (folder / "problem.toml").write_text(text.replace("recline_deg = 15.0", "recline_deg = 5.0"))
    with pytest.raises(BadResult, match="misses the tasks"):
        pik.read_posture(folder)


def test_a_result_with_other_tasks_is_refused(folder: Path) -> None:
    text = (folder / "problem.toml").read_text()
    (folder / "problem.toml").write_text(text.replace('position = "free"', 'position = "over C1"'))
    with pytest.raises(BadResult, match=r"does not belong to the problem\.toml"):
        pik.read_posture(folder)


def test_a_trajectory_is_written_with_its_certificate(tmp_path: Path) -> None:
    problem = pik.load_problem("reach_cyclic")
    found = pik.reach(pik.build_body(problem.subject), problem)
    pik.write_trajectory(found, tmp_path)
    with xr.open_dataset(tmp_path / "trajectory.nc", engine="h5netcdf") as data:
        for name in ("q", "v", "a", "tau"):
            assert data[name].dims == ("time", "dof")
            assert data[name].attrs["units"]
            np.testing.assert_array_equal(data[name], getattr(found, name))
        np.testing.assert_array_equal(data["time"], found.time)
        assert list(data["dof"].values) == list(found.limb.joints)
        for name in ("cost", "status", "primal", "dual", "defect", "overshoot", "end_error"):
            assert data.attrs[name] == getattr(found, name)
        assert list(data["round_intervals"].values) == [each.intervals for each in found.rounds]
        np.testing.assert_array_equal(data["start"], found.limb.start)


def test_activations_are_written_with_their_certificate(tmp_path: Path) -> None:
    problem = pik.load_problem("pilot")
    body = pik.build_body(problem.subject)
    activity = pik.solve_activation(body, pik.solve_posture(body, problem), problem)
    pik.write_activation(activity, tmp_path)
    with xr.open_dataset(tmp_path / "activation.nc", engine="h5netcdf") as data:
        for name in ("activation", "force", "demand", "passive", "delivered", "reserve"):
            np.testing.assert_array_equal(data[name], getattr(activity, name))
            assert data[name].attrs["units"]
        assert list(data["muscle"].values) == list(activity.muscles.names)
        assert list(data["dof"].values) == list(activity.paths.dofs)
        assert data.attrs["duality_gap"] == activity.worst_certificate()[2]
        assert data.attrs["shortfalls"] == ""
