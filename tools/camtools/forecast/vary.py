r"""V.toml: unknown numbers of a machine, how they are spread, and machines drawn from them.

>>> text = '[u.delay_us]\ndistribution = "uniform"\nof = "nominal"\nlow = 0.9\nhigh = 1.1\n'
>>> [unknown.key for unknown in read_vary(text.encode(), "v.toml", {})]
['u.delay_us']
"""

import warnings
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy

from camtools.base.errors import InputError
from camtools.base.quantities import Floats, FloatsLike
from camtools.sim.machine_file import nominal_of
from camtools.sim.uncertain import USUAL, Spread, read_spreads, usual_spreads

_SIGMAS = 3.0  # truncation where none is given
_LEAST_SHARE = 1e-6  # of a distribution that must lie between its ends


class Unknown(NamedTuple):
    """A number of the machine that is not known."""

    key: str  # table and key of the machine file
    nominal: float  # what the controller believes
    low: float  # end of what is drawn, in the unit of the key
    high: float
    words: str  # the distribution for people
    frozen: Any  # without its ends

    def at(self, share: FloatsLike) -> Floats:
        """Return the number below which a share of the truncated law lies, MATHS.md (162)."""
        first, last = self.frozen.cdf(self.low), self.frozen.cdf(self.high)
        value = self.frozen.ppf(first + np.asarray(share) * (last - first))
        return np.asarray(np.clip(value, self.low, self.high))


def _frozen(spread: Spread, scale: float, nominal: float) -> tuple[Any, float, float, str]:
    """Return the distribution, its natural ends and its description; numbers times scale."""
    if spread.distribution == "uniform":
        low, high = (spread.low or 0.0) * scale, (spread.high or 0.0) * scale
        return scipy.stats.uniform(low, high - low), low, high, "uniform"
    if spread.distribution == "normal":
        mean = nominal if spread.mean is None else spread.mean * scale
        sd = (spread.sd or 0.0) * abs(scale)
        words = f"normal {mean:.4g} +- {sd:.3g}"
        return scipy.stats.norm(mean, sd), mean - _SIGMAS * sd, mean + _SIGMAS * sd, words
    median = nominal if spread.median is None else spread.median * scale
    factor = spread.factor or 1.0
    ends = median * factor**-_SIGMAS, median * factor**_SIGMAS
    words = f"lognormal {median:.4g} */ {factor:.3g}"
    return scipy.stats.lognorm(np.log(factor), scale=median), *ends, words


def _unknown(key: str, spread: Spread, machine: Mapping[str, Any], file: str) -> Unknown:
    nominal = nominal_of(machine, key)
    if nominal is None:
        remedy = "give a number of host_sim/machines/default.toml"
        raise InputError(file, key, None, "not a number of a machine file", remedy)
    is_share = spread.of == "nominal"
    if nominal == 0.0 and (is_share or (spread.distribution == "lognormal" and not spread.median)):
        remedy = 'give the numbers themselves with of = "unit"'
        problem = "is 0 on this machine, and so is any multiple of it"
        raise InputError(file, f"{key}.of", spread.of, problem, remedy)
    scale = nominal if is_share else 1.0
    frozen, low, high, words = _frozen(spread, scale, nominal)
    low = low if spread.low is None else spread.low * scale
    high = high if spread.high is None else spread.high * scale
    low, high = min(low, high), max(low, high)  # a nominal value below 0 turns them round
    share = float(frozen.cdf(high) - frozen.cdf(low))
    if not share >= _LEAST_SHARE:
        problem = f"leaves {share:.1g} of the distribution between {low:g} and {high:g}"
        raise InputError(file, key, None, problem, "give ends around its middle")
    return Unknown(key, nominal, low, high, f"{words}, {low:.4g} .. {high:.4g}", frozen)


def read_vary(data: bytes, file: str, machine: Mapping[str, Any]) -> list[Unknown]:
    """Return the unknown numbers of a machine; refuse distributions that cannot be."""
    spreads = read_spreads(data, file)
    return [_unknown(key, spread, machine, file) for key, spread in spreads.items() if spread.drawn]


def default_vary(machine: Mapping[str, Any]) -> tuple[list[Unknown], list[str]]:
    """Return the usual unknowns, and those left out: shares of numbers that are 0 here."""
    found, left_out = [], []
    for key, spread in usual_spreads().items():
        if not spread.drawn:
            continue
        if spread.of == "nominal" and not nominal_of(machine, key):
            left_out.append(key)
        else:
            found.append(_unknown(key, spread, machine, USUAL.name))
    return found, left_out


def draw(
    unknowns: Sequence[Unknown], n_runs: int, *, seed: int, is_independent: bool = False
) -> Floats:
    """Return numbers (n_runs, unknowns); a longer draw continues a shorter one, MATHS.md (162).

    They fill their range evenly, or each row is drawn on its own, as bounds of (168) need it.
    """
    rng = np.random.default_rng(seed)
    if is_independent:
        points = rng.random((n_runs, len(unknowns)))
    else:
        sobol = scipy.stats.qmc.Sobol(len(unknowns), scramble=True, rng=rng)
        with warnings.catch_warnings():  # balance wants powers of two; any number is a fair sample
            warnings.simplefilter("ignore", UserWarning)
            points = sobol.random(n_runs)
    return np.column_stack([unknown.at(points[:, place]) for place, unknown in enumerate(unknowns)])
