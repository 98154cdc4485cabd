"""Newton against IPOPT, its judge: the same optimum wherever it claims one."""

from __future__ import annotations

import numpy as np
import pytest

import posture_ik as pik
from posture_ik.posture.ipopt import solve_with_ipopt
from posture_ik.posture.newton import solve_with_newton
from posture_ik.posture.statement import Statement


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


def both(body: pik.Body, problem: pik.Problem) -> tuple[object, object]:
    statement = Statement.of(body, problem)
    lower, upper = statement.x_of(body.lower), statement.x_of(body.upper)
    start = np.clip(np.zeros(len(lower)), lower, upper)
    solvers = (solve_with_newton, solve_with_ipopt)
    return tuple(solver(statement, start, lower, upper) for solver in solvers)


@pytest.mark.parametrize(
    "name",
    [
        "upright",
        "reclined_15",
        "reclined_30",
        "reclined_45",
        "reclined_15_gravity",
        "look_left",
        "slouched",
        "pilot",
    ],
)
def test_newton_finds_what_ipopt_finds(body: pik.Body, name: str) -> None:
    """IPOPT stops at 1e-11 with its barrier still on: 1e-6 in x, 1e-5 on multipliers of 100 N."""
    newton, ipopt = both(body, pik.load_problem(name))
    assert newton.converged
    assert newton.minimum
    assert newton.iterations <= 10
    np.testing.assert_allclose(newton.x, ipopt.x, atol=1e-6)
    np.testing.assert_allclose(newton.multipliers, ipopt.multipliers, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(newton.bound_multipliers, ipopt.bound_multipliers, atol=1e-5)


@pytest.mark.parametrize("recline", [-20, -5, 5, 20, 35, 50])
@pytest.mark.parametrize("turn", [0, 15])
def test_newton_agrees_over_seats_and_gazes(body: pik.Body, recline: float, turn: float) -> None:
    settings = (f"seat.recline_deg={recline}", f"task.head.looking={{ turn_deg = {turn} }}")
    newton, ipopt = both(body, pik.load_problem("reclined_15", settings))
    assert newton.converged == ipopt.converged
    if newton.converged:
        assert newton.x @ newton.x == pytest.approx(ipopt.x @ ipopt.x, abs=1e-8)


@pytest.mark.parametrize("recline", [5, 10, 20, 25])
def test_contacts_are_told_open_from_shut(body: pik.Body, recline: float) -> None:
    """From where weight makes the tangent a saddle to the contacts that IPOPT finds."""
    settings = (f"seat.recline_deg={recline}",)
    newton, ipopt = both(body, pik.load_problem("reclined_15_gravity", settings))
    assert newton.converged
    assert newton.minimum
    np.testing.assert_allclose(newton.x, ipopt.x, atol=1e-6)
    np.testing.assert_allclose(newton.multipliers, ipopt.multipliers, rtol=1e-5, atol=1e-5)


def test_known_multipliers_and_pressures_shorten_the_way(body: pik.Body) -> None:
    """Started where it ended, one step; with a limit pressed the wrong way, the same end."""
    posture = pik.solve_posture(body, pik.load_problem("reclined_45"))
    assert posture.at_limit.any()
    statement = posture.statement
    lower, upper = statement.x_of(body.lower), statement.x_of(body.upper)
    x, pressure = statement.x_of(posture.q), posture.limit_multipliers / statement.scale
    again = solve_with_newton(statement, x, lower, upper, posture.multipliers, pressure)
    assert (again.converged, again.iterations) == (True, 1)
    wrong = pressure.copy()
    wrong[np.argmin(np.abs(x / upper - 0.5))] = 1e3
    back = solve_with_newton(statement, x, lower, upper, posture.multipliers, wrong)
    assert back.converged
    np.testing.assert_allclose(back.x, again.x, atol=1e-8)


def test_newton_gives_up_where_the_posture_buckles(body: pik.Body) -> None:
    """On the stiff buttocks 30 degrees buckle the spine; IPOPT goes on from there to a minimum."""
    problem = pik.load_problem("reclined_30", ("posture.stiffness=tissue",))
    newton, ipopt = both(body, problem)
    assert not newton.converged
    assert ipopt.converged
    assert pik.solve_posture(body, problem).certificate.holds
