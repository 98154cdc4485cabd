"""Mode shapes in the 3D page: how every link moves in them, and what the page says of them."""

import base64
import json
import re

import numpy as np
import pinocchio as pin
import pytest

import posture_ik as pik
from posture_ik.errors import PostureIKError
from posture_ik.kinematics import frame_poses
from posture_ik.muscle import Activity, Paths
from posture_ik.posture import Motion
from posture_ik.problem import SPINE
from posture_ik.show import write_view
from posture_ik.show.looks import looks_of
from posture_ik.show.mode_shapes import mode_shapes, scaled
from posture_ik.show.tubes import POINTS, along, riders
from posture_ik.vibration import Vibration, vibrate
from posture_ik.vibration.shapes import link_motions

LINKS = ("Head", "C4", "T6", "L3", "S1", "scapula_r", "humerus_l", "hand_r", "thigh_l")


def vibrating(name: str, *settings: str) -> Vibration:
    problem = pik.load_problem(name, ("vibration.frequencies={stop=0.2}", *settings))
    body = pik.build_body(problem.subject)
    return vibrate(body, pik.solve_posture(body, problem), problem)


@pytest.fixture(scope="module")
def free() -> Vibration:
    return vibrating("reclined_15")


@pytest.fixture(scope="module")
def gripping() -> Vibration:
    """Held by a rigid backrest and a lever that follows the hand."""
    return vibrating("pilot_push", 'seat.backrest={kind="rigid"}')


@pytest.fixture(scope="module")
def elements() -> Vibration:
    settings = 'vibration.model="finite_element"', 'seat.backrest={kind="rigid"}', "seat.cushion={}"
    return vibrating("reclined_15", *settings)


def shown(vibration: Vibration) -> dict:
    return mode_shapes(vibration, looks_of(vibration.posture.body), None)


def swing(page: dict, mode: dict, path: str) -> np.ndarray:
    """Complex motion of a path in a mode, (6,), as the page is given it."""
    numbers = np.frombuffer(base64.b64decode(mode["swing"]), "<f4").reshape(-1, 2, 6)
    real, imaginary = numbers[page["paths"].index(path)]
    return real + 1j * imaginary


def test_links_move_as_forward_kinematics(free: Vibration) -> None:
    """Against central differences; the viscera go with their vertebra and slide along its axes."""
    body, q = free.posture.body, free.posture.q
    assert free.system.coordinates[: len(q)] == body.dofs
    motions = link_motions(free, (*LINKS, "T11V"))
    step = 1e-5  # differences err by step² times curvature, and by rounding over step: 1e-10
    for mode in (free.undamped[0], free.undamped[1], free.undamped[18]):
        phi = mode.shape.real / np.abs(mode.shape).max()
        before, after = (frame_poses(body.model, q + s * step * phi[: len(q)]) for s in (-1, 1))
        for link, motion in motions.items():
            turned = pin.log3(after[link].rotation @ before[link].rotation.T)
            moved = after[link].translation - before[link].translation
            expected = np.r_[moved, turned] / (2 * step)
            if link == "T11V":
                slide = [phi[free.system.coordinates.index(f"T11V_{axis}")] for axis in "xz"]
                axes = free.posture.frames["T11V"].rotation[:, [0, 2]]
                expected[:3] += axes @ slide
            np.testing.assert_allclose(motion @ phi, expected, atol=1e-8)


