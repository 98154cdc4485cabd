"""A short motion that many tests look at."""

import pytest

from posture_ik.body import build_body
from posture_ik.posture import Motion, move
from posture_ik.problem import load_problem


@pytest.fixture(scope="session")
def sweep() -> Motion:
    """The backrest reclined from 0 to 45 degrees, 21 steps in 2 s."""
    problem = load_problem("recline_sweep", ("motion.rate=10",))
    return move(build_body(problem.subject), problem)
