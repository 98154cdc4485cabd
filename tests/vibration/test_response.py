"""Frequency responses against closed forms, python-control, SciPy and the laws of mechanics."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
from scipy import signal
from scipy.linalg import lu_factor, lu_solve

import posture_ik as pik
from posture_ik.errors import BadProblem, PostureIKError
from posture_ik.problem import Cushion, FoamBack, RigidBack
from posture_ik.vibration import LinearSystem, Port, build_finite_element, response
from posture_ik.vibration.network import average, carry
from posture_ik.vibration.person import Person

Models = Any  # of conftest.py

FREQUENCIES = np.linspace(0.1, 20.0, 60)


def chain(*links: tuple[float, float, float]) -> LinearSystem:
    """Masses one on another above a seat: each (m, k, c), the lowest first; absolute heights."""
    n = len(links)
    mass = np.diag([m for m, _, _ in links])
    spring, damper = np.zeros((2, n + 1, n + 1))
    for i, (_, k, c) in enumerate(links):
        pair = np.ix_([i, i + 1], [i, i + 1])
        spring[pair] += k * np.array([[1, -1], [-1, 1]])
        damper[pair] += c * np.array([[1, -1], [-1, 1]])
    B, Y, D = np.zeros((3, n, 1)), np.zeros((3, 2, n)), np.zeros((3, 2, 1))
    B[0], B[1] = -spring[1:, :1], -damper[1:, :1]
    Y[0, 0, -1] = 1.0
    Y[0, 1], Y[1, 1] = spring[0, 1:], damper[0, 1:]
    D[0, 1], D[1, 1] = spring[0, 0], damper[0, 0]
    return LinearSystem(
        tuple(f"m{i}_z" for i in range(n)),
        mass,
        damper[1:, 1:],
        spring[1:, 1:],
        (Port("seat z", "m"),),
        (Port("Head z", "m"), Port("seat force z", "N")),
        B,
        Y,
        D,
    )


ONE = (50.0, 50e3, 1200.0)
TWO = (ONE, (6.0, 20e3, 90.0))


@pytest.mark.parametrize("method", ["modal", "schur", "direct"])
def test_two_masses_by_hand(method: Any) -> None:
    """Each mass a link of the chain: its apparent mass m + q / (1 - q / (k + s c) ...) above."""
    data = pik.frequency_response(chain(*TWO), FREQUENCIES, method)
    s = 2j * np.pi * FREQUENCIES
    (m1, k1, c1), (m2, k2, c2) = TWO
    top, low = k2 + s * c2, k1 + s * c1
    above = m2 * top / (m2 * s**2 + top)  # apparent mass of the upper
    whole = m1 + above
    expected = whole * low / (whole * s**2 + low)
    found = data.apparent_mass.sel(force="z", motion="z").values
    np.testing.assert_allclose(found, expected, rtol=1e-11)
    to_head = low / (whole * s**2 + low) * top / (m2 * s**2 + top)
    np.testing.assert_allclose(data.stht.values[:, 0, 0], to_head, rtol=1e-11)
    np.testing.assert_allclose(data.impedance.values[:, 0, 0], expected * s, rtol=1e-11)


@pytest.mark.parametrize("method", ["modal", "schur"])
@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("upright", ()),
        ("reclined_15", ("seat.backrest.kind=foam",)),
        ("pilot_push", ("seat.backrest.kind=rigid", "vibration.gravity=true")),
    ],
)
def test_the_ways_agree(models: Models, name: str, settings: tuple[str, ...], method: Any) -> None:
    """Found within 1e-9 of the largest of its units, over every output and input."""
    system = models(name, *settings)
    fast = pik.frequency_response(system, FREQUENCIES, method)
    slow = pik.frequency_response(system, FREQUENCIES, "direct")
    assert fast.method == method
    assert fast.miss < 1e-9
    for unit in np.unique(fast.output_unit):
        rows = fast.output_unit.values == unit
        a, b = fast.response.values[:, rows], slow.response.values[:, rows]
        assert np.max(np.abs(a - b)) < 1e-9 * np.max(np.abs(b))


@pytest.mark.parametrize("minimal", [False, True])
@pytest.mark.parametrize(
    ("settings", "inputs", "outputs"),
    [
        ((), ["seat z"], ["Head acceleration z"]),
        ((), ["seat x", "seat z"], ["Head acceleration", "seat force"]),
        (("seat.backrest.kind=foam",), ["backrest x"], ["Head x", "backrest force x"]),
        (("vibration.gravity=true",), ["seat ry", "seat x"], ["seat force ry", "Head z"]),
    ],
)
def test_equals_python_control(
    models: Models,
    settings: tuple[str, ...],
    inputs: list[str],
    outputs: list[str],
    minimal: bool,
) -> None:
    """To 1e-8 of the largest; what a minimal model leaves out is 1e-11 of a resonance each."""
    system = models("reclined_15", *settings)
    s = 2j * np.pi * FREQUENCIES
    data = pik.frequency_response(system.of(inputs, outputs), FREQUENCIES)
    ours = data.response.values / s[:, None, None] ** 2
    model = pik.state_space(system, inputs, outputs, minimal)
    theirs = np.moveaxis(model.frequency_response(s.imag).frdata, 2, 0)
    np.testing.assert_allclose(theirs, ours, atol=1e-8 * np.max(np.abs(ours)))


def test_equals_scipy() -> None:
    """Of few states: SciPy takes the long way, by polynomials."""
    system = chain(*TWO, (4.0, 9e3, 60.0))
    s = 2j * np.pi * FREQUENCIES
    ours = pik.frequency_response(system, FREQUENCIES).response.values / s[:, None, None] ** 2
    model = pik.state_space(system, ["seat"], ["Head", "seat"])
    for row in range(2):
        plain = signal.StateSpace(model.A, model.B, model.C[row : row + 1], model.D[row : row + 1])
        _, theirs = signal.freqresp(plain, s.imag)
        np.testing.assert_allclose(theirs, ours[:, row, 0], rtol=1e-7)


def test_a_minimal_model_has_the_states_that_count() -> None:
    """Two equal masses side by side on one seat, summed: their difference is never seen."""
    one = chain(ONE)
    twice = LinearSystem(
        ("a_z", "b_z"),
        np.kron(np.eye(2), one.mass),
        np.kron(np.eye(2), one.damping),
        np.kron(np.eye(2), one.stiffness),
        one.inputs,
        one.outputs[1:],
        np.concatenate([one.B, one.B], axis=1),
        np.concatenate([one.Y, one.Y], axis=2)[:, 1:],
        2 * one.D[:, 1:],
    )
    full = pik.state_space(twice, ["seat"], ["seat"])
    least = pik.state_space(twice, ["seat"], ["seat"], minimal=True)
    assert (full.nstates, least.nstates) == (4 + 2, 2 + 2)
    w = 2 * np.pi * FREQUENCIES
    np.testing.assert_allclose(least(1j * w), full(1j * w), rtol=1e-9)


def test_a_mass_that_is_missing_is_no_obstacle() -> None:
    """A massless point between two springs: QZ takes what eigenvalues of M⁻¹K cannot."""
    data = pik.frequency_response(chain((0.0, 20e3, 300.0), (30.0, 30e3, 300.0)), FREQUENCIES)
    assert data.method == "schur"
    s = 2j * np.pi * FREQUENCIES
    pair = 1 / (1 / (20e3 + 300 * s) + 1 / (30e3 + 300 * s))
    np.testing.assert_allclose(data.stht.values[:, 0, 0], pair / (30 * s**2 + pair), rtol=1e-9)


def test_a_double_eigenvalue_is_answered_right(monkeypatch: pytest.MonkeyPatch) -> None:
    """Critically damped there is one eigenvector for two: modes know half the digits, 1e-8.

    Where that is not enough it is solved directly.
    """
    m, k = 4.0, 400.0
    system = chain((m, k, 2 * math.sqrt(k * m)))
    s = 2j * np.pi * FREQUENCIES
    expected = (k + s * 2 * math.sqrt(k * m)) / (m * s**2 + s * 2 * math.sqrt(k * m) + k)
    data = pik.frequency_response(system, FREQUENCIES)
    np.testing.assert_allclose(data.stht.values[:, 0, 0], expected, atol=response.TOLERANCE)
    monkeypatch.setattr(response, "TOLERANCE", 1e-12)
    data = pik.frequency_response(system, FREQUENCIES)
    assert data.method == "direct"
    np.testing.assert_allclose(data.stht.values[:, 0, 0], expected, rtol=1e-12)


@pytest.mark.parametrize("backrest", [None, FoamBack(), RigidBack()])
@pytest.mark.parametrize("cushion", [None, Cushion()])
def test_stiff_shear_springs_leave_the_modes_exact(
    backrest: FoamBack | RigidBack | None, cushion: Cushion | None
) -> None:
    """Springs of 1e10 N/m beside 5 kN/m: modes within 2e-8 of the answer in 64 binary digits.

    That answer: solved directly, then refined against residuals in long double until it stands.
    The direct one alone is no nearer; both see M, C and K only as rounded, to 1e-6 N/m.
    """
    system = build_finite_element(backrest=backrest, cushion=cushion)
    frequencies = np.array([0.2, 2.0, 5.0, 20.0])
    data = pik.frequency_response(system, frequencies)
    assert data.method == "modal"
    exact = refined(system, 2j * np.pi * frequencies)
    for unit in np.unique(data.output_unit):
        for given in np.unique(data.input_unit):
            part = np.ix_(range(4), data.output_unit == unit, data.input_unit == given)
            a, b = data.response.values[part], exact[part]
            assert np.max(np.abs(a - b)) < 2e-8 * np.max(np.abs(b))


def refined(system: pik.LinearSystem, s: np.ndarray) -> np.ndarray:
    """H (F, r, p) by iterative refinement in extended precision."""
    parts = [part.astype(np.longdouble) for part in (system.stiffness, system.damping, system.mass)]
    answers = []
    for at in s.astype(np.clongdouble):
        dynamic = sum(at**k * part for k, part in enumerate(parts))
        driven = sum(at**k * part for k, part in enumerate(system.B))
        factor = lu_factor(dynamic.astype(complex))
        x = np.zeros_like(driven)
        for _ in range(6):
            x = x + lu_solve(factor, (driven - dynamic @ x).astype(complex))
        seen = sum(at**k * part for k, part in enumerate(system.Y))
        straight = sum(at**k * part for k, part in enumerate(system.D))
        answers.append((seen @ x + straight).astype(complex))
    return np.array(answers)


# What mechanics says


@pytest.mark.parametrize("name", ["upright", "reclined_45", "look_left"])
def test_a_rigid_person_is_a_mass(models: Models, name: str) -> None:
    """All K towards infinity: the inertia of the whole about the seat, and the head goes along."""
    posture, _ = models.solved(name)
    system = models(name)
    stiff = system._replace(stiffness=system.stiffness * 1e9)
    data = pik.frequency_response(stiff, [0.5, 2.0], "direct")
    person = Person.of(posture.body)
    spatial = pin_inertia(person, posture)
    # the softest, a wrist, is 1e9 times stiffer than it weighs at 2 Hz
    np.testing.assert_allclose(data.apparent_mass.values.real, [spatial] * 2, atol=1e-5)
    np.testing.assert_allclose(data.stht.values, [np.eye(3)] * 2, atol=1e-6)


def pin_inertia(person: Person, posture: pik.Posture) -> np.ndarray:
    """Inertia (6, 6), linear first, of the whole model about the world's origin."""
    import pinocchio as pin

    model, data = person.model, person.model.createData()
    q = person.configuration(posture.q)
    pin.ccrba(model, data, q, np.zeros(model.nv))
    centre = pin.SE3(np.eye(3), data.com[0])
    return centre.act(data.Ig).matrix()


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("upright", ()),
        ("reclined_15", ("seat.backrest.kind=rigid",)),
        ("pilot_push", ("seat.backrest.kind=foam",)),
        ("pilot_cyclic", ("seat.backrest.kind=rigid", "seat.cushion={}")),
    ],
)
def test_slowly_moved_the_seat_carries_the_mass(
    models: Models, name: str, settings: tuple[str, ...]
) -> None:
    posture, problem = models.solved(name, *settings)
    system, cushion = models(name, *settings), problem.seat.cushion
    data = pik.frequency_response(system, [1e-3], "direct")
    base = "floor" if cushion else "seat"
    whole = pik.apparent_mass(data, "total", base).values[0]
    # (f / f1)² with f1 near 0.4 Hz is 6e-6
    expected = pin_inertia(Person.of(posture.body), posture)
    if cushion:
        expected[:3, :3] += (cushion.seat.mass + cushion.cushion.mass) * np.eye(3)
    np.testing.assert_allclose(whole.real, expected, atol=3e-4)
    np.testing.assert_allclose(pik.transmissibility(data, base=base)[0], np.eye(3), atol=1e-4)


