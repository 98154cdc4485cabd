"""How fast a reach is found: `pytest tests/benchmarks --benchmark-enable`. No time is asserted."""

from __future__ import annotations

from typing import Any

import pytest

import posture_ik as pik
from posture_ik.kinematics import Kinematics
from posture_ik.posture.collocation import Points
from posture_ik.posture.program import Program

Benchmark = Any  # pytest-benchmark's fixture is callable and has no public type
TRUNK = (
    *("buttocks_S1_ry", "L5_S1_ry", "L4_L5_ry", "L3_L4_ry", "L2_L3_ry", "L1_L2_ry"),
    *("T11_T12_rz", "T10_T11_rz", "T9_T10_rz", "T8_T9_rz", "T12_L1_ry", "T11_T12_ry", "T10_T11_ry"),
)
STRENGTH = {
    **{"shoulder_flexion_r": 40.0, "shoulder_abduction_r": 40.0, "shoulder_rotation_r": 30.0},
    **{"elbow_flexion_r": 30.0, "pronation_r": 8.0},
    **{"wrist_deviation_r": 8.0, "wrist_flexion_r": 8.0},
}


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


@pytest.fixture(scope="module")
def to_the_cyclic() -> pik.Problem:
    hands = [task for task in pik.load_problem("pilot").task if isinstance(task, pik.Hand)]
    return pik.Problem(task=tuple(hand for hand in hands if hand.side == "right"))


def reach(body: pik.Body, problem: pik.Problem, **asked: Any) -> pik.Trajectory:
    """Reach from the reference shape, as in `tests/posture/test_trajectory.py`."""
    block = pik.TrajectoryBlock(**asked)
    problem = problem.model_copy(update={"trajectory": block})
    return pik.reach(body, problem, start=body.q_reference)


def forget() -> None:
    """Drop every graph built so far."""
    Kinematics._by_structure.clear()
    Kinematics._by_model.clear()
    Program._known.clear()
    Points._known.clear()


@pytest.mark.benchmark(group="reach")
def test_cold_reach(benchmark: Benchmark, body: pik.Body, to_the_cyclic: pik.Problem) -> None:
    """Graphs built, then solved."""
    keywords = {"duration": 1.0}
    benchmark.pedantic(reach, (body, to_the_cyclic), keywords, setup=forget, rounds=3)


@pytest.mark.benchmark(group="reach")
def test_warm_reach(benchmark: Benchmark, body: pik.Body, to_the_cyclic: pik.Problem) -> None:
    keywords = {"duration": 1.0}
    found = benchmark.pedantic(reach, (body, to_the_cyclic), keywords, rounds=3, warmup_rounds=1)
    benchmark.extra_info["meshes"] = [each.intervals for each in found.rounds]
    assert found.end_error < 1e-3


@pytest.mark.benchmark(group="reach")
def test_reach_in_free_time(
    benchmark: Benchmark, body: pik.Body, to_the_cyclic: pik.Problem
) -> None:
    benchmark.pedantic(reach, (body, to_the_cyclic), rounds=3, warmup_rounds=1)


@pytest.mark.benchmark(group="reach")
def test_reach_in_least_time(
    benchmark: Benchmark, body: pik.Body, to_the_cyclic: pik.Problem
) -> None:
    keywords = {"cost": "time", "torque": STRENGTH}
    benchmark.pedantic(reach, (body, to_the_cyclic), keywords, rounds=3, warmup_rounds=1)


@pytest.mark.benchmark(group="reach")
@pytest.mark.parametrize("lag", [False, True])
def test_reach_by_muscles(
    benchmark: Benchmark, body: pik.Body, to_the_cyclic: pik.Problem, lag: bool
) -> None:
    """25 muscles drive the arm; where they lag, each has a state of its own."""
    keywords = {"cost": "activation", "duration": 1.0, "activation_dynamics": lag}
    found = benchmark.pedantic(reach, (body, to_the_cyclic), keywords, rounds=2, warmup_rounds=1)
    benchmark.extra_info["meshes"] = [each.intervals for each in found.rounds]
    assert found.imbalance < 1e-6


@pytest.mark.benchmark(group="reach")
@pytest.mark.parametrize("count", [5, 13])
def test_reach_with_the_trunk(benchmark: Benchmark, body: pik.Body, count: int) -> None:
    """Farther than the arm: 12 and 20 joints, some of them stiff."""
    far = pik.Hand(side="right", position=(0.62, -0.15, 0.35), components=("x", "y", "z"))
    arm = [dof for dof in body.dofs if dof.endswith("_r")]
    keywords = {"duration": 1.2, "tolerance": 1e-3, "joints": (*arm, *TRUNK[:count])}
    found = benchmark.pedantic(reach, (body, pik.Problem(task=(far,))), keywords, rounds=1)
    benchmark.extra_info["meshes"] = [each.intervals for each in found.rounds]
    assert found.end_error < 1e-3


@pytest.mark.benchmark(group="reach")
def test_reach_beside_bioptim() -> None:
    """The same arm by bioptim, which stands on biorbd: both come from conda-forge alone."""
    pytest.skip("bioptim has no wheel: it needs biorbd, which conda alone builds")
