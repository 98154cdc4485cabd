"""Scaling against the laws it must obey."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest

from posture_ik.anthropometry import typical_measures
from posture_ik.body import build_body
from posture_ik.body.geometry import BodyGeometry
from posture_ik.body.laws import LAWS, scale_of
from posture_ik.body.parts import Inertia
from posture_ik.body.scaling import REFERENCE, REGIONS, Scale
from posture_ik.body.scaling_anthropometric import seated_share
from posture_ik.body.scaling_thesis import KITAZAKI
from posture_ik.body.spine import SPINE_DOFS
from posture_ik.problem import SPINE, Subject

ONES = Scale.alike((1.0, 1.0, 1.0), 1.0)


def body_of(scale, monkeypatch):
    """The geometry that a law of these factors gives."""
    monkeypatch.setitem(LAWS, "anthropometric", lambda subject: scale)
    return BodyGeometry.of(REFERENCE)


@pytest.mark.parametrize(
    ("law", "reference"), [("anthropometric", REFERENCE), ("thesis", KITAZAKI)]
)
def test_reference_subject_is_not_scaled(law, reference):
    assert scale_of(reference.model_copy(update={"scaling": law})) == ONES


def test_doubled_lengths_have_the_exponents_of_similarity(monkeypatch):
    """Masses 2³, forces per length 2, per angle 2³, inertias 2⁵; the arms' springs are assumed."""
    small = body_of(ONES, monkeypatch)
    large = body_of(Scale.alike((2.0, 2.0, 2.0), 8.0), monkeypatch)
    for dof in small.stiffness:
        ratio = large.stiffness[dof] / small.stiffness[dof]
        if dof[-2:] in ("_r", "_l"):
            assert ratio == 1.0
        else:
            assert ratio == pytest.approx(2.0 if dof.endswith("axial") else 8.0)
        assert large.damping[dof] / small.damping[dof] == pytest.approx(ratio)
        grown = small.lower[dof] * (2.0 if dof.endswith("axial") else 1.0)
        assert large.lower[dof] == pytest.approx(grown)
    for link, inertia in small.inertias.items():
        assert large.inertias[link].mass == pytest.approx(8.0 * inertia.mass)
        np.testing.assert_allclose(large.inertias[link].centre, 2 * inertia.centre, atol=1e-12)
        np.testing.assert_allclose(large.inertias[link].tensor, 32 * inertia.tensor, atol=1e-12)
    for name, node in small.nodes.items():
        np.testing.assert_allclose(large.nodes[name], 2.0 * node, atol=1e-12)


def test_softer_tissue_is_softer_and_nothing_else(monkeypatch):
    stiff = body_of(ONES, monkeypatch)
    soft = body_of(replace(ONES, modulus=0.5, viscosity=0.25), monkeypatch)
    for dof in SPINE_DOFS:
        assert soft.stiffness[dof] == pytest.approx(0.5 * stiff.stiffness[dof])
        assert soft.damping[dof] == pytest.approx(0.25 * stiff.damping[dof])
    assert soft.lower == stiff.lower


def test_stretched_inertia_is_that_of_the_stretched_points():
    random = np.random.default_rng(3)
    points, masses = random.normal(size=(40, 3)), random.uniform(0.1, 1.0, 40)
    length = np.array([1.2, 0.9, 0.8])
    scale = Scale.alike(tuple(length), 1.3)

    def inertia(points, masses):
        centre = masses @ points / masses.sum()
        r = points - centre
        tensor = sum(
            m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, r, strict=True)
        )
        return Inertia(masses.sum(), centre, tensor)

    ours = scale.inertia(inertia(points, masses), "lumbar")
    direct = inertia(points * length, 1.3 * masses)
    assert ours.mass == pytest.approx(direct.mass)
    np.testing.assert_allclose(ours.centre, direct.centre)
    np.testing.assert_allclose(ours.tensor, direct.tensor)


def test_heights_change_smoothly_from_region_to_region():
    """Each region's end stands where its own growth puts it, and no vertebra overtakes another."""
    regions = dict(ONES.length) | {"lumbar": (1.0, 1.0, 1.3), "cervical": (1.0, 1.0, 0.7)}
    scale = replace(ONES, length=regions)
    ends = np.array([0.0, *REGIONS.values()])
    grown = np.diff(ends) * [regions[region][2] for region in REGIONS]
    np.testing.assert_allclose(scale.heights(ends), [0.0, *np.cumsum(grown)], atol=1e-12)
    z = np.linspace(0.0, ends[-1], 2000)
    slopes = np.diff(scale.heights(z)) / np.diff(z)
    assert slopes.min() > 0.5
    assert np.abs(np.diff(slopes)).max() < 0.02


def test_bending_is_that_of_the_stretched_section():
    """Second moments of an elliptic section, and Saint-Venant's polar one, over the height."""
    x, y, z = 0.9, 1.1, 1.2
    scale = Scale.alike((x, y, z), 1.0)
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
        assert scale.stiffness("lumbar", component) == pytest.approx(after[component] / value)


