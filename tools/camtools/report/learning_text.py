"""What the controller learned, in words; without the libraries of pictures.

>>> numbers_text([2, 3, 4, 7])
'2 .. 4, 7'
"""

from collections.abc import Sequence

import numpy as np

from camtools.base.quantities import Floats, length_text
from camtools.base.text import Json
from camtools.report.text import ReportRow
from camtools.sim.results import AnyCut

_OFF = {
    "not_asked": "learn_harmonics = 0; below 5 kHz that is the default",
    "not_measured": "the port does not measure U, so there is no error to learn from",
    "no_table": "no table is active",
    "modulated": "the table modulates the spindle speed",
    "slow_turn": "a turn has more ticks than learning can store; turn faster",
    "fast_turn": "a turn has too few ticks for even one harmonic; turn more slowly",
}
_LIMITED = {
    "lobes": "for a shaft with lobes, only the drive constants are learned",
    "diverged": "the drive constants did not converge; the best values found are used",
    "rippled": "the ripple of the spindle exceeds 12 mrad in total; only 12 mrad are compensated",
    "limited": "a correction has reached its limit, or U the end of its stroke",
    "slow_loop": "the position loop of U is too slow for this speed; a stiffer one learns",
}
_END_TURNS = 20  # of a cut, at either end
_STANDS_OUT = 1.5  # times the median of all turns
_SEEN = 0.5  # share of the error that U's scale must show
_NO_REHEARSAL = "on, but no turn was steady enough to learn from; set rehearse_turns"


def numbers_text(numbers: Sequence[int]) -> str:
    """Return numbers in rising order in words, neighbours as a range."""
    breaks = np.flatnonzero(np.diff(numbers) != 1) + 1
    runs = [run.tolist() for run in np.split(np.array(numbers, int), breaks)]
    texts = [f"{run[0]} .. {run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs]
    return ", ".join(texts)


def _k1_text(ns: int) -> str:
    return f"{ns * 1e-6:+.4g} ms" if abs(ns) >= 100_000 else f"{ns * 1e-3:+.4g} µs"


def _k2_text(us2: int) -> str:
    return f"{us2 * 1e-6:+.3g} ms²" if abs(us2) >= 10_000 else f"{us2:+d} µs²"


def _on_text(found: Json) -> str:
    at_first, at_last = length_text(found["begin_error_um"]), length_text(found["error_um"])
    texts = [
        f"on, {found['turns']} turns used: rms error at the scale {at_first} at first, {at_last} "
        "at the end",
        f"k1 corrected by {_k1_text(found['k1_ns'])}, k2 by {_k2_text(found['k2_us2'])}",
        f"friction corrected by {found['friction_nm']:+d} nm, the chip's force learned as "
        f"{found['chip_nm_per_mm2'] * 1e-3:.3g} µm/mm²",
        f"correction added to U: {length_text(found['correction_um'])} in total",
    ]
    if found["ripple_turns"]:
        ripple_urad = 2e-3 * np.pi * found["ripple_nturn"]
        texts.append(
            f"spindle ripple of {ripple_urad:.0f} µrad learned from {found['ripple_turns']} turns"
        )
    masked = [k for k in found["masked"] if k > 0]
    texts.append(f"harmonics masked: {numbers_text(masked)}" if masked else "no harmonic is masked")
    if 0 in found["masked"]:
        texts.append("the mean of U is not corrected")
    if found["reason"] in _LIMITED:
        texts.append(_LIMITED[found["reason"]])
    return "; ".join(texts)


def _cut_um(summary: Json) -> Floats:
    """Return the largest errors of the turns of the cut."""
    states = summary["error_per_turn"]["state"]
    pairs = zip(summary["error_per_turn_um"], states, strict=True)
    return np.asarray([um for um, state in pairs if state == "cutting"], dtype=np.float64)


def _at_an_end(summary: Json) -> str | None:
    """Return the cause if the largest error is that of the first or last turns."""
    um = _cut_um(summary)
    if um.size < 3 * _END_TURNS or um.max() < _STANDS_OUT * np.median(um):
        return None
    usual = f"elsewhere {length_text(float(np.median(um)))}"
    if um.argmax() < _END_TURNS:
        known = "the next part begins with what was learned of the force"
        return f"of the first turns, {usual}; a longer feed_ramp_turns helps, and {known}"
    if um.argmax() >= um.size - _END_TURNS:
        return f"of the last turns, {usual}; a longer feed_ramp_turns or a smaller feed helps"
    return None


def _cause(summary: Json) -> str:
    """Return the likely cause of the largest error, and what helps most."""
    found, form = summary["learning"], summary["form_error_um"]
    if found["reason"] == "limited":
        return (
            "of a correction at its limit; drive constants that match the machine, more stroke or "
            "less feed help"
        )
    at_an_end = _at_an_end(summary)
    if at_an_end is not None:
        return at_an_end
    if "better_rpm" in summary:
        return f"of encoder counts that do not average; {summary['better_rpm']:g} r/min helps"
    if form.get("rms_not_turned") is not None and form["rms_not_turned"] < 0.7 * form["rms"]:
        return (
            f"an angle by which the whole part is turned, {form['turned_urad']:+.0f} µrad; "
            "index_offset_udeg or a finer encoder helps"
        )
    if 3 * found["error_um"] > _SEEN * form["max"]:
        return (
            "seen by U's scale but not learned: friction, masked harmonics, those above the 16th, "
            "or noise; a finer scale, less friction or a smaller speed helps"
        )
    return (
        "not seen by U's scale: run-out, eccentricity of the encoder, bending of the tool; gauge "
        "the part and correct its table by mktables --measured"
    )


def learning_rows(summary: Json) -> list[ReportRow]:
    """Return whether and what was learned, and what remains; nothing where camsim does not say."""
    found = summary.get("learning")
    if found is None:
        return []
    if found["is_on"]:
        rows, largest_um = [ReportRow("learning", _on_text(found))], summary["form_error_um"]["max"]
        if largest_um is not None:
            remains = f"{length_text(largest_um)}, likely {_cause(summary)}"
            rows.append(ReportRow("what remains", remains))
        return rows
    why = _OFF.get(found["reason"])
    return [ReportRow("learning", f"off: {why}" if why else _NO_REHEARSAL)]


def learned(cut: AnyCut) -> list[ReportRow]:
    """Return `learning_rows` of a cut."""
    return learning_rows(cut.summary)
