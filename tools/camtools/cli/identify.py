# SPDX-License-Identifier: Apache-2.0
"""Command line that identifies U's drive, on the simulator or over CAN.

>>> main(["--machine", "nowhere"])
2
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple, TextIO

from camtools.base.argument_types import not_negative, positive
from camtools.base.command import Parser, run_command
from camtools.base.output import write_all
from camtools.base.project_paths import ROOT
from camtools.cli.connected_u import add_u_options, check_u_options, connected_u
from camtools.cli.record_text import record_text
from camtools.identify.bode import bode_png
from camtools.identify.configured_drive import Believed
from camtools.identify.excitation_plan import Excitation, Wishes, plan
from camtools.identify.excited import U, excited
from camtools.identify.foreign_record import parse_record
from camtools.identify.identified import Identified, Limits, identify
from camtools.identify.linear_model import identify_record
from camtools.identify.machine_file import with_keys
from camtools.identify.part_error import ToolMotion, motion_of
from camtools.identify.record_report import record_lines, record_numbers
from camtools.identify.report import chosen, form_left, numbers, report
from camtools.identify.simulated_drive import CutShortError, SimulatedU
from camtools.link.messages import Refused
from camtools.pipeline.load import load
from camtools.pipeline.make_table import Made, make
from camtools.report.text import plain
from camtools.sim.machines import machine_bytes
from camtools.table.image import pack

NOT_GOOD = 1
_ANY_PART = ROOT / "tools" / "parts" / "perkins240.toml"
_EPILOG = """\
Examples:
  tools/identify --machine real PART.toml -o build/identify
  tools/identify --record scope.csv -o DIR
  tools/identify --bus --interface socketcan --channel can0 PART.toml -o DIR --apply
