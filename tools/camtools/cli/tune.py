"""Command line that proposes or judges the position loop of a force drive.

>>> main(["nowhere.toml"])
2
"""

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from camtools.base.arguments import Option, UsageError, Word, command, option_of, positive
from camtools.base.files import write_all
from camtools.cli.drive_options import UOptions, connected_u, record_text
from camtools.identify.configured_drive import with_keys
from camtools.identify.drives import CutShortError
from camtools.identify.excitation_plan import U
from camtools.link.messages import Refused
from camtools.sim.machine_file import machine_bytes
from camtools.tune import excited
from camtools.tune.judgement import Proposal, Subject, proposed, subject_of
from camtools.tune.parameters import drive_of, read_tree, settings_of, text_of
from camtools.tune.plant_fit import fit_lines_of, fit_table, parse_loop_record, with_fit

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


@dataclass(frozen=True)
class Options:
    """Whose loop is tuned, and how."""

    u: UOptions
    drive: Annotated[Path | None, Word("drive file", "DRIVE.toml")] = None
    record: Annotated[
        Path | None,
        Option(
            "recording that gives the drive's constants: time_s, injected_n or setpoint_um, "
            "force_n, position_um; a drive file then gives the limits alone",
            "FILE.csv",
            one_of="where",
        ),
    ] = None
    machine: Annotated[
        str | None, Option("simulated machine, excited for the constants", "M", one_of="where")
    ] = None
    bus: Annotated[
        bool,
        Option(
            "real controller over CAN, excited for the constants: in state ready, its loop weak",
            one_of="where",
        ),
    ] = False
    highest_hz: Annotated[
        float | None,
        Option(
            "highest frequency of the excitation in Hz, at least 50 "
            f"(default: {excited.HIGHEST_HZ:g})",
            "F",
            read=positive,
        ),
    ] = None
    pulse: Annotated[
        float | None,
        Option(
            "first power-up: push U by N newtons in both directions, for sign and mass alone",
            "N",
            read=positive,
        ),
    ] = None
    loop: Annotated[Path | None, Option("parameters to judge instead of a proposal", "FILE")] = None
    apply: Annotated[
        bool,
        Option("set the parameters in the controller, or in a machine file in the folder of -o"),
    ] = False
    out: Annotated[
        Path | None,
        Option("folder for picture, text and parameters (default: none are written)", "DIR", "-o"),
    ] = None

    def __post_init__(self) -> None:
        is_excited = self.bus or self.machine is not None
        if not is_excited and self.drive is None and self.record is None:
            raise UsageError("no drive: give DRIVE.toml, --record FILE.csv, --machine M or --bus")
        given = {"--apply": self.apply, "--highest-hz": self.highest_hz, "--pulse": self.pulse}
        for name, value in given.items():
            if value and not is_excited:
                raise UsageError(f"{name}: needs a controller: add --bus, or --machine M")
        if self.pulse is not None:
            self._check_pulse(self.pulse)
        if self.apply and not self.bus and self.out is None:
            raise UsageError("--apply: needs a folder for the machine file: add -o DIR")
        if self.highest_hz is not None and self.highest_hz < 50:
            raise UsageError(f"--highest-hz {self.highest_hz:g}: give at least 50")
        self.u.check(is_bus=self.bus, machine=self.machine)

    def _check_pulse(self, pulse_n: float) -> None:
        for name in ("drive", "loop", "out", "highest_hz"):
            if getattr(self, name) is not None:
                option = {"drive": "DRIVE.toml", "out": "-o"}.get(name, option_of(name))
                raise UsageError(f"{option}: has no effect with --pulse; leave it out")
        if self.apply and not self.bus:
            raise UsageError("--apply: sets the result of a pulse over CAN only: use --bus")
        if pulse_n > _MOST_PULSE_N:
            raise UsageError(f"--pulse {pulse_n:g}: give at most {_MOST_PULSE_N:g}")


def _keys(arguments: Options) -> dict[str, Any]:
    return read_tree(arguments.drive) if arguments.drive is not None else {}


