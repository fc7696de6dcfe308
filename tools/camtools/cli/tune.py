# SPDX-License-Identifier: Apache-2.0
"""Command line that proposes or judges the position loop of a force drive.

>>> main(["nowhere.toml"])
2
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from camtools.base.command import Parser, run_command
from camtools.base.output import write_all
from camtools.cli.record_text import record_text
from camtools.identify.simulated_drive import CutShortError
from camtools.tune.drive import Drive, drive_of, read_tree
from camtools.tune.excited import fit_machine
from camtools.tune.judgement import Judgement, judge, refusal
from camtools.tune.loop_design import best
from camtools.tune.parameters import loop_of, parameters_of, read_loop, text_of
from camtools.tune.record import fit_lines_of, fit_table, parse_loop_record, with_fit
from camtools.tune.text import lines_of

REFUSED = 1
_EPILOG = """\
Examples:
  tools/tune voice_coil.toml -o build/tune
  tools/tune voice_coil.toml --loop mine_servo.toml
  tools/tune --machine force.toml -o build/tune
  tools/tune limits.toml --record scope.csv -o build/tune
Exit status: 0 done; 1 no loop with the margins or cut short, nothing is written;
2 wrong usage or bad input."""


def _arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = Parser(
        prog="tools/tune",
        description="Propose the position loop of a force drive, with margins of 6 dB and 30 "
        "degrees over the mass +-30 %, or judge a given one.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("drive", nargs="?", type=Path, metavar="DRIVE.toml", help="drive file")
    add(
        "--record",
        type=Path,
        metavar="FILE.csv",
        help="recording that gives the drive's constants: time_s, injected_n or setpoint_um, "
        "force_n, position_um; a drive file then gives the limits alone",
    )
    add("--machine", metavar="M", help="simulated machine that is excited instead of a --record")
    add("--loop", type=Path, metavar="FILE", help="parameters to judge instead of a proposal")
    add(
        "-o",
        "--out",
        type=Path,
        metavar="DIR",
        help="folder for picture, text and parameters (default: none are written)",
    )
    arguments = parser.parse_args(argv)
    if arguments.drive is None and arguments.record is None and arguments.machine is None:
        parser.error("what drive? give DRIVE.toml, or --record FILE.csv, or both")
    if arguments.record is not None and arguments.machine is not None:
        parser.error("--machine: has no effect with --record; leave one out")
    return arguments


def _values(drive: Drive, given: Path | None) -> dict[str, int]:
    """Return the parameters of the loop, given or proposed."""
    if given is not None:
        return read_loop(given, drive)
    return parameters_of(best(drive.plant), drive)


def _judged(values: dict[str, int], drive: Drive) -> Judgement:
    """Judge the loop of parameters, which may be made for another mass."""
    mass_kg = values["servo_mass_g"] / 1000
    plant = replace(drive.plant, mass_kg=mass_kg)
    return judge(loop_of(values, drive), plant, drive.mass_kg / mass_kg)


def _write(
    folder: Path, drive: Drive, name: str, judged: Judgement, lines: list[str],
    values: dict[str, int],
) -> None:  # fmt: skip
    from camtools.tune.plots import loop_png  # matplotlib is slow to load

    files = {
        f"{name}_loop.png": loop_png(judged, f"{name}: position loop"),
        f"{name}_loop.txt": ("\n".join(lines) + "\n").encode("ascii"),
        f"{name}_servo.toml": text_of(values, drive, f"tools/tune of {name}").encode("utf-8"),
    }
    write_all(folder, files)


def _drive(arguments: argparse.Namespace) -> tuple[Drive, list[str]]:
    """Return the drive, and the report of its fit."""
    file, csv = arguments.drive, arguments.record
    keys = read_tree(file) if file is not None else {}
    if arguments.machine is not None:
        found, tick_hz = fit_machine(arguments.machine)
        keys = with_fit(keys, found, tick_hz)
        return drive_of(keys, arguments.machine), list(fit_lines_of(found))
    if csv is None:
        return drive_of(keys, str(file)), []
    record = parse_loop_record(record_text(csv), str(csv))
    found = fit_table(record, float(keys.get("scale_quantum_nm", 0.0)))
    return drive_of(with_fit(keys, found, record.rate_hz), str(csv)), list(fit_lines_of(found))


def _run(arguments: argparse.Namespace) -> int:
    given = arguments.loop
    file = arguments.drive or arguments.record or Path(arguments.machine)
    try:
        drive, lines = _drive(arguments)
    except CutShortError as cut:
        sys.stderr.write(f"tune: {file}: {cut}\n")
        return REFUSED
    values = _values(drive, given)
    judged = _judged(values, drive)
    problem = refusal(judged, is_proposal=given is None)
    if problem:
        sys.stderr.write(f"tune: {given or file}: {problem}\n")
        return REFUSED
    lines += lines_of(judged, drive)
    if arguments.out is not None:
        _write(arguments.out, drive, file.stem, judged, lines, values)
    sys.stdout.write("\n".join(lines) + "\n")
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status: 0 done, 1 refused, 2 bad input."""
    return run_command("tune", lambda: _run(_arguments(argv)))


if __name__ == "__main__":
    sys.exit(main())
