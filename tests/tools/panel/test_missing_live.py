# SPDX-License-Identifier: Apache-2.0
"""What is missing, compared with what the firmware of a live lathe really refuses.

For each situation the order that leads on is refused, its first missing item tells why and vanishes
when it is done; when nothing is missing the order is accepted.
"""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from camtools.link.manual_axes import AXES, carry_out
from camtools.link.messages import Refused
from camtools.link.parameters import get_all
from camtools.link.refusal_text import ask_done
from camtools.panel.views.missing import Way, way_on
from checks.patience import limit_s, until
from tests.tools.cases.live_cases import LiveCase, live_case

# What is missing does not depend on how fast axes search.
PACES = {"{}_jog_um_per_s": 100_000, "{}_home_um_per_s": 100_000, "{}_home_slow_um_per_s": 20_000}
QUICK = {name.format(axis): value for axis in "xz" for name, value in PACES.items()}


class Bench(LiveCase):
    """A live lathe, and the parameters of its controller."""

    def __init__(self, case: LiveCase) -> None:
        super().__init__(case.lathe, case.link)
        self.values = get_all(self.link)

    def way(self) -> Way:
        """Return what is missing by a status that is yet to come."""
        self.link.status.signals.clear()
        status = self.link.listen()
        return way_on(status.state, status.signals, self.values)

    def missing(self) -> list[str]:
        """Return the names of what is missing."""
        return [item.key for item in self.way().missing]

    def happens(self, word: str) -> None:
        """Let something happen to the lathe."""
        self.lathe.type(word)
        self.lathe.wait_for(f"{word}: done")
        self.link.wait(lambda: False, 0.1)

    def set(self, **values: int) -> None:
        """Set parameters and read them all."""
        super().set(**values)
        self.values = get_all(self.link)

    def refused(self, result: str) -> None:
        """Give the order that leads on; it must be refused for a reason, and something missing."""
        way = self.way()
        answer = self.link.ask(way.order)
        assert way.missing and answer.result == result, (way, answer)

    def goes_on(self, state: str) -> None:
        """Give the order that leads on, with nothing missing; it must be accepted."""
        way = self.way()
        assert not way.missing, way
        ask_done(self.link, way.order)
        self.until(state)

    def home(self, axis: str) -> None:
        """Home an axis by hand; on a computer that is too busy to keep the order alive, again."""
        ask_done(self.link, "manual")
        self.until("manual")

        def is_done() -> bool:
            with suppress(Refused):
                return carry_out(self.link, "home_axis", axis) == "done"
            return False

        until(is_done, f"home {axis}")
        ask_done(self.link, "disable", AXES[axis])
        self.until("off")


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    """Run a live lathe of its own."""
    with live_case(tmp_path) as case:
        yield Bench(case)


def test_what_is_missing_is_what_the_firmware_refuses(bench: Bench) -> None:
    """Inputs, then homes that are demanded, then the whole way to a part, a fault and back."""
    bench.set(**QUICK)
    for word, key in (("estop", "estop"), ("drive", "drive"), ("bus", "bus")):
        bench.happens(word)
        assert bench.missing()[0] == key
        bench.refused(key)
        bench.happens("release")
        assert bench.missing() == []
    bench.set(u_stroke_nm=1000)
    assert bench.missing() == [] and bench.link.ask("enable").result == "u_stroke"
    bench.set(u_stroke_nm=1_200_000, homing_required=1)
    left = ["home_u", "home_x", "home_z"]
    for axis in ("u", "x", "z"):
        assert bench.missing() == left
        left = left[1:]
        bench.refused("not_homed")
        bench.home(axis)
    bench.goes_on("homing")
    assert bench.missing()[:1] in (["turn"], ["index"], [])
    bench.until("ready")
    bench.goes_on("engaging")
    bench.until("cutting")
    ask_done(bench.link, "hold")
    bench.until("holding")
    bench.goes_on("cutting")
    bench.happens("estop")
    bench.until("fault")
    assert "estop" in bench.missing()
    bench.happens("release")
    assert bench.link.wait(lambda: bench.missing() == [], limit_s())
    bench.goes_on("off")
    bench.goes_on("ready")
