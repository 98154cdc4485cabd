"""A short motion, and muscles, that many tests look at."""

import pytest

from posture_ik.body import build_body
from posture_ik.muscle import Activity, solve_activation
from posture_ik.posture import Motion, move, solve_posture
from posture_ik.problem import load_problem


@pytest.fixture(scope="session")
def sweep() -> Motion:
    """The backrest reclined from 0 to 45 degrees, 21 steps in 2 s."""
    problem = load_problem("recline_sweep", ("motion.rate=10",))
    return move(build_body(problem.subject), problem)


@pytest.fixture(scope="session")
def pilot() -> Activity:
    """The muscles of a pilot who holds both levers still."""
    problem = load_problem("pilot")
    body = build_body(problem.subject)
    return solve_activation(body, solve_posture(body, problem), problem)


@pytest.fixture(scope="session")
def raising() -> Activity:
    """The muscles of a pilot who raises the collective, 21 steps in 2 s; the right arm rests."""
    problem = load_problem("pilot_collective", ("motion.rate=10",))
    body = build_body(problem.subject)
    return solve_activation(body, move(body, problem), problem)
