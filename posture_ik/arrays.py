"""The one array type: real numbers in double precision; shapes are told where it is used."""

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
