"""What was identified: constants, doubts, settings, and what errors of them do to a part.

The latter is MATHS.md (156).

>>> turn = np.arange(64) / 64
>>> motion = ToolMotion(500_000 * np.cos(4 * np.pi * turn), 3000.0)
>>> round(motion.peak_speed_mm_s), round(motion.peak_acceleration_m_s2)
(314, 197)
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from camtools.base.project import with_names
from camtools.base.quantities import Floats, length_text, omega_rad_s
from camtools.identify.configured_drive import Believed, frequency_and_damping
from camtools.identify.fit import FRICTION, K1, K2, LEAD, ModeFit, second_order, slide_of, solved
from camtools.identify.identified import Identified, is_rubbing
from camtools.identify.recording import STICTION_NM_S, Complexes
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
    error = (response / second_order(s, believed) - 1) * motion.harmonics
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
    inverse = slide_of(s, values)
    by = np.zeros((4, motion.u_nm.size))
    for i, term in ((K1, s / inverse), (K2, s**2 / inverse), (LEAD, s)):
        by[i] = motion.over_turn(term * motion.harmonics)
    return float(np.sqrt(np.max(np.einsum("in,ij,jn->n", by, covariance, by))))


def friction_error_nm(motion: ToolMotion, values: Floats) -> float:
    """Return the largest error that friction leaves, which feed-forward does not know."""
    speed = motion.over_turn(motion.harmonics * motion.s)
    direction = np.fft.rfft(np.clip(speed / STICTION_NM_S, -1.0, 1.0))
    rubbed = values[FRICTION] * direction / slide_of(motion.s, values)
    return float(np.max(np.abs(motion.over_turn(rubbed))))


_SIGMAS = 2.0
_NOTHING_UM = 1e-6


class _Entry(NamedTuple):
    name: str
    unit: str
    found: float
    deviation: float
    believed: float | None


def _entries(found: Identified, believed: Believed) -> Iterator[_Entry]:
    values, covariance = found.judged.values, found.judged.covariance
    k1_s, k2_s2, friction_nm, lead_s = (float(value) for value in values)
    (hz, damping), held = frequency_and_damping(values), frequency_and_damping(believed.values)
    held_hz, held_damping = held if believed.k2_us2 > 0 else (None, None)

    def entry(name: str, unit: str, value: float, by: Floats, held: float | None) -> _Entry:
        """Return a quantity; `by`: its derivatives by the constants."""
        return _Entry(name, unit, value, float(np.sqrt(by @ covariance @ by)), held)

    by_k1, by_k2, by_friction, by_lead = np.eye(4)
    yield entry("k1_ns", "ns", k1_s * 1e9, 1e9 * by_k1, believed.k1_ns)
    yield entry("k2_us2", "us2", k2_s2 * 1e12, 1e12 * by_k2, believed.k2_us2)
    lead_ns = lead_s * 1e9 - believed.u_scale_latency_ns
    yield entry("lead_ns", "ns", lead_ns, 1e9 * by_lead, believed.lead_ns)
    yield entry("natural frequency", "Hz", hz, -0.5 * hz / k2_s2 * by_k2, held_hz)
    by = damping / k1_s * by_k1 - 0.5 * damping / k2_s2 * by_k2
    yield entry("damping", "", damping, by, held_damping)
    by = 1e-9 * (by_friction - friction_nm / k2_s2 * by_k2) / k2_s2
    yield entry("friction", "m/s2", 1e-9 * friction_nm / k2_s2, by, None)


def _number(value: float, sigma: float) -> str:
    """Return a number with as many digits as its deviation leaves it, two of the deviation."""
    places = 1 - int(np.floor(np.log10(sigma))) if sigma > 0 else 3
    return f"{value:.{min(max(places, 0), 6)}f}"


def _table(found: Identified, believed: Believed) -> Iterator[str]:
    yield f"{'':<18}{'found':>12}{'deviation':>12}{'believed':>12}{'off':>9}"
    for row in _entries(found, believed):
        name = row.name if row.name.endswith(("_ns", "_us2")) else f"{row.name} {row.unit}".strip()
        figures = (_number(value, row.deviation) for value in (row.found, row.deviation))
        text = f"{name:<18}" + "".join(f"{figure:>12}" for figure in figures)
        if row.believed is not None:
            off = 100 * (row.believed / row.found - 1) if row.found else np.inf
            text += f"{_number(row.believed, row.deviation):>12}{off:>+7.2f} %"
        yield text


def _fit_lines(found: Identified, believed: Believed) -> Iterator[str]:
    plain, spectra = found.plain, found.spectra
    lost = f", {spectra.n_lost} below the noise omitted" if spectra.n_lost else ""
    yield (
        f"fit: {spectra.bins.size} lines {spectra.frequency_hz[0]:g} .. "
        f"{spectra.frequency_hz[-1]:g} Hz{lost}; misfit {100 * plain.misfit:.3g} %"
    )
    yield (
        "lead: dead time and half a tick of hold; the latency of the scale cannot be separated "
        f"from it, so u_scale_latency_ns = {believed.u_scale_latency_ns} ns is subtracted"
    )
    if found.with_mode is not None and found.has_mode:
        yield from _mode_lines(found)


def _mode_lines(found: Identified) -> Iterator[str]:
    assert found.with_mode is not None
    mode, bias = found.with_mode.mode, found.bias
    yield (
        f"mode: {mode.hz:.1f} Hz, damping {mode.damping:.3f}; a fit without it is off: k1 "
        f"{100 * bias[K1]:+.2f} %, k2 {100 * bias[K2]:+.2f} %, lead {bias[LEAD] * 1e6:+.1f} us; "
        f"with the mode {100 * found.with_mode.misfit:.2g} % are left"
    )
    beside, slow = found.with_mode.values, found.with_mode.slow_values
    for what, values in (("beside the mode", beside), ("far below the mode", slow)):
        yield (
            f"{what}: k1_ns {values[K1] * 1e9:.0f}, k2_us2 {values[K2] * 1e12:.0f}, "
            f"lead with latency {values[LEAD] * 1e9:.0f} ns"
        )


def _part_lines(
    found: Identified, believed: Believed, motion: ToolMotion, name: str
) -> Iterator[str]:
    left = form_left(found, believed, motion)
    yield (
        f"{name} at {motion.rpm:g} r/min: U moves at up to {motion.peak_speed_mm_s:.3g} mm/s and "
        f"{motion.peak_acceleration_m_s2:.3g} m/s2"
    )
    yield f"form error with the present constants: {length_text(left.believed_um)}"
    most = length_text(left.chosen_um + left.doubt_um)
    doubt = f"up to {most} if they are off by {_SIGMAS:g} standard deviations"
    yield f"form error with the identified constants: {length_text(left.chosen_um)}; {doubt}"
    if is_rubbing(found.plain):
        rubbing_um = friction_error_nm(motion, found.plain.values) * 1e-3
        yield f"friction adds up to {length_text(rubbing_um)}; u_friction_nm and learning remove it"


def chosen(found: Identified, motion: ToolMotion | None) -> Floats:
    """Return the constants for the feed-forward: of the fit, or beside a mode that biases it."""
    biasing = found.biasing
    if biasing is None:
        return found.plain.values
    if motion is None:
        return biasing.slow_values
    beside = biasing.values
    values = constants_for(motion, biasing.response(motion.s), float(beside[LEAD]))
    values[FRICTION] = beside[FRICTION]
    return values


class FormLeft(NamedTuple):
    """Errors of form that constants leave on a part [um]; the true drive is the one identified."""

    believed_um: float
    chosen_um: float
    doubt_um: float  # two deviations of the constants


def form_left(found: Identified, believed: Believed, motion: ToolMotion) -> FormLeft:
    """Return what a part is off by with the believed and with the identified constants."""
    response = found.judged.response(motion.s)
    now_um = form_error_nm(motion, believed.values, response) * 1e-3
    then_um = form_error_nm(motion, chosen(found, motion), response) * 1e-3
    if found.biasing is not None:
        sigma_um = 1e-3 * mode_sigma_nm(motion, found.biasing)
    else:
        sigma_um = 1e-3 * form_sigma_nm(motion, found.plain.values, found.plain.covariance)
    return FormLeft(now_um, then_um if then_um > _NOTHING_UM else 0.0, _SIGMAS * sigma_um)


def report(
    found: Identified,
    believed: Believed,
    motion: ToolMotion | None = None,
    part: str = "",
    *,
    is_good: bool,
) -> list[str]:
    """Return the whole report, line by line; with settings where they are to be set."""
    lines = [*_table(found, believed), *_fit_lines(found, believed)]
    what = "doubtful" if is_good else "not to be applied"
    lines += [f"{what}: {problem}" for problem in found.problems()]
    if is_good:
        values = chosen(found, motion)
        settings = believed.settings(values)
        lines += ["", *(with_names(f"tools/camctl set {key} {n}") for key, n in settings.items())]
        keys = believed.machine_keys(values)
        lines += ["", "[believed.u]", *(f"{name} = {value:.10g}" for name, value in keys.items())]
    if motion is not None:
        lines += ["", *_part_lines(found, believed, motion, part)]
    return lines


def numbers(
    found: Identified, believed: Believed, motion: ToolMotion | None = None
) -> dict[str, object]:
    """Return what the report says for other programs, as JSON has it."""
    result: dict[str, object] = {
        "parameters": {
            row.name.replace(" ", "_"): {k: v for k, v in row._asdict().items() if k != "name"}
            for row in _entries(found, believed)
        },
        "misfit": found.plain.misfit,
        "lines": int(found.spectra.bins.size),
        "lost_lines": found.spectra.n_lost,
        "gain": found.gain,
        "problems": found.problems(),
        "settings": believed.settings(chosen(found, motion)),
    }
    if found.with_mode is not None and found.has_mode:
        beside = believed.settings(found.with_mode.values)
        result["mode"] = {
            "hz": found.with_mode.mode.hz,
            "damping": found.with_mode.mode.damping,
            "misfit": found.with_mode.misfit,
            "bias_k1": float(found.bias[K1]),
            "bias_k2": float(found.bias[K2]),
            "bias_lead_us": float(found.bias[LEAD]) * 1e6,
            "beside": beside,
        }
    if motion is not None:
        left = form_left(found, believed, motion)
        names = ("believed", "identified", "doubt")
        result["form_error_um"] = dict(zip(names, left, strict=True))
    return result