def test_what_is_held_moves_along(gripping: Vibration) -> None:
    """The held coordinates can be found from the motions; with them all links move as they must."""
    body, q = gripping.posture.body, gripping.posture.q
    links = [*SPINE, "humerus_r", "hand_r", "humerus_l", "hand_l", "grip_r", "lever_cyclic_grip"]
    motions = link_motions(gripping, links)
    assert len(gripping.system.coordinates) < len(q) + 14
    data = body.model.createData()
    pin.computeJointJacobians(body.model, data, q)
    pin.updateFramePlacements(body.model, data)
    jacobian = np.vstack(
        [
            pin.getFrameJacobian(
                body.model, data, body.model.getFrameId(link), pin.LOCAL_WORLD_ALIGNED
            )
            for link in links
        ]
    )
    moved = np.vstack([motions[link] for link in links])
    joints = np.linalg.lstsq(jacobian, moved, rcond=None)[0]
    # Rounding of a least-squares problem of condition 1e3, motions up to 10.
    np.testing.assert_allclose(jacobian @ joints, moved, atol=1e-9)
    for j, name in enumerate(gripping.system.coordinates):
        if name in body.dofs:
            np.testing.assert_allclose(joints[body.dofs.index(name), j], 1.0, atol=1e-8)
    grip, lever = motions["grip_r"][:3], motions["lever_cyclic_grip"][:3]
    assert np.abs(lever).max() > 0.1
    np.testing.assert_allclose(grip, lever, atol=1e-9)


def test_links_ride_rigidly_on_finite_elements(elements: Vibration) -> None:
    motions = link_motions(elements, ("Head", "T2", "scapula_l", "hand_r", "thigh_l"))
    frames, coordinates = elements.posture.frames, elements.system.coordinates
    one = np.eye(len(coordinates))
    for i, component in enumerate(("x", "y", "z", "rx", "ry", "rz")):
        assert motions["Head"][i] == pytest.approx(one[coordinates.index(f"Head {component}")])
    for link in ("scapula_l", "hand_r"):
        apart = frames[link].translation - frames["T2"].translation
        turn = motions["T2"][3:]
        assert np.all(motions[link][3:] == turn)
        expected = motions["T2"][:3] + np.cross(turn.T, apart).T
        np.testing.assert_allclose(motions[link][:3], expected, atol=1e-12)
    assert not motions["thigh_l"].any()
    # The rigid backrest eliminates five coordinates, whose bodies move nonetheless.
    gone = [f"{body} x" for body in SPINE if f"{body} x" not in coordinates]
    assert gone
    for name in gone:
        assert np.abs(link_motions(elements, [name.split()[0]])[name.split()[0]][0]).max() > 0.1


def test_cushion_and_seat_move(elements: Vibration) -> None:
    """The lowest mode is the person on both in a row, nearly static: each gives as it is soft."""
    page = shown(elements)
    mode = page["kinds"]["undamped"][0]
    cushion, seat = (swing(page, mode, path)[2].real for path in ("seat/pan", "seat/stem"))
    layers = elements.problem.seat.cushion
    ratio = layers.cushion.stiffness / (layers.cushion.stiffness + layers.seat.stiffness)
    assert seat / cushion == pytest.approx(ratio, rel=0.1)  # the seat's own inertia
    assert swing(page, mode, "seat/backrest") == pytest.approx(swing(page, mode, "seat/stem"))


def test_largest_displacement_is_one_metre_at_the_start() -> None:
    rng = np.random.default_rng(4)
    motions = rng.normal(size=(7, 6)) + 1j * rng.normal(size=(7, 6))
    unit = scaled(motions)
    turn = np.exp(1j * np.linspace(0.0, 2 * np.pi, 721))
    placed = np.real(unit[:, :, None] * turn)
    far = np.linalg.norm(placed[:, :3], axis=1)
    far = np.vstack([far, 0.1 * np.linalg.norm(placed[:, 3:], axis=1)])
    assert far.max() == pytest.approx(1.0, abs=1e-12)
    assert far[:, 0].max() == pytest.approx(1.0, abs=1e-12)
    assert np.ptp(np.angle(unit / motions)) < 1e-12
    assert np.ptp(np.abs(unit / motions)) < 1e-12


