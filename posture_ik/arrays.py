"""The one array type, real numbers in double precision, and CasADi functions called on arrays."""

from __future__ import annotations

from contextlib import AbstractContextManager
from functools import cache
from typing import Any, TypeAlias

import casadi as ca
import numpy as np
import numpy.typing as npt
from threadpoolctl import ThreadpoolController

Array: TypeAlias = npt.NDArray[np.float64]

#: Columns that LAPACK's `sytrf` is to factor at a time. Left alone SciPy asks for one, and each
#: rank-one update is shared among threads: for a hundred rows that takes twice as long on a quiet
#: machine, and a hundred times as long on a busy one.
BLOCK = 32


def call(function: ca.Function, *arguments: Array) -> list[Array]:
    """Call a CasADi function of dense arguments and results without CasADi's own conversions.

    These take 0.2 ms a call, longer than most functions here.

    Args:
        function: what to call.
        arguments: arrays of as many numbers as it takes.

    Returns:
        Its results, matrices (r, c) and columns (r,).

    Raises:
        ValueError: a result is sparse.
    """
    buffer: Any
    buffer, evaluate = function.buffer()
    numbers = [np.asarray(argument, dtype=float).ravel(order="F") for argument in arguments]
    shapes = [function.size_out(i) for i in range(function.n_out())]
    results = [np.empty(shape, order="F") for shape in shapes]
    for i, number in enumerate(numbers):
        buffer.set_arg(i, number.data)
    for i, result in enumerate(results):
        if result.size != function.nnz_out(i):
            raise ValueError(f"{function.name()} gives a sparse {function.name_out(i)}")
        if result.size:
            buffer.set_res(i, result.reshape(-1, order="F").data)
    evaluate()
    return [result[:, 0] if result.shape[1] == 1 else result for result in results]


def one_thread() -> AbstractContextManager[object]:
    """A block in which linear algebra keeps to one thread.

    Matrices of a few hundred rows are not worth sharing: on a busy machine the threads waiting for
    each other take ten times as long as the work.
    """
    limited: AbstractContextManager[object] = _pools().limit(limits=1, user_api="blas")
    return limited


@cache
def _pools() -> ThreadpoolController:
    return ThreadpoolController()
