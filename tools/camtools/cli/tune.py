# SPDX-License-Identifier: Apache-2.0
"""Command line that proposes or judges the position loop of a force drive.

>>> main(["nowhere.toml"])
2
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from camtools.base.argument_types import positive
from camtools.base.command import Parser, run_command
from camtools.base.output import write_all
from camtools.cli.connected_u import add_u_options, check_u_options, connected_u
from camtools.cli.record_text import record_text
from camtools.identify.excited import U
from camtools.identify.machine_file import with_keys
from camtools.identify.simulated_drive import CutShortError
from camtools.link.messages import Refused
from camtools.sim.machines import machine_bytes
from camtools.tune.drive import drive_of, read_tree
from camtools.tune.excited import HIGHEST_HZ, measure, simulated_u
from camtools.tune.parameters import settings_of, text_of
from camtools.tune.proposal import Proposal, Subject, proposed, subject_of
from camtools.tune.pulse import measure_pulse, pulse_lines, pulse_settings
from camtools.tune.record import fit_lines_of, fit_table, parse_loop_record, with_fit

REFUSED = 1
_MOST_PULSE_N = 4000  # of any force limit
_EPILOG = """\
Examples:
  tools/tune voice_coil.toml -o build/tune
  tools/tune voice_coil.toml --loop mine_servo.toml
  tools/tune --machine force.toml -o build/tune --apply
  tools/tune limits.toml --record scope.csv -o build/tune
  tools/tune --bus -i socketcan -c can0 --pulse 10
  tools/tune limits.toml --bus -i socketcan -c can0 -o build/tune --apply
