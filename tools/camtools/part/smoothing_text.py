# SPDX-License-Identifier: Apache-2.0
"""What smoothing did to listed points, or would do, for programs and for people.

>>> residuals(0.5, np.array([0.1, -0.5]), np.array([10.0, 20.0]), "largest_at_mm")["largest_at_mm"]
20.0
>>> share_text(0.5, 5.0)
'smoothing takes 0.5 um of the tolerance of 5 um'
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.errors import GeometryError
from camtools.base.json_text import Json
from camtools.base.quantities import Floats, plain_number, rounded_up

_NOTHING_UM = 1e-5  # a residual below it is the rounding of the solver
_RISEN = 1 + 1e-3  # of a peak: more than numerical noise


class PeakChange(NamedTuple):
    """The largest magnitude of a derivative before and after smoothing."""

    name: str
    before: float
    after: float
    unit: str

    @property
    def text(self) -> str:
        """Return it in words."""
        return f"largest {self.name} from {self.before:.4g} to {self.after:.4g} {self.unit}"


def residuals(band_um: float, off_um: Floats, places: Floats, key: str) -> Json:
    """Return the residuals of smoothed points as data; `key` names the place of the largest."""
    worst = int(np.abs(off_um).argmax())
    return {
        "smooth_um": band_um,
        "largest_um": abs(float(off_um[worst])),
        key: float(places[worst]),
        "rms_um": float(np.sqrt(np.mean(off_um**2))),
    }


def smoothed_texts(what: str, facts: Json, place: str, peaks: list[PeakChange]) -> list[str]:
    """Return what smoothing did as lines for people.

    Parameters
    ----------
    facts : dict
        From `residuals`.
    place : str
        Of the largest residual, with its unit.
    peaks : list of PeakChange
        The second derivative is the first of them.
    """
    within = f"{what} smoothed within {facts['smooth_um']:g} um"
    if facts["largest_um"] < _NOTHING_UM:
        return [f"{within}: nothing changes, because its points are smooth already"]
    largest, rms = plain_number(facts["largest_um"]), plain_number(facts["rms_um"])
    changes = ", ".join(one.text for one in peaks)
    lines = [f"{within}: largest residual {largest} um at {place}, rms {rms} um; {changes}"]
    bend = peaks[0]
    if bend.after > _RISEN * bend.before:
        lines.append(
            f"warning: smoothing raises the largest {bend.name} of the {what}; remove smooth_um, "
            "or change it until the value falls"
        )
    return lines


def noise_text(what: str, remedy: str, peaks: list[PeakChange]) -> str:
    """Return the warning of points that should be smoothed."""
    changes = ", ".join(one.text for one in peaks)
    return f"warning: the {what} is noisy or rounded coarsely: {remedy} would change {changes}"


def band_words(band_um: float, taken_um: float, form_error_um: float) -> str:
    """Return the keys that smooth points within a band, with a tolerance that it leaves room in.

    >>> band_words(0.5, 0.5, 1.0), band_words(2.5, 2.5, 1.0)
    ('smooth_um = 0.5', 'smooth_um = 2.5 with process.form_error_um = 5')
    """
    allowed_um = form_error_for(taken_um, form_error_um)
    more = "" if allowed_um == form_error_um else f" with process.form_error_um = {allowed_um:g}"
    return f"smooth_um = {band_um:g}{more}"


def form_error_for(taken_um: float, form_error_um: float) -> float:
    """Return the form error, or twice what smoothing takes where it takes all of it."""
    return form_error_um if taken_um < form_error_um else rounded_up(2 * taken_um)


def share_text(taken_um: float, form_error_um: float) -> str:
    """Return how much of the tolerance smoothing takes."""
    taken = plain_number(taken_um)
    return f"smoothing takes {taken} um of the tolerance of {plain_number(form_error_um)} um"


def sheet_note(form: Json, taken_um: float) -> str:
    """Return what the sheets of a part with smoothed points must state, nothing of others."""
    if taken_um == 0:
        return ""
    share = share_text(taken_um, form["tolerance"] + taken_um)
    return f"the drawing is that with smoothed points; {share}, and so much less is accepted here"


def check_share(field: str, taken_um: float, form_error_um: float) -> None:
    """Refuse smoothing that leaves nothing of the tolerance for the cut.

    Parameters
    ----------
    field : str
        Dotted path of smooth_um.
    taken_um : float
        How far smoothing moves the surface at most, along the radius or the lift.
    """
    if taken_um and taken_um >= form_error_um:
        problem = (
            f"smoothing moves the surface by up to {plain_number(taken_um)} um, which leaves "
            f"nothing of process.form_error_um = {form_error_um:g}"
        )
        remedy = f"reduce smooth_um, or set process.form_error_um above {rounded_up(taken_um):g}"
        raise GeometryError(field, problem, remedy)