@pytest.mark.parametrize("method", ["modal", "direct"])
@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("upright", ("vibration.gravity=true",)),
        ("reclined_15", ("seat.backrest.kind=rigid",)),
        ("pilot_push", ("seat.backrest.kind=foam",)),
        ("pilot_cyclic", ("seat.backrest.kind=rigid", "seat.cushion={}")),
    ],
)
def test_reciprocity(models: Models, name: str, settings: tuple[str, ...], method: Any) -> None:
    """What moves at A presses on B as B would on A: seat, backrest and pivots, 1e-10."""
    system = models(name, *settings)
    interfaces = list(dict.fromkeys(port.name.rpartition(" ")[0] for port in system.inputs))
    # what moves with the seat or floor is felt there in all
    outputs = ["total" if name in ("seat", "floor") else name for name in interfaces]
    read = [f"{name} force" for name in outputs]
    data = pik.frequency_response(system.of(interfaces, read), FREQUENCIES, method)
    assert data.method == method
    matrix = data.response.values
    assert np.max(np.abs(matrix - matrix.swapaxes(1, 2))) < 1e-10 * np.abs(matrix).max()


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("upright", ()),
        ("reclined_15", ("seat.backrest.kind=rigid", "seat.backrest.tangential_damping=50.0")),
        ("look_left", ("seat.backrest.kind=foam", "vibration.gravity=true")),
        ("upright", ("seat.backrest.kind=foam", "seat.cushion={}")),
    ],
)
def test_power_goes_in(models: Models, name: str, settings: tuple[str, ...]) -> None:
    """Dampers take power: as much as they turn to heat, v·C v at every frequency."""
    system = models(name, *settings)
    data = pik.frequency_response(system, FREQUENCIES, "direct")
    power = pik.absorbed_power(data, system.inputs[0].name.partition(" ")[0])
    assert float(power.min()) >= 0.0
    s = 2j * np.pi * FREQUENCIES
    heat = []
    for at in s:
        dynamic = at**2 * system.mass + at * system.damping + system.stiffness
        moved = sum(at**k * system.B[k][:, :6] for k in range(3)) / at**2
        v = at * np.linalg.solve(dynamic, moved)
        heat.append(np.einsum("ij,ik,kj->j", v.conj(), system.damping, v).real)
    # rotations of the seat reach C through nothing but the coordinates
    np.testing.assert_allclose(power.values, heat, rtol=1e-8)


