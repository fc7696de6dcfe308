"""What was identified, as text and as JSON: constants, doubts, settings, error of a part.

>>> constants_of(np.array([1.0, 7e-4, 3e-7, 1e-4]), "command_um")["k1 ns"]
700000.0
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from camtools.base.project import with_names
from camtools.base.quantities import Floats, length_text
from camtools.base.text import Json
from camtools.identify.configured_drive import Believed
from camtools.identify.fit import FRICTION, K1, K2, LEAD
from camtools.identify.foreign_record import FORCES, ForeignRecord
from camtools.identify.identified import Identified, Limits, is_rubbing
from camtools.identify.linear_model import DELAY, RATE, SECOND, STATIC, LinearModel, jackknife
from camtools.identify.part_error import (
    ToolMotion,
    constants_for,
    form_error_nm,
    form_sigma_nm,
    friction_error_nm,
    mode_sigma_nm,
)

_SIGMAS = 2.0
_NOTHING_UM = 1e-6


class _Entry(NamedTuple):
    name: str
    unit: str
    found: float
    deviation: float
    believed: float | None


def _derived(values: Floats) -> tuple[float, float]:
    """Return natural frequency [Hz] and damping."""
    k2_s2 = max(float(values[K2]), 1e-18)
    return 1 / (2 * np.pi * k2_s2**0.5), float(values[K1]) / (2 * k2_s2**0.5)


def _entries(found: Identified, believed: Believed, limits: Limits) -> Iterator[_Entry]:
    values, covariance = found.judged(limits).values, found.judged(limits).covariance
    k1_s, k2_s2, friction_nm, lead_s = (float(value) for value in values)
    (hz, damping), held = _derived(values), _derived(believed.values)
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


def _table(found: Identified, believed: Believed, limits: Limits) -> Iterator[str]:
    yield f"{'':<18}{'found':>12}{'deviation':>12}{'believed':>12}{'off':>9}"
    for row in _entries(found, believed, limits):
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


def set_lines(settings: Mapping[str, int]) -> list[str]:
    """Return lines for a shell that set parameters of a controller."""
    return [with_names(f"tools/camctl set {name} {value}") for name, value in settings.items()]


def _part_lines(
    found: Identified, believed: Believed, limits: Limits, motion: ToolMotion, name: str
) -> Iterator[str]:
    left = form_left(found, believed, limits, motion)
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


def chosen(found: Identified, limits: Limits, motion: ToolMotion | None) -> Floats:
    """Return the constants for the feed-forward: of the fit, or beside a mode that biases it."""
    if found.with_mode is None or not found.is_biased(limits):
        return found.plain.values
    if motion is None:
        return found.with_mode.slow_values
    beside = found.with_mode.values
    values = constants_for(motion, found.with_mode.response(motion.s), float(beside[LEAD]))
    values[FRICTION] = beside[FRICTION]
    return values


class FormLeft(NamedTuple):
    """Errors of form that constants leave on a part [um]; the true drive is the one identified."""

    believed_um: float
    chosen_um: float
    doubt_um: float  # two deviations of the constants


def form_left(
    found: Identified, believed: Believed, limits: Limits, motion: ToolMotion
) -> FormLeft:
    """Return what a part is off by with the believed and with the identified constants."""
    with_mode = found.with_mode if found.is_biased(limits) else None
    response = (with_mode or found.plain).response(motion.s)
    now_um = form_error_nm(motion, believed.values, response) * 1e-3
    then_um = form_error_nm(motion, chosen(found, limits, motion), response) * 1e-3
    plain = found.plain
    sigma_nm = form_sigma_nm(motion, plain.values, plain.covariance)
    sigma_um = 1e-3 * (sigma_nm if with_mode is None else mode_sigma_nm(motion, with_mode))
    return FormLeft(now_um, then_um if then_um > _NOTHING_UM else 0.0, _SIGMAS * sigma_um)


def report(
    found: Identified,
    believed: Believed,
    limits: Limits,
    motion: ToolMotion | None = None,
    part: str = "",
    *,
    is_good: bool,
) -> list[str]:
    """Return the whole report, line by line; with settings where they are to be set."""
    lines = [*_table(found, believed, limits), *_fit_lines(found, believed)]
    what = "doubtful" if is_good else "not to be applied"
    lines += [f"{what}: {problem}" for problem in found.problems(limits)]
    if is_good:
        values = chosen(found, limits, motion)
        lines += ["", *set_lines(believed.settings(values))]
        keys = believed.machine_keys(values)
        lines += ["", "[believed.u]", *(f"{name} = {value:.10g}" for name, value in keys.items())]
    if motion is not None:
        lines += ["", *_part_lines(found, believed, limits, motion, part)]
    return lines


def numbers(
    found: Identified, believed: Believed, limits: Limits, motion: ToolMotion | None = None
) -> dict[str, object]:
    """Return what the report says for other programs, as JSON has it."""
    result: dict[str, object] = {
        "parameters": {
            row.name.replace(" ", "_"): {k: v for k, v in row._asdict().items() if k != "name"}
            for row in _entries(found, believed, limits)
        },
        "misfit": found.plain.misfit,
        "lines": int(found.spectra.bins.size),
        "lost_lines": found.spectra.n_lost,
        "gain": found.gain.share,
        "problems": found.problems(limits),
        "settings": believed.settings(chosen(found, limits, motion)),
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
        left = form_left(found, believed, limits, motion)
        names = ("believed", "identified", "doubt")
        result["form_error_um"] = dict(zip(names, left, strict=True))
    return result


_NS, _US2, _UM = 1e9, 1e12, 1e6  # per s, s2 and m


def constants_of(values: Floats, command: str) -> dict[str, float]:
    """Return constants, as of `LinearModel`, by name and unit; the command's column chooses."""
    static, rate, second, delay_s = (float(values[i]) for i in (STATIC, RATE, SECOND, DELAY))
    ringing = max(static / second, 0.0) ** 0.5 if second else 0.0  # rad/s
    shape = {
        "delay ns": delay_s * _NS,
        "natural frequency Hz": ringing / (2 * np.pi),
        "damping": rate / (2 * second * ringing) if ringing else float("inf"),
    }
    if command in FORCES:
        return {"mass kg": second, "viscous N s/m": rate, "stiffness N/m": static} | shape
    gain, unit = (_UM / static, "um/V") if command == "command_v" else (1 / static, "")
    drive = {"k1 ns": rate / static * _NS, "k2 us2": second / static * _US2}
    return {f"gain {unit}".strip(): gain} | drive | shape


