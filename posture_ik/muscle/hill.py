"""Force of a muscle by its length, rate and activation: Hill's law in two forms (eqs 30, 31).

Both laws are affine in the activation, f = f_passive + a df/da, and both take the tendon as rigid.

Which length is meant. Eq 31 writes x = l/l0 and says of l0 only that the peak force is produced
there; its curves are those of fibres (x from 0.5 to 1.5 and back to nothing), while the numbers
that go with it are those of fibres in series with a tendon. Taken of the whole path, with l0 the
optimal fibre length plus the tendon's, x of a wrist muscle would hardly leave 0.9 to 1.1 and its
force neither fall off nor its passive part rise. So x is of the fibres: with a tendon as long as
its slack length l_s,

    x = (l - l_s) / l0,   l0 = l_opt cos(alpha),

path length l, optimal fibre length l_opt, and alpha the pennation there, so that x = 1 is where
the fibres of a pennate muscle have their optimal length too.

The formulas are written once, for numbers and for CasADi's symbols: `math` is the module whose
functions they call, `numpy` or `casadi`, of names that both have. A comparison counts as 0 or 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np

from posture_ik.arrays import Array


class Fibres(Protocol):
    """What a law asks of the muscles; arrays over them, (m,)."""

    @property
    def peak_force(self) -> Array:
        """Isometric force at optimal length, N."""

    @property
    def optimal_length(self) -> Array:
        """Fibre length where that is reached, m."""

    @property
    def slack_length(self) -> Array:
        """Length of the tendon, m."""

    @property
    def pennation(self) -> Array:
        """Angle of the fibres to the tendon at their optimal length, rad."""

    @property
    def fastest(self) -> Array:
        """Rate v0 at which the fibres shorten without load, m/s."""


class Force(NamedTuple):
    """Forces along the paths and their derivatives, arrays over muscles (..., m).

    `force` (N) pulls; `d_length` (N/m), `d_rate` (N s/m) and `d_activation` (N) are its partial
    derivatives. `passive` (N) and `d_passive` (N/m) are what it and `d_length` are at rest, a = 0:
    a passive force does not ask how fast it is stretched.
    """

    force: Array
    d_length: Array
    d_rate: Array
    d_activation: Array
    passive: Array
    d_passive: Array


class Law(Protocol):
    """A muscle law: forces from path lengths (m), their rates (m/s, positive lengthening), a."""

    def __call__(
        self, muscles: Fibres, length: Array, rate: Array, activation: Array, math: Any = np
    ) -> Force:
        """Forces and derivatives, arrays over muscles (..., m); of symbols with `casadi`."""


def working_length(muscles: Fibres, math: Any = np) -> Array:
    """Length l0 along the path that x of either law is counted in, (m,), m."""
    length: Array = muscles.optimal_length * math.cos(muscles.pennation)
    return length


def pennestri(
    muscles: Fibres, length: Array, rate: Array, activation: Array, math: Any = np
) -> Force:
    """The law of Pennestrì et al. (2007), J. Biomech. 40:1350, as corrected (eqs 30, 31).

    f = f0 [f1(x) f2(v) a + f3(x)] with x = (l - l_s)/l0 and v = l'/v0, positive lengthening;

        f1 = exp(-40 (x - 0.95)⁴ + (x - 0.95)²)
        f2 = 1.6 - 1.6 exp(0.1/(1 - v)² - 1.1/(1 - v)⁴), 1.6 for v >= 1
        f3 = 1.3 atan(0.1 (x - 0.22)¹⁰), 0 for x <= 0.22

    The even power of f3 would have slack muscles push a tendon apart; from its double root down it
    is held at 0, smooth to the ninth derivative. f2 comes to nothing at v = -2.3, more than twice
    the fastest shortening, and stays within 0.004 of it.
    """
    l0 = working_length(muscles, math)
    x = (length - muscles.slack_length) / l0
    s = x - 0.95
    s2 = s * s
    f1 = math.exp(s2 - 40 * s2 * s2)
    df1 = f1 * s * (2 - 160 * s2)

    # At 1 - v = 0.1 the exponential has long vanished in double precision, slopes and all.
    u = 1 / math.fmax(1 - rate / muscles.fastest, 0.1)
    u2 = u * u
    vanishing = 1.6 * math.exp(u2 * (0.1 - 1.1 * u2))
    f2 = 1.6 - vanishing
    df2 = vanishing * u * u2 * (4.4 * u2 - 0.2)

    p = math.fmax(x - 0.22, 0.0)
    p3 = p * p * p
    p9 = p3 * p3 * p3
    bent = 0.1 * p9 * p
    f3 = 1.3 * math.atan(bent)
    df3 = 1.3 * p9 / (1 + bent * bent)

    f0 = muscles.peak_force
    return Force(
        force=f0 * (f1 * f2 * activation + f3),
        d_length=f0 * (df1 * f2 * activation + df3) / l0,
        d_rate=f0 * f1 * df2 * activation / muscles.fastest,
        d_activation=f0 * f1 * f2,
        passive=f0 * f3,
        d_passive=f0 * df3 / l0,
    )


#: Height, centre, width and its growth with x of the three bells that make up the active curve.
_BELLS = (
    (0.8150671134243542, 1.055033428970575, 0.162384573599574, 0.063303448465465),
    (0.433004984392647, 0.716775413397760, -0.029947116970696, 0.200356847296188),
    (0.1, 1.0, np.sqrt(0.125), 0.0),
)
#: Of the curve over velocity, with the first and the last such that it meets (-1, 0) and (0, 1).
_D1, _D2, _D3, _D4 = -0.3211346127989808, -8.149, -0.374, 0.8825327733249912
#: Passive: steepness, strain at peak force, and the length below which there is none.
_STEEPNESS, _STRAIN, _SHORTEST = 4.0, 0.6, 0.2
#: Fibres are never shorter along the tendon than this, m: slack ones keep a direction.
_SLACK = 1e-6


def de_groote(
    muscles: Fibres, length: Array, rate: Array, activation: Array, math: Any = np
) -> Force:
    """The usual pennate muscle on a rigid tendon, with the curves of De Groote et al. (2016).

    f = f0 [a fl(x) fv(v) + fp(x)] cos(alpha): fibres of length l_m lie at an angle alpha to the
    tendon and keep their height, l_m sin(alpha) = l_opt sin(alpha_opt), as in Millard et al.
    (2013), J. Biomech. Eng. 135:021005; x = l_m/l_opt and v = l' cos(alpha)/v0. The curves are
    the closed forms of De Groote et al. (2016), Ann. Biomed. Eng. 44:2922, with the coefficients
    that opensim-core (Apache-2.0) corrected. fv is held at 0 below v = -1, where it would push,
    and fp below x = 0.2; both have a kink there.
    """
    lo = muscles.optimal_length
    free = length - muscles.slack_length
    taut = free >= _SLACK
    along, height = math.fmax(free, _SLACK), lo * math.sin(muscles.pennation)
    fibre = math.hypot(along, height)
    cos = along / fibre
    dcos = taut * height**2 / fibre**3
    x, dx = fibre / lo, taut * cos / lo
    v, dv = rate * cos / muscles.fastest, rate * dcos / muscles.fastest

    fl, dfl = 0 * x, 0 * x
    for high, centre, width, growth in _BELLS:
        spread = width + growth * x
        spread = spread + (math.fabs(spread) < 1e-3) * (1e-3 - spread)  # by then the bell is 0
        z = (x - centre) / spread
        bell = high * math.exp(-(z**2) / 2)
        fl += bell
        dfl -= bell * z * (1 - growth * z) / spread

    y = _D2 * v + _D3
    fv = _D1 * math.asinh(y) + _D4
    dfv = (fv > 0) * (_D1 * _D2) / math.hypot(y, 1.0)
    fv = math.fmax(fv, 0.0)

    floor, whole = np.exp(_STEEPNESS * (_SHORTEST - 1) / _STRAIN), np.exp(_STEEPNESS)
    rising = math.exp(_STEEPNESS * (math.fmax(x, _SHORTEST) - 1) / _STRAIN)
    fp = (rising - floor) / (whole - floor)
    dfp = (x > _SHORTEST) * (_STEEPNESS / _STRAIN / (whole - floor)) * rising

    f0 = muscles.peak_force
    passive, d_passive = f0 * fp * cos, f0 * (fp * dcos + dfp * dx * cos)
    d_active = dfl * dx * fv * cos + fl * dfv * dv * cos + fl * fv * dcos
    return Force(
        force=f0 * fl * fv * cos * activation + passive,
        d_length=f0 * d_active * activation + d_passive,
        d_rate=f0 * fl * dfv * cos**2 * activation / muscles.fastest,
        d_activation=f0 * fl * fv * cos,
        passive=passive,
        d_passive=d_passive,
    )


#: The laws by the names a problem file may use.
LAWS: Mapping[str, Law] = {"pennestri": pennestri, "de_groote": de_groote}
