"""Nastran decks: run by NASTRAN-95, and read back by pyNastran and rebuilt with SciPy."""

import io
import re
from types import SimpleNamespace

import nastran95_oracle as nastran95
import numpy as np
import pytest
import scipy.linalg
import scipy.sparse
from direct_response import modes, response
from pyNastran.bdf.bdf import BDF
from pyNastran.bdf.mesh_utils.mass_properties import mass_properties

import posture_ik as pik
from posture_ik.body.tables import table
from posture_ik.exchange import DECKS, write_nastran
from posture_ik.problem import (
    COMPONENTS,
    Cushion,
    FoamBack,
    RigidBack,
    Seat,
    Subject,
    VibrationBlock,
)
from posture_ik.vibration import build_finite_element
from posture_ik.vibration.spine_elements import spine_elements

SEATS = {
    "bare": Seat(),
    "reclined on a cushion": Seat(recline_deg=20.0, cushion=Cushion()),
    "foam": Seat(recline_deg=15.0, backrest=FoamBack(), cushion=Cushion()),
    "rigid": Seat(
        recline_deg=30.0, backrest=RigidBack(tangential_stiffness=5e3, tangential_damping=500.0)
    ),
}
FREQUENCIES = {"start": 0.5, "stop": 18.0, "step": 3.5}
GRIDS = {name: int(row["id"]) for name, row in table("table_8_nodes").items()}


@pytest.fixture(scope="module", params=SEATS)
def case(request, tmp_path_factory):
    """A person on one of the seats, our model of it, and both dialects' decks."""
    stated = pik.load_problem("upright").model_copy(
        update={
            "seat": SEATS[request.param],
            "subject": Subject(weight=70.0, stature=1.7),
            "vibration": VibrationBlock(frequencies=FREQUENCIES),
        }
    )
    folder = tmp_path_factory.mktemp("decks")
    for dialect in DECKS:
        write_nastran(stated, folder, dialect)
    seat = stated.seat
    given = stated.subject, np.radians(seat.recline_deg), seat.backrest, seat.cushion
    return SimpleNamespace(
        problem=stated,
        folder=folder,
        elements=spine_elements(*given),
        system=build_finite_element(*given),
    )


@nastran95.needed
def test_modes_are_nastran_95s(case):
    """Its cards are read in single precision: seven digits; forty modes agree to 1e-6."""
    printed = nastran95.run((case.folder / "modes.inp").read_text())
    found, ours = nastran95.frequencies(printed)[:40], modes(case.system, 40)[0]
    np.testing.assert_allclose(found[:14], ours[:14], rtol=1e-5)
    np.testing.assert_allclose(found, ours, rtol=1e-4)
    shapes = nastran95.shapes(printed)
    _, vectors = scipy.linalg.eigh(case.system.stiffness, case.system.mass, subset_by_index=[0, 13])
    at = [name.split() for name in case.system.coordinates]
    rows = [i for i, (body, _) in enumerate(at) if GRIDS.get(body, 99) <= GRIDS["S1"]]
    for mode in range(14):
        shape = [shapes[mode + 1, GRIDS[at[i][0]]][COMPONENTS.index(at[i][1])] for i in rows]
        vector = vectors[rows, mode]
        both = (vector @ shape) ** 2 / (vector @ vector) / np.dot(shape, shape)
        assert both == pytest.approx(1.0, abs=1e-6)  # modal assurance criterion


@nastran95.needed
def test_response_is_nastran_95s(case):
    """Head and seat force within 1e-3 of the largest component at each frequency.

    NASTRAN-95 substitutes in single precision, and its stiffest springs that are left, of 2e6 N/m,
    bear on a person whose softest mode has some 400 N/m.
    """
    deck = (case.folder / "response.inp").read_text()
    moved = nastran95.accelerations(nastran95.run(deck))
    cushion = re.search(r"^\$ ---- cushion, .*\nGRID +(\d+)", deck, re.MULTILINE)
    base = case.elements.nodes[0].name
    for number, component in enumerate("xyz", 1):
        frequencies, head = moved[number, GRIDS["Head"]]
        np.testing.assert_allclose(frequencies, 0.5 + 3.5 * np.arange(6), rtol=1e-6)
        names = [f"{what} {c}" for what in ("Head acceleration", "seat force") for c in COMPONENTS]
        ours = response(case.system, frequencies, [f"{base} {component}"], names)[:, :, 0]
        omega = 2 * np.pi * frequencies[:, None]
        ours /= -(omega**2)
        _close(head + np.eye(6)[number - 1], ours[:, :6])
        under = moved[number, int(cushion[1])] if cushion else None
        _close(_seat_force(case.elements, moved[number, GRIDS["S1"]], under), ours[:, 6:9])


def _close(found, ours):
    assert np.max(np.abs(found - ours) / np.max(np.abs(ours), axis=1, keepdims=True)) < 1e-3


def _seat_force(elements, sacrum, cushion):
    """Force of the buttocks' springs and dampers, (F, 3), by how far their ends moved."""
    iw = 2j * np.pi * sacrum[0][:, None]
    below = cushion[1][:, :3] if cushion else 0.0
    at = next(node.point for node in elements.nodes if node.name == "S1")
    force = np.zeros((len(iw), 3), dtype=complex)
    for link in elements.below:
        rotated = np.cross(sacrum[1][:, 3:], link.point - at)
        stretch = (sacrum[1][:, :3] + rotated - below) / iw**2
        force -= (link.stiffness[:3] + iw * link.damping[:3]) * stretch
    return force


