# SPDX-License-Identifier: Apache-2.0
"""FIGURES.md has the figures of the recorded campaign, which was whole and found nothing."""

import json
from pathlib import Path

from tests.campaign.campaign_run import HOURS, figures_page, key_of
from tests.campaign.reactions import CASES, Reaction

HERE = Path(__file__).resolve().parent
FLAT = json.loads((HERE / "figures.json").read_text("utf-8"))


def test_page_has_the_recorded_figures() -> None:
    """It is made of figures.json as it is."""
    assert (HERE / "FIGURES.md").read_text("utf-8") == figures_page(FLAT)


def test_recorded_campaign_is_whole_and_found_nothing() -> None:
    """Hours at every rate, every disturbance with the reaction that is asked for, every fall."""
    assert FLAT["found"] == 0
    for hz, _, _ in HOURS:
        assert FLAT[f"hours_hours_at_{hz}_hz"] > 0.0
    for case in CASES:
        assert FLAT[f"{key_of(Reaction(case, ''))}_fault"] == case.fault, case.name
    for name in ("power_stm", "power_linux"):
        assert FLAT[f"{name}_falls"] == FLAT[f"{name}_old"] + FLAT[f"{name}_new"] > 0
