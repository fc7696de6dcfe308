# SPDX-License-Identifier: Apache-2.0
"""The recorded campaign, which the safety case quotes, is whole and found nothing."""

import json
from pathlib import Path

from tests.fuzz.fuzzing import TARGETS

HERE = Path(__file__).resolve().parent


def test_recorded_campaign_ran_every_target_and_found_nothing() -> None:
    """Each target was executed, and the executions add up."""
    flat = json.loads((HERE / "figures.json").read_text("utf-8"))
    targets = {path.stem.removeprefix("target_") for path in (HERE / "targets").glob("target_*.c")}
    assert targets == {key.removesuffix("_executions") for key in flat if "_executions" in key}
    assert flat["found"] == 0
    assert flat["executions"] == sum(flat[f"{name}_executions"] for name in targets)


def test_machines_sessions_and_commands_get_half_of_the_time() -> None:
    """The fast readers do not take the time of the states that are deep."""
    deep = sum(target.share for target in TARGETS if target.name in ("machine", "session", "can"))
    assert 2 * deep >= sum(target.share for target in TARGETS)
