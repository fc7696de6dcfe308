"""What tools/run is asked for, whatever the kind of the part.

>>> RunJob(Correcting(), feed=0.5).feed_words()
['--feed', '0.5']
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated

from camtools.base.arguments import Option, Word, option_of, positive
from camtools.base.errors import CamtoolsError
from camtools.base.files import cannot_write
from camtools.base.project import RESULTS, ROOT, shown_name
from camtools.base.quantities import plain_number
from camtools.cut.correction import Correction
from camtools.measured.correction_round import DEFAULT_GAIN, Request, next_round
from camtools.measured.correction_step import cautions
from camtools.part.common import PartFile, Tool, check_tracks, is_feed_within
from camtools.pipeline.load import Loaded, Made
from camtools.roundness.section import DEFAULT_UPR, UPR_CHOICES
from camtools.sim.drawn_parts import DrawnParts, cut_facts, read_parts, refuse_zones
from camtools.sim.machine_file import machine_bytes, names
from camtools.table.header import check_tolerance

_MEASURED = Option(
    "correct the table by the measured surface of a part, from camsim or as angle, height and "
    "deviation (tools/docs/MEASURED.md)",
    "SURFACE.csv",
)
_PREVIOUS = Option(
    "summary of the table that cut that part (default: next to the surface)", "NAME.json"
)
_GAIN = Option(f"share of the deviation to correct (default: {DEFAULT_GAIN})", "G")
_HARMONICS = Option("highest harmonic to correct, in waves per turn (default: 16)", "N")
_CENTRED = Option("do not correct mean and centre, which the instrument has removed")


@dataclass(frozen=True)
class Correcting:
    """How the surface of a gauged part corrects the next table."""

    measured: Annotated[Path | None, _MEASURED] = None
    previous: Annotated[Path | None, _PREVIOUS] = None
    gain: Annotated[float | None, _GAIN] = None
    keep_harmonics: Annotated[int | None, _HARMONICS] = None
    centred: Annotated[bool, _CENTRED] = False

    def __post_init__(self) -> None:
        for option in fields(self) if self.measured is None else ():
            if getattr(self, option.name) not in (None, False):
                problem = f"{option_of(option.name)}: has no effect without --measured"
                raise CamtoolsError([f"{problem}; add --measured SURFACE.csv"])

    def correction(self, loaded: Loaded, output: Path | None) -> Correction | None:
        """Return the correction that is asked for, nothing without --measured.

        The new table must not take the place of the one that cut the part: a folder `output` that
        holds that one is refused. Errors as of `next_round`.
        """
        if self.measured is None:
            return None
        kind, part = loaded
        name = part.part.name
        gain = DEFAULT_GAIN if self.gain is None else self.gain
        request = Request(self.measured, self.previous, gain, self.keep_harmonics, self.centred)
        found = next_round(request, name, kind.drawing(part))
        path = found.previous.path
        if output is not None and (output / f"{name}.json").resolve() == path.resolve():
            problem = f"has the {name}.json of the table that cut the measured part"
            raise CamtoolsError([f"-o {output}: {problem}; give another folder for each round"])
        for line in cautions(part.process, getattr(part, "tool", None), found.previous.report):
            sys.stderr.write(f"{line.strip()}\n")
        return found.correction


RUNS = RESULTS / "run"
_MAX_FEED_MM = 10.0  # range of the firmware's parameter
DEFAULT_PART = ROOT / "tools" / "parts" / "perkins240.toml"
MACHINE_HELP = (
    f"machine file, or one of {', '.join(names())} (default: a machine with the part's limits)"
)
_OURS = (
    *("--rpm", "--feed", "--trace", "--surface", "--summary", "--sections", "--sections-mm"),
    *("--design", "--progress", "--help"),
)


def _count(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text}: give a whole number of at least 1")
    return value


def _above_0(option: str, unit: str) -> Callable[[str], float]:

    def read(text: str) -> float:
        try:
            return positive(text)
        except (ValueError, argparse.ArgumentTypeError) as error:
            problem = f"{option} {text}: must be a finite number above 0"
            remedy = f"give {unit}, or leave it out for the part's own"
            raise CamtoolsError([f"{problem}; {remedy}"]) from error

    return read


_RPM = Option("spindle speed in r/min (default: the part's)", "N", read=_above_0("--rpm", "r/min"))
_FEED = Option(
    "feed in mm per turn (default: the part's)", "MM", read=_above_0("--feed", "mm per turn")
)
_TOLERANCE = Option(
    *("largest error of the table in nm (default: as tools/mktables)", "T"),
    read=_above_0("--tolerance-nm", "nm"),
)
_UPR = Option(
    "cut-off of the Gaussian roundness filter in the measurement sheets, in waves per turn "
    f"(default: {DEFAULT_UPR})",
    choices=UPR_CHOICES,
)
_FORECAST = Option(
    "judge with the uncertainty of the machine: a forecast of this cut with --sections", "DIR"
)
_KEEP = Option(
    "delete all but the N newest runs in build/run, this one included (default: keep all)",
    "N",
    read=_count,
)
_OUTPUT = Option(
    "folder for the results (default: build/run/NAME, NAME-roundN for a corrected table)",
    *("DIR", "-o"),
)


@dataclass(frozen=True)
class RunJob:
    """What was asked for, checked as far as this is possible without the part."""

    correcting: Correcting
    part: Annotated[Path, Word("part file (default: perkins240)", "PART.toml")] = DEFAULT_PART
    rpm: Annotated[float | None, _RPM] = None
    feed: Annotated[float | None, _FEED] = None
    machine: Annotated[bytes | None, Option(MACHINE_HELP, "M", read=machine_bytes)] = None
    tolerance_nm: Annotated[float | None, _TOLERANCE] = None
    upr: Annotated[int, _UPR] = DEFAULT_UPR
    forecast: Annotated[Path | None, _FORECAST] = None
    csv: Annotated[bool, Option("also write the trace as trace.csv")] = False
    keep: Annotated[int | None, _KEEP] = None
    output: Annotated[str | None, _OUTPUT] = None
    extra: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.tolerance_nm is not None:
            check_tolerance(self.tolerance_nm)
        if self.output == "":
            raise CamtoolsError(["-o: an empty path; give a folder"])
        if self.keep is not None and self.output:
            raise CamtoolsError(["--keep: applies only to build/run; leave out -o or --keep"])
        if self.forecast is not None and self.upr != DEFAULT_UPR:
            problem = f"--upr {self.upr}: forecasts have {DEFAULT_UPR}"
            raise CamtoolsError([f"{problem}; leave out --upr or --forecast"])

    def with_words(self, words: Sequence[str]) -> "RunJob":
        """Return the job with the user's words for camsim, which works in another folder."""
        for word in words:
            if word.split("=")[0] in _OURS:
                raise CamtoolsError([f"-- {word}: is set by tools/run itself; leave it out"])
        found = (str(Path(word).resolve()) if Path(word).is_file() else word for word in words)
        return replace(self, extra=tuple(found))

    def check_feed(self, part: PartFile) -> None:
        """Refuse a feed that camsim would refuse, before anything is made."""
        feed_mm, tool = self.feed, getattr(part, "tool", None)
        if feed_mm is not None and isinstance(tool, Tool):
            check_tracks(tool, feed_mm)
        if feed_mm is None or (feed_mm <= _MAX_FEED_MM and is_feed_within(part, feed_mm)):
            return
        most_mm = min(part.height_mm, _MAX_FEED_MM)
        why = "the height of the part" if most_mm < _MAX_FEED_MM else "the limit of the firmware"
        problem = f"--feed {feed_mm:.9g}: must be at most {most_mm:.9g} mm, {why}"
        raise CamtoolsError([f"{problem}; give at most --feed {most_mm:.9g}"])

    def folder(self, name: str, n_rounds: int = 0) -> Path:
        """Return the output folder for a part's name, and a table of so many rounds."""
        own = f"{name}-round{n_rounds}" if n_rounds else name
        return Path(self.output) if self.output else RUNS / own

    def tolerance(self, form_error_um: float, taken_um: float) -> list[str]:
        """Return what smoothing leaves of the form error, given or the part's, as words."""
        given = _last_value(self.extra, "--tolerance-um")
        if given is None:
            return ["--tolerance-um", repr(form_error_um - taken_um)]
        if taken_um == 0:
            return []
        try:
            left_um = float(given) - taken_um
        except ValueError:
            return []  # camsim refuses it
        if left_um <= 0:
            problem = f"--tolerance-um {given}: smoothing takes {plain_number(taken_um)} um"
            raise CamtoolsError([f"{problem}; allow more, or reduce smooth_um"])
        return ["--tolerance-um", repr(left_um)]

    def drawn(self, made: Made) -> DrawnParts | None:
        """Return the parts of the forecast that is given, which must be of this cut."""
        if self.forecast is None:
            return None
        part = made.table.part
        refuse_zones(part, "--forecast")
        text = made.kind.machine(part) if self.machine is None else self.machine.decode("utf-8")
        words = [] if self.rpm is None else ["--rpm", repr(self.rpm)]
        words += [*self.feed_words(), *self.extra]
        table = made.files(with_plots=False)[f"{part.part.name}.camtab"]
        return read_parts(self.forecast, cut_facts(table, part, text, words))

    def feed_words(self) -> list[str]:
        """Return camsim's options for the feed, when one is given."""
        return [] if self.feed is None else ["--feed", repr(self.feed)]


def _last_value(words: Sequence[str], name: str) -> str | None:
    """Return the value that camsim's words give an option last, nothing where they do not."""
    found = None
    for word, following in pairwise([*words, ""]):
        key, equals, value = word.partition("=")
        if key == name:
            found = value if equals else following
    return found


def without_faults(words: Sequence[str]) -> list[str]:
    """Return camsim's words without --inject and its value."""
    kept, skips = [], False
    for word in words:
        if not skips and not word.startswith("--inject"):
            kept.append(word)
        skips = not skips and word == "--inject"
    return kept


def say(text: str) -> None:
    """Report progress on standard error."""
    print(f"{shown_name('run')}: {text}", file=sys.stderr, flush=True)


def write_files(folder: Path, files: dict[str, bytes]) -> None:
    """Write files into a folder, or refuse what cannot be written."""
    try:
        for name, data in files.items():
            (folder / name).write_bytes(data)
    except OSError as error:
        raise cannot_write(folder.parent, error) from error


def shown(folder: Path) -> str:
    """Return a folder as the user may type it, relative when it lies below."""
    try:
        return str(folder.resolve().relative_to(Path.cwd()))
    except ValueError:
        return str(folder)