Exit status: 0 done; 1 no loop with the margins, cut short, refused by the controller or no answer:
nothing is written or set; 2 wrong usage or bad input."""


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
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--record",
        type=Path,
        metavar="FILE.csv",
        help="recording that gives the drive's constants: time_s, injected_n or setpoint_um, "
        "force_n, position_um; a drive file then gives the limits alone",
    )
    where.add_argument(
        "--machine", metavar="M", help="simulated machine, excited for the constants"
    )
    where.add_argument(
        "--bus",
        action="store_true",
        help="real controller over CAN, excited for the constants: in state ready, its loop weak",
    )
    add_u_options(parser)
    add(
        "--highest-hz",
        type=positive,
        metavar="F",
        help=f"highest frequency of the excitation in Hz, at least 50 (default: {HIGHEST_HZ:g})",
    )
    add(
        "--pulse",
        type=positive,
        metavar="N",
        help="first power-up: push U by N newtons in both directions, for sign and mass alone",
    )
    add("--loop", type=Path, metavar="FILE", help="parameters to judge instead of a proposal")
    add(
        "--apply",
        action="store_true",
        help="set the parameters in the controller, or in a machine file in the folder of -o",
    )
    add(
        "-o",
        "--out",
        type=Path,
        metavar="DIR",
        help="folder for picture, text and parameters (default: none are written)",
    )
    arguments = parser.parse_args(argv)
    _check(parser, arguments)
    return arguments


def _check(parser: Parser, arguments: argparse.Namespace) -> None:
    """End with a line when options do not go together."""
    is_excited = arguments.bus or arguments.machine is not None
    if not is_excited and arguments.drive is None and arguments.record is None:
        parser.error("no drive: give DRIVE.toml, --record FILE.csv, --machine M or --bus")
    for name, value in (("--apply", arguments.apply), ("--highest-hz", arguments.highest_hz)):
        if value and not is_excited:
            parser.error(f"{name}: needs a controller: add --bus, or --machine M")
    if arguments.pulse is not None:
        _check_pulse(parser, arguments)
    if arguments.apply and not arguments.bus and arguments.out is None:
        parser.error("--apply: needs a folder for the machine file: add -o DIR")
    if arguments.highest_hz is not None and arguments.highest_hz < 50:
        parser.error(f"--highest-hz {arguments.highest_hz:g}: give at least 50")
    check_u_options(parser, arguments)


def _check_pulse(parser: Parser, arguments: argparse.Namespace) -> None:
    """End with a line when other options do not go with --pulse."""
    if not arguments.bus and arguments.machine is None:
        parser.error("--pulse: needs a controller: add --bus, or --machine M")
    names = ("drive", "loop", "out", "highest_hz")
    for name in (one for one in names if getattr(arguments, one) is not None):
        option = {"drive": "DRIVE.toml", "out": "-o"}.get(name, f"--{name.replace('_', '-')}")
        parser.error(f"{option}: has no effect with --pulse; leave it out")
    if arguments.apply and not arguments.bus:
        parser.error("--apply: sets the result of a pulse over CAN only: use --bus")
    if arguments.pulse > _MOST_PULSE_N:
        parser.error(f"--pulse {arguments.pulse:g}: give at most {_MOST_PULSE_N:g}")


def _keys(arguments: argparse.Namespace) -> dict[str, Any]:
    return read_tree(arguments.drive) if arguments.drive is not None else {}


def _write(folder: Path, one: Subject, proposal: Proposal) -> None:
    from camtools.tune.plots import loop_png  # matplotlib is slow to load

    name, text = one.name, "\n".join(proposal.lines) + "\n"
    loop = text_of(proposal.values, one.drive, f"tools/tune of {name}")
    files = {
        f"{name}_loop.png": loop_png(proposal.judged, f"{name}: position loop", one.measured),
        f"{name}_loop.txt": text.encode("ascii"),
        f"{name}_servo.toml": loop.encode("utf-8"),
    }
    write_all(folder, files)


def _tuned(one: Subject, arguments: argparse.Namespace) -> dict[str, int]:
    """Show and write the loop; return the parameters to be set, none if it is refused."""
    proposal = proposed(one, arguments.loop)
    if proposal.problem:
        sys.stderr.write(f"tune: {arguments.loop or one.where}: {proposal.problem}\n")
        return {}
    if arguments.out is not None:
        _write(arguments.out, one, proposal)
    sys.stdout.write("\n".join(proposal.lines) + "\n")
    sys.stdout.flush()
    return settings_of(proposal.values, one.drive)


def _described(arguments: argparse.Namespace) -> int:
    """Tune the drive of a drive file, or of a recording."""
    file, csv, keys = arguments.drive, arguments.record, _keys(arguments)
    if csv is None:
        one = Subject(file.stem, str(file), drive_of(keys, str(file)), [])
    else:
        record = parse_loop_record(record_text(csv), str(csv))
        found = fit_table(record, float(keys.get("scale_quantum_nm", 0.0)))
        drive = drive_of(with_fit(keys, found, record.rate_hz), str(csv))
        where = file or csv
        one = Subject(where.stem, str(where), drive, list(fit_lines_of(found)))
    return 0 if _tuned(one, arguments) else REFUSED


def _simulated(arguments: argparse.Namespace) -> int:
    """Tune U of a simulated machine."""
    name, keys = arguments.machine, _keys(arguments)
    machine = machine_bytes(name)
    with simulated_u(machine, name) as u:
        if arguments.pulse is not None:
            return 0 if _pushed(u, arguments) else REFUSED
        found = measure(u, name, arguments.highest_hz or HIGHEST_HZ)
    one = subject_of(found, keys, (arguments.drive or Path(name)).stem, name)
    settings = _tuned(one, arguments)
    if settings and arguments.apply:
        text = with_keys(machine.decode("utf-8"), "controller", settings)
        file = f"{one.name}_tuned.toml"
        write_all(arguments.out, {file: text.encode("utf-8")})
        sys.stdout.write(f"applied: {file}\n")
    return 0 if settings else REFUSED


def _connected(arguments: argparse.Namespace) -> int:
    """Tune U of a controller over CAN."""
    keys = _keys(arguments)
    with connected_u(arguments, "tune") as (u, node):
        where = u.link.where
        if arguments.pulse is not None:
            settings = _pushed(u, arguments)
        else:
            found = measure(u, where, arguments.highest_hz or HIGHEST_HZ)
            name = arguments.drive.stem if arguments.drive else f"node{node}"
            settings = _tuned(subject_of(found, keys, name, where), arguments)
        if settings and arguments.apply:
            u.apply(settings)
            what = f"{len(settings)} parameters; the drives are off, enable and home again"
            sys.stdout.write(f"applied: {what}, then repeat --bus to measure the drive\n")
    return 0 if settings else REFUSED


def _pushed(u: U, arguments: argparse.Namespace) -> dict[str, int]:
    """Push U and show the result; return the parameters to be set, none if U is reversed."""
    found = measure_pulse(u, arguments.pulse)
    sys.stdout.write("\n".join(pulse_lines(found)) + "\n")
    sys.stdout.flush()
    return pulse_settings(found) if found.sign > 0 else {}


def _run(arguments: argparse.Namespace) -> int:
    try:
        if arguments.bus:
            return _connected(arguments)
        return _described(arguments) if arguments.machine is None else _simulated(arguments)
    except (Refused, CutShortError) as refused:
        sys.stderr.write(f"tune: {refused}\n")
        return REFUSED


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status: 0 done, 1 refused, 2 bad input."""
    return run_command("tune", lambda: _run(_arguments(argv)))


if __name__ == "__main__":
    sys.exit(main())
