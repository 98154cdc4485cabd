"""Levers that follow the hand: the closed loop against trigonometry and statics."""

from __future__ import annotations

import numpy as np
import pytest

import posture_ik as pik
from posture_ik.errors import InfeasiblePosture

LENGTH, PIVOT = 0.46, np.array([0.42, 0.0, -0.17])


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


def pushed(*settings: str) -> pik.Problem:
    return pik.load_problem("pilot_push", settings)


def angles(posture: pik.Posture) -> tuple[float, float]:
    by_name = dict(zip(posture.body.dofs, posture.q, strict=True))
    return by_name["lever_cyclic_fore_aft"], by_name["lever_cyclic_lateral"]


def test_the_angles_are_those_of_a_gimbal(body: pik.Body) -> None:
    """Where the grip is, x = l sin(fore) cos(lateral) and y = -l sin(lateral) from the pivot."""
    for x, y in ((0.33, 0.02), (0.40, -0.05)):
        place = ("task.frame.components=['x', 'y']", f"task.frame.position=[{x}, {y}, 0]")
        posture = pik.solve_posture(body, pushed(*place))
        fore_aft, lateral = angles(posture)
        expected = -np.arcsin((y - PIVOT[1]) / LENGTH)
        assert lateral == pytest.approx(expected, abs=1e-9)
        expected = np.arcsin((x - PIVOT[0]) / (LENGTH * np.cos(expected)))
        assert fore_aft == pytest.approx(expected, abs=1e-9)
        hand, handle = posture.frames["grip_r"], posture.frames["lever_cyclic_grip"]
        np.testing.assert_allclose(hand.translation, handle.translation, atol=1e-9)
        # the hand may turn about the handle, and about nothing else
        np.testing.assert_allclose(hand.rotation[:, 2], handle.rotation[:, 2], atol=1e-9)


@pytest.mark.parametrize("gravity", ["false", "true"])
def test_the_lever_is_in_equilibrium(body: pik.Body, gravity: str) -> None:
    """About each hinge: what the hand does to the handle, the spring and the lever's weight."""
    posture = pik.solve_posture(body, pushed(f"posture.gravity={gravity}"))
    hand = next(wrench for wrench in posture.wrenches if wrench.label == "right hand")
    fore_aft, lateral = angles(posture)
    at = posture.frames["lever_cyclic_grip"].translation - PIVOT
    moment = -hand.moment - np.cross(at, hand.force)
    if gravity == "true":
        moment += np.cross(at / 2, [0.0, 0.0, -9.81])  # 1 kg half way up
    rest = np.radians(posture.problem.lever["cyclic"].fore_aft_deg)
    axis = np.array([np.cos(fore_aft), 0.0, -np.sin(fore_aft)])
    assert moment[1] == pytest.approx(2.0 * (fore_aft - rest), abs=1e-8)
    assert moment @ axis == pytest.approx(2.0 * lateral, abs=1e-8)


def test_driving_to_where_it_follows_gives_the_same_posture(body: pik.Body) -> None:
    """A driven lever at the angles found: the same least energy, less the lever's spring."""
    followed = pik.solve_posture(body, pushed())
    driving = {
        f"{name}_deg": float(np.degrees(angle))
        for name, angle in zip(("fore_aft", "lateral"), angles(followed), strict=True)
    }
    problem = pushed()
    lever = problem.lever["cyclic"].model_copy(update={"follows": (), **driving})
    still = problem.model_copy(update={"lever": {"cyclic": lever}, "task": problem.task[:3]})
    # what is beside the lever is given: the hand's x and the lever's angles say the same
    driven = pik.solve_posture(body, still)
    n = body.model.nv
    assert driven.energy == pytest.approx(followed.energies[:n].sum(), rel=1e-9)
    np.testing.assert_allclose(driven.q, followed.q[:n], atol=1e-7)


def test_a_posture_with_a_lever_is_read_back(body: pik.Body, tmp_path) -> None:
    from posture_ik.exchange import read_posture, write_posture

    posture = pik.solve_posture(body, pushed())
    write_posture(posture, tmp_path)
    again = read_posture(tmp_path)
    assert again.body.dofs == posture.body.dofs
    np.testing.assert_array_equal(again.q, posture.q)


def test_a_lever_out_of_reach_is_named(body: pik.Body) -> None:
    with pytest.raises(InfeasiblePosture, match="right hand"):
        pik.solve_posture(body, pushed("lever.cyclic.pivot=[1.4, 0, -0.17]"))


def test_the_end_of_a_throw_is_named(body: pik.Body) -> None:
    """0.30 m forward takes the lever 15 degrees back, and 13 is as far as it goes."""
    place = "task.frame.position=[0.30, 0, 0]"
    with pytest.raises(InfeasiblePosture, match="lever_cyclic_fore_aft at its lower limit"):
        pik.solve_posture(body, pushed(place, "lever.cyclic.throw_deg=5"))


def test_a_posture_s_body_gets_its_levers_once(body: pik.Body) -> None:
    """A result read back has the body with levers; what is found from it anew is of the same."""
    posture = pik.solve_posture(body, pushed())
    again = pik.solve_posture(posture.body, pushed())
    assert again.body is posture.body
    np.testing.assert_allclose(again.q, posture.q, atol=1e-12)