def _uncertain(found: LinearModel, command: str) -> list[tuple[str, float, float]]:
    """Return name, value and deviation of each constant."""
    constants = constants_of(found.values, command)
    rows = [list(constants_of(one, command).values()) for one in found.replicas]
    return [*zip(constants, constants.values(), jackknife(np.array(rows)).tolist(), strict=True)]


def record_lines(found: LinearModel, record: ForeignRecord) -> Iterator[str]:
    """Yield the report, line by line."""
    hz = np.abs(found.lines.s) / (2 * np.pi)
    coherence = found.lines.coherence
    held = "held for each step" if found.lines.hold_s else "continuous"
    yield (
        f"record: {record.u.size} rows at {record.rate_hz:.6g} Hz; command {held}; {hz.size} lines "
        f"{hz[0]:.3g} .. {hz[-1]:.4g} Hz, coherence {np.median(coherence):.4g} in the median, "
        f"{coherence.min():.3g} at least"
    )
    yield f"{'':<22}{'found':>14}{'deviation':>12}"
    for name, value, sigma in _uncertain(found, record.command):
        yield f"{name:<22}{value:>14.6g}{sigma:>12.2g}"
    yield f"misfit {100 * found.misfit:.3g} %, {found.chi:.3g} times the deviations of the lines"
    yield from (f"a linear model does not hold: {one}" for one in found.problems)


def record_numbers(found: LinearModel, record: ForeignRecord) -> Json:
    """Return the report for other programs."""
    return {
        "constants": {
            name: {"found": value, "deviation": sigma}
            for name, value, sigma in _uncertain(found, record.command)
        },
        "command_hold_s": found.lines.hold_s,
        "lines": int(found.lines.s.size),
        "coherence_median": float(np.median(found.lines.coherence)),
        "misfit": found.misfit,
        "misfit_deviations": found.chi,
        "problems": found.problems,
    }
