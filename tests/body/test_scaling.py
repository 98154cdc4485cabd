"""Scaling against the laws it must obey."""

import numpy as np
import pinocchio as pin
import pytest

from posture_ik.body import build_body
from posture_ik.body.geometry import BodyGeometry
from posture_ik.body.parts import Inertia
from posture_ik.body.scaling import REFERENCE, Scale
from posture_ik.problem import Subject


def test_reference_subject_is_not_scaled():
    assert Scale.of(REFERENCE) == Scale((1.0, 1.0, 1.0), 1.0)


def test_mass_follows_weight_and_height_follows_stature():
    subject = Subject(gender="female", age=50, weight=60.0, stature=1.62)
    body = build_body(subject)
    assert pin.computeTotalMass(body.model) == pytest.approx(61.39 * 60 / 80)
    data = body.model.createData()
    pin.framesForwardKinematics(body.model, data, body.q_reference)
    head = data.oMf[body.model.getFrameId("Head")].translation
    assert head[2] == pytest.approx(0.75375 * 0.9, abs=1e-12)
    assert head[0] == pytest.approx(0.02617 * np.sqrt(0.75 / 0.9), abs=1e-12)


def test_similar_bodies_obey_the_laws_of_similarity():
    """Grown alike in all directions by f: forces per length as f, per angle f³, inertia f⁵."""
    f = 1.1
    small, large = (BodyGeometry.of(Subject(weight=80 * g**3, stature=1.80 * g)) for g in (1.0, f))
    for dof in small.stiffness:
        ratio = large.stiffness[dof] / small.stiffness[dof]
        if dof[-2:] in ("_r", "_l"):
            assert ratio == 1.0
        else:
            assert ratio == pytest.approx(f if dof.endswith("axial") else f**3)
        assert large.damping[dof] / small.damping[dof] == pytest.approx(ratio)
        grown = small.lower[dof] * (f if dof.endswith("axial") else 1.0)
        assert large.lower[dof] == pytest.approx(grown)
    for link, inertia in small.inertias.items():
        assert large.inertias[link].mass == pytest.approx(f**3 * inertia.mass)
        np.testing.assert_allclose(large.inertias[link].centre, f * inertia.centre, atol=1e-12)
        np.testing.assert_allclose(large.inertias[link].tensor, f**5 * inertia.tensor, atol=1e-12)


def test_stretched_inertia_is_that_of_the_stretched_points():
    random = np.random.default_rng(3)
    points, masses = random.normal(size=(40, 3)), random.uniform(0.1, 1.0, 40)
    scale = Scale.of(Subject(weight=95.0, stature=1.65))

    def inertia(points, masses):
        centre = masses @ points / masses.sum()
        r = points - centre
        tensor = sum(
            m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, r, strict=True)
        )
        return Inertia(masses.sum(), centre, tensor)

    ours = scale.inertia(inertia(points, masses))
    direct = inertia(points * scale.length, scale.mass * masses)
    assert ours.mass == pytest.approx(direct.mass)
    np.testing.assert_allclose(ours.centre, direct.centre)
    np.testing.assert_allclose(ours.tensor, direct.tensor)


def test_bending_is_that_of_the_stretched_section():
    """Second moments of an elliptic section, and Saint-Venant's polar one, over the height."""
    scale = Scale.of(Subject(weight=70.0, stature=1.95))
    x, y, z = scale.length
    a, b, h = 0.02, 0.02, 0.03

    def section(a, b, h):
        return {
            "axial": np.pi * a * b / h,
            "rx": np.pi * a * b**3 / 4 / h,
            "ry": np.pi * a**3 * b / 4 / h,
            "rz": (np.pi * a * b**3 / 4 + np.pi * a**3 * b / 4) / h,
        }

    before, after = section(a, b, h), section(x * a, y * b, z * h)
    for component, value in before.items():
        assert scale.stiffness(component) == pytest.approx(after[component] / value)


@pytest.mark.parametrize("stature", [1.40, 1.60, 1.90, 2.10])
@pytest.mark.parametrize("body_mass_index", [14.5, 22.0, 35.0, 54.5])
def test_every_valid_subject_has_a_body(stature, body_mass_index):
    """Also where a stretch would turn an inertia that is no body's negative (table 9's T1)."""
    subject = Subject(stature=stature, weight=body_mass_index * stature**2)
    body = build_body(subject)
    assert pin.computeTotalMass(body.model) == pytest.approx(61.39 * subject.weight / 80)
    assert all(np.all(np.diag(inertia.inertia) >= 0) for inertia in body.model.inertias)
