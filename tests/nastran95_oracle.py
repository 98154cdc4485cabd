"""NASTRAN-95 as an oracle: it runs a deck and its printed results are read.

Its wheel wants Python 3.12 or 3.13. `POSTURE_IK_NASTRAN95` names such a Python that has it.
"""

import os
import re
import subprocess

import numpy as np
import pytest

PYTHON = os.environ.get("POSTURE_IK_NASTRAN95")
needed = pytest.mark.skipif(
    PYTHON is None,
    reason="needs NASTRAN-95: pip install nastran95 into Python 3.12 or 3.13 and name that "
    "Python in POSTURE_IK_NASTRAN95",
)
_RUN = "import sys, nastran95; print(nastran95.run(sys.stdin.read()).output)"
_NUMBER = r"-?\d\.\d+E[+-]\d+"


def run(deck):
    """What NASTRAN-95 prints of a deck."""
    done = subprocess.run(
        [str(PYTHON), "-I", "-c", _RUN], input=deck, capture_output=True, text=True, check=True
    )
    fatal = re.search(r"^.*FATAL.*(\n.*){2}", done.stdout, re.MULTILINE)
    assert fatal is None, fatal[0]
    return done.stdout


def frequencies(printed):
    """Frequencies of the modes, Hz."""
    row = rf"^ +\d+ +\d+ +{_NUMBER} +{_NUMBER} +({_NUMBER}) +{_NUMBER} +{_NUMBER} *$"
    return np.array(re.findall(row, printed, re.MULTILINE), dtype=float)


def shapes(printed):
    """Mode shapes by mode number and grid, (6,)."""
    found, mode = {}, 0
    for line in printed.splitlines():
        if heading := re.search(r"E I G E N V E C T O R   N O \. +(\d+)", line):
            mode = int(heading[1])
        if mode and (row := re.match(rf"^ +(\d+) +G +({_NUMBER}.*)$", line)):
            found[mode, int(row[1])] = np.array(row[2].split(), dtype=float)
    return found


def accelerations(printed):
    """Frequencies, (F,), and complex accelerations, (F, 6), by subcase and grid."""
    found, case, grid, real = {}, 0, 0, None
    for line in printed.splitlines():
        if heading := re.search(r"SUBCASE (\d+)", line):
            case = int(heading[1])
        if heading := re.search(r"POINT-ID = +(\d+)", line):
            grid = int(heading[1])
        if row := re.match(rf"^0? +({_NUMBER}) +G +(.*)$", line):
            at, real = float(row[1]), np.array(row[2].split(), dtype=float)
        elif real is not None:
            value = real + 1j * np.array(line.split(), dtype=float)
            found.setdefault((case, grid), []).append((at, value))
            real = None
    return {
        key: (np.array([at for at, _ in rows]), np.array([value for _, value in rows]))
        for key, rows in found.items()
    }
