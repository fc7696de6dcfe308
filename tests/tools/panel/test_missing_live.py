"""What is missing, compared with what the firmware really refuses.

For each situation the order that leads on is refused, its first missing item tells why and vanishes
when it is done; when nothing is missing the order is accepted.
"""

import pytest

from camtools.link.controller import Link
from camtools.link.kept_values import get_all
from camtools.link.operator import AXES, carry_out
from camtools.link.refusal_text import ask_done
from camtools.panel.views.availability import NextSteps, next_steps
from checks.patience import limit_s
from tests.tools.cases.camctl_bench import FAULTS, Bench
from tests.tools.cases.live_cases import LinkCase

# By switch, as they stand, by switch: each axis has its place, and the part stays where it was.
HOMES = {"u_home": 2, "z_home": 1, "x_home": 2, "x_home_nm": 61_000_000, "homing_required": 1}


class Operator(LinkCase):
    """Gives the orders that lead on, with the parameters of the controller."""

    def __init__(self, link: Link) -> None:
        super().__init__(link)
        self.values = get_all(link)

    def steps(self) -> NextSteps:
        """Return what is missing by a status that is yet to come."""
        self.link.status.signals.clear()
        status = self.link.listen()
        return next_steps(status.state, status.signals, self.values)

    def missing(self) -> list[str]:
        """Return the names of what is missing."""
        return [item.key for item in self.steps().missing]

    def set(self, **values: int) -> None:
        """Set parameters and read them all."""
        super().set(**values)
        self.values = get_all(self.link)

    def refused(self, result: str) -> None:
        """Give the order that leads on; it must be refused for a reason, and something missing."""
        steps = self.steps()
        answer = self.link.ask(steps.order)
        assert steps.missing and answer.result == result, (steps, answer)

    def goes_on(self, state: str) -> None:
        """Give the order that leads on, with nothing missing; it must be accepted."""
        steps = self.steps()
        assert not steps.missing, steps
        self.order(steps.order, state)

    def home(self, axis: str) -> None:
        """Home an axis by hand."""
        self.order("manual", "manual")
        assert carry_out(self.link, "home_axis", axis) == "done"
        ask_done(self.link, "disable", AXES[axis])
        self.until("off")


@pytest.mark.long
def test_what_is_missing_is_what_the_firmware_refuses(bench: Bench, link: Link) -> None:
    """Inputs, then homes that are demanded, then the whole way to a part, a fault and back."""
    operator = Operator(link)
    for name in FAULTS:
        bench.fault(name, is_there=True)
        assert link.wait(lambda: operator.missing()[:1] == [name], limit_s())  # noqa: B023
        operator.refused(name)
        bench.fault(name, is_there=False)
        assert link.wait(lambda: operator.missing() == [], limit_s())
    operator.set(u_stroke_nm=1000)
    assert operator.missing() == [] and link.ask("enable").result == "u_stroke"
    operator.set(u_stroke_nm=1_200_000, **HOMES)
    left = ["home_u", "home_x", "home_z"]
    for axis in ("u", "x", "z"):
        assert operator.missing() == left
        left = left[1:]
        operator.refused("not_homed")
        operator.home(axis)
    operator.goes_on("homing")
    assert operator.missing()[:1] in (["turn"], ["index"], [])
    operator.until("ready")
    operator.goes_on("engaging")
    operator.until("cutting")
    ask_done(link, "hold")
    operator.until("holding")
    operator.goes_on("cutting")
    bench.fault("estop", is_there=True)
    operator.until("fault")
    assert "estop" in operator.missing()
    bench.fault("estop", is_there=False)
    assert link.wait(lambda: operator.missing() == [], limit_s())
    operator.goes_on("off")
    operator.goes_on("ready")
