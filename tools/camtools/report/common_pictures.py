"""Pictures that the report of every kind of part has, and what to look for in them.

>>> [picture.key for picture in in_order({"a": ("", ""), "b": ("", "")}, {"b": Figure})]
['b']
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from matplotlib.figure import Figure

from camtools.report.compare import draw_variants
from camtools.report.learning import convergence
from camtools.report.motion import draw_fault, draw_following, draw_sequence
from camtools.report.page import Picture
from camtools.sim.results import CUTTING, FAULT, AnyCut

Drawers = Mapping[str, Callable[[], Figure]]
"""What draws each picture, by its key."""

SEQUENCE_TEXT = (
    "Sequence of the cut",
    "Homing finds the index with U out of the work; engaging brings X to depth and increases the "
    "stroke of U smoothly from zero; disengaging is the reverse. No line may jump; only the green "
    "stretch counts for the verdict.",
)
COMPARE_TEXT = (
    "What each part of the controller contributes",
    "The same cut with parts of the controller switched off; the scale is logarithmic. Dead-time "
    "lead plays the table ahead by the reaction time of the drive; feed-forward adds the velocity "
    "and acceleration of the table so that U does not lag.",
)


def common_drawers(outcome: AnyCut, angle: str) -> dict[str, Callable[[], Figure]]:
    """Return what can be drawn of any cut, against the spindle's angle of this name."""
    trace, variants = outcome.trace, outcome.variants
    drawers = convergence(outcome.summary)
    if (trace.state == FAULT).any():
        retract_s = outcome.summary.get("fault", {}).get("retract_s", 0.0)
        drawers["fault"] = lambda: draw_fault(trace, retract_s)
    if (trace.state == CUTTING).any():
        drawers["following"] = lambda: draw_following(trace, angle)
    if trace.t_s.size > 1:
        drawers["sequence"] = lambda: draw_sequence(trace, outcome.overview)
    if len(variants) > 1:
        tolerance_um = outcome.summary["form_error_um"]["tolerance"]
        drawers["compare"] = lambda: draw_variants(variants, tolerance_um)
    return drawers


def in_order(texts: Mapping[str, tuple[str, str]], drawers: Drawers) -> list[Picture]:
    """Return the pictures that can be drawn, in the order of their titles and texts."""
    return [Picture(key, *text, drawers[key]) for key, text in texts.items() if key in drawers]