@pytest.mark.parametrize(
    ("frequencies", "said"),
    [
        ([], "there are none"),
        ([1.0, math.nan], "number 2 is nan"),
        ([1.0, math.inf], "number 2 is inf"),
        ([0.0, 1.0], "number 1 is 0 Hz"),
        ([1.0, -2.0], "number 2 is -2 Hz"),
        ([1.0, 3.0, 2.0], "number 3, 2 Hz, is not above 3 Hz"),
        ([1.0, 1.0], "number 2, 1 Hz, is not above 1 Hz"),
        (["a"], "give a list of numbers in Hz"),
        (3.0, "there are none"),
    ],
)
def test_bad_frequencies(frequencies: Any, said: str) -> None:
    with pytest.raises(BadProblem, match=re.escape(said)):
        pik.frequency_response(chain(ONE), frequencies)


def test_bad_models_and_questions() -> None:
    broken = chain(ONE)._replace(stiffness=np.array([[np.nan]]))
    with pytest.raises(PostureIKError, match="must be finite"):
        pik.frequency_response(broken, [1.0])
    with pytest.raises(PostureIKError, match="valid are modal, schur, direct"):
        pik.frequency_response(chain(ONE), [1.0], "fft")  # type: ignore[arg-type]
    data = pik.frequency_response(chain(ONE), [1.0])
    with pytest.raises(PostureIKError, match="it has no T7"):
        pik.transmissibility(data, "T7")


