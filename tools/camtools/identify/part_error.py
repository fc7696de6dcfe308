"""What errors of the constants do to a part, MATHS.md (156).

>>> turn = np.arange(64) / 64
>>> motion = ToolMotion(500_000 * np.cos(4 * np.pi * turn), 3000.0)
>>> round(motion.peak_speed_mm_s), round(motion.peak_acceleration_m_s2)
(314, 197)
"""

from dataclasses import dataclass

import numpy as np

from camtools.base.quantities import Floats, omega_rad_s
from camtools.identify.fit import K1, K2, LEAD, second_order, solved
from camtools.identify.multisine import Complexes
from camtools.identify.recording import STICTION_NM_S
from camtools.identify.resonance import ModeFit
from camtools.table.channel import KIND_U
from camtools.table.evaluate import evaluate_grid
from camtools.table.image import Table

_POINTS = 8  # of each segment between two knots
_MOST_POINTS = 4096


@dataclass(frozen=True, eq=False)
class ToolMotion:
    """The way of U over one turn."""

    u_nm: Floats  # shape (n,); at angles that divide the turn evenly
    rpm: float  # spindle speed, its mean where it is modulated

    @property
    def s(self) -> Complexes:
        """J times the angular frequency [rad/s] of each harmonic, from 0."""
        order = np.arange(self.u_nm.size // 2 + 1)
        return np.asarray(1j * omega_rad_s(self.rpm) * order, np.complex128)

    @property
    def harmonics(self) -> Complexes:
        """Spectrum of the way, as of numpy.fft.rfft."""
        return np.asarray(np.fft.rfft(self.u_nm))

    def over_turn(self, harmonics: Complexes) -> Floats:
        """Return what a spectrum is over the turn."""
        return np.asarray(np.fft.irfft(harmonics, self.u_nm.size))

    @property
    def peak_speed_mm_s(self) -> float:
        """Highest speed of U."""
        return float(np.max(np.abs(self.over_turn(self.harmonics * self.s)))) * 1e-6

    @property
    def peak_acceleration_m_s2(self) -> float:
        """Highest acceleration of U."""
        return float(np.max(np.abs(self.over_turn(self.harmonics * self.s**2)))) * 1e-9


def motion_of(table: Table, rpm: float) -> ToolMotion:
    """Return the fastest turn of a table: that whose speed of U is highest."""
    channel = table.channel(KIND_U)
    if channel.has_patterns:
        heights = np.arange(channel.n_slices, dtype=np.float64)
    else:
        heights = np.linspace(channel.z_first_nm, channel.z_last_nm, channel.n_slices)
    values = evaluate_grid(channel, heights, np.arange(_POINTS) / _POINTS)
    row = int(np.argmax(np.max(np.abs(values.d1), axis=1)))
    u_nm = np.tile(values.value[row], 1 << channel.log2_repeat)
    return ToolMotion(u_nm[:: max(1, u_nm.size // _MOST_POINTS)], rpm)


def form_error_nm(motion: ToolMotion, believed: Floats, response: Complexes) -> float:
    """Return the largest error of form that feed-forward with believed constants leaves."""
    s = motion.s
    error = (response / second_order(s, *believed[[K1, K2, LEAD]]) - 1) * motion.harmonics
    error[0] = 0
    return float(np.max(np.abs(motion.over_turn(error))))


def constants_for(motion: ToolMotion, response: Complexes, lead_s: float) -> Floats:
    """Return k1 and k2 for a lead that leave a part the least error, by least squares."""
    s = motion.s[1:]
    moved = (response[1:] * np.exp(lead_s * s)) * motion.harmonics[1:]
    (k1_s, k2_s2), _ = solved([moved * s, moved * s**2], motion.harmonics[1:] - moved)
    values = np.zeros(4)
    values[K1], values[K2], values[LEAD] = k1_s, k2_s2, lead_s
    return values


def mode_sigma_nm(motion: ToolMotion, found: ModeFit) -> float:
    """Return the standard deviation of the error of form, the drive having a mode."""
    by = np.array([motion.over_turn(share) for share in found.shares(motion.s) * motion.harmonics])
    return float(np.sqrt(np.max(np.einsum("in,ij,jn->n", by, found.place_covariance, by))))


def form_sigma_nm(motion: ToolMotion, values: Floats, covariance: Floats) -> float:
    """Return the deviation of the error of form from those of the constants."""
    s = motion.s
    inverse = 1 + values[K1] * s + values[K2] * s**2
    by = np.zeros((4, motion.u_nm.size))
    for i, term in ((K1, s / inverse), (K2, s**2 / inverse), (LEAD, s)):
        by[i] = motion.over_turn(term * motion.harmonics)
    return float(np.sqrt(np.max(np.einsum("in,ij,jn->n", by, covariance, by))))


def friction_error_nm(motion: ToolMotion, values: Floats) -> float:
    """Return the largest error that friction leaves, which feed-forward does not know."""
    speed = motion.over_turn(motion.harmonics * motion.s)
    direction = np.fft.rfft(np.clip(speed / STICTION_NM_S, -1.0, 1.0))
    slide = second_order(motion.s, values[K1], values[K2], 0.0)
    return float(np.max(np.abs(motion.over_turn(values[2] * direction * slide))))
