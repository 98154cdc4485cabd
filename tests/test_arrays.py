"""CasADi functions called through buffers against CasADi's own calls."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from posture_ik.arrays import call


def test_call_gives_what_casadi_gives() -> None:
    """Matrices by columns, columns flat, nothing for an empty result; the same bits."""
    x, y = ca.SX.sym("x", 3), ca.SX.sym("y", 2, 3)
    outputs = [y @ x, y.T, ca.SX(0, 1), ca.dot(x, x)]
    function = ca.Function("f", [x, y], outputs)
    a, b = np.array([1.0, 2.0, 3.5]), np.arange(6.0).reshape(2, 3) ** 2
    product, turned, nothing, square = call(function, a, b)
    expected = [value.full() for value in function(a, b)]
    np.testing.assert_array_equal(product, expected[0].ravel())
    np.testing.assert_array_equal(turned, expected[1])
    assert nothing.shape == (0,)
    assert square == expected[3].item()


def test_a_sparse_result_is_refused() -> None:
    x = ca.SX.sym("x", 2)
    with pytest.raises(ValueError, match="f gives a sparse"):
        call(ca.Function("f", [x], [ca.diag(x)]), np.ones(2))
