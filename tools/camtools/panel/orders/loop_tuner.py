"""The position loop of a U that takes forces: measured, proposed and set, in the link's thread.

>>> LoopTuner().newest is None
True
"""

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

from camtools.identify.drives import ConnectedU
from camtools.link.controller import Link
from camtools.link.messages import Refused
from camtools.tune.excited import (
    Recorded,
    fitted,
    measure_pulse,
    pulse_lines,
    pulse_settings,
    recorded,
)
from camtools.tune.judgement import proposed, subject_of
from camtools.tune.parameters import settings_of

_LOOK_S = 1.0
_NAME = "U"
Say = Callable[[str], None]


@dataclass(frozen=True)
class Tuned:
    """What a measurement of U shows, for pages."""

    text: str  # the report of tools/tune
    picture: bytes  # of the loop, a PNG; empty where the loop is refused
    settings: Mapping[str, int]  # that `apply` sets; empty where the loop is refused or set
    problem: str = ""  # why the loop is refused


def tuned(record: Recorded, where: str) -> Tuned:
    """Return the report and the loop for a record, as tools/tune makes them."""
    from camtools.tune.plots import loop_png  # matplotlib is slow to load

    subject = subject_of(fitted(record), {}, _NAME, where)
    found = proposed(subject)
    if found.problem:
        return Tuned("\n".join(subject.lines), b"", {}, found.problem)
    picture = loop_png(found.judged, "position loop of U", subject.measured)
    settings = settings_of(found.values, subject.drive, subject.is_measured)
    return Tuned("\n".join(found.lines), picture, settings)


class LoopTuner:
    """The newest measurement of U; its orders raise CamtoolsError or Refused with the reason."""

    def __init__(self) -> None:
        self.newest: Tuned | None = None  # also while a new one is under way

    def push(self, link: Link, force_n: float, say: Say) -> str:
        """Push U in both directions; sign, mass and friction are what `apply` then sets."""
        self.newest = None
        say("the pulse of U")
        found = measure_pulse(ConnectedU(link, keeps_command=True), force_n)
        lines = list(pulse_lines(found))
        if found.sign < 0:
            self.newest = Tuned("\n".join(lines), b"", {}, lines[0])
            raise Refused(lines[0])
        self.newest = Tuned("\n".join(lines), b"", pulse_settings(found))
        return "mass and friction are known; see the report, then apply them"

    def measure(self, link: Link, say: Say, rests: Callable[[], None] = lambda: None) -> str:
        """Excite U and propose a loop; the link is served while that is computed.

        When U stands again `rests` is called: what follows needs nobody at the page.
        """
        self.newest = None
        say("the measurement of U")

        def progress(here: int, in_all: int) -> None:
            rests()
            say(f"the record of U, {here * 100 // in_all} %")

        record = recorded(ConnectedU(link, keeps_command=True, progress=progress), link.where)
        say("the loop of U, which is computed")
        pool = ThreadPoolExecutor(1)
        computed = pool.submit(tuned, record, link.where)
        pool.shutdown(wait=False)
        while not link.wait(computed.done, _LOOK_S):
            pass  # STOP ends it
        self.newest = computed.result()
        if self.newest.problem:
            raise Refused(self.newest.problem)
        return "a loop with the margins is proposed; see the report, then apply it"

    def apply(self, link: Link, say: Say) -> str:
        """Switch the drives off and set what was proposed, or nothing where that is refused."""
        newest = self.newest
        if newest is None or not newest.settings:
            raise Refused("nothing is proposed; measure first")
        say("what U's measurement proposed, which is set")
        ConnectedU(link, keeps_command=True).apply(newest.settings)
        self.newest = replace(newest, settings={})
        what = f"{len(newest.settings)} parameters are set, the drives are off"
        return f"{what}; enable, home and measure again, then keep the parameters"
