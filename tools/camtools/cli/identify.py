"""Command line that identifies U's drive, on the simulator or over CAN.

>>> main(["--machine", "nowhere"])
2
"""

import json
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NamedTuple

from camtools.base.arguments import (
    Option,
    UsageError,
    Word,
    command,
    not_negative,
    option_of,
    positive,
    whole_within,
)
from camtools.base.files import write_all
from camtools.base.project import ROOT
from camtools.cli.drive_options import UOptions, connected_u, record_text
from camtools.identify.bode import bode_png
from camtools.identify.configured_drive import Believed, with_keys
from camtools.identify.drives import CutShortError, SimulatedU
from camtools.identify.excitation_plan import Excitation, U, Wishes, excited, plan
from camtools.identify.foreign_record import parse_record
from camtools.identify.identified import Identified, identify
from camtools.identify.linear_model import identify_record, record_lines, record_numbers
from camtools.identify.report import (
    ToolMotion,
    chosen,
    form_left,
    motion_of,
    numbers,
    report,
)
from camtools.link.messages import Refused
from camtools.pipeline.load import Made, load, make
from camtools.report.text import plain
from camtools.sim.machine_file import machine_bytes
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


@dataclass(frozen=True)
class Options:
    """Which drive is identified, and how."""

    u: UOptions
    part: Annotated[Path | None, Word("part whose form error is predicted", "PART.toml")] = None
    machine: Annotated[
        str | None, Option("simulated machine: a name or a machine file", "M", one_of="where!")
    ] = None
    bus: Annotated[bool, Option("real controller over CAN, in state ready", one_of="where!")] = (
        False
    )
    record: Annotated[
        Path | None,
        Option(
            "recording of another instrument: time_s, command_um or force_n, position_um",
            "FILE.csv",
            one_of="where!",
        ),
    ] = None
    rpm: Annotated[
        float | None, Option("spindle speed in r/min (default: the part's)", "N", read=positive)
    ] = None
    rms_um: Annotated[
        float | None,
        Option("rms amplitude in um (default: 25, or 100 for a coarse scale)", "A", read=positive),
    ] = None
    carrier_um: Annotated[
        float | None,
        Option("amplitude of the 20 Hz carrier in um (default: 300)", "A", read=not_negative),
    ] = None
    highest_hz: Annotated[
        float, Option("highest frequency in Hz, at least 50 (default: 700)", "F", read=positive)
    ] = 700.0
    form_error_um: Annotated[
        float | None,
        Option("also accept a fit that leaves a form error of at most E um", "E", read=positive),
    ] = None
    periods: Annotated[
        int,
        Option(
            "periods of 0.2 s, 3 .. 100; the first is discarded (default: 5)",
            "N",
            read=whole_within(3, 100),
        ),
    ] = 5
    apply: Annotated[bool, Option("set the parameters if the fit is good")] = False
    output: Annotated[
        Path | None,
        Option(
            "folder for plot, results and machine file (default: none are written)", "DIR", "-o"
        ),
    ] = None

    def __post_init__(self) -> None:
        if self.apply and self.machine is not None and self.output is None:
            raise UsageError("--apply: needs a folder for the machine file: add -o DIR")
        for name in ("form_error_um", "rpm"):
            if getattr(self, name) is not None and self.part is None:
                raise UsageError(f"{option_of(name)}: needs a part: add PART.toml")
        if self.highest_hz < 50:
            raise UsageError(f"--highest-hz {self.highest_hz:g}: give at least 50")
        if self.record is not None and (self.part or self.apply):
            name = "PART.toml" if self.part else "--apply"
            raise UsageError(f"{name}: has no effect with --record; leave it out")
        self.u.check(is_bus=self.bus, machine=self.machine)


class _Part:
    """A part, its table and the motion of its U."""

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
    motion = part.motion if part is not None else None
    results = numbers(found, believed, motion)
    return {
        f"{name}_bode.png": bode_png(found, believed.values, f"U of {name}"),
        f"{name}_identified.json": f"{json.dumps(results, indent=2)}\n".encode("ascii"),
        f"{name}_identified.txt": ("\n".join(lines) + "\n").encode("utf-8"),
    }


