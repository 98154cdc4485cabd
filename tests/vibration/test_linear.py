"""The linearised person against differences of Pinocchio's dynamics, and closed forms."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from armless import without_arms
from scipy.linalg import eigvalsh, null_space

import posture_ik as pik
from posture_ik.errors import PostureIKError
from posture_ik.muscle import ARMS
from posture_ik.muscle.hill import LAWS
from posture_ik.problem import LawBack
from posture_ik.vibration.backrest import at_preload
from posture_ik.vibration.network import average
from posture_ik.vibration.person import Person
from posture_ik.vibration.seat import law_stiffness

Models = Any  # of conftest.py

FOAM = ("seat.backrest.kind=foam", "seat.backrest.tangential_stiffness=5e3")
RIGID = ("seat.backrest.kind=rigid",)
GRAVITY = ("vibration.gravity=true",)
LET_GO = ("vibration.grip=false",)
CUSHION = ("seat.cushion={}",)

CASES = [
    ("upright", ()),
    ("reclined_15", GRAVITY),
    ("look_left", GRAVITY),
    ("reclined_15", (*FOAM, "seat.backrest.tangential_damping=80.0")),
    ("pilot_push", (*GRAVITY, *LET_GO)),
    ("reclined_15", (*FOAM, *CUSHION)),
    ("pilot_push", (*LET_GO, *CUSHION)),
]


def own(person: Person, z: np.ndarray) -> np.ndarray:
    """What z moves of the model's own: on a cushion the person rises by it, and no lever does."""
    count = len(person.order)
    found = z[:count].copy()
    if len(z) > count:
        found[2] += z[-1]
        found[8 : 6 * len(person.moved) : 6] -= z[-1]
    return found


def at(person: Person, posture: pik.Posture, z: np.ndarray) -> np.ndarray:
    """A configuration of the model with what is moved and the coordinates z away from rest."""
    q = person.configuration(posture.q)
    q[person.order] += own(person, z)
    return q


def elements(
    person: Person, posture: pik.Posture, problem: pik.Problem, z: np.ndarray
) -> list[tuple[float, float, float]]:
    """Length, stiffness and damping of each spring between points at a finite displacement."""
    model, data = person.model, person.data
    pin.framesForwardKinematics(model, data, at(person, posture, z))

    def place(frame: str) -> pin.SE3:
        return data.oMf[model.getFrameId(frame)]

    found = []
    for upper, lower, k, c in person.column:
        gap = place(upper).translation - place(lower).translation
        found.append((float(np.linalg.norm(gap)), k, c))
    back = problem.seat.backrest
    if back is not None:
        # Where the seat has gone is taken off; then the rotation that fits best, as a whole.
        tilt = np.radians(problem.seat.recline_deg)
        square = np.array([np.cos(tilt), 0.0, np.sin(tilt)])
        along = np.array([-np.sin(tilt), 0.0, np.cos(tilt)])
        before = [posture.frames[name] for name in back.bodies]
        seat = data.oMi[6].copy()
        if problem.seat.cushion:
            seat.translation += [0.0, 0.0, z[-2] - z[-1]]
        now = [seat.actInv(place(name)) for name in back.bodies]
        centre, middle = (np.mean([p.translation for p in ps], axis=0) for ps in (before, now))
        point = posture.frames["T7"].translation - 0.1 * square
        length = np.mean([np.linalg.norm(p.translation - point) for p in before])
        spread = sum(
            np.outer(b.translation - middle, a.translation - centre)
            + length**2 / 2 * b.rotation @ a.rotation.T
            for a, b in zip(before, now, strict=True)
        )
        left, _, right = np.linalg.svd(spread)
        travel = middle + left @ right @ (point - centre) - point
        found.append((float(square @ travel), back.stiffness, back.damping))
        found.append((float(along @ travel), back.tangential_stiffness, back.tangential_damping))
    cushion = problem.seat.cushion
    if cushion:
        found.append((float(z[-2]), cushion.seat.stiffness, cushion.seat.damping))
        found.append((float(z[-1] - z[-2]), cushion.cushion.stiffness, cushion.cushion.damping))
    return found


