"""Fits a psychometric function to a session's answers by maximum likelihood, in log units of the level.

    psi(x) = g + (1 - g - l) F(x),      x = log10(level)
    Weibull:              F(x) = 1 - exp(-ln 2 * 10^(b (x - t)))
    cumulative Gaussian:  F(x) = Phi(2 b (x - t))

g is the guess rate, 1/2 in 2IFC; l the lapse rate, fitted within [0, 0.05]; 10^t the threshold, where F = 1/2: 75 % correct in
2IFC without lapses; b the slope (Wichmann & Hill 2001, Percept. Psychophys. 63, 1293). The interval is that of the profile
likelihood: all t whose deviance, least over b and l, is within 3.84 of the best, the 95 % point of chi-squared with one degree
of freedom (Venzon & Moolgavkar 1988, Appl. Statist. 37, 87).

A hundred answers hardly determine b and l, and adaptive methods ask near the threshold alone. Both have weak priors, which
the likelihood is multiplied by (as in Schuett et al. 2016, Vision Res. 122, 105): ln b is Gaussian about ln 1.3, the exponent
of an observer whose d' is proportional to the level, with the standard deviation ln 2; l is exponential with the mean 0.01.
"""
import math
from dataclasses import dataclass

import numpy

GUESS_RATE = 0.5
MAX_LAPSE_RATE = 0.05
SLOPES = (0.3, 15.0)   # fitted within
MIN_TRIALS = 20
REACH = 1.0            # decades beyond the levels, in which a threshold is sought
CHI_SQUARED_95 = 3.841458820694124
FAMILIES = ("weibull", "gaussian")
USUAL_SLOPE, SLOPE_SPREAD, USUAL_LAPSE_RATE = 1.3, math.log(2), 0.01
_SLOPES = numpy.exp(numpy.linspace(*numpy.log(SLOPES), 41))[:, None, None]
_LAPSES = numpy.linspace(0, MAX_LAPSE_RATE, 6)[None, :, None]


class NoThreshold(Exception):
    """The answers do not determine a threshold: why, and what would help."""


@dataclass(frozen=True)
class Fit:
    """threshold, low and high (95 % interval) in the unit of the levels; slope b; lapse rate l; deviance of the fit."""
    family: str
    threshold: float
    low: float
    high: float
    slope: float
    lapse_rate: float
    deviance: float

    def proportion_correct(self, level):
        """psi at a level, or an array of levels."""
        return psi(self.family, numpy.log10(level), math.log10(self.threshold), self.slope, self.lapse_rate)


def psi(family, x, t, slope, lapse_rate):
    """The proportion of correct answers at x = log10(level); arrays are broadcast."""
    from scipy.special import ndtr
    distance = slope * (x - t)
    rise = -numpy.expm1(-math.log(2) * 10 ** numpy.minimum(distance, 3)) if family == "weibull" else ndtr(2 * distance)
    return GUESS_RATE + (1 - GUESS_RATE - lapse_rate) * rise


def tally(trials):
    """(levels, n, correct), arrays over the levels in order, of (level, correct) pairs."""
    levels = sorted({level for level, _ in trials})
    n = [sum(level == each for level, _ in trials) for each in levels]
    right = [sum(level == each and correct for level, correct in trials) for each in levels]
    return numpy.array(levels, float), numpy.array(n, float), numpy.array(right, float)


