"""MBDyn input, read back by a parser of its own and rebuilt with numpy by MBDyn's formulae."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

import posture_ik as pik
from posture_ik.errors import BadURDF
from posture_ik.exchange import write_mbdyn

#: At rest; leaning with weight on; turned; arms out, own springs, joint limits that carry; a lever.
EXAMPLES = ["upright", "reclined_15_gravity", "look_left", "pilot", "pilot_push"]


class Pose:
    """Where a node or frame is: position p (3,) and rotation R (3, 3) in the world."""

    def __init__(self, p: np.ndarray, R: np.ndarray) -> None:
        self.p, self.R = p, R


@dataclass
class Deformable:
    nodes: tuple[int, int]
    frames: tuple[Pose, Pose]
    stiffness: np.ndarray
    damping: np.ndarray
    prestrain: np.ndarray
    prestress: np.ndarray

    def loads(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Force and moment on node 1, and where the force acts on both, in the world."""
        one, two = self.frames
        turn = Rotation.from_matrix(one.R.T @ two.R).as_rotvec()
        strain = np.concatenate([one.R.T @ (two.p - one.p), turn])
        law = self.prestress + self.stiffness * (strain - self.prestrain)
        return one.R @ law[:3], one.R @ law[3:], two.p


class Deck:
    """What `posture.mbd` and its includes say; what is used before it is defined fails."""

    def __init__(self, folder: Path) -> None:
        self.references: dict[int, Pose] = {}
        self.nodes: dict[int, Pose] = {}
        self.names: dict[int, str] = {}  # of the nodes
        self.bodies: dict[int, tuple[int, float, np.ndarray, np.ndarray]] = {}
        self.joints: dict[int, str] = {}
        self.springs: list[Deformable] = []
        #: node 1, node 2, direction in the world, point of a force or None for a moment
        self.rigid: list[tuple[int, int, np.ndarray, np.ndarray | None]] = []
        self.misfits: list[float] = []
        self.loads: dict[int, tuple[int, np.ndarray, np.ndarray | None]] = {}
        self.gravity = np.zeros(3)
        self.counts: dict[str, int] = {}
        text = (folder / "posture.mbd").read_text(encoding="utf-8")
        include = r'include: "([^"]+)";'
        text = re.sub(include, lambda m: (folder / m[1]).read_text(encoding="utf-8"), text)
        text = re.sub(r"#.*", "", text)
        self.variables: dict[str, int] = {}
        for card in filter(None, map(str.strip, text.split(";"))):
            keyword, _, rest = card.partition(":")
            self.words = [word.strip() for word in rest.split(",")]
            read = getattr(self, "read_" + keyword.strip().replace(" ", "_"), None)
            if read is not None:
                read()
                assert not self.words, f"left over in {card}"
            else:
                self.counts[keyword.strip()] = int(rest) if rest.strip().isdigit() else 1

    # words

    def take(self, *expected: str) -> str:
        word = self.words.pop(0)
        assert not expected or word in expected, f"{word!r} is none of {expected}"
        return word

    def maybe(self, word: str) -> bool:
        if self.words and self.words[0] == word:
            return bool(self.words.pop(0))
        return False

    def label(self, known: dict[int, object] | None = None) -> int:
        terms = [self.variables.get(term.strip()) or int(term) for term in self.take().split("+")]
        assert known is None or sum(terms) in known, f"{sum(terms)} is used before it is defined"
        return sum(terms)

    def new(self, known: dict[int, object]) -> int:
        label = self.label()
        assert label not in known, f"{label} is defined twice"
        if self.maybe("name"):
            self.names.setdefault(label, self.take().strip('"'))
        return label

    def floats(self, count: int) -> np.ndarray:
        return np.array([float(self.take()) for _ in range(count)])

    def base(self, node: Pose) -> Pose:
        if not self.maybe("reference"):
            return node
        if self.words[0] in ("global", "node"):
            kind = self.take()
            return node if kind == "node" else Pose(np.zeros(3), np.eye(3))
        return self.references[self.label(self.references)]

    def point(self, node: Pose) -> np.ndarray:
        base = self.base(node)
        return base.p + base.R @ (np.zeros(3) if self.maybe("null") else self.floats(3))

    def vector(self, node: Pose) -> np.ndarray:
        base = self.base(node)
        return base.R @ (np.zeros(3) if self.maybe("null") else self.floats(3))

    def matrix(self, node: Pose) -> np.ndarray:
        base = self.base(node)
        if self.maybe("eye"):
            return base.R
        self.take("matr")
        return base.R @ self.floats(9).reshape(3, 3)

    # cards

    def read_set(self) -> None:
        match = re.fullmatch(r"ifndef const integer (\w+) = (\d+)", self.take())
        assert match
        self.variables[match[1]] = int(match[2])

    def read_reference(self) -> None:
        label = self.new(self.references)
        world = Pose(np.zeros(3), np.eye(3))
        pose = Pose(self.point(world), self.matrix(world))
        assert not np.any(self.vector(world)), "nothing moves"
        assert not np.any(self.vector(world)), "nothing turns"
        np.testing.assert_allclose(pose.R.T @ pose.R, np.eye(3), atol=1e-12)
        self.references[label] = pose

    def read_structural(self) -> None:
        label = self.new(self.nodes)
        self.take("dynamic", "static")
        world = Pose(np.zeros(3), np.eye(3))
        self.nodes[label] = Pose(self.point(world), self.matrix(world))
        assert not np.any(self.vector(world))
        assert not np.any(self.vector(world))

    def read_body(self) -> None:
        label = self.new(self.bodies)
        node = self.label(self.nodes)
        pose = self.nodes[node]
        mass = float(self.take())
        centre = self.point(pose)
        assert self.take() == "reference"
        assert self.take() == "node"
        assert self.take() == "matr"
        tensor = self.floats(9).reshape(3, 3)
        self.bodies[label] = (node, mass, centre, pose.R @ tensor @ pose.R.T)

    def read_gravity(self) -> None:
        if self.words == [""]:
            self.words.clear()  # the count in the control data
            return
        self.take("uniform")
        self.take("component")
        self.gravity = np.array([float(self.take("const") and self.take()) for _ in range(3)])

    def read_force(self) -> None:
        label = self.new(self.loads)
        self.take("absolute")
        node = self.label(self.nodes)
        self.take("position")
        point = self.point(self.nodes[node])
        self.loads[label] = (node, self.constant(), point)

    def read_couple(self) -> None:
        label = self.new(self.loads)
        self.take("absolute")
        node = self.label(self.nodes)
        self.loads[label] = (node, self.constant(), None)

    def constant(self) -> np.ndarray:
        self.take("single")
        value = self.vector(Pose(np.zeros(3), np.eye(3)))
        self.take("const")
        return value * float(self.take())

    def read_joint(self) -> None:
        label = self.new(self.joints)
        kind = self.joints[label] = self.take()
        getattr(self, kind.replace(" ", "_"))()

    def ends(self, *words: str) -> tuple[tuple[int, int], tuple[Pose, Pose]]:
        nodes, frames = [], []
        for _ in range(2):
            nodes.append(self.label(self.nodes))
            pose = self.nodes[nodes[-1]]
            frame = Pose(pose.p, pose.R)
            for word in words:
                self.take(word)
                if word == "position":
                    frame.p = self.point(pose)
                else:
                    frame.R = self.matrix(pose)
            frames.append(frame)
        return (nodes[0], nodes[1]), (frames[0], frames[1])

    def clamp(self) -> None:
        assert self.names[self.label(self.nodes)] == "seat"
        self.take("node")
        self.take("node")

    def total_joint(self) -> None:
        (lower, upper), (one, two) = self.ends("position", "position orientation")
        self.take("position constraint")
        away = one.R.T @ (two.p - one.p)
        for axis in range(3):
            if self.take("active", "inactive") == "active":
                self.rigid.append((lower, upper, one.R[:, axis], two.p))
                self.misfits.append(away[axis])
        self.take("null")

    def revolute_rotation(self) -> None:
        (lower, upper), (one, two) = self.ends("orientation")
        for axis in range(2):
            self.rigid.append((lower, upper, one.R[:, axis], None))
            self.misfits.append(one.R[:, axis] @ two.R[:, 2])

    def cardano_rotation(self) -> None:
        (lower, upper), (one, two) = self.ends("orientation")
        self.rigid.append((lower, upper, np.cross(one.R[:, 2], two.R[:, 1]), None))
        self.misfits.append(one.R[:, 2] @ two.R[:, 1])

    def deformable_joint(self) -> None:
        nodes, frames = self.ends("position", "orientation")
        self.take("linear viscoelastic generic")
        self.take("diag")
        stiffness = self.floats(6)
        self.take("diag")
        damping = self.floats(6)
        prestress = self.floats(6) if self.maybe("prestress") else np.zeros(6)
        self.take("prestrain")
        self.take("single")
        prestrain = self.floats(6)
        self.take("const")
        assert float(self.take()) == 1.0
        self.springs.append(Deformable(nodes, frames, stiffness, damping, prestrain, prestress))


