# SPDX-License-Identifier: Apache-2.0
"""The short form: bits that move an axis if nobody notices them, most of which somebody has to."""

from __future__ import annotations

import re
from collections.abc import Sequence

from flips_campaign import Outcome
from flips_image import MEMORY, Strike
from flips_judge import WRONG
from flips_layout import Layout
from flips_plan import Planner

COUNT, MOST_WRONG, LEAST_RETRACTED = 160, 5, 80  # found at first: 4 and 103
_NUMBER = r".*\+[1-6]"  # not its lowest byte, and no flag
_AIMED = {  # members whose flips are watched for
    "state": r"g_cam\.(motion\.(state|u_home_nm|axis.*(pos|vel)_q10|height_q32|scale_q30|phase_q32)"
    r"|tell\.(u\.|vel)|watch\.led|plan\.|spindle\.)" + _NUMBER,
    "configuration": r"g_cam\.config\.half\[\d\]\.(play|tell|guard)\." + _NUMBER,
}


def _aimed(planner: Planner, layout: Layout, stratum: str) -> list[int]:
    """Return the bytes of a stratum whose flips are watched for."""
    pattern = re.compile(_AIMED[stratum])
    every = (a for p in planner.places[stratum] for a in range(p.address, p.address + p.size))
    return [a for a in every if pattern.fullmatch(layout.of_address(a) or "")]


def short_strikes(planner: Planner, layout: Layout) -> list[Strike]:
    """Return the strikes, as many in each stratum."""
    strikes = []
    for stratum in _AIMED:
        places = _aimed(planner, layout, stratum)
        for _ in range(COUNT // len(_AIMED)):
            place = int(planner.rng.choice(places))
            bit = int(planner.rng.integers(8))
            strikes.append(Strike(*planner.when(is_main=False), MEMORY, place, bit, stratum))
    return strikes


def judge_short(outcomes: Sequence[Outcome]) -> str:
    """Return what is wrong with a short campaign, nothing where all is well."""
    n_wrong = sum(o.verdict.kind in WRONG for o in outcomes)
    n_retracted = sum(o.verdict.kind == "detected" for o in outcomes)
    if n_wrong > MOST_WRONG:
        return f"{n_wrong} of {len(outcomes)} moved an axis wrongly, {MOST_WRONG} may"
    if n_retracted < LEAST_RETRACTED:
        return f"{n_retracted} of {len(outcomes)} were noticed, {LEAST_RETRACTED} have to be"
    return ""
