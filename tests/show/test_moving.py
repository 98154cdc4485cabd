"""What the 3D page's player is given: every instant, as the motion has it."""

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from posture_ik.body.laws import scale_of
from posture_ik.errors import UnwritableOutput
from posture_ik.kinematics import frame_poses
from posture_ik.problem import SPINE
from posture_ik.show import write_view
from posture_ik.show.arrows import arrows, turns
from posture_ik.show.looks import looks_of
from posture_ik.show.moving import (
    animation,
    followed,
    largest_wrenches,
    peak_parts,
    round_times,
    shown_steps,
)
from posture_ik.show.skin import skin
from posture_ik.show.strain import parts_of


def floats(text, *shape):
    return np.frombuffer(base64.b64decode(text), "<f4").reshape(shape)


@pytest.fixture(scope="module")
def played(sweep):
    looks = looks_of(sweep.body)
    parts = parts_of(sweep.postures[0], {look.link for look in looks})
    return animation(sweep, looks, peak_parts(sweep, parts))


@pytest.fixture(scope="module")
def page(sweep, tmp_path_factory):
    path = tmp_path_factory.mktemp("view") / "view.html"
    write_view(sweep, path)
    return path.read_text(encoding="utf-8")


def test_every_link_stands_where_the_motion_puts_it(sweep, played):
    poses = floats(played["poses"], len(sweep.time), len(played["paths"]), 7)
    for step in (0, 7, 20):
        for name in ("S1", "L3", "T4", "Head", "hand_r"):
            shown = pin.XYZQUATToSE3(
                poses[step, played["paths"].index(f"person/{name}")].astype(float)
            )
            assert shown.isApprox(sweep.postures[step].frames[name], 1e-6)
    assert np.all(np.sum(poses[1:, :, 3:] * poses[:-1, :, 3:], axis=2) > 0.9), "no sign flips"


def test_backrest_reclines_with_the_back(sweep, played):
    poses = floats(played["poses"], len(sweep.time), len(played["paths"]), 7)
    quaternions = poses[:, played["paths"].index("seat/backrest"), 3:]
    lean = np.degrees(-2 * np.arctan2(quaternions[:, 1], quaternions[:, 3]))
    asked = [posture.problem.seat.recline_deg for posture in sweep.postures]
    assert lean == pytest.approx(asked, abs=1e-4)


def test_skin_can_be_carried_to_where_it_is(sweep, played):
    """The page's rule, in numpy: each point goes with the two levels that it lies between."""
    given = played["skin"]
    rest, share = floats(given["rest"], -1, 3), floats(given["share"], -1, 1)
    lower = np.frombuffer(base64.b64decode(given["lower"]), "u1").astype(int)
    back = [pin.XYZQUATToSE3(p.astype(float)) for p in floats(given["poses"], len(SPINE), 7)]
    frames = sweep.postures[-1].frames
    assert [played["paths"][i] for i in given["levels"]] == [f"person/{name}" for name in SPINE]
    carried = [
        np.eye(4),
        *((frames[n] * b.inverse()).homogeneous for n, b in zip(SPINE, back, strict=True)),
    ]
    points = np.column_stack([rest, np.ones(len(rest))])
    below, above = (
        np.einsum("nij,nj->ni", np.array(carried)[lower + k], points)[:, :3] for k in (0, 1)
    )
    reference = frame_poses(sweep.body.model, sweep.body.q_reference)
    expected = skin(reference, frames, scale_of(sweep.body.subject).length["thoracic"][0]).vertices
    assert np.allclose((1 - share) * below + share * above, expected, atol=1e-6)


def test_arrows_keep_one_scale_through_the_motion(sweep, played):
    given = played["wrenches"]
    drawn = floats(given["drawn"], len(sweep.time), len(given["names"]), 9)
    lengths = np.linalg.norm(drawn[..., 3:6] - drawn[..., :3], axis=2)
    sizes = np.linalg.norm(sweep.forces, axis=2)
    assert lengths.max() == pytest.approx(0.30, abs=1e-6)
    seen = lengths > 0.061  # shorter arrows are all drawn 0.06 m long
    assert np.count_nonzero(seen) > 10
    assert lengths[seen] == pytest.approx(0.30 * sizes[seen] / sizes.max(), rel=1e-4)
    assert np.allclose(drawn[..., 3:6], sweep.points, atol=1e-6)
    assert set(given["lengths"]) == {"backrest", "seat"}
    force = sizes[10, given["names"].index("backrest")]
    assert given["loads"][10][0][0] == f"{force:.3g}"


def test_what_grows_to_be_drawn_is_in_the_drawing(sweep, page):
    wrenches = largest_wrenches(sweep)
    for arrow in arrows(wrenches):
        assert f"forces/{arrow.name}/force" in decoded(page)
    for turn in turns(wrenches):
        assert f"forces/{turn.name}/moment" in decoded(page)


def decoded(page):
    commands = json.loads(re.search(r"const commands = (\[.*?\]);\n", page).group(1))
    return "".join(base64.b64decode(c)[:200].decode("latin-1") for c in commands)


def test_parts_hold_the_most_energy_of_any_instant(sweep):
    parts = peak_parts(sweep, parts_of(sweep.postures[0], set(SPINE)))
    lumbar = [i for i, dof in enumerate(sweep.body.dofs) if dof.startswith("L4_L5")]
    most = max(posture.energies[lumbar].sum() for posture in sweep.postures)
    assert parts["L4"].energy == pytest.approx(most)


def test_only_what_goes_somewhere_is_followed(sweep):
    ways = followed(sweep)
    assert list(ways) == ["head", "right hand", "left hand"]
    assert ways["head"][-1] == pytest.approx(sweep.postures[-1].frames["Head"].translation)
    still = replace(sweep, postures=sweep.postures[:1] * 21)
    assert followed(still) == {}


@pytest.mark.parametrize(
    ("duration", "rate", "count"),
    [(2.0, 500, 121), (2.0, 10, 21), (60.0, 100, 900), (0.002, 500, 2)],
)
def test_shown_instants_are_even_and_at_most_sixty_a_second(duration, rate, count):
    time = np.arange(round(duration * rate) + 1) / rate
    steps = shown_steps(time)
    assert len(steps) == count
    assert (steps[0], steps[-1]) == (0, len(time) - 1)
    assert np.ptp(np.diff(steps)) <= 1


def test_ticks_are_round_and_few():
    assert round_times(np.linspace(0, 2, 99)).tolist() == pytest.approx([0, 0.5, 1, 1.5, 2])
    assert round_times(np.linspace(0, 1.55, 99)).tolist() == pytest.approx(np.arange(8) * 0.2)
    for span in (0.03, 0.7, 9.0, 600.0):
        assert 3 <= len(round_times(np.linspace(0, span, 50))) <= 9


def test_page_is_whole_small_and_needs_nothing_from_outside(page, sweep):
    markup = re.sub(r"<script>.*?</script>", "", page, flags=re.DOTALL)
    assert re.findall(r'(?:src|href)="(?!data:)', markup) == []
    assert "url(" not in page.split("</style>")[0]
    assert len(page) < 6_000_000
    text = " ".join(re.sub(r"<[^>]+>", " ", markup).split())
    assert sweep.problem.title in text
    assert "Lasts 2 s, 21 steps" in text
    assert "Backrest reclined 0° to 45°" in text


def test_unwritable_place_is_told_and_left_alone(sweep, tmp_path):
    (tmp_path / "file").write_text("kept")
    with pytest.raises(UnwritableOutput):
        write_view(sweep, tmp_path / "file" / "view.html")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
