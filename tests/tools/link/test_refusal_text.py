"""The remedies of refusals."""

from typing import cast

from camtools.link.controller import Link
from camtools.link.messages import NAMES, NUMBERS, REFUSALS, Answer
from camtools.link.refusal_text import explain


class _Refusing:
    """Tells of its last refusal by numbers."""

    def __init__(self, result: str, **numbers: int) -> None:
        self.numbers = {"result": NUMBERS["result"][result]} | numbers

    def ask(self, command: str, parameter: int) -> Answer:
        """Answer a question about a number, or about the parameter that is the limit."""
        if command == "get_parameter":
            return Answer(
                command, "done", float(self.numbers.get("stroke", self.numbers["limit"])), parameter
            )
        assert command == "get_refusal"
        return Answer(command, "done", float(self.numbers.get(REFUSALS[parameter], 0)), 0)


def _explained(result: str, command: str, **numbers: int) -> str:
    link = cast("Link", _Refusing(result, **numbers))
    return explain(link, Answer(command, result, 0.0, 0))


def test_a_loop_that_is_not_set_is_told_with_its_remedy() -> None:
    """The name is that of cam_err.h."""
    assert "servo_none" in NAMES["result"].values()
    text = _explained("servo_none", "enable")
    assert text.startswith("refused: servo none; design the loop with tools/tune")


def test_a_parameter_of_the_loop_that_does_not_fit_is_named() -> None:
    """Many are set at once, so that the command does not tell it."""
    number = NUMBERS["parameter"]["servo_pole_hz"]
    text = _explained("servo", "apply", parameter=number, needed=5000)
    assert text.startswith("refused: servo_pole_hz = 5000 does not fit the others; keep ")
    assert "servo_pole_hz within a fifth" in text


def test_force_that_the_limits_of_u_take_is_told() -> None:
    """Needed and limit in newtons, then the remedy."""
    text = _explained("servo_force", "set_parameter", needed=390000, limit=375000)
    assert ": needs 390 N, limit 375 N (servo_force_limit_mn); raise servo_force_limit_mn" in text


def test_a_limit_of_the_table_is_not_taken_for_one_of_the_machine() -> None:
    """Half of a stroke is the machine's; any other number than that of the parameter is not."""
    for limit, source in ((375000, "u_stroke_nm"), (374999, "the table's")):
        link = _Refusing("u_stroke", needed=390000, limit=limit)
        link.numbers |= {"stroke": 750000}
        text = explain(cast("Link", link), Answer("start", "u_stroke", 0.0, 0))
        assert f"needs 0.39 mm, limit {limit / 1e6:.9g} mm ({source}); no speed is feas" in text