def test_muscles_ride_on_their_links(pilot: Activity) -> None:
    """The page's rule, in numpy: between corners carried by links, points lie on the new path."""
    posture, body, given = pilot.shown, pilot.shown.body, riders(pilot)
    kinds = {"corners": "<f4", "carriers": "u1", "before": "<i2", "share": "<f4"}
    corners, carriers, before, share = (
        np.frombuffer(base64.b64decode(given[key]), kind) for key, kind in kinds.items()
    )
    later = posture.q.copy()
    later[body.dofs.index("elbow_flexion_r")] += 0.05
    poses = [frame_poses(body.model, q) for q in (posture.q, later)]
    carried = [poses[1][link] * poses[0][link].inverse() for link in given["links"]]
    moved = np.array(
        [
            carried[k].act(corner.astype(float))
            for corner, k in zip(corners.reshape(-1, 3), carriers, strict=True)
        ]
    )
    at, towards = moved[before], moved[before + 1] - moved[before]
    ridden = (at + share[:, None] * towards).reshape(-1, POINTS, 3)
    paths = Paths.of(body)
    first = np.array([along(line) for line in paths.polylines(posture.q)])
    assert np.linalg.norm(ridden - first, axis=2).max() > 0.01
    off = [
        np.linalg.norm(points[:, None] - along(line, 800), axis=2).min(axis=1)
        for points, line in zip(ridden, paths.polylines(later), strict=True)
    ]
    # Where a path wraps it touches elsewhere; samples of the new path lie 0.7 mm apart.
    assert np.max(off) < 1e-3


def test_page_is_given_the_modes_below_20_hz(free: Vibration) -> None:
    page = shown(free)
    for kind, modes in (("undamped", free.undamped), ("damped", free.damped)):
        given = page["kinds"][kind]
        below = [m for m in modes if m.frequency <= 20.0 and m.eigenvalue.imag > 0.0][:20]
        assert [mode["frequency"] for mode in given] == [mode.frequency for mode in below]
        assert [mode["symmetry"] for mode in given] == [mode.symmetry for mode in below]
        assert all(mode["frequency"] <= 20.0 for mode in given)
    head = link_motions(free, ["Head"])["Head"]
    mode, shape = page["kinds"]["damped"][3], head @ free.damped[3].shape
    ratio = swing(page, mode, "person/Head") / shape
    assert ratio == pytest.approx(np.full(6, ratio[0]), rel=1e-4)


def test_file_grows_by_less_than_a_megabyte(free: Vibration, tmp_path) -> None:
    write_view(free.posture, tmp_path / "bare.html")
    write_view(free.posture, tmp_path / "modes.html", vibration=free)
    bare, modes = ((tmp_path / f"{name}.html").stat().st_size for name in ("bare", "modes"))
    assert modes < bare + 500_000
    text = (tmp_path / "modes.html").read_text(encoding="utf-8")
    given = json.loads(re.search(r"const modes = (\{.*?\});\n", text).group(1))
    assert len(given["kinds"]["undamped"]) == 20
    assert "free: the model has no backrest" in text


def test_lumped_model_says_that_it_has_no_shapes(tmp_path) -> None:
    vibration = vibrating("reclined_15", 'vibration.model="lumped:boileau_rakheja"')
    assert link_motions(vibration, ["Head"]) == {}
    write_view(vibration.posture, tmp_path / "view.html", vibration=vibration)
    text = (tmp_path / "view.html").read_text(encoding="utf-8")
    assert "it has no shapes to show" in text
    assert 'id="player"' not in text


def test_unstable_posture_is_told(tmp_path) -> None:
    vibration = vibrating("upright", "vibration.gravity=true")
    write_view(vibration.posture, tmp_path / "view.html", vibration=vibration)
    text = (tmp_path / "view.html").read_text(encoding="utf-8")
    assert "The posture is unstable, doubling every" in text


def test_modes_need_their_own_posture(free: Vibration, sweep: Motion, tmp_path) -> None:
    with pytest.raises(PostureIKError, match="about the posture of their vibration alone"):
        write_view(sweep, tmp_path / "view.html", vibration=free)
    assert list(tmp_path.iterdir()) == []