def _played(excitation: Excitation) -> str:
    wave, play = excitation
    peaks = wave.peaks
    return (
        f"excited: {wave.rms_nm * 1e-3:.3g} um rms on {wave.carrier_nm * 1e-3:.3g} um at 20 Hz, "
        f"about {play.place_nm * 1e-3:.3g} um, {play.n_periods} periods; up to "
        f"{peaks.speed_mm_s:.3g} mm/s and {peaks.acceleration_mm_s2 * 1e-3:.3g} m/s2"
    )


class _Found(NamedTuple):
    """Result of one excitation."""

    found: Identified
    believed: Believed
    lines: list[str]
    is_good: bool
    settings: dict[str, int]


def _fitted(u: U, arguments: Options, part: _Part | None) -> _Found:
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
    lines += report(found, believed, motion, name, is_good=is_good)
    lines = [plain(line) for line in lines]
    print(*lines, sep="\n", flush=True)
    return _Found(found, believed, lines, is_good, believed.settings(chosen(found, motion)))


def _is_good(
    found: Identified, believed: Believed, part: _Part | None, most_um: float | None
) -> bool:
    """Return whether the constants may be set: within the limits, or good enough for the part."""
    if not found.problems():
        return True
    if part is None or most_um is None or not found.plain.is_physical:
        return False
    left = form_left(found, believed, part.motion)
    return left.chosen_um + left.doubt_um <= most_um


def _simulate(arguments: Options, given: str) -> int:
    machine, name = machine_bytes(given), Path(given).stem
    wanted = _Part(arguments.part or _ANY_PART, arguments.rpm)
    part = wanted if arguments.part is not None else None
    with tempfile.TemporaryDirectory(prefix="identify.") as folder:
        u = SimulatedU(Path(folder), machine, given, wanted.image)
        fit = _fitted(u, arguments, part)
    if arguments.output is not None:
        files = _files(name, fit.found, fit.believed, fit.lines, part)
        if arguments.apply and fit.is_good:
            text = with_keys(machine.decode("utf-8"), "controller", fit.settings)
            files[f"{name}_identified.toml"] = text.encode("utf-8")
        write_all(arguments.output, files)
    return _status(fit, arguments, f"{name}_identified.toml" if arguments.apply else "")


def _status(fit: _Found, arguments: Options, applied: str) -> int:
    if fit.is_good and applied:
        sys.stdout.write(f"applied: {applied}\n")
    if not fit.is_good:
        what = "nothing was applied" if arguments.apply else "the fit is not good enough to apply"
        sys.stderr.write(f"identify: {what}: {fit.found.problems()[0]}\n")
    return 0 if fit.is_good else NOT_GOOD


def _connect(arguments: Options) -> int:
    part = _Part(arguments.part, arguments.rpm) if arguments.part is not None else None
    with connected_u(arguments.u) as (u, node):
        fit = _fitted(u, arguments, part)
        if arguments.output is not None:
            files = _files(f"node{node}", fit.found, fit.believed, fit.lines, part)
            write_all(arguments.output, files)
        if arguments.apply and fit.is_good:
            u.apply(fit.settings)
    what = "k1_ns, k2_us2, lead_ns, u_friction_nm; the drives are off, enable and home again"
    return _status(fit, arguments, what if arguments.apply else "")


def _recorded(csv: Path, output: Path | None) -> int:
    record = parse_record(record_text(csv), str(csv))
    found = identify_record(record)
    text = "\n".join(record_lines(found, record)) + "\n"
    sys.stdout.write(text)
    if output is not None:
        name = f"{csv.stem}_identified"
        results = json.dumps(record_numbers(found, record), indent=2)
        files = {f"{name}.json": f"{results}\n".encode(), f"{name}.txt": text.encode()}
        write_all(output, files)
    return NOT_GOOD if found.problems else 0


def identify_drive(arguments: Options) -> int:
    """Excite U, identify its drive, and report the matching controller parameters."""
    if arguments.record is not None:
        return _recorded(arguments.record, arguments.output)
    try:
        if arguments.machine is None:
            return _connect(arguments)
        return _simulate(arguments, arguments.machine)
    except (Refused, CutShortError) as refused:
        sys.stderr.write(f"identify: {refused}\n")
        return NOT_GOOD


main = command("tools/identify", identify_drive, epilog=_EPILOG)

if __name__ == "__main__":
    sys.exit(main())
