"""How people are built: what is typical of a person, and people who never lived.

Fitted to ANSUR II, the 2012 survey of 4082 men and 1986 women of the US Army, each gender on its
own (`tools/fit_anthropometry.py`; the fit ships as `data/ansur_ii.json`, with how good it is):

    ln y = b0 + b1 (age − 30)/10 + b2 ln(stature / 1.80 m) + b3 ln(weight / 80 kg) + e,  e ~ N(0, Σ)

for each length y, with e joint over all of them, so that what is measured of a person tells of what
is not. Heights are above the seat. Age, stature and weight come together by a Gaussian copula with
the survey's own quantiles. Soldiers are of 17 to 58 years: age counts as 58 from there on. They are
neither as thin nor as heavy as people can be: beyond, the powers are extrapolated.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from scipy.special import ndtr

from posture_ik.arrays import Array

Gender = Literal["male", "female"]
#: What the regressions are centred on: years, m, kg.
AGE, STATURE, WEIGHT = 30.0, 1.80, 80.0
#: The youngest and the oldest age whose effect is known, years.
_AGES = (17.0, 58.0)
#: How many standard deviations off a length is taken for a slip.
_DEVIATIONS = 5.0
_FIT = Path(__file__).resolve().parent / "data" / "ansur_ii.json"


class Fit(NamedTuple):
    """What is fitted to one gender.

    Attributes:
        measures: Names of the k lengths.
        coefficients: b0 (ln m), b1, b2, b3 of each, (k, 4).
        covariance: Σ of the residuals, (k, k).
        people: `age`, `stature`, `weight`: their quantiles at `levels`; years, m, kg.
        levels: Shares of the gender, from 0 to 1.
        correlation: Of the normal scores of age, stature and weight, (3, 3).
    """

    measures: tuple[str, ...]
    coefficients: Array
    covariance: Array
    people: Mapping[str, Array]
    levels: Array
    correlation: Array

    @classmethod
    @cache
    def of(cls, gender: Gender) -> Fit:
        """The fit of a gender."""
        data = json.loads(_FIT.read_text(encoding="utf-8"))
        fit = data["genders"][gender]
        rows = fit["measures"]
        return cls(
            tuple(rows),
            np.array([row["coefficients"] for row in rows.values()]),
            np.array(fit["residual_covariance"]),
            {name: np.array(quantiles) for name, quantiles in fit["quantiles"].items()},
            np.array(data["levels"]),
            np.array(fit["correlation"]),
        )

    def mean(self, age: Array, stature: Array, weight: Array) -> Array:
        """Mean of ln y of n people (n,) each: (n, k)."""
        years = np.clip(age, *_AGES) - AGE
        terms = [
            np.ones_like(years),
            years / 10,
            np.log(stature / STATURE),
            np.log(weight / WEIGHT),
        ]
        return np.stack(terms, axis=-1) @ self.coefficients.T


def typical_measures(
    gender: Gender,
    age: float,
    stature: float,
    weight: float,
    measured: Mapping[str, float] | None = None,
) -> dict[str, float]:
    """What a person probably measures.

    Args:
        gender: Whose fit.
        age: Years.
        stature: m.
        weight: kg.
        measured: Lengths known of this person, m; the others are what goes with them.

    Returns:
        Each fitted length, m: the mean of its logarithm given all that is known.
    """
    fit, measured = Fit.of(gender), measured or {}
    mean = fit.mean(*(np.array(number) for number in (age, stature, weight)))
    known = [fit.measures.index(name) for name in measured]
    if known:
        off = np.log(list(measured.values())) - mean[known]
        across = fit.covariance[:, known]
        mean = mean + across @ np.linalg.solve(fit.covariance[np.ix_(known, known)], off)
    return dict(zip(fit.measures, np.exp(mean).tolist(), strict=True)) | dict(measured)


def plausible_ranges(
    gender: Gender, age: float, stature: float, weight: float, measured: Mapping[str, float]
) -> dict[str, tuple[float, float]]:
    """Between which lengths each of the measured should lie, by the person and the other measured.

    Args:
        gender: Whose fit.
        age: Years.
        stature: m.
        weight: kg.
        measured: Lengths known of this person, m; at least one.

    Returns:
        The least and the greatest of each, m: five standard deviations to either side of the mean.
    """
    fit = Fit.of(gender)
    known = [fit.measures.index(name) for name in measured]
    mean = fit.mean(*(np.array(number) for number in (age, stature, weight)))[known]
    off = np.log(list(measured.values())) - mean
    # Of a joint normal with inverse covariance P, each entry given the others has the variance
    # 1 / P_ii and the mean off_i - (P off)_i / P_ii.
    precision = np.linalg.inv(fit.covariance[np.ix_(known, known)])
    variance = 1 / np.diag(precision)
    expected = mean + off - variance * (precision @ off)
    reach = _DEVIATIONS * np.sqrt(variance)
    low, high = np.exp(expected - reach).tolist(), np.exp(expected + reach).tolist()
    return dict(zip(measured, zip(low, high, strict=True), strict=True))


def percentile(gender: Gender, of: Literal["age", "stature", "weight"], percent: float) -> float:
    """A percentile of the survey: years, m or kg."""
    fit = Fit.of(gender)
    return float(np.interp(percent / 100, fit.levels, fit.people[of]))


def sample_measures(gender: Gender, n: int, random: np.random.Generator) -> dict[str, Array]:
    """Age (years), stature (m), weight (kg) and all fitted lengths (m) of n virtual people.

    Args:
        gender: Of all of them.
        n: How many.
        random: What draws them.

    Returns:
        Each (n,), jointly distributed.
    """
    fit = Fit.of(gender)
    scores = random.multivariate_normal(np.zeros(3), fit.correlation, n)
    people = {
        name: np.interp(ndtr(score), fit.levels, quantiles)
        for (name, quantiles), score in zip(fit.people.items(), scores.T, strict=True)
    }
    residual = random.multivariate_normal(np.zeros(len(fit.measures)), fit.covariance, n)
    lengths = np.exp(fit.mean(people["age"], people["stature"], people["weight"]) + residual)
    return people | dict(zip(fit.measures, lengths.T, strict=True))