# What is held moves as what holds it


def test_a_hand_goes_where_its_lever_goes(models: Models) -> None:
    """On a lever that stands: with the pivot, and with the seat that carries the pivot."""
    posture, _ = models.solved("pilot_cyclic")
    system = models("pilot_cyclic", "seat.backrest.kind=foam")
    grip = [f"grip_r {axis}" for axis in "xyz"]
    data = pik.frequency_response(system.of(["seat", "lever_cyclic"], grip), [0.7, 9.0])
    place = posture.frames["grip_r"].translation
    pivot = np.array(posture.problem.lever["cyclic"].pivot)
    for base, arm in (("seat", place), ("lever_cyclic", place - pivot)):
        turn = np.array([[0, arm[2], -arm[1]], [-arm[2], 0, arm[0]], [arm[1], -arm[0], 0]])
        got = data.response.sel(input=[f"{base} {m}" for m in ("x", "y", "z", "rx", "ry", "rz")])
        np.testing.assert_allclose(got.values, [np.hstack([np.eye(3), turn])] * 2, atol=1e-8)


def test_the_back_goes_where_a_rigid_backrest_goes(models: Models) -> None:
    """The mean motion of T1 to T10, along the backrest's axes, but for the slide."""
    settings = ("seat.backrest.kind=rigid",)
    posture, problem = models.solved("reclined_15", *settings)
    bodies = problem.seat.backrest.bodies
    system = pik.linearise(models.body, posture, problem, frames=bodies)
    motions = [f"{name} {m}" for name in bodies for m in ("x", "y", "z", "rx", "ry", "rz")]
    data = pik.frequency_response(system.of(["backrest", "seat"], motions), [0.7, 9.0])
    tilt = np.radians(15.0)
    axes = np.array([[np.cos(tilt), 0, -np.sin(tilt)], [0, 1, 0], [np.sin(tilt), 0, np.cos(tilt)]])
    point = posture.frames["T7"].translation - 0.1 * axes[:, 0]
    places = [posture.frames[name].translation for name in bodies]
    mean = average(list(np.split(np.eye(6 * len(bodies)), len(bodies))), places, point)
    along = np.kron(np.eye(2), axes.T)
    rows = [0, 1, 3, 4, 5]
    got = (along @ mean @ data.response.values)[:, rows]
    expected = np.hstack([np.eye(6), along @ carry(point)])[rows]
    np.testing.assert_allclose(got, [expected] * 2, atol=1e-8)


def test_accelerations_tell_the_same_transmissibility() -> None:
    system = chain(*TWO)
    rates = np.zeros_like(system.Y), np.zeros_like(system.D)
    for swift, slow in zip(rates, (system.Y, system.D), strict=True):
        swift[2, 0] = slow[0, 0]
    swift_system = system._replace(
        outputs=(Port("Head acceleration z", "m/s²"), system.outputs[1]), Y=rates[0], D=rates[1]
    )
    ours = pik.frequency_response(swift_system, FREQUENCIES).stht.values
    expected = pik.frequency_response(system, FREQUENCIES).stht.values
    np.testing.assert_allclose(ours, expected, rtol=1e-9)


def test_the_grid_of_a_problem() -> None:
    block = pik.VibrationBlock().frequencies
    assert len(block.values) == 399
    assert block.values[0] == 0.1
    assert block.values[-1] == pytest.approx(20.0, abs=1e-12)
