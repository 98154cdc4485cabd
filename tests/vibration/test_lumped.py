"""Lumped models against closed forms, the figures of table 7's models, and bad files."""

import numpy as np
import pytest
from direct_response import modes, over_acceleration, peak, response

from posture_ik.errors import BadProblem
from posture_ik.problem import Cushion
from posture_ik.vibration.lumped import Link, LumpedModel, build_lumped, load_lumped, lumped_models

FREQUENCIES = np.arange(0.5, 12.0, 0.01)
TWO = LumpedModel(
    title="Two masses",
    head="head",
    masses={"trunk": 50.0, "head": 5.0},
    link=(
        Link(between=("trunk", "seat"), stiffness=50e3, damping=1500.0),
        Link(between=("trunk", "head"), stiffness=20e3, damping=300.0),
    ),
)


def test_two_masses_in_closed_form():
    """Undamped frequencies by the quadratic formula; responses by substitution, to rounding."""
    m1, m2, k1, k2, c1, c2 = 50.0, 5.0, 50e3, 20e3, 1500.0, 300.0
    system = build_lumped(TWO)
    b, c = (k1 + k2) / m1 + k2 / m2, k1 * k2 / (m1 * m2)
    squares = (b + np.array([-1, 1]) * np.sqrt(b**2 - 4 * c)) / 2
    np.testing.assert_allclose(modes(system)[0], np.sqrt(squares) / (2 * np.pi))
    s = 2j * np.pi * FREQUENCIES
    z1, z2 = k1 + c1 * s, k2 + c2 * s
    up = z2 / (m2 * s**2 + z2)  # the head over the trunk
    trunk = z1 / (m1 * s**2 + z1 + m2 * s**2 * up)
    found = response(
        system, FREQUENCIES, ["seat z"], ["Head acceleration z", "trunk acceleration z"]
    )
    np.testing.assert_allclose(found[:, 0, 0] / s**2, trunk * up, rtol=1e-10)
    np.testing.assert_allclose(found[:, 1, 0] / s**2, trunk, rtol=1e-10)
    force = response(system, FREQUENCIES, ["seat z"], ["seat force z"])[:, 0, 0]
    np.testing.assert_allclose(force, z1 * (1 - trunk), rtol=1e-9)


@pytest.mark.parametrize("name", lumped_models())
def test_slowly_moved_a_model_is_a_rigid_mass(name):
    """At 1 mHz, transmissibility 1 and apparent mass the total: off by (f/4 Hz)², 1e-7."""
    model = load_lumped(name)
    system = build_lumped(model)
    assert over_acceleration(system, [1e-3], "seat z", "Head acceleration z") == pytest.approx(
        1.0, rel=1e-6
    )
    total = sum(model.masses.values())
    static = over_acceleration(system, [1e-3], "seat z", "seat force z")
    assert static == pytest.approx(total, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "size", "frequency"),
    [
        ("boileau_rakheja", 1.74, 4.95),
        ("bai_12_6", 1.41, 4.44),
        ("bai_14_6", 1.37, 4.37),
        ("abbas", 1.39, 4.06),
        ("wan_schimmels", 1.37, 3.98),
        ("zhang", 1.49, 4.15),
    ],
)
def test_peaks_of_table_7(name, size, frequency):
    """Seat to head; the figures are known to their last digit, so to 1 %."""
    system = build_lumped(load_lumped(name))
    found = over_acceleration(system, FREQUENCIES, "seat z", "Head acceleration z")
    assert peak(FREQUENCIES, found) == pytest.approx((size, frequency), rel=0.01)


def test_apparent_mass_and_impedance_of_boileau_and_rakheja():
    system = build_lumped(load_lumped("boileau_rakheja"))
    mass = over_acceleration(system, FREQUENCIES, "seat z", "seat force z")
    assert peak(FREQUENCIES, mass) == pytest.approx((88.6, 4.83), rel=0.01)
    impedance = mass * 2 * np.pi * FREQUENCIES
    assert peak(FREQUENCIES, impedance) == pytest.approx((2981.0, 5.9), rel=0.01)


def test_the_seat_of_table_5_under_boileau_and_rakheja():
    system = build_lumped(load_lumped("boileau_rakheja"), Cushion())
    found = over_acceleration(system, FREQUENCIES, "floor z", "Head acceleration z")
    assert peak(FREQUENCIES, found) == pytest.approx((3.52, 2.21), rel=0.01)


def test_a_seat_carries_its_own_mass_and_the_person():
    system = build_lumped(TWO, Cushion())
    found = response(system, [1e-3], ["floor z"], ["floor force z", "seat force z"])[0, :, 0].real
    np.testing.assert_allclose(-found / (2e-3 * np.pi) ** 2, [55 + 14.5, 55], rtol=1e-5)


def test_a_users_own_file_is_read(tmp_path):
    file = tmp_path / "two.toml"
    file.write_text(GOOD)
    assert load_lumped(file) == TWO


GOOD = """
title = "Two masses"
head = "head"
[masses]
trunk = 50.0
head = 5.0
[[link]]
between = ["trunk", "seat"]
stiffness = 50e3
damping = 1500.0
[[link]]
between = ["trunk", "head"]
stiffness = 20e3
damping = 300.0
"""


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ('head = "head"', 'head = "haed"', "head = 'haed' is none of the masses; did you mean"),
        ("head = 5.0", "head = -5.0", "masses.head = -5.0: input should be greater than 0"),
        ("head = 5.0", "head = nan", "masses.head = nan: input should be"),
        ("trunk = 50.0", 'trunk = "heavy"', "masses.trunk = 'heavy': input should be"),
        ("trunk = 50.0", "trunk = 50.0\nfloor = 1.0", "masses.floor: 'floor' is the name of"),
        ('["trunk", "seat"]', '["trunk", "set"]', "link 1.between: 'set' is neither a mass nor"),
        ('["trunk", "seat"]', '["trunk", "head"]', "masses.trunk does not stand on the seat"),
        ('["trunk", "head"]', '["head", "head"]', "link 2.between joins 'head' to itself"),
        ('["trunk", "head"]', '["head"]', "link 2.between.item 2 is missing"),
        ("20e3", "-20e3", "link 2.stiffness = -20000.0: input should be greater than or equal"),
        ("20e3", "0.0", "masses.head does not stand on the seat; link it to 'seat'"),
        ("damping = 300.0", "damper = 300.0", "link 2.damper is not a known key; did you mean"),
        ("stiffness = 20e3\n", "", "link 2.stiffness is missing"),
        ('title = "Two masses"', "", "title is missing"),
        ("[masses]", "[mass]", "masses is missing"),
        ("[[link]]", "[link", "is not valid TOML"),
        ("[[link]]", "[[links]]", "link is missing"),
    ],
)
def test_bad_files_are_refused_in_one_sentence(tmp_path, before, after, says):
    assert before in GOOD
    file = tmp_path / "mine.toml"
    file.write_text(GOOD.replace(before, after))
    with pytest.raises(BadProblem) as caught:
        load_lumped(file)
    message = str(caught.value)
    assert "mine.toml" in message
    assert says in message
    assert "\n" not in message


def test_unknown_names_and_files_are_refused(tmp_path):
    with pytest.raises(BadProblem, match="did you mean 'boileau_rakheja'"):
        load_lumped("boileau_rakeja")
    with pytest.raises(BadProblem, match="there is no such file"):
        load_lumped(tmp_path / "none.toml")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(BadProblem, match="not a text file in UTF-8"):
        load_lumped(tmp_path / "binary.toml")
