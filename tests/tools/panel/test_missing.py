"""What is missing to go on: a sentence for everything, in the order in which it must be done."""

from itertools import product

import pytest

from camtools.link.messages import NAMES
from camtools.panel.views.availability import RULES, next_steps, stop_order, why_not
from camtools.panel.views.wording import LOOKS, look

STATES = list(NAMES["state"].values())
INPUTS = {
    "is_estop": (0.0, 1.0),
    "is_drive_ready": (0.0, 1.0),
    "is_bus_lost": (0.0, 1.0),
    "table_size": (0.0, 3456.0),
    "is_synced": (0.0, 1.0),
    "is_retracted": (0.0, 1.0),
    "speed": (-100.0, 0.0, 2500.0),
}
GOOD = {name: values[-1] for name, values in INPUTS.items()} | {"is_estop": 0.0, "is_bus_lost": 0.0}


def test_every_state_has_a_look_of_its_own() -> None:
    """Word and shape of two states are never the same: colour is never needed alone."""
    assert set(LOOKS) == set(STATES)
    assert len({one.word for one in LOOKS.values()}) == len(STATES)
    assert len({one.icon for one in LOOKS.values()}) == len(STATES)
    assert look("cutting", is_connected=False).word == "NO CONNECTION"
    assert look("unknown", is_connected=True).word == "WAITING"


@pytest.mark.parametrize("state", [*STATES, "unknown"])
def test_every_state_and_input_gives_sentences(state: str) -> None:
    """Each ends with a full stop, none stands there twice."""
    for values in product(*INPUTS.values()):
        signals = dict(zip(INPUTS, values, strict=True))
        for is_connected in (True, False):
            sentences = next_steps(state, signals, {}, is_connected=is_connected).sentences
            assert sentences and all(text.endswith(".") for text in sentences)
            assert len(set(sentences)) == len(sentences)


@pytest.mark.parametrize("state", STATES)
def test_nothing_is_missing_where_all_is_well(state: str) -> None:
    """The order that leads on is one that makes sense in that state."""
    signals = GOOD | {"is_held": float(state == "holding")}
    steps = next_steps(state, signals, {})
    assert not steps.missing, steps
    if steps.order:
        assert why_not(steps.order, state, signals) == ""


BAD = {"is_estop": 1.0, "is_drive_ready": 0.0, "is_bus_lost": 1.0, "table_size": 0.0}
HOMES = {"homing_required": 1, "x_home": 2, "z_home": 2, "u_stroke_nm": 1_000_000}
# State, changed signals, parameters; what is missing, and the order that is offered.
MISSING = [
    (
        *("off", BAD | {"u_actual": -0.6}, HOMES),
        *("estop drive bus table u_place home_x home_z", "enable"),
    ),
    # A Z that another controller moves needs no home, as cam_machine_jog.c has it.
    ("off", {}, {"homing_required": 1, "z_home": 2, "z_is_measured": 1}, "", "enable"),
    ("homing", {"speed": 0.0}, {}, "turn", ""),
    ("homing", {"speed": -100.0}, {}, "sense", ""),
    ("homing", {"is_synced": 0.0}, {}, "index", ""),
    ("rehearsing", {"start_wait": 1.0}, {}, "steady", ""),
    ("engaging", {"start_wait": 1.0}, {}, "steady", ""),
    ("ready", {"start_wait": 2.0}, {}, "unsteady", "start"),
    # Resume would be refused: the override is to be raised.
    ("holding", {"is_held": 0.0, "override_of_feed": 0.0}, {}, "feed", ""),
]


@pytest.mark.parametrize(("state", "changed", "values", "missing", "order"), MISSING)
def test_what_is_missing_is_told_in_the_order_of_doing(
    state: str, changed: dict[str, float], values: dict[str, int], missing: str, order: str
) -> None:
    """People and power come first, then the table, then the places of the axes."""
    steps = next_steps(state, GOOD | changed, values)
    assert [item.key for item in steps.missing] == missing.split()
    assert steps.order == order and steps.sentence == steps.sentences[0]


@pytest.mark.parametrize("state", STATES)
def test_every_order_is_possible_or_says_why_not(state: str) -> None:
    """A button that is off has a reason; stop always has a meaning."""
    for order in RULES:
        reason = why_not(order, state, GOOD)
        assert reason == reason.strip() and not reason.endswith(".")
    assert stop_order(state) in ("stop", "disable")


def test_reset_waits_for_the_retract() -> None:
    """The controller refuses it until then."""
    assert "still leaving the work" in why_not("reset", "fault", {"is_retracted": 0.0})
    assert why_not("reset", "fault", {"is_retracted": 1.0}) == ""
