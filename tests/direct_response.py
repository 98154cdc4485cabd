"""Frequency responses and modes of a linear system by the plainest means, to check others by."""

import numpy as np
import scipy.linalg


def response(system, frequencies, inputs, outputs):
    """Outputs over inputs as displacements, (f, r, p): one dense solve a frequency."""
    i = [[port.name for port in system.inputs].index(name) for name in inputs]
    o = [[port.name for port in system.outputs].index(name) for name in outputs]
    found = []
    for s in 2j * np.pi * np.asarray(frequencies, dtype=float):
        powers = s ** np.arange(3)
        B, Y, D = (np.tensordot(powers, matrix, 1) for matrix in (system.B, system.Y, system.D))
        dynamic = system.stiffness + s * system.damping + s**2 * system.mass
        found.append((Y @ np.linalg.solve(dynamic, B[:, i]) + D[:, i])[o])
    return np.array(found)


def over_acceleration(system, frequencies, given, read):
    """Magnitude of one output over one input's acceleration, (f,)."""
    found = response(system, frequencies, [given], [read])[:, 0, 0]
    return np.abs(found) / (2 * np.pi * np.asarray(frequencies)) ** 2


def peak(frequencies, values):
    """The largest value and its frequency, by a parabola through three samples."""
    i = int(np.argmax(values))
    assert 0 < i < len(values) - 1, "the peak lies at the end of the band"
    a, b, c = np.polyfit(frequencies[i - 1 : i + 2] - frequencies[i], values[i - 1 : i + 2], 2)
    return c - b**2 / (4 * a), frequencies[i] - b / (2 * a)


def modes(system, most=None):
    """Undamped frequencies, Hz, and whether each is symmetric about the sagittal plane."""
    which = None if most is None else [0, most - 1]
    squares, shapes = scipy.linalg.eigh(system.stiffness, system.mass, subset_by_index=which)
    odd = np.array([name.split()[-1] in ("y", "rx", "rz") for name in system.coordinates])
    mirror = np.einsum("in,ij,jn->n", shapes, system.mass, np.where(odd, -1, 1)[:, None] * shapes)
    return np.sqrt(squares) / (2 * np.pi), mirror > 0