Exit status: 0 done; 1 the fit is not good enough to be applied, refused by the controller or no
answer; 2 wrong usage or bad input."""


def _periods(text: str) -> int:
    value = int(text)
    if not 3 <= value <= 100:
        raise argparse.ArgumentTypeError(f"{text}: give 3 .. 100")
    return value


def _arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = Parser(
        prog="tools/identify",
        description="Excite U, identify its drive, and report the matching controller parameters.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument(
        "part", nargs="?", type=Path, metavar="PART.toml", help="part whose form error is predicted"
    )
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--machine", metavar="M", help="simulated machine: a name or a machine file")
    where.add_argument(
        "--bus", action="store_true", help="real controller over CAN, in state ready"
    )
    where.add_argument(
        "--record",
        type=Path,
        metavar="FILE.csv",
        help="recording of another instrument: time_s, command_um or force_n, position_um",
    )
    add_u_options(parser)
    parser.add_argument(
        "--rpm", type=positive, metavar="N", help="spindle speed in r/min (default: the part's)"
    )
    parser.add_argument(
        "--rms-um",
        type=positive,
        metavar="A",
        help="rms amplitude in um (default: 25, or 100 for a coarse scale)",
    )
    parser.add_argument(
        "--carrier-um",
        type=not_negative,
        metavar="A",
        help="amplitude of the 20 Hz carrier in um (default: 300)",
    )
    parser.add_argument(
        "--highest-hz",
        type=positive,
        default=700.0,
        metavar="F",
        help="highest frequency in Hz, at least 50 (default: 700)",
    )
    parser.add_argument(
        "--form-error-um",
        type=positive,
        metavar="E",
        help="also accept a fit that leaves a form error of at most E um",
    )
    parser.add_argument(
        "--periods",
        type=_periods,
        default=5,
        metavar="N",
        help="periods of 0.2 s, 3 .. 100; the first is discarded (default: 5)",
    )
    parser.add_argument(
        "--apply", action="store_true", help="set the parameters if the fit is good"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help="folder for plot, results and machine file (default: none are written)",
    )
    arguments = parser.parse_args(argv)
    _check(parser, arguments)
    return arguments


def _check(parser: Parser, arguments: argparse.Namespace) -> None:
    """End with a line when options do not go together."""
    if arguments.apply and arguments.machine is not None and arguments.output is None:
        parser.error("--apply: needs a folder for the machine file: add -o DIR")
    if arguments.form_error_um is not None and arguments.part is None:
        parser.error("--form-error-um: needs a part: add PART.toml")
    if arguments.rpm is not None and arguments.part is None:
        parser.error("--rpm: needs a part: add PART.toml")
    if arguments.highest_hz < 50:
        parser.error(f"--highest-hz {arguments.highest_hz:g}: give at least 50")
    if arguments.record is not None:
        given = {"PART.toml": arguments.part, "--apply": arguments.apply}
        for name in (name for name, value in given.items() if value):
            parser.error(f"{name}: has no effect with --record; leave it out")
    check_u_options(parser, arguments)


class _Part:
    """A part, its table and the way of its U."""

    def __init__(self, path: Path, rpm: float | None) -> None:
        self.made: Made = make(load(path), path, rpm=rpm)
        table = self.made.table.table
        self.image = pack(table)
        speed_rpm = self.made.kind.mean_rpm(self.made.table, rpm)
        self.motion: ToolMotion = motion_of(table, speed_rpm)
        self.name: str = table.part_name


def _files(
    name: str, found: Identified, believed: Believed, lines: list[str], part: _Part | None
) -> dict[str, bytes]:
    """Return the results by file name."""
    motion = part.motion if part is not None else None
    results = numbers(found, believed, Limits(), motion)
    return {
        f"{name}_bode.png": bode_png(found, believed.values, f"U of {name}"),
        f"{name}_identified.json": f"{json.dumps(results, indent=2)}\n".encode("ascii"),
        f"{name}_identified.txt": ("\n".join(lines) + "\n").encode("utf-8"),
    }


def _played(excitation: Excitation) -> str:
    wave = excitation.wave
    peaks = wave.peaks
    return (
        f"excited: {wave.rms_nm * 1e-3:.3g} um rms on {wave.carrier_nm * 1e-3:.3g} um at 20 Hz, "
        f"about {excitation.place_nm * 1e-3:.3g} um, {excitation.n_periods} periods; up to "
        f"{peaks.speed_mm_s:.3g} mm/s and {peaks.acceleration_mm_s2 * 1e-3:.3g} m/s2"
    )


def _one(u: U, arguments: argparse.Namespace, part: _Part | None, out: TextIO) -> _Found:
    """Excite, fit and report."""
    believed = u.believed()
    wishes = Wishes(
        rms_nm=None if arguments.rms_um is None else arguments.rms_um * 1e3,
        carrier_nm=None if arguments.carrier_um is None else arguments.carrier_um * 1e3,
        highest_hz=arguments.highest_hz,
        n_periods=arguments.periods,
    )
    excitation = plan(believed, wishes)
    lines = [_played(excitation)]
    found = identify(excited(u, excitation, believed))
    is_good = _is_good(found, believed, part, arguments.form_error_um)
    motion, name = (part.motion, part.name) if part is not None else (None, "")
    lines += report(found, believed, Limits(), motion, name, is_good=is_good)
    lines = [plain(line) for line in lines]
    out.write("\n".join(lines) + "\n")
    out.flush()
    settings = believed.settings(chosen(found, Limits(), motion))
    return _Found(found, believed, lines, is_good, settings)


def _is_good(
    found: Identified, believed: Believed, part: _Part | None, most_um: float | None
) -> bool:
    """Return whether the constants may be set: within the limits, or good enough for the part."""
    if not found.problems(Limits()):
        return True
    if part is None or most_um is None or not found.plain.is_physical:
        return False
    return form_left(found, believed, Limits(), part.motion).most_um <= most_um


class _Found(NamedTuple):
    """Result of one excitation."""

    found: Identified
    believed: Believed
    lines: list[str]
    is_good: bool
    settings: dict[str, int]


def _simulate(arguments: argparse.Namespace, out: TextIO) -> int:
    machine = machine_bytes(arguments.machine)
    name = Path(arguments.machine).stem
    wanted = _Part(arguments.part or _ANY_PART, arguments.rpm)
    part = wanted if arguments.part is not None else None
    with tempfile.TemporaryDirectory(prefix="identify.") as folder:
        u = SimulatedU(Path(folder), machine, arguments.machine, wanted.image)
        one = _one(u, arguments, part, out)
    if arguments.output is not None:
        files = _files(name, one.found, one.believed, one.lines, part)
        if arguments.apply and one.is_good:
            text = with_keys(machine.decode("utf-8"), "controller", one.settings)
            files[f"{name}_identified.toml"] = text.encode("utf-8")
        write_all(arguments.output, files)
    return _status(one, arguments, out, f"{name}_identified.toml" if arguments.apply else "")


def _status(one: _Found, arguments: argparse.Namespace, out: TextIO, applied: str) -> int:
    if one.is_good and applied:
        out.write(f"applied: {applied}\n")
    if not one.is_good:
        what = "nothing was applied" if arguments.apply else "the fit is not good enough to apply"
        first = one.found.problems(Limits())[0]
        sys.stderr.write(f"identify: {what}: {first}\n")
    return 0 if one.is_good else NOT_GOOD


def _connect(arguments: argparse.Namespace, out: TextIO) -> int:
    part = _Part(arguments.part, arguments.rpm) if arguments.part is not None else None
    with connected_u(arguments, "identify") as (u, node):
        one = _one(u, arguments, part, out)
        if arguments.output is not None:
            name = f"node{node}"
            files = _files(name, one.found, one.believed, one.lines, part)
            write_all(arguments.output, files)
        if arguments.apply and one.is_good:
            u.apply(one.settings)
    what = "k1_ns, k2_us2, lead_ns, u_friction_nm; the drives are off, enable and home again"
    return _status(one, arguments, out, what if arguments.apply else "")


def _recorded(arguments: argparse.Namespace, out: TextIO) -> int:
    """Fit a recording of another instrument."""
    file = str(arguments.record)
    record = parse_record(record_text(arguments.record), file)
    found = identify_record(record)
    lines = list(record_lines(found, record))
    out.write("\n".join(lines) + "\n")
    if arguments.output is not None:
        name = f"{arguments.record.stem}_identified"
        results = json.dumps(record_numbers(found, record), indent=2)
        files = {f"{name}.json": f"{results}\n", f"{name}.txt": "\n".join(lines) + "\n"}
        write_all(arguments.output, {key: one.encode("utf-8") for key, one in files.items()})
    return NOT_GOOD if found.problems else 0


def _run(arguments: argparse.Namespace, out: TextIO) -> int:
    if arguments.record is not None:
        return _recorded(arguments, out)
    try:
        return _connect(arguments, out) if arguments.bus else _simulate(arguments, out)
    except (Refused, CutShortError) as refused:
        sys.stderr.write(f"identify: {refused}\n")
        return NOT_GOOD


def main(argv: Sequence[str] | None = None, out: TextIO | None = None) -> int:
    """Run the command; return its exit status: 0 done, 1 not good or refused, 2 bad input."""
    to = sys.stdout if out is None else out
    return run_command("identify", lambda: _run(_arguments(argv), to))


if __name__ == "__main__":
    sys.exit(main())
