"""`response.nc` holds model, modes and responses whole, with units, without complex numbers."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from scipy.linalg import eigh

from posture_ik.body import build_body
from posture_ik.exchange import write_vibration
from posture_ik.posture import solve_posture
from posture_ik.problem import load_problem
from posture_ik.vibration import Vibration, vibrate
from posture_ik.vibration.response import TOLERANCE


@pytest.fixture(scope="module")
def shaken() -> Vibration:
    problem = load_problem(
        "vibration_upright", ("vibration.frequencies={ start = 1.0, stop = 10.0, step = 1.0 }",)
    )
    body = build_body(problem.subject)
    return vibrate(body, solve_posture(body, problem), problem)


@pytest.fixture(scope="module")
def path(shaken: Vibration, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("response")
    write_vibration(shaken, folder)
    return folder / "response.nc"


@pytest.fixture(scope="module")
def data(path: Path) -> xr.Dataset:
    with xr.open_dataset(path, engine="h5netcdf") as read:
        return read.load()


def test_plain_netcdf_that_any_program_reads(path: Path) -> None:
    """No compound types, as complex numbers would be, and everything has a unit and a name."""
    with h5py.File(path) as file:
        for name, item in file.items():
            assert isinstance(item, h5py.Dataset)
            assert item.dtype.names is None, f"{name} is of a compound type"
    with xr.open_dataset(path, engine="h5netcdf") as read:
        for name, values in read.data_vars.items():
            assert values.attrs["units"], name
            assert values.attrs["long_name"], name


def test_the_file_is_enough_to_answer_anew(shaken: Vibration, data: xr.Dataset) -> None:
    """M, C, K, B, Y and D as read, solved with NumPy, against the response beside them."""
    s = 2j * np.pi * data["frequency"].values[:, None, None]
    M, C, K = (data[name].values for name in ("mass", "damping", "stiffness"))
    B, Y, D = (sum(s**k * data[name].values[k] for k in range(3)) for name in "BYD")
    answered = Y @ np.linalg.solve(s**2 * M + s * C + K, B) + D
    stored = data["response_real"].values + 1j * data["response_imag"].values
    apart = np.abs(answered - stored).max(axis=0) / np.abs(stored).max(axis=0).clip(1e-9)
    names = data["output"].values
    heads = [i for i, name in enumerate(names) if name.startswith("Head ")]
    # The modal way is certified to 1e-8 of the largest of its unit.
    assert apart[heads][:3, :3].diagonal().max() < 1e-6
    np.testing.assert_array_equal(stored, shaken.response["response"].values)


def test_modes_solve_the_eigenvalue_problem_of_the_matrices(data: xr.Dataset) -> None:
    squares, _ = eigh(data["stiffness"].values, data["mass"].values)
    expected = np.sqrt(np.abs(squares)) / (2 * np.pi)
    np.testing.assert_allclose(data["undamped_frequency"].values, expected, rtol=1e-6)
    M, C, K = (data[name].values for name in ("mass", "damping", "stiffness"))
    low = data.isel(damped=slice(0, 8))
    for i in range(8):
        mode = low.isel(damped=i)
        value = complex(mode["damped_eigenvalue_real"], mode["damped_eigenvalue_imag"])
        shape = mode["damped_shape_real"].values + 1j * mode["damped_shape_imag"].values
        terms = [value**2 * (M @ shape), value * (C @ shape), K @ shape]
        size = sum(np.linalg.norm(term) for term in terms)
        assert np.linalg.norm(sum(terms)) < 1e-8 * size
    assert set(data["undamped_symmetry"].values) <= {"symmetric", "anti-symmetric", "mixed"}


def test_models_stand_beside_each_other(shaken: Vibration, data: xr.Dataset) -> None:
    models = ["multibody", "finite_element", "lumped:boileau_rakheja"]
    assert data["model"].values.tolist() == models
    assert data["force"].values.tolist() == ["x", "y", "z", "rx", "ry", "rz"]
    lumped = data.sel(model=models[2])
    assert np.isnan(lumped["transmissibility_real"].sel({"to": "x", "from": "x"})).all()
    at = {"to": "z", "from": "z"}
    head = lumped["transmissibility_real"].sel(at) + 1j * lumped["transmissibility_imag"].sel(at)
    other = shaken.beside[models[2]]["response"].sel(output="Head acceleration z", input="seat z")
    omega = 2 * np.pi * data["frequency"].values
    np.testing.assert_allclose(head.values, -other.values / omega**2)


def test_certificate_and_stability_are_told(data: xr.Dataset) -> None:
    assert data.attrs["stable"] == 1
    assert data.attrs["stability"].startswith("stable")
    assert data.attrs["method"] == "modal"
    assert 0.0 < data.attrs["miss"] < 1e-9
    assert data.attrs["base"] == "seat"
    assert (data["miss"].values < TOLERANCE).all()
