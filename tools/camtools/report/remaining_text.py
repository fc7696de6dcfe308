"""What remains of the form error after learning, in words: its size, likely cause and remedy.

>>> um = [9.0] * 3 + [1.0] * 57
>>> cut = {"error_per_turn_um": um, "error_per_turn": {"state": ["cutting"] * 60}}
>>> form = {"max": 9.0, "rms": 2.0, "rms_not_turned": 2.0, "turned_urad": 0.0}
>>> learned = {"error_um": 0.1, "masked": [], "reason": "all"}
>>> remaining_text(cut | {"form_error_um": form, "learning": learned}).split(";")[0]
'9 µm, likely of the first turns, elsewhere 1 µm'
"""

from __future__ import annotations

import numpy as np

from camtools.base.json_text import Json
from camtools.base.quantities import Floats, length_text

_END_TURNS = 20  # of a cut, at either end
_STANDS_OUT = 1.5  # times the median of all turns
_SEEN = 0.5  # share of the error that U's scale must show


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


def _is_turned(summary: Json) -> bool:
    """Return whether the rotation of the whole part makes up most of the rms error."""
    form = summary["form_error_um"]
    without = form.get("rms_not_turned")
    return without is not None and without < 0.7 * form["rms"]


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
    if _is_turned(summary):
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


def remaining_text(summary: Json) -> str | None:
    """Return the sentence, nothing if no turn was gauged.

    Parameters
    ----------
    summary
        Of camsim, with learning on.
    """
    largest_um = summary["form_error_um"]["max"]
    if largest_um is None:
        return None
    return f"{length_text(largest_um)}, likely {_cause(summary)}"