def test_cards_say_what_the_person_is(case):
    """Masses by pyNastran's own sum; every link has its springs and dampers."""
    for name in DECKS["nastran"]:
        model = BDF(debug=None)
        model.read_bdf(case.folder / name)
        mass, centre, _ = mass_properties(model)
        lumps = [(lump.mass, lump) for lump in case.elements.lumps]
        assert mass == pytest.approx(sum(m for m, _ in lumps), rel=1e-9)
        points = {node.name: node.point for node in case.elements.nodes}
        moment = sum(m * (points[lump.node] + lump.centre) for m, lump in lumps)
        np.testing.assert_allclose(centre, moment / mass, atol=1e-9)
        counts = model.card_count
        springs = sum(len(link.sprung) for link in case.elements.every_link)
        for card in ("CELAS1", "PELAS", "CDAMP1", "PDAMP"):
            assert counts[card] == springs
        assert counts["CONM2"] == len(lumps)
        assert counts.get("RBE3", 0) == (case.elements.back is not None)
    assert [counts[card] for card in ("SPCD", "RLOAD1", "DLOAD", "FREQ1", "EIGRL")] == [
        3,
        3,
        3,
        1,
        1,
    ]
    assert model.sol == 111


def test_cards_make_our_modes(case):
    """The deck assembled by a second code: all modes below 50 Hz to 1e-6.

    Shear of 1e10 N/m leaves six digits of the lowest.
    """
    model = BDF(debug=None)
    model.read_bdf(case.folder / "modes.bdf")
    M, K = _assembled(model)
    ours = modes(case.system, 40)[0]
    squares = scipy.linalg.eigh(K, M, eigvals_only=True, subset_by_index=[0, 39])
    np.testing.assert_allclose(np.sqrt(squares) / (2 * np.pi), ours, rtol=1e-5)


def _assembled(model):
    """Mass and stiffness of a deck, in its grids' own axes, by the equations of its cards."""
    grids = sorted(model.nodes)
    first = {grid: 6 * i for i, grid in enumerate(grids)}
    n = 6 * len(grids)
    point = {grid: model.nodes[grid].get_position() for grid in grids}
    own = {grid: np.kron(np.eye(2), model.coords[model.nodes[grid].Cd()].beta()) for grid in grids}

    def carried(lead, to):
        """Motion of what `lead` carries at a point, in basic axes, by its six components."""
        x, y, z = to - point[lead]
        link = np.eye(6)
        link[:3, 3:] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
        return link @ own[lead].T

    rows, held = [], []
    for card in model.rigid_elements.values():
        if card.type == "RBE2":
            lead, (follower,) = card.gn, card.Gmi
            each = own[follower] @ carried(lead, point[follower])
            for c in (int(digit) - 1 for digit in card.cm):
                rows.append([(first[lead] + j, each[c, j]) for j in range(6)])
                rows[-1].append((first[follower] + c, -1.0))
                held.append(first[follower] + c)
            continue
        mean, (of,) = card.refgrid, card.Gijs
        square = np.mean([np.linalg.norm(point[grid] - point[mean]) for grid in of]) ** 2
        weight = np.diag([1, 1, 1, square, square, square])
        rigid = [own[mean].T @ carried(mean, point[grid]).T for grid in of]
        normal = sum(r @ weight @ r.T for r in rigid)
        for c in range(6):
            row = [(first[mean] + c, -1.0)]
            for r, grid in zip(rigid, of, strict=True):
                part = own[mean] @ np.linalg.solve(normal, r @ weight) @ own[grid].T
                row += [(first[grid] + j, part[c, j]) for j in range(6)]
            rows.append(row)
        hanging = card.Gmi[0] if card.Gmi else mean
        held += [first[hanging] + c for c in range(6)]
    A = scipy.sparse.lil_matrix((len(rows), n))
    for i, row in enumerate(rows):
        for j, value in row:
            A[i, j] += value
    A = A.tocsc()
    fixed = [
        first[spc.nodes[0]] + c for spcs in model.spcs.values() for spc in spcs for c in range(6)
    ]
    free = np.setdiff1d(np.arange(n), [*held, *fixed])
    T = np.zeros((n, len(free)))
    T[free, np.arange(len(free))] = 1.0
    T[held] = -scipy.sparse.linalg.spsolve(A[:, held], A[:, free]).toarray()

    M, K = np.zeros((len(free),) * 2), np.zeros((len(free),) * 2)
    for card in model.masses.values():
        grid = card.nid
        motion = carried(grid, point[grid] + card.X) @ T[first[grid] : first[grid] + 6]
        M += motion.T @ scipy.linalg.block_diag(card.mass * np.eye(3), card.Inertia()) @ motion
    for card in model.elements.values():
        if card.type == "CELAS1":
            (one, two), k = card.nodes, model.properties[card.pid].k
            stretch = T[first[two] + card.c2 - 1] - T[first[one] + card.c1 - 1]
            K += k * np.outer(stretch, stretch)
    return M, K


def test_a_single_frequency_and_an_odd_title_are_written(tmp_path):
    stated = pik.load_problem("upright").model_copy(
        update={
            "title": "Größe {x}",
            "vibration": VibrationBlock(frequencies={"start": 2.0, "stop": 2.0}),
        }
    )
    write_nastran(stated, tmp_path)
    model = BDF(debug=None)
    model.read_bdf(io.StringIO((tmp_path / "response.bdf").read_text()))
    assert model.frequencies[1][0].freqs == [2.0]
    assert model.case_control_deck.get_subcase_parameter(1, "TITLE")[0] == "Gr??e {x}: response"
