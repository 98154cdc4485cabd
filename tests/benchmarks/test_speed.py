"""How fast, and against whom: `pytest tests/benchmarks --benchmark-enable`.

Groups put ours beside a peer in the same run; read the ratios in brackets. No time is asserted.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from pinocchio_recline import PinocchioRecline
from scipy.spatial.transform import Rotation

import posture_ik as pik
from posture_ik.kinematics import Kinematics
from posture_ik.posture import ipopt
from posture_ik.posture.program import Program

Benchmark = Any  # pytest-benchmark's fixture is callable and has no public type


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


def forget() -> None:
    """Drop every graph and solver built so far."""
    Kinematics._by_structure.clear()
    Kinematics._by_model.clear()
    Program._known.clear()
    ipopt._solvers.clear()


@pytest.mark.benchmark(group="build")
def test_build_body(benchmark: Benchmark) -> None:
    benchmark(pik.build_body, pik.Subject())


@pytest.mark.benchmark(group="build")
def test_new_person(benchmark: Benchmark, body: pik.Body) -> None:
    """Body, posture and linear model of someone new, with every graph built already."""
    problem, people = pik.load_problem("reclined_15"), iter(pik.sample_people(200, seed=1))
    pik.linearise(body, pik.solve_posture(body, problem), problem)

    def someone_new() -> pik.LinearSystem:
        new = pik.build_body(next(people))
        return pik.linearise(new, pik.solve_posture(new, problem), problem)

    benchmark.pedantic(someone_new, rounds=20)


@pytest.mark.benchmark(group="build")
def test_cold_solve(benchmark: Benchmark, body: pik.Body) -> None:
    """Twin, program and solver built, then solved."""
    problem = pik.load_problem("reclined_15")
    benchmark.pedantic(pik.solve_posture, (body, problem), setup=forget, rounds=5)


@pytest.mark.parametrize("name", ["reclined_15", "reclined_30", "reclined_45", "pilot"])
@pytest.mark.benchmark(group="warm solve")
def test_warm_solve(benchmark: Benchmark, body: pik.Body, name: str) -> None:
    posture = benchmark(pik.solve_posture, body, pik.load_problem(name))
    benchmark.extra_info["iterations"] = posture.iterations


@pytest.mark.benchmark(group="reclined_15 against SciPy")
def test_ours_reclined(benchmark: Benchmark, body: pik.Body) -> None:
    benchmark(pik.solve_posture, body, pik.load_problem("reclined_15"))


@pytest.mark.benchmark(group="reclined_15 against SciPy")
def test_slsqp_with_pinocchio(benchmark: Benchmark, body: pik.Body) -> None:
    posture = pik.solve_posture(body, pik.load_problem("reclined_15"))
    oracle = PinocchioRecline(body, posture.problem)
    limits = (posture.stiffness, posture.q_ergo, body.lower, body.upper)
    _, found = benchmark.pedantic(oracle.minimise, limits, rounds=3, warmup_rounds=1)
    assert found.fun == pytest.approx(posture.energy, abs=1e-8)


@pytest.fixture(scope="module")
def two_frames(body: pik.Body) -> pik.Problem:
    """Head and T5 held in all components where reclined_15 puts them: what Pink can be asked."""
    frames = pik.solve_posture(body, pik.load_problem("reclined_15")).frames
    tasks = []
    for frame in ("Head", "T5"):
        angles = Rotation.from_matrix(frames[frame].rotation).as_euler("xyz", degrees=True)
        tasks.append(
            pik.Frame(
                frame=frame,
                components=("x", "y", "z", "rx", "ry", "rz"),
                position=tuple(frames[frame].translation),
                rotation_deg=tuple(angles),
            )
        )
    return pik.Problem(task=tuple(tasks))


@pytest.mark.benchmark(group="two frames against Pink")
def test_ours_two_frames(benchmark: Benchmark, body: pik.Body, two_frames: pik.Problem) -> None:
    posture = benchmark(pik.solve_posture, body, two_frames)
    assert posture.certificate.holds


@pytest.mark.benchmark(group="two frames against Pink")
def test_pink_two_frames(benchmark: Benchmark, body: pik.Body, two_frames: pik.Problem) -> None:
    """Pink with the frames as equalities and the springs as its posture task, to the same 1e-9."""
    pink = pytest.importorskip("pink", reason="pin-pink is not installed")
    ours = pik.solve_posture(body, two_frames)
    frames = []
    for frame in ("Head", "T5"):
        task = pink.tasks.FrameTask(frame, position_cost=1.0, orientation_cost=1.0)
        task.set_target(ours.frames[frame])
        frames.append(task)
    springs = pink.tasks.PostureTask(cost=np.sqrt(ours.stiffness))
    springs.set_target(ours.q_ergo)
    limits = [pink.limits.ConfigurationLimit(body.model, config_limit_gain=1.0)]

    def drive() -> tuple[np.ndarray, int]:
        configuration = pink.Configuration(body.model, body.model.createData(), ours.q_ergo)
        iteration = 0
        while iteration < 200:
            iteration += 1
            velocity = pink.solve_ik(
                configuration, [springs], 1.0, "daqp", limits=limits, constraints=frames
            )
            configuration.integrate_inplace(velocity, 1.0)
            missed = max(np.abs(task.compute_error(configuration)).max() for task in frames)
            scaled = np.abs(velocity * np.sqrt(ours.stiffness)).max()
            if missed < 1e-9 and scaled < 1e-8:
                break
        return configuration.q, iteration

    q, iterations = benchmark.pedantic(drive, rounds=3, warmup_rounds=1)
    benchmark.extra_info["iterations"] = iterations
    energy = ours.stiffness @ (q - ours.q_ergo) ** 2 / 2
    assert energy == pytest.approx(ours.energy, rel=1e-6)


@pytest.mark.benchmark(group="whole command")
def test_whole_command(benchmark: Benchmark, tmp_path: Path) -> None:
    """A new process from problem file to report and 3D page."""
    command = [
        sys.executable,
        "-m",
        "posture_ik",
        "run",
        "reclined_15",
        "-o",
        str(tmp_path / "out"),
    ]
    benchmark.pedantic(
        subprocess.run, (command,), {"check": True, "capture_output": True}, rounds=3
    )
    assert (tmp_path / "out" / "view.html").exists()


def test_pinocchio_is_the_peer_it_claims_to_be(body: pik.Body) -> None:
    """The SciPy peer's Jacobian against differences: a slow peer must not be a wrong one."""
    oracle = PinocchioRecline(body, pik.load_problem("reclined_15"))
    pin.seed(1)
    q = 0.3 * pin.randomConfiguration(body.model)
    step = 1e-6
    columns = [
        (oracle.residual(q + step * e) - oracle.residual(q - step * e)) / (2 * step)
        for e in np.eye(len(q))
    ]
    np.testing.assert_allclose(oracle.jacobian(q), np.transpose(columns), atol=1e-8)
