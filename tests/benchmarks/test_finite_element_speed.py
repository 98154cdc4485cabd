"""How fast a finite-element spine is built, alone and held by a rigid backrest on a cushion."""

from typing import Any

import pytest

from posture_ik.problem import Cushion, RigidBack
from posture_ik.vibration import build_finite_element

Benchmark = Any  # pytest-benchmark's fixture is callable and has no public type


@pytest.mark.benchmark(group="finite-element spine, built")
def test_bare(benchmark: Benchmark) -> None:
    system = benchmark(build_finite_element)
    assert len(system.coordinates) == 26 * 6 + 14


@pytest.mark.benchmark(group="finite-element spine, built")
def test_on_a_cushion_with_a_rigid_backrest(benchmark: Benchmark) -> None:
    system = benchmark(build_finite_element, backrest=RigidBack(), cushion=Cushion())
    assert len(system.coordinates) == 26 * 6 + 14 + 2 - 5