def fit(trials, family="weibull"):
    """The Fit of (level, correct) pairs. Raises NoThreshold; ValueError of an unknown family."""
    if family not in FAMILIES:
        raise ValueError(f"family is {family}; one of {', '.join(FAMILIES)} is wanted")
    levels, n, right = tally(trials)
    check_identifiable(n, right)
    x = numpy.log10(levels)
    ends = x[0] - REACH, x[-1] + REACH
    best, slope, lapse_rate, least = maximum(family, x, n, right, ends)
    if min(best - ends[0], ends[1] - best) < 0.01:
        raise NoThreshold(f"the fit puts the threshold beyond the levels, {levels[0]:g} to {levels[-1]:g}, by a factor of 10: "
                          "the answers do not get better with the level. Let the participant practise, or use larger levels")
    low, high = (end_of_interval(family, x, n, right, best, end, least) for end in ends)
    if low is None or high is None:
        raise NoThreshold(f"the 95 % interval has no {'lower' if low is None else 'upper'} end within a factor of 10 of the "
                          "levels: the answers do not bound the threshold. More trials help, and "
                          f"{'smaller' if low is None else 'larger'} levels")
    return Fit(family, 10 ** best, 10 ** low, 10 ** high, slope, lapse_rate, least - saturated(n, right))


def check_identifiable(n, right):
    total = int(n.sum())
    if total < MIN_TRIALS:
        raise NoThreshold(f"{total} trials are too few for a fit; {MIN_TRIALS} are the least, 60 and more are usual")
    if right.sum() == total:
        raise NoThreshold("every answer is correct: all levels are above the threshold. Smaller levels help")
    if right.sum() == 0:
        raise NoThreshold("every answer is wrong: were the keys confused? The participant's answers would have to be looked at")
    if len(n) < 2:
        raise NoThreshold("all trials have one level; a fit needs two or more")


def deviance(family, x, n, right, t, slope, lapse_rate):
    """-2 log likelihood, summed over the last axis."""
    p = numpy.clip(psi(family, x, t, slope, lapse_rate), 1e-9, 1 - 1e-9)
    return -2 * (right * numpy.log(p) + (n - right) * numpy.log1p(-p)).sum(axis=-1)


def penalty(slope, lapse_rate):
    """-2 log of the weak priors: a Gaussian of ln b, an exponential of l."""
    return ((numpy.log(slope) - math.log(USUAL_SLOPE)) / SLOPE_SPREAD) ** 2 + 2 * lapse_rate / USUAL_LAPSE_RATE


def saturated(n, right):
    from scipy.special import xlogy
    return float(-2 * (xlogy(right, right / n) + xlogy(n - right, (n - right) / n)).sum())


def profile(family, x, n, right, t):
    """(least deviance over slope and lapse rate at this t, that slope, that lapse rate)."""
    over = deviance(family, x, n, right, t, _SLOPES, _LAPSES) + penalty(_SLOPES[..., 0], _LAPSES[..., 0])
    i, j = numpy.unravel_index(over.argmin(), over.shape)
    return float(over[i, j]), float(_SLOPES[i, 0, 0]), float(_LAPSES[0, j, 0])


def maximum(family, x, n, right, ends):
    """(t, slope, lapse rate, deviance) of the maximum likelihood: from the best point of a grid, by L-BFGS-B."""
    from scipy.optimize import minimize
    grid = numpy.linspace(*ends, 81)
    start = min(grid, key=lambda t: profile(family, x, n, right, t)[0])
    least, slope, lapse_rate = profile(family, x, n, right, start)
    found = minimize(lambda given: deviance(family, x, n, right, given[0], math.exp(given[1]), given[2]) +
                     penalty(math.exp(given[1]), given[2]),
                     (start, math.log(slope), lapse_rate), method="L-BFGS-B",
                     bounds=(ends, tuple(map(math.log, SLOPES)), (0, MAX_LAPSE_RATE)))
    if not math.isfinite(found.fun) or found.fun > least + 0.1:
        raise NoThreshold(f"the fit does not converge ({found.message}). More trials at more levels help")
    return float(found.x[0]), math.exp(found.x[1]), float(found.x[2]), min(float(found.fun), least)


def end_of_interval(family, x, n, right, best, end, least):
    """Where the profile's deviance crosses the limit between the best t and `end`; None where it does not."""
    from scipy.optimize import brentq
    def over(t):
        return profile(family, x, n, right, t)[0] - least - CHI_SQUARED_95
    return float(brentq(over, best, end, xtol=1e-4)) if over(end) > 0 > over(best) else None