def _write(folder: Path, subject: Subject, proposal: Proposal, settings: Mapping[str, int]) -> None:
    from camtools.tune.plots import loop_png  # matplotlib is slow to load

    name, text = subject.name, "\n".join(proposal.lines) + "\n"
    loop = text_of(settings, f"tools/tune of {name}")
    files = {
        f"{name}_loop.png": loop_png(proposal.judged, f"{name}: position loop", subject.measured),
        f"{name}_loop.txt": text.encode("ascii"),
        f"{name}_servo.toml": loop.encode("utf-8"),
    }
    write_all(folder, files)


def _tuned(subject: Subject, arguments: Options) -> dict[str, int]:
    """Show and write the loop; return the parameters to be set, none if it is refused."""
    proposal = proposed(subject, arguments.loop)
    if proposal.problem:
        sys.stderr.write(f"tune: {arguments.loop or subject.where}: {proposal.problem}\n")
        return {}
    settings = settings_of(proposal.values, subject.drive, subject.is_measured)
    if arguments.out is not None:
        _write(arguments.out, subject, proposal, settings)
    print(*proposal.lines, sep="\n", flush=True)
    return settings


def _described(arguments: Options) -> int:
    file, csv, keys = arguments.drive, arguments.record, _keys(arguments)
    if csv is None:
        assert file is not None
        subject = Subject(file.stem, str(file), drive_of(keys, str(file)), [], False)
    else:
        record = parse_loop_record(record_text(csv), str(csv))
        found = fit_table(record, float(keys.get("scale_quantum_nm", 0.0)))
        drive = drive_of(with_fit(keys, found, record.rate_hz), str(csv))
        where = file or csv
        subject = Subject(where.stem, str(where), drive, list(fit_lines_of(found)), True)
    return 0 if _tuned(subject, arguments) else REFUSED


def _simulated(arguments: Options, name: str) -> int:
    keys = _keys(arguments)
    machine = machine_bytes(name)
    with excited.simulated_u(machine, name) as u:
        if arguments.pulse is not None:
            return 0 if _pushed(u, arguments.pulse) else REFUSED
        found = excited.measure(u, name, arguments.highest_hz or excited.HIGHEST_HZ)
    subject = subject_of(found, keys, (arguments.drive or Path(name)).stem, name)
    settings = _tuned(subject, arguments)
    if settings and arguments.apply and arguments.out is not None:
        text = with_keys(machine.decode("utf-8"), "controller", settings)
        file = f"{subject.name}_tuned.toml"
        write_all(arguments.out, {file: text.encode("utf-8")})
        sys.stdout.write(f"applied: {file}\n")
    return 0 if settings else REFUSED


def _connected(arguments: Options) -> int:
    keys = _keys(arguments)
    with connected_u(arguments.u) as (u, node):
        where = u.link.where
        if arguments.pulse is not None:
            settings = _pushed(u, arguments.pulse)
        else:
            found = excited.measure(u, where, arguments.highest_hz or excited.HIGHEST_HZ)
            name = arguments.drive.stem if arguments.drive else f"node{node}"
            settings = _tuned(subject_of(found, keys, name, where), arguments)
        if settings and arguments.apply:
            u.apply(settings)
            what = f"{len(settings)} parameters; the drives are off, enable and home again"
            sys.stdout.write(f"applied: {what}, then repeat --bus to measure the drive\n")
    return 0 if settings else REFUSED


def _pushed(u: U, pulse_n: float) -> dict[str, int]:
    """Push U and show the result; return the parameters to be set, none if U is reversed."""
    found = excited.measure_pulse(u, pulse_n)
    print(*excited.pulse_lines(found), sep="\n", flush=True)
    return excited.pulse_settings(found) if found.sign > 0 else {}


def tune(arguments: Options) -> int:
    """Propose the position loop of a force drive, or judge a given loop.

    It has margins of 6 dB and 30 degrees over the mass +-30 %.
    """
    try:
        if arguments.bus:
            return _connected(arguments)
        if arguments.machine is None:
            return _described(arguments)
        return _simulated(arguments, arguments.machine)
    except (Refused, CutShortError) as refused:
        sys.stderr.write(f"tune: {refused}\n")
        return REFUSED


main = command("tools/tune", tune, epilog=_EPILOG)

if __name__ == "__main__":
    sys.exit(main())