class Case:
    def __init__(self, name: str, folder: Path) -> None:
        problem = pik.load_problem(name)
        self.posture = pik.solve_posture(pik.build_body(problem.subject), problem)
        self.folder = folder
        write_mbdyn(self.posture, folder)
        self.deck = Deck(folder)


@pytest.fixture(scope="module", params=EXAMPLES)
def case(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Case:
    return Case(request.param, tmp_path_factory.mktemp(request.param))


def spring_wrenches(deck: Deck) -> dict[int, np.ndarray]:
    """Force and moment of all springs on each node, at the node, (6,)."""
    found = {label: np.zeros(6) for label in deck.nodes}
    for joint in deck.springs:
        force, moment, point = joint.loads()
        for sign, label in zip((1.0, -1.0), joint.nodes, strict=True):
            arm = point - deck.nodes[label].p
            found[label] += sign * np.concatenate([force, moment + np.cross(arm, force)])
    return found


def test_every_label_counts_and_every_body_is_where_it_is(case: Case) -> None:
    deck, posture = case.deck, case.posture
    assert deck.counts["structural nodes"] == len(deck.nodes)
    assert deck.counts["rigid bodies"] == len(deck.bodies)
    assert deck.counts["joints"] == len(deck.joints)
    assert deck.counts["forces"] == len(deck.loads)
    names = [deck.names[label] for label in deck.nodes]
    assert Counter(names).most_common(1)[0][1] == 1
    assert {"seat", "S1", "L4", "T2", "Head", "humerus_r", "hand_l"} <= set(names)
    for label, pose in deck.nodes.items():
        expected = posture.frames[deck.names[label]]
        np.testing.assert_allclose(pose.p, expected.translation, atol=1e-12)
        np.testing.assert_allclose(pose.R, expected.rotation, atol=1e-12)


def test_masses_are_the_persons(case: Case) -> None:
    """Mass, its centre, and the inertia about it, all of the body against Pinocchio's."""
    model, data = case.posture.body.model, case.posture.body.model.createData()
    pin.ccrba(model, data, case.posture.q, np.zeros(model.nv))
    parts = case.deck.bodies.values()
    mass = sum(part[1] for part in parts)
    centre = sum(part[1] * part[2] for part in parts) / mass
    tensor = sum(
        part[3] - part[1] * pin.skew(part[2] - centre) @ pin.skew(part[2] - centre)
        for part in parts
    )
    assert mass == pytest.approx(data.Ig.mass, rel=1e-12)
    np.testing.assert_allclose(centre, data.com[0], atol=1e-12)
    np.testing.assert_allclose(tensor, data.Ig.inertia, atol=1e-10)


def test_rigid_directions_are_met(case: Case) -> None:
    """87 of the 6 a body are rigid, 117 are left: those of the posture."""
    assert len(case.deck.rigid) == 6 * (len(case.deck.nodes) - 1) - len(case.posture.q)
    np.testing.assert_allclose(case.deck.misfits, 0.0, atol=1e-12)


def test_springs_do_the_work_of_the_prestrain(case: Case) -> None:
    """Virtual work by Pinocchio's Jacobians: along each coordinate what its spring and limit do."""
    posture, model = case.posture, case.posture.body.model
    data = model.createData()
    pin.computeJointJacobians(model, data, posture.q)
    pin.framesForwardKinematics(model, data, posture.q)
    generalized = np.zeros(model.nv)
    for label, wrench in spring_wrenches(case.deck).items():
        frame = model.getFrameId(case.deck.names[label], pin.FrameType.BODY)
        jacobian = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
        generalized += jacobian.T @ wrench
    expected = posture.prestrain_force - posture.limit_multipliers
    np.testing.assert_allclose(generalized, expected, atol=1e-8)


def test_stiffness_and_damping_are_the_postures(case: Case) -> None:
    posture = case.posture
    for name in ("stiffness", "damping"):
        written = np.concatenate([getattr(joint, name) for joint in case.deck.springs])
        expected = posture.stiffness if name == "stiffness" else posture.body.damping
        assert sorted(written[written > 0.0]) == pytest.approx(sorted(expected), rel=1e-12)


def test_every_body_is_in_equilibrium(case: Case) -> None:
    """Springs, tasks and weight leave only what the rigid directions can carry, body by body."""
    deck = case.deck
    rows = {label: 6 * i for i, label in enumerate(list(deck.nodes)[1:])}
    load = np.zeros(6 * len(rows))

    def push(target: np.ndarray, label: int, force: np.ndarray, point: np.ndarray | None) -> None:
        if label not in rows:
            return  # the seat
        i = rows[label]
        if point is None:
            target[i + 3 : i + 6] += force
        else:
            target[i : i + 3] += force
            target[i + 3 : i + 6] += np.cross(point - deck.nodes[label].p, force)

    for label, wrench in spring_wrenches(deck).items():
        push(load, label, wrench[:3], deck.nodes[label].p)
        push(load, label, wrench[3:], None)
    for node, value, point in deck.loads.values():
        push(load, node, value, point)
    for node, mass, centre, _ in deck.bodies.values():
        push(load, node, mass * deck.gravity, centre)
    reactions = np.zeros((len(load), len(deck.rigid)))
    for column, (lower, upper, direction, point) in zip(reactions.T, deck.rigid, strict=True):
        push(column, lower, direction, point)
        push(column, upper, -direction, point)
    carried, *_ = np.linalg.lstsq(reactions, -load)
    np.testing.assert_allclose(load + reactions @ carried, 0.0, atol=1e-6)
    assert np.any(deck.gravity) == case.posture.problem.posture.gravity


def test_limits_that_carry_become_prestress(tmp_path: Path) -> None:
    case = Case("pilot", tmp_path)
    assert case.posture.active_limits
    stressed = [joint for joint in case.deck.springs if np.any(np.abs(joint.prestress) > 1e-9)]
    assert 0 < len(stressed) <= len(case.posture.active_limits)


def test_hinges_that_do_not_meet_are_refused(tmp_path: Path) -> None:
    problem = pik.load_problem("upright")
    text = pik.build_body(problem.subject).urdf
    shifted = re.sub(
        r'(<joint name="L4_L5_rx".*?<origin xyz=")0.0', r"\g<1>0.01", text, count=1, flags=re.S
    )
    assert shifted != text
    (tmp_path / "mine.urdf").write_text(shifted)
    subject = pik.Subject(urdf=tmp_path / "mine.urdf")
    problem = problem.model_copy(update={"subject": subject})
    posture = pik.solve_posture(pik.build_body(subject), problem)
    with pytest.raises(BadURDF, match=r"mine\.urdf: joint 'L4_L5_rz' does not fit"):
        write_mbdyn(posture, tmp_path)


MBDYN = shutil.which("mbdyn")


@pytest.mark.skipif(MBDYN is None, reason="MBDyn is not installed: its own verdict is left out")
def test_mbdyn_agrees_that_nothing_moves(case: Case, tmp_path: Path) -> None:
    """Accelerations (m/s², rad/s²) at the start, and the way gone after 0.1 s (m), are nil."""
    run = subprocess.run(
        [str(MBDYN), "-s", "-f", "posture.mbd", "-o", str(tmp_path / "moved")],
        cwd=case.folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    lines = (tmp_path / "moved.mov").read_text().splitlines()
    rows = [[float(word) for word in line.split()] for line in lines]
    dynamic = np.array([row for row in rows if len(row) == 19])
    steps = dynamic.reshape(-1, len(case.deck.nodes) - 1, 19)
    np.testing.assert_allclose(steps[0, :, 13:], 0.0, atol=1e-5)
    np.testing.assert_allclose(steps[-1, :, 1:4], steps[0, :, 1:4], atol=1e-9)
