# SPDX-License-Identifier: Apache-2.0
"""What a record says about U's drive, and whether it may be believed, MATHS.md (152) .. (155).

>>> Limits().k1_share, Limits().lead_s
(0.01, 2e-06)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camtools.base.quantities import Floats
from camtools.identify.fit import FRICTION, K1, K2, LEAD, DriveFit, Gain, fit, moved_per_commanded
from camtools.identify.friction import friction_of
from camtools.identify.recording import SettledRecord
from camtools.identify.resonance import ModeFit, fit_mode
from camtools.identify.spectra import Spectra, spectra_of

_ROUNDS = 5  # friction played with the constants found so far
_MODE_ROUNDS = 3
_RATHER_A_MODE = 2.0  # a gain that is off explains less than that
_SETTLED_SIGMAS = 0.1
_FRICTION_SIGMAS = 3.0
_MODE_GAIN = 4.0  # a mode is there when it makes the sum of the squares smaller by this


@dataclass(frozen=True)
class Limits:
    """What a fit must keep to be applied."""

    k1_share: float = 0.01  # standard deviation and bias
    k2_share: float = 0.01
    lead_s: float = 2e-6
    misfit: float = 0.05
    gain_off: float = 0.01


@dataclass(frozen=True, eq=False)
class Identified:
    """The constants of U's drive with their doubts."""

    spectra: Spectra  # with the friction that the fit found
    plain: DriveFit  # of a drive of second order
    with_mode: ModeFit | None  # of one with a mode as well
    gain: Gain  # share of a commanded way that U moves

    @property
    def has_mode(self) -> bool:
        """A mode explains most of what the plain fit leaves, so that the fit is biased."""
        one = self.with_mode
        return (
            one is not None
            and one.plain_cost > _MODE_GAIN * one.cost
            and self.gain.cost > _RATHER_A_MODE * one.cost
        )

    @property
    def has_friction(self) -> bool:
        """Friction stands above its error."""
        return is_rubbing(self.plain)

    @property
    def bias(self) -> Floats:
        """Plain fit minus the drive beside its mode: k1 and k2 as shares, 0, lead [s]."""
        bias = np.zeros(4)
        if self.with_mode is not None and self.has_mode:
            free = self.with_mode.values
            bias[[K1, K2]] = self.plain.values[[K1, K2]] / free[[K1, K2]] - 1
            bias[LEAD] = self.plain.values[LEAD] - free[LEAD]
        return bias

    def is_biased(self, limits: Limits) -> bool:
        """Return whether a mode biases the fit beyond the limits."""
        bias = np.abs(self.bias)
        most = (limits.k1_share, limits.k2_share, limits.lead_s)
        return bool(np.any(bias[[K1, K2, LEAD]] > most))

    def judged(self, limits: Limits) -> DriveFit | ModeFit:
        """Return the fit that counts: that of the drive beside its mode where a mode biases."""
        if self.with_mode is not None and self.is_biased(limits):
            return self.with_mode
        return self.plain

    def problems(self, limits: Limits) -> list[str]:
        """Return why the constants are not to be applied; an empty list when they are."""
        one = self.judged(limits)
        if not one.is_physical:
            return ["no drive of second order has such a response"]
        found = []
        sigmas = np.sqrt(np.diag(one.covariance))
        shares = {"k1": (K1, limits.k1_share), "k2": (K2, limits.k2_share)}
        for name, (i, limit) in shares.items():
            share = float(sigmas[i] / one.values[i])
            if share > limit:
                found.append(
                    f"{name} is known to {100 * share:.3g} % only, at most {100 * limit:g} %"
                )
        if sigmas[LEAD] > limits.lead_s:
            found.append(
                f"lead is known to {sigmas[LEAD] * 1e6:.3g} us, at most {limits.lead_s * 1e6:g} us"
            )
        if one.misfit > limits.misfit:
            found.append(
                f"the fit leaves {100 * one.misfit:.3g} % of what was measured, at most "
                f"{100 * limits.misfit:g} %"
            )
        if not self.has_mode and abs(self.gain.share - 1) > limits.gain_off:
            moved = f"U moves {self.gain.share:.4f} of what is commanded"
            remedy = "correct the scale of the drive"
            found.append(f"{moved}, at most {limits.gain_off:g} off; {remedy}")
        return found


def is_rubbing(found: DriveFit) -> bool:
    """Return whether friction stands above its error."""
    return bool(found.values[FRICTION] > _FRICTION_SIGMAS * found.sigmas[FRICTION])


def _rubbing(spectra: Spectra, record: SettledRecord, values: Floats) -> Spectra:
    """Return the lines with the friction of a drive of these constants."""
    period_nm = record.period_nm  # played twice: what remains of the begin has died away then
    shares = friction_of(values, np.tile(period_nm, 2), 1 / record.grid.tick_hz)
    return spectra.with_friction(np.tile(shares[period_nm.size :], (spectra.n_periods, 1)))


def _fit_plain(spectra: Spectra, record: SettledRecord) -> tuple[Spectra, DriveFit]:
    """Return the lines and their fit with friction as played, where that explains more."""
    found = fit(spectra)
    for _ in range(_ROUNDS):
        if not (found.is_physical and is_rubbing(found)):
            break
        played = _rubbing(spectra, record, found.values)
        better = fit(played)
        if better.misfit >= found.misfit:
            break
        moved = np.abs(better.values - found.values)
        spectra, found = played, better
        if np.all(moved < _SETTLED_SIGMAS * better.sigmas):
            break
    return spectra, found


def _fit_mode(spectra: Spectra, record: SettledRecord, plain: DriveFit) -> ModeFit | None:
    """Return the fit with a mode, its own friction played."""
    found = fit_mode(spectra, plain)
    if found is None or not is_rubbing(plain) or found.plain_cost < _MODE_GAIN * found.cost:
        return found
    for _ in range(_MODE_ROUNDS):
        if min(found.values[K1], found.values[K2], found.values[LEAD]) <= 0:
            break
        better = fit_mode(_rubbing(spectra, record, found.values), plain, found)
        if better is None or better.cost >= found.cost:
            break
        found = better
    return found


def _plain_of(record: SettledRecord) -> tuple[Spectra, DriveFit]:
    u_nm, y_nm = record.settled
    return _fit_plain(spectra_of(record.grid, u_nm, y_nm, record.quantum_nm), record)


def identify(record: SettledRecord, *, with_mode: bool = True) -> Identified:
    """Return what a record says about U's drive.

    A scale that is coarse may belong to a drive that rounds its commands likewise; the record with
    rounded set-points is believed where it leaves less.

    Parameters
    ----------
    with_mode : bool
        look for a mode as well

    Raises
    ------
    CamtoolsError
        Too few lines stand above their noise.
    """
    spectra, plain = _plain_of(record)
    if record.is_coarse:
        record_too = record.rounded()
        other = _plain_of(record_too)
        if other[1].misfit < plain.misfit:
            record, (spectra, plain) = record_too, other
    looks = with_mode and plain.is_physical
    return Identified(
        spectra=spectra,
        plain=plain,
        with_mode=_fit_mode(spectra, record, plain) if looks else None,
        gain=moved_per_commanded(spectra, plain),
    )
