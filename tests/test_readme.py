"""The Python example of README.md runs as printed."""

import re
from pathlib import Path

import pytest

README = Path(__file__).parent.parent / "README.md"


def test_python_example_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    assert len(example.splitlines()) <= 12, "the example is meant to be ten lines"
    monkeypatch.chdir(tmp_path)
    exec(compile(example, str(README), "exec"), {})
    assert " J in " in capsys.readouterr().out
    assert (tmp_path / "report.html").stat().st_size > 0
    assert (tmp_path / "posture.nc").stat().st_size > 0
