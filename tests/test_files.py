"""Folders are written whole or not at all."""

from __future__ import annotations

from pathlib import Path

import pytest

from posture_ik.errors import UnwritableOutput
from posture_ik.files import whole_folder


def test_files_arrive_together_and_leave_others_alone(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "notes.txt").write_text("mine")
    (tmp_path / "out" / "a.txt").write_text("old")
    with whole_folder(tmp_path / "out") as scratch:
        (scratch / "a.txt").write_text("new")
        (scratch / "deep").mkdir()
        (scratch / "deep" / "b.txt").write_text("b")
        assert (tmp_path / "out" / "a.txt").read_text() == "old"
    found = {p.relative_to(tmp_path / "out").as_posix() for p in (tmp_path / "out").rglob("*")}
    assert found == {"notes.txt", "a.txt", "deep", "deep/b.txt"}
    assert (tmp_path / "out" / "a.txt").read_text() == "new"


def test_an_error_leaves_nothing(tmp_path: Path) -> None:
    def fail_half_way() -> None:
        with whole_folder(tmp_path / "new" / "deep") as scratch:
            (scratch / "a.txt").write_text("half")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail_half_way()
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_the_way_is_said(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("mine")
    with (
        pytest.raises(UnwritableOutput, match=r"taken/deep: cannot write here"),
        whole_folder(tmp_path / "taken" / "deep"),
    ):
        pass
    assert (tmp_path / "taken").read_text() == "mine"
