"""What the pictures of a cut show, in words: for who cannot see them, and where they do not load.

>>> _variants_sentence([{"name": "complete", "max_um": 0.1}, {"name": "bare", "max_um": 2.0}])
'Largest error of the controller: complete 100 nm; bare 2 µm.'
"""

from __future__ import annotations

from typing import Any

import numpy as np

from camtools.base.quantities import length_text
from camtools.report.charts import following_sentence
from camtools.report.motion import following_by_angle
from camtools.report.text import fault_story
from camtools.sim.results import CUTTING, AnyCut

_ABOUT_THE_SURFACE = ("map", "sections", "section", "height", "skirt", "profile")


def _variants_sentence(variants: list[dict[str, Any]]) -> str:
    found = "; ".join(f"{one['name']} {length_text(one['max_um'])}" for one in variants)
    return f"Largest error of the controller: {found}."


def _learning_sentence(outcome: AnyCut) -> str:
    um = outcome.summary["error_per_turn_um"]
    first, last, least = (length_text(value) for value in (um[0], um[-1], min(um)))
    return f"Error of each of {len(um)} turns: {first} first, {last} last, {least} least."


def surface_sentence(outcome: AnyCut) -> str:
    """Return the error of the surface in words."""
    surface, form = outcome.surface, outcome.summary["form_error_um"]
    worst = int(np.argmax(np.abs(surface.error_um)))
    where = f"{360 * surface.turn[worst]:.1f}° and {surface.z_mm[worst]:.2f} mm"
    least, most = surface.error_um.min(), surface.error_um.max()
    return (
        f"Error {length_text(float(least))} to {length_text(float(most))}, the largest at {where}; "
        f"tolerance {length_text(form['tolerance'])}."
    )


def sentences_of(outcome: AnyCut) -> dict[str, str]:
    """Return what each picture of every kind shows, by its key."""
    found: dict[str, str] = {}
    if outcome.surface.turn.size:
        found |= dict.fromkeys(_ABOUT_THE_SURFACE, surface_sentence(outcome))
    if outcome.has_fault:
        found["fault"] = " ".join(f"{row.name}: {row.value}." for row in fault_story(outcome)[:3])
    if (outcome.trace.state == CUTTING).any():
        found["following"] = following_sentence(following_by_angle(outcome.trace))
    if outcome.trace.t_s.size > 1:
        whole = outcome.trace if outcome.overview is None else outcome.overview
        cutting = whole.t_s[whole.state == CUTTING]
        from_to = f", cutting from {cutting[0]:.2f} to {cutting[-1]:.2f} s" if cutting.size else ""
        found["sequence"] = f"State, Z, X and U over {whole.t_s[-1]:.2f} s{from_to}."
    if outcome.variants:
        found["compare"] = _variants_sentence([one._asdict() for one in outcome.variants])
    if len(outcome.summary.get("error_per_turn_um", [])) > 1:
        found["learning"] = _learning_sentence(outcome)
    return found
