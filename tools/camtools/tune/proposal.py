"""A drive that was measured or described, and the loop that is proposed or given for it.

>>> drive = Drive(mass_kg=1.5, amplifier_hz=1500.0, delay_us=25.0, tick_hz=20000.0)
>>> found = proposed(Subject("coil", "coil.toml", drive, []))
>>> found.problem, found.values["servo_mass_g"], found.lines[0][:10]
('', 1500, 'crossover:')
"""

from pathlib import Path
from typing import Any, NamedTuple

from camtools.tune.drive import Drive, drive_of
from camtools.tune.excited import Measured
from camtools.tune.judgement import Judgement, judge, lines_of, refusal
from camtools.tune.loop_design import best
from camtools.tune.measured_loop import OpenLoop, measured_loop, model_loop
from camtools.tune.measured_loop import text_of as loop_text
from camtools.tune.parameters import loop_of, parameters_of, plant_of, read_loop
from camtools.tune.plant_fit import fit_lines_of, with_fit


class Subject(NamedTuple):
    """What is tuned."""

    name: str  # of files
    where: str  # in errors
    drive: Drive
    lines: list[str]  # of its constants, and of its loop as it is
    measured: OpenLoop | None = None


class Proposal(NamedTuple):
    """A loop for a drive."""

    values: dict[str, int]  # its parameters
    judged: Judgement
    problem: str  # why it is refused; "" where it has the margins
    lines: list[str]  # the report


def subject_of(found: Measured, keys: dict[str, Any], name: str, where: str) -> Subject:
    """Return the drive that an excitation shows, with keys of a drive file, and its loop."""
    drive = drive_of(with_fit(keys, found.fit, found.tick_hz), where)
    measured = measured_loop(found.lines, found.values, drive)
    lines = [
        *fit_lines_of(found.fit),
        f"as it is (measured): {loop_text(measured)}",
        f"as it is (model): {loop_text(model_loop(found.values, drive))}",
    ]
    return Subject(name, where, drive, lines, measured)


def proposed(one: Subject, given: Path | None = None) -> Proposal:
    """Return the best loop for a drive, or the given one, which may be for another mass."""
    drive = one.drive
    values = read_loop(given, drive) if given else parameters_of(best(drive.plant), drive)
    judged = judge(loop_of(values, drive), *plant_of(values, drive))
    problem = refusal(judged, is_proposal=given is None)
    head = ["given:" if given else "proposed:"] if one.measured else []
    return Proposal(values, judged, problem, [*one.lines, *head, *lines_of(judged, drive)])