@pytest.mark.parametrize("gender", ["male", "female"])
@pytest.mark.parametrize("stature", [1.40, 1.60, 1.90, 2.10])
@pytest.mark.parametrize("body_mass_index", [14.0, 22.0, 35.0, 55.0])
def test_every_valid_subject_has_a_body_of_its_weight(gender, stature, body_mass_index):
    """Also where a stretch would turn an inertia that is no body's negative (table 9's T1)."""
    subject = Subject(gender=gender, stature=stature, bmi=body_mass_index)
    body = build_body(subject)
    on_seat = seated_share(subject) * subject.weight
    assert pin.computeTotalMass(body.model) == pytest.approx(on_seat, abs=1e-9)
    assert all(np.all(np.diag(inertia.inertia) >= 0) for inertia in body.model.inertias)
    nodes = BodyGeometry.of(subject).nodes
    assert all(nodes[upper][2] > nodes[lower][2] for lower, upper in pairwise(SPINE))


def test_seat_carries_table_9_of_the_reference_and_less_of_a_woman():
    """De Leva's women have more of their mass in the legs, of which the seat carries a part."""
    assert seated_share(REFERENCE) == 61.39 / 80
    woman = seated_share(REFERENCE.model_copy(update={"gender": "female"}))
    upper = {"male": 6.94 + 43.46 + 2 * 4.94, "female": 6.68 + 42.57 + 2 * 4.49}
    assert upper["female"] / upper["male"] < woman / seated_share(REFERENCE) < 1.0


def test_sitting_height_and_breadths_are_those_typical_of_the_person():
    """Ratios of the regressions' own predictions, written out for one person."""
    subject = Subject(gender="female", age=45, weight=68.0, stature=1.66)
    hers = typical_measures("female", 45, 1.66, 68.0)
    his = typical_measures("male", 30, 1.80, 80.0)
    scale = scale_of(subject)
    for region, x, y in (
        ("pelvis", "buttock_depth", "hip_breadth"),
        ("lumbar", "waist_depth", "waist_breadth"),
        ("thoracic", "chest_depth", "chest_breadth"),
        ("head", "head_length", "head_breadth"),
    ):
        assert scale.length[region][:2] == pytest.approx((hers[x] / his[x], hers[y] / his[y]))
    crest, cervicale = (
        hers[name] / his[name] for name in ("iliac_crest_height", "cervicale_height")
    )
    ends = np.array([REGIONS["pelvis"], REGIONS["thoracic"], REGIONS["head"]])
    rises = scale.heights(ends)
    assert rises[:2] == pytest.approx(ends[:2] * (crest, cervicale))
    assert scale.length["lumbar"][2] == scale.length["thoracic"][2]
    above = [who["sitting_height"] - who["cervicale_height"] for who in (hers, his)]
    assert rises[2] - rises[1] == pytest.approx(above[0] / above[1] * (ends[2] - ends[1]))


def test_measured_lengths_move_the_body():
    """A long arm is long, and half a metre of shoulders stands at half a metre over typical."""
    plain = Subject()
    typical = typical_measures("male", 30, 1.80, 80.0)
    longer = {"upper_arm_length": 1.08, "forearm_length": 1.08, "hand_length": 1.08}
    arms = Subject(measured={name: f * typical[name] for name, f in longer.items()})
    assert scale_of(arms).arm == pytest.approx(1.08)
    tall = Subject(measured={"sitting_height": 1.05 * typical["sitting_height"]})
    head = BodyGeometry.of(tall).nodes["Head"][2] / BodyGeometry.of(plain).nodes["Head"][2]
    assert head == pytest.approx(1.05, abs=0.01)
    shoulders = Subject(measured={"shoulder_height": 1.1 * typical["shoulder_height"]})
    node = BodyGeometry.of(shoulders).nodes["R_arm"][2]
    assert node == pytest.approx(1.1 * BodyGeometry.of(plain).nodes["R_arm"][2])


def test_measured_masses_stand_and_the_trunk_carries_the_rest():
    subject = Subject(weight=90.0, measured={"head_mass": 9.0, "arm_mass": 5.0})
    masses = {name: inertia.mass for name, inertia in BodyGeometry.of(subject).inertias.items()}
    head = [name for name in masses if name == "Head" or name.startswith("C")]
    assert sum(masses[name] for name in head) == pytest.approx(9.0)
    arms = [name for name in masses if name.endswith(("_r", "_l"))]
    assert sum(masses[name] for name in arms) == pytest.approx(10.0)
    assert sum(masses.values()) == pytest.approx(seated_share(subject) * 90.0, abs=1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_laws_are_smooth_in_the_subject(law):
    """No law jumps: a thousandth of stature or weight changes no factor by a hundredth."""

    def factors(**changed):
        subject = REFERENCE.model_copy(update={"scaling": law, **changed})
        scale = scale_of(subject)
        lengths = [factor for lengths in scale.length.values() for factor in lengths]
        return np.array([*lengths, *scale.mass.values(), scale.arm, scale.modulus])

    start = factors()
    for changed in ({"stature": 1.8018}, {"weight": 80.08}, {"age": 30.03}):
        assert 0.0 <= np.abs(factors(**changed) / start - 1.0).max() < 0.01
