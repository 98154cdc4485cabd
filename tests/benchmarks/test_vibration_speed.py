"""How fast a person is linearised and answers: all ways, a plain loop, and python-control."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import posture_ik as pik
from posture_ik.arrays import one_thread
from posture_ik.vibration.peak import Magnitude, follow_peak

Benchmark = Any  # pytest-benchmark's fixture is callable and has no public type

FREQUENCIES = np.linspace(0.05, 20.0, 400)
IN, OUT = ["seat"], ["Head x", "Head y", "Head z", "seat force"]


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


@pytest.fixture(scope="module")
def spine(body: pik.Body) -> pik.LinearSystem:
    """The spine and viscera alone, 117 degrees of freedom: the arms ride along."""
    problem = pik.load_problem("reclined_15")
    system = pik.linearise(body, pik.solve_posture(body, problem), problem)
    stay = [i for i, name in enumerate(system.coordinates) if not name.endswith(("_r", "_l"))]
    assert len(stay) == 117
    square = np.ix_(stay, stay)
    mass, damping, stiffness = (part[square] for part in system[1:4])
    system = system._replace(
        coordinates=tuple(system.coordinates[i] for i in stay),
        mass=mass,
        damping=damping,
        stiffness=stiffness,
        B=system.B[:, stay],
        Y=system.Y[:, :, stay],
    )
    return system.of(IN, OUT)


@pytest.mark.benchmark(group="linearise")
@pytest.mark.parametrize("name", ["reclined_15", "pilot_push"])
def test_linearise(benchmark: Benchmark, body: pik.Body, name: str) -> None:
    problem = pik.load_problem(
        name, ("seat.backrest.kind=foam", "vibration.gravity=true", "vibration.prestress=true")
    )
    posture = pik.solve_posture(body, problem)
    system = benchmark(pik.linearise, body, posture, problem)
    assert len(system.outputs) > 80


@pytest.mark.benchmark(group="400 frequencies of 117 degrees of freedom")
@pytest.mark.parametrize("method", ["modal", "schur", "direct"])
def test_frequency_response(benchmark: Benchmark, spine: pik.LinearSystem, method: Any) -> None:
    data = benchmark(pik.frequency_response, spine, FREQUENCIES, method)
    assert data.method == method


@pytest.mark.benchmark(group="a peak of 117 degrees of freedom, to rounding")
def test_follow_peak(benchmark: Benchmark, spine: pik.LinearSystem) -> None:
    with one_thread():
        peak = benchmark(follow_peak, spine, Magnitude("Head z", "seat z"), 4.0)
    assert 3.0 < peak.frequency < 6.0


@pytest.mark.benchmark(group="400 frequencies of 117 degrees of freedom")
def test_plain_loop(benchmark: Benchmark, spine: pik.LinearSystem) -> None:
    def loop() -> np.ndarray:
        answers = []
        for s in 2j * np.pi * FREQUENCIES:
            dynamic = s**2 * spine.mass + s * spine.damping + spine.stiffness
            x = np.linalg.solve(dynamic, spine.B[0] + s * spine.B[1] + s**2 * spine.B[2])
            answers.append((spine.Y[0] + s * spine.Y[1] + s**2 * spine.Y[2]) @ x)
        return np.array(answers)

    with one_thread():
        assert np.all(np.isfinite(benchmark(loop)))


@pytest.mark.benchmark(group="400 frequencies of 117 degrees of freedom")
def test_python_control(benchmark: Benchmark, spine: pik.LinearSystem) -> None:
    """Given the state space for nothing, with seat accelerations in."""
    model = pik.state_space(spine, IN, [name.name for name in spine.outputs[3:]])
    with one_thread():
        answer = benchmark(model.frequency_response, 2 * np.pi * FREQUENCIES)
    assert np.all(np.isfinite(answer.frdata))
