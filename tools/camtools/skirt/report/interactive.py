"""What of the report of a skirt is alive: the board of its surface, U over one turn.

>>> ANGLE
'spindle angle from the long axis'
"""

from __future__ import annotations

from camtools.base.quantities import NM_PER_MM
from camtools.report.board import board_of
from camtools.report.charts import TurnOfU, motion_sentence
from camtools.report.page_scripts import Live, charts_of
from camtools.skirt.report.motion_plot import motion_at
from camtools.skirt.report.outcome import SkirtOutcome
from camtools.skirt.report.shape_plot import enlargement_of

ANGLE = "spindle angle from the long axis"


def motion_of(outcome: SkirtOutcome) -> TurnOfU:
    """Return U over the turn in which it moves most."""
    generated = outcome.generated
    speed, middle_mm = generated.speed, generated.middle_nm / NM_PER_MM
    law = speed.channel if speed is not None else None
    speed_rpm = outcome.summary["cut"]["spindle_rpm"]
    return motion_at(outcome.trace, generated.geometry, speed_rpm, middle_mm, law)


def live_of(outcome: SkirtOutcome) -> Live:
    """Return what of a report is alive."""
    geometry, magnify = outcome.generated.geometry, outcome.generated.part.magnify
    board = board_of(
        outcome.surface,
        (geometry.z_first_mm, geometry.z_last_mm),
        outcome.summary["cut"]["feed_mm"],
        outcome.summary["form_error_um"]["tolerance"],
        enlargement_of(magnify.factor if magnify else 1.0),
    )
    motion = motion_of(outcome)
    charts = charts_of(outcome.trace, motion)
    return Live(board, ANGLE, charts, {"motion": motion_sentence(motion)})
