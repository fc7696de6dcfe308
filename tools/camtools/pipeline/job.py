"""What tools/run was asked for, whatever the kind of the part.

>>> RunJob(["--feed", "0.5"]).feed_words()
['--feed', '0.5']
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from itertools import pairwise
from math import isfinite
from pathlib import Path

from camtools.base.command import Parser
from camtools.base.errors import CamtoolsError
from camtools.base.output import cannot_write
from camtools.base.project_paths import RESULTS, ROOT, shown_name
from camtools.base.provenance import origin_of
from camtools.base.quantities import plain_number
from camtools.part.common import PartFile, is_feed_within
from camtools.part.tool import Tool, check_tracks
from camtools.pipeline.correct_options import add_measured, request_of
from camtools.roundness.waves import DEFAULT_UPR, UPR_CHOICES
from camtools.sim.machines import machine_bytes, names
from camtools.table.header import check_tolerance

RUNS = RESULTS / "run"
_MAX_FEED_MM = 10.0  # range of the firmware's parameter
_DEFAULT_PART = ROOT / "tools" / "parts" / "perkins240.toml"
_OURS = (
    "--rpm",
    "--feed",
    "--trace",
    "--surface",
    "--summary",
    "--sections",
    "--sections-mm",
    "--design",
    "--progress",
    "--help",
)
_EPILOG = """\
Options after -- go to `camsim run`, for example an emergency stop after 5 s of cutting:
  tools/run -o build/run/estop -- --inject estop@5
Exit status: 0 done, 1 the cut ended in a fault, is out of tolerance or not gauged, 2 wrong usage
or bad input."""


def _count(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text}: give a whole number of at least 1")
    return value


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="tools/run",
        usage="tools/run [PART.toml] [--rpm N] [--feed MM] [--machine M] [--tolerance-nm T]\n"
        "                 [--measured SURFACE.csv ..] [--upr N] [--csv] [--keep N] [-o DIR]\n"
        "                 [-- CAMSIM-OPTIONS]",
        description="Make the table of a part, cut the part on the host simulator, write a report.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument(
        "part", type=Path, nargs="?", metavar="PART.toml", help="part file (default: perkins240)"
    )
    parser.add_argument("--rpm", metavar="N", help="spindle speed in r/min (default: the part's)")
    parser.add_argument("--feed", metavar="MM", help="feed in mm per turn (default: the part's)")
    parser.add_argument(
        "--machine",
        metavar="M",
        help=f"machine file, or one of {', '.join(names())} (default: a machine with the part's "
        "limits)",
    )
    parser.add_argument(
        "--tolerance-nm",
        metavar="T",
        help="largest error of the table in nm (default: as tools/mktables)",
    )
    add_measured(parser)
    parser.add_argument(
        "--upr",
        type=int,
        choices=UPR_CHOICES,
        default=DEFAULT_UPR,
        help="cut-off of the Gaussian roundness filter in the measurement sheets, in waves per "
        f"turn (default: {DEFAULT_UPR})",
    )
    parser.add_argument("--csv", action="store_true", help="also write the trace as trace.csv")
    parser.add_argument(
        "--keep",
        type=_count,
        metavar="N",
        help="delete all but the N newest runs in build/run, this one included (default: keep all)",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        help="folder for the results (default: build/run/NAME, NAME-roundN for a corrected table)",
    )
    return parser


def _positive(option: str, text: str | None, unit: str) -> float | None:
    """Return the number of an option, None when it is not given.

    Raises
    ------
    CamtoolsError
        Not a finite number above 0.
    """
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not (isfinite(value) and value > 0):
        problem = f"{option} {text}: must be a finite number above 0"
        raise CamtoolsError([f"{problem}; give {unit}, or leave it out for the part's own"])
    return value


def _for_camsim(words: Sequence[str]) -> list[str]:
    """Return the user's words for camsim, which works in another folder.

    Raises
    ------
    CamtoolsError
        An option that this command sets itself.
    """
    for word in words:
        if word.split("=")[0] in _OURS:
            raise CamtoolsError([f"-- {word}: is set by tools/run itself; leave it out"])
    return [str(Path(word).resolve()) if Path(word).is_file() else word for word in words]


class RunJob:
    """What was asked for, checked as far as this is possible without the part.

    Parameters
    ----------
    argv : list of str
        Command line without the program's name.
    """

    def __init__(self, argv: Sequence[str]) -> None:
        words = list(argv)
        self.origin = origin_of("tools/run", words)
        split = words.index("--") if "--" in words else len(words)
        arguments = _parser().parse_args(words[:split])
        self.part_path: Path = arguments.part or _DEFAULT_PART
        self.rpm = _positive("--rpm", arguments.rpm, "r/min")
        self.feed_mm = _positive("--feed", arguments.feed, "mm per turn")
        self.machine: bytes | None = (
            None if arguments.machine is None else machine_bytes(arguments.machine)
        )
        self.tolerance_nm = _positive("--tolerance-nm", arguments.tolerance_nm, "nm")
        if self.tolerance_nm is not None:
            check_tolerance(self.tolerance_nm)
        self.options = arguments  # with those of `add_measured`
        request_of(arguments)
        self.extra = _for_camsim(words[split + 1 :])
        if arguments.output == "":
            raise CamtoolsError(["-o: an empty path; give a folder"])
        if arguments.keep is not None and arguments.output:
            raise CamtoolsError(["--keep: applies only to build/run; leave out -o or --keep"])
        self.keep: int | None = arguments.keep
        self.cutoff_upr: int = arguments.upr
        self.keeps_text: bool = arguments.csv
        self.output: Path | None = Path(arguments.output) if arguments.output else None

    def check_feed(self, part: PartFile) -> None:
        """Refuse a feed that camsim would refuse, before anything is made.

        Raises
        ------
        CamtoolsError
            Beyond the height of the part, beyond what the firmware takes, or so large that metal
            stays between the tracks of the part's tool.
        """
        feed_mm, tool = self.feed_mm, getattr(part, "tool", None)
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
        return self.output or RUNS / own

    def tolerance(self, form_error_um: float, taken_um: float) -> list[str]:
        """Return what smoothing leaves of the form error, the part's or the one given, for camsim.

        It follows the other words, of which camsim takes the last of a name.

        Raises
        ------
        CamtoolsError
            The form error that is given leaves nothing.
        """
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

    def feed_words(self) -> list[str]:
        """Return camsim's options for the feed, when one is given."""
        return [] if self.feed_mm is None else ["--feed", repr(self.feed_mm)]


def _last_value(words: Sequence[str], name: str) -> str | None:
    """Return the value that camsim's words give an option last, nothing where they do not.

    >>> _last_value(["--a=1", "--b", "2", "--a", "3"], "--a"), _last_value(["--b", "2"], "--a")
    ('3', None)
    """
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
    sys.stderr.write(f"{shown_name('run')}: {text}\n")
    sys.stderr.flush()


def write_files(folder: Path, files: dict[str, bytes]) -> None:
    """Write files into a folder.

    Raises
    ------
    CamtoolsError
        A file cannot be written.
    """
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