@pytest.mark.parametrize(("name", "settings"), CASES)
def test_matrices_equal_differences_of_the_dynamics(
    models: Models, name: str, settings: tuple[str, ...]
) -> None:
    """All of M, C, K and the columns of B that move seat and pivots, by central differences.

    With steps of 1e-5 they err by step² and by 1e-16 / step: 1e-6 in the scale of row and column.
    """
    posture, problem = models.solved(name, *settings)
    system, person = models(name, *settings), Person.of(posture.body)
    model, data = person.model.copy(), person.model.createData()
    if GRAVITY[0] not in settings:
        model.gravity = pin.Motion.Zero()
    cushion = problem.seat.cushion
    layers = (cushion.seat, cushion.cushion) if cushion else ()
    moved, count, step = 6 * len(person.moved), len(person.order), 1e-5
    size = count + len(layers)
    rest = np.zeros(size)

    def inertial(z: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        rates = np.zeros((2, count))
        rates[:, person.order] = own(person, v), own(person, a)
        force = pin.rnea(model, data, at(person, posture, z), *rates)[person.order]
        if not layers:
            return force
        levers = force[8 : 6 * len(person.moved) : 6]
        force = np.r_[force, 0.0, force[2] - levers.sum()]
        for i, layer in enumerate(layers):
            inertia = layer.mass * (a[:3] + np.array([0.0, 0.0, a[count + i]]))
            force[:3] += inertia
            force[count + i] += inertia[2]
        return force

    def difference(order: int) -> np.ndarray:
        columns = []
        for way in np.eye(size):
            forward, backward = ([rest] * 3 for _ in range(2))
            forward[order], backward[order] = step * way, -step * way
            columns.append((inertial(*forward) - inertial(*backward)) / (2 * step))
        return np.array(columns).T

    slopes = np.array(
        [
            [
                (ahead[0] - behind[0]) / (2 * step)
                for ahead, behind in zip(
                    elements(person, posture, problem, step * way),
                    elements(person, posture, problem, -step * way),
                    strict=True,
                )
            ]
            for way in np.eye(size)
        ]
    )
    _, springs, dampers = np.array(elements(person, posture, problem, rest)).T
    joints = np.zeros((2, size))
    joints[:, moved:count] = person.stiffness, person.damping
    expected = [difference(order) for order in range(3)]
    expected[0] += np.diag(joints[0]) + (slopes * springs) @ slopes.T
    expected[1] += np.diag(joints[1]) + (slopes * dampers) @ slopes.T

    scale = np.sqrt(np.abs(np.diag(expected[2]))) + 1e-3
    for order, ours in enumerate((system.stiffness, system.damping, system.mass)):
        theirs = expected[order][moved:]
        unit = np.outer(scale[moved:], scale)
        unit = np.maximum(unit, np.sqrt(np.abs(np.outer(np.diag(ours), np.diag(expected[order])))))
        np.testing.assert_allclose((ours - theirs[:, moved:]) / unit[:, moved:], 0, atol=1e-6)
        np.testing.assert_allclose(
            (-system.B[order][:, :moved] - theirs[:, :moved]) / unit[:, :moved], 0, atol=1e-6
        )


@pytest.mark.parametrize(
    ("name", "settings"),
    [*CASES, ("pilot_cyclic", RIGID), ("pilot_push", ("vibration.prestress=true",))],
)
def test_symmetric_and_the_mass_positive(
    models: Models, name: str, settings: tuple[str, ...]
) -> None:
    system = models(name, *settings)
    for part in (system.mass, system.damping, system.stiffness):
        np.testing.assert_array_equal(part, part.T)
    assert eigvalsh(system.mass)[0] > 0.0
    # dampers take energy and never give any; rounding is 1e-16 of the largest
    assert eigvalsh(system.damping)[0] > -1e-12 * np.max(system.damping)


def test_muscles_stiffen_the_arms_at_work_alone(models: Models) -> None:
    """What activity adds to K and C, in place of springs: differences of the muscles' torques.

    Activations stay as they are. Torques of some 10 N m by steps of 1e-5: 1e-6 of the largest.
    """
    settings = ("activation.short_range=false", *LET_GO)
    posture, problem = models.solved("pilot_collective", *settings)
    activity = pik.solve_activation(models.body, posture, problem)
    stiff = pik.linearise(models.body, posture, problem, activity=activity)
    plain, person = models("pilot_collective", *settings), Person.of(posture.body)
    law, rows, paths = LAWS[activity.asked.law], activity.paths.rows, activity.paths
    assert activity.working == ("left",)

    def torque(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        length, jacobian = paths.evaluate(q)
        force = law(activity.muscles, length, jacobian @ v[rows], activity.activation[0])
        return -jacobian.T @ force.force

    step, n, rest = 1e-5, len(posture.q), np.zeros(len(posture.q))
    expected = np.zeros((2, len(stiff.coordinates), len(stiff.coordinates)))
    at_work = rows[ARMS["left"][1]]
    for i in at_work:
        away = step * np.eye(n)[i]
        slopes = (
            torque(posture.q + away, rest) - torque(posture.q - away, rest),
            torque(posture.q, away) - torque(posture.q, -away),
        )
        for part, slope in zip(expected, slopes, strict=True):
            part[at_work, i] = -slope[ARMS["left"][1]] / (2 * step)
    for part, springs in zip(expected, (person.stiffness, person.damping), strict=True):
        part[at_work, at_work] -= springs[at_work]
    found = stiff.stiffness - plain.stiffness, stiff.damping - plain.damping
    for ours, theirs in zip(found, expected, strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-6 * np.max(np.abs(theirs)))


def test_viscera_ride_as_in_the_posture_where_they_stand_still(
    models: Models, body: pik.Body
) -> None:
    """Held at their ties, they give back the mass matrix of the posture's own model."""
    posture, _ = models.solved("reclined_30")
    system = models("reclined_30")
    assert system.coordinates[:117] == body.dofs
    assert len(system.coordinates) == 117 + 14
    mass = pin.crba(body.model, body.model.createData(), posture.q)
    expected = np.triu(mass) + np.triu(mass, 1).T
    np.testing.assert_allclose(system.mass[:117, :117], expected, atol=1e-12)


def test_without_arms_there_are_117(tmp_path: Path, models: Models) -> None:
    path = tmp_path / "armless.urdf"
    path.write_text(without_arms(models.body.urdf))
    problem = pik.load_problem("upright")
    body = pik.build_body(pik.Subject(urdf=path))
    system = pik.linearise(body, pik.solve_posture(body, problem), problem)
    assert len(system.coordinates) == 103 + 14


@pytest.mark.parametrize("name", ["reclined_15_gravity", "look_left", "pilot_push"])
def test_weight_and_holding_forces_bend_the_energy(models: Models, name: str) -> None:
    """What gravity and prestress add to K: differences of the weight's and the tasks' torques."""
    on = (*LET_GO, *GRAVITY, "vibration.prestress=true")
    posture, _ = models.solved(name, *LET_GO)
    loaded, plain = models(name, *on), models(name, *LET_GO)
    model, program = posture.body.model, posture.statement.program
    data, numbers, n = model.createData(), posture.statement.parameters, len(posture.q)

    def torque(q: np.ndarray) -> np.ndarray:
        jacobian = program.jacobian(q, numbers).full()
        return pin.computeGeneralizedGravity(model, data, q) + jacobian.T @ posture.multipliers

    step = 1e-6
    slope = [(torque(posture.q + e) - torque(posture.q - e)) / (2 * step) for e in step * np.eye(n)]
    bent = (loaded.stiffness - plain.stiffness)[:n, :n]
    # rounding of some 100 N m over the step
    np.testing.assert_allclose(bent, slope, atol=1e-6 * np.max(np.abs(slope)))


@pytest.mark.parametrize(
    ("name", "settings"), [("pilot_cyclic", ()), ("pilot_push", ()), ("pilot_collective", ())]
)
def test_grips_leave_what_their_tasks_leave(
    models: Models, name: str, settings: tuple[str, ...]
) -> None:
    """The eigenvalues are those on the null space of the tasks' own Jacobian."""
    posture, _ = models.solved(name, *settings)
    held, free = models(name, *settings), models(name, *settings, *LET_GO)
    program, statement = posture.statement.program, posture.statement
    rows = program.jacobian(posture.q, statement.parameters).full()
    labels = [c.label for c in posture.constraints for _ in c.rows]
    levers = {f"{t.side} hand" for t in posture.problem.task if getattr(t, "lever", None)}
    hands = np.zeros((sum(label in levers for label in labels), len(free.coordinates)))
    hands[:, : len(posture.q)] = rows[[label in levers for label in labels]]
    assert len(hands)
    basis = null_space(hands)
    expected = eigvalsh(basis.T @ free.stiffness @ basis, basis.T @ free.mass @ basis)
    # 1e-9 of each: both are symmetric problems with condition 1e6 in mass
    np.testing.assert_allclose(eigvalsh(held.stiffness, held.mass), expected, rtol=1e-7)


def test_a_rigid_backrest_leaves_the_slide_alone(models: Models) -> None:
    """As foam without bound: the eigenvalues in the range of interest come to those held."""
    held = models("reclined_15", *RIGID)
    assert len(held.coordinates) == 131 - 5
    posture, problem = models.solved("reclined_15", *FOAM)
    free = models("reclined_15")
    points = [posture.frames[body].translation for body in problem.seat.backrest.bodies]
    tilt = np.radians(15.0)
    axes = np.array([[np.cos(tilt), 0, -np.sin(tilt)], [0, 1, 0], [np.sin(tilt), 0, np.cos(tilt)]])
    body, data = posture.body, posture.body.model.createData()
    pin.computeJointJacobians(body.model, data, posture.q)
    pin.updateFramePlacements(body.model, data)
    jacobians = [
        pin.getFrameJacobian(body.model, data, body.model.getFrameId(name), pin.LOCAL_WORLD_ALIGNED)
        for name in problem.seat.backrest.bodies
    ]
    motion = average(jacobians, points, posture.frames["T7"].translation - 0.1 * axes[:, 0])
    rows = np.kron(np.eye(2), axes.T) @ motion
    rows = np.hstack([rows, np.zeros((6, 14))])[[0, 1, 3, 4, 5]]
    basis = null_space(rows)
    expected = eigvalsh(basis.T @ free.stiffness @ basis, basis.T @ free.mass @ basis)
    np.testing.assert_allclose(eigvalsh(held.stiffness, held.mass), expected, rtol=1e-7)


def test_strains_of_a_disc_are_its_coordinates(models: Models) -> None:
    """And spring and damper take what lies between: force over strain is k + iωc."""
    posture, problem = models.solved("reclined_15")
    system = pik.linearise(models.body, posture, problem, frames=(), discs=("L4_L5",))
    names = [f"L4_L5_{component}" for component in ("axial", "rx", "ry", "rz")]
    assert [port.unit for port in system.outputs[:8]] == ["m", *["rad"] * 3, "N", *["N m"] * 3]
    ports = ["L4_L5_axial", "L4_L5_ry", "L4_L5_axial force", "L4_L5_ry force"]
    data = pik.frequency_response(system.of(["seat x"], ports), [2.0, 7.0]).response.values[..., 0]
    at = [models.body.dofs.index(name) for name in names]
    k, c = (part[at][[0, 2]] for part in (models.body.stiffness, models.body.damping))
    omega = 2 * np.pi * np.array([[2.0], [7.0]])
    np.testing.assert_allclose(data[:, 2:] / data[:, :2], k + 1j * omega * c, rtol=1e-9)
    with pytest.raises(PostureIKError, match=re.escape("no disc called 'L4_L6'; did you mean")):
        pik.linearise(models.body, posture, problem, discs=("L4_L6",))


def test_a_law_is_the_foam_that_it_is_at_its_preload(models: Models) -> None:
    """Also where the posture's own weight presses on the backrest, 4.4 N to each side or more."""
    law = "seat.backrest.kind=law"
    pressed = models("reclined_15", law, "seat.backrest.preload=60.0")
    stiffness = law_stiffness(60.0)
    foam = (f"seat.backrest.stiffness={stiffness}", "seat.backrest.damping=0.0")
    np.testing.assert_allclose(
        pressed.stiffness, models("reclined_15", *FOAM[:1], *foam).stiffness, rtol=1e-12
    )
    posture, problem = models.solved("reclined_15_gravity", law)
    contact = next(w.force for w in posture.wrenches if w.label == "backrest contact")
    square = np.array([np.cos(np.radians(15.0)), 0.0, np.sin(np.radians(15.0))])
    own = at_preload(problem.seat.backrest, posture)
    assert own.stiffness == pytest.approx(law_stiffness(contact @ square))
    with pytest.raises(PostureIKError, match="no preload is given"):
        at_preload(LawBack())
    with pytest.raises(PostureIKError, match="must be at least 0 N"):
        models("reclined_30", law)


def test_foam_takes_what_its_law_says(models: Models) -> None:
    """The backrest's force where it alone moves: k on the reference point, from the matrices."""
    system = models("reclined_15", *FOAM)
    data = pik.frequency_response(system, [1e-3, 1.0], "direct")
    force = data.response.sel(output="backrest force x", input="backrest x").values
    others = system.B[0][:, [p.name for p in system.inputs].index("backrest x")]
    # with the person as a spring behind: k - k²aᵀ K⁻¹ a, that K⁻¹ holds the foam already
    expected = 21e3 - others @ np.linalg.solve(system.stiffness, others)
    assert force[0].real == pytest.approx(expected, rel=1e-4)
    for kind in ("force y", "force rx", "force ry", "force rz"):
        free = data.response.sel(output=f"backrest {kind}", input="backrest x").values
        assert np.max(np.abs(free)) < 1e-9 * np.max(np.abs(force))


def test_bad_requests_are_told_in_a_sentence(models: Models, body: pik.Body) -> None:
    posture, problem = models.solved("upright")
    with pytest.raises(
        PostureIKError, match=re.escape("no link called 'Haed'; did you mean 'Head'")
    ):
        pik.linearise(body, posture, problem, frames=["Haed"])
    other = pik.build_body(pik.Subject(stature=1.9))
    with pytest.raises(PostureIKError, match="posture is of another body"):
        pik.linearise(other, posture, problem)
    with pytest.raises(PostureIKError, match="no input called 'seat w'"):
        models("upright").of(["seat w"], ["Head"])
