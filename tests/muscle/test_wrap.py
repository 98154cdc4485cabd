"""Lengths past one sphere or cylinder, against tangents and arcs, and against search."""

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from posture_ik.muscle.wrap import Surface, bend, straight

R = 0.02
AXIS = np.array([2.0, -1.0, 2.0]) / 3.0
CENTRE = np.array([0.01, -0.02, 0.03])


def evaluate(surface, start, end):
    """Length and its slope by the end."""
    point = ca.SX.sym("end", 3)
    piece = bend(ca.SX(start), point, surface)
    outputs = [piece.length, piece.pull]
    if piece.ring:
        outputs = ca.substitute(outputs, [piece.ring.incidence], [piece.ring.value])
    length, pull = ca.Function("piece", [point], outputs)(end)
    return float(length), pull.full().ravel()


def turned(angle, climb=0.0, distance=0.05):
    """A point about AXIS through CENTRE."""
    across = np.array([AXIS[1], -AXIS[0], 0.0]) / np.hypot(AXIS[0], AXIS[1])
    beside = np.cross(AXIS, across)
    return CENTRE + climb * AXIS + distance * (np.cos(angle) * across + np.sin(angle) * beside)


def on_surface(angle, climb):
    return turned(angle, climb, R)


def tangents_and_arc(angle, climb=0.0):
    """From 0.05 to 0.035 m off the axis: straight until the string leaves the rim, then the arc."""
    arc = angle - np.arccos(R / 0.05) - np.arccos(R / 0.035)
    if arc < 0.0:
        return np.linalg.norm(turned(angle, climb, 0.035) - turned(0.0))
    return np.hypot(np.sqrt(0.05**2 - R**2) + np.sqrt(0.035**2 - R**2) + R * arc, climb)


# 1e-9 m, clear of the switch: these angles stay 0.25 rad, 8 of its widths, off the touch at 2.12.
@pytest.mark.parametrize("angle", [0.3, 1.0, 1.8, 2.4, 3.1, 3.6, 4.5, 6.0])
def test_cylinder_is_passed_along_tangents_and_arc(angle):
    """Also by more than half a turn."""
    surface = Surface("cylinder", CENTRE, R, AXIS, turn=np.pi)
    length, _ = evaluate(surface, turned(0.0), turned(angle, 0.03, 0.035))
    assert length == pytest.approx(tangents_and_arc(angle, 0.03), abs=1e-9)


@pytest.mark.parametrize("angle", [0.3, 1.0, 1.8, 2.4, 3.1])
def test_outside_sphere_is_passed_along_tangents_and_arc(angle):
    surface = Surface("outside", CENTRE, R)
    length, _ = evaluate(surface, turned(0.0), turned(angle, 0.0, 0.035))
    assert length == pytest.approx(tangents_and_arc(angle), abs=1e-9)


@pytest.mark.parametrize("angle", [0.2, 1.0, 1.4, 2.9])
def test_inside_sphere_is_the_shortest_way_through(angle):
    """To 1e-9 m, which is what the search is good for."""
    start, end = turned(0.0), turned(angle, 0.0, 0.024)

    def length(x):
        touch = on_surface(x, 0.0)
        return np.linalg.norm(touch - start) + np.linalg.norm(end - touch)

    found = minimize_scalar(length, bounds=(0.0, angle), method="bounded", options={"xatol": 1e-10})
    shortest = np.linalg.norm(end - start) if angle > 2.5 else found.fun
    surface = Surface("inside", CENTRE, R)
    assert evaluate(surface, start, end)[0] == pytest.approx(shortest, abs=1e-9)


@pytest.mark.parametrize("kind", ["outside", "inside", "cylinder"])
def test_slope_across_the_touch(kind):
    """By central differences, 1e-8 of a slope of at most 1, also where a path takes hold."""
    start = turned(0.0)
    surface = Surface(kind, CENTRE, R, AXIS if kind == "cylinder" else None, turn=np.pi)
    touch = np.arccos(R / 0.05) + np.arccos(R / 0.035)
    for angle in touch + np.linspace(-0.1, 0.1, 9):
        end = turned(angle, 0.01, 0.035)
        _, pull = evaluate(surface, start, end)
        step = 1e-6
        differences = [
            (
                evaluate(surface, start, end + step * e)[0]
                - evaluate(surface, start, end - step * e)[0]
            )
            / (2 * step)
            for e in np.eye(3)
        ]
        np.testing.assert_allclose(pull, differences, atol=1e-8)


def test_a_cylinder_is_the_same_from_either_end():
    surface = Surface("cylinder", CENTRE, R, AXIS, turn=np.pi)
    start, end = turned(0.0), turned(4.0, 0.02, 0.035)
    forth, _ = evaluate(surface, start, end)
    back, _ = evaluate(surface.reversed(), end, start)
    assert forth == pytest.approx(back, abs=1e-15)


def test_straight():
    piece = straight(ca.SX([0.0, 0.0, 0.0]), ca.SX([0.0, 3.0, 4.0]))
    assert float(piece.length) == 5.0
    np.testing.assert_allclose(ca.DM(piece.pull).full().ravel(), [0.0, 0.6, 0.8], atol=1e-15)
