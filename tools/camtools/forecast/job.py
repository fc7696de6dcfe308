r"""What a forecast is about to cut: the part, its machine, what is not known, the machines drawn.

>>> _LINE.sub(r"\1", "drawn: line 3: u.damping = 0.01: out of range")
'u.damping = 0.01: out of range'
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from camtools.base.errors import CamtoolsError, InputError
from camtools.base.project import library_path
from camtools.base.quantities import Floats
from camtools.forecast.cuts import TABLE, Task, build_of, folder_of
from camtools.forecast.vary import Unknown, default_vary, draw, read_vary
from camtools.part.model import read_part_file
from camtools.pipeline.load import Made, load, make
from camtools.sim.drawn_parts import LEAST_CUTS, refuse_zones
from camtools.sim.machine_file import (
    Machine,
    Tree,
    emit_machine,
    find_machine,
    mistaken,
    read_machine,
)
from camtools.sim.simulate import begun
from camtools.sim.uncertain import USUAL

_PROBE = "drawn"
_LINE = re.compile(rf"{_PROBE}: line \d+: (.*)")


class ForecastPlan(NamedTuple):
    """All that is to be cut."""

    made: Made  # the part and its table
    machine: Machine  # as given or made from the part file
    unknowns: list[Unknown]
    left_out: list[str]  # of the usual unknowns those that this machine does not have
    inputs: Floats  # shape (runs, unknowns); true numbers of the machines
    texts: list[str]  # machine files
    keys: list[str]  # digest of each cut
    task: Task  # what the cuts share
    tolerance_um: float  # that a good part keeps
    words: tuple[str, ...]  # options of camsim: speed, feed, turns, parameters
    seed: int

    @property
    def names(self) -> list[str]:
        """Return the keys of the unknowns."""
        return [unknown.key for unknown in self.unknowns]


def plan_of(
    part_file: Path,
    n_runs: int,
    seed: int,
    *,
    machine_name: str | None = None,
    vary: Path | None = None,
    rpm: float | None = None,
    words: Sequence[str] = (),
    tolerance_um: float | None = None,
    feed_mm: float | None = None,
    has_sections: bool = False,
) -> ForecastPlan:
    """Make the table, read machine and unknowns, draw the machines; nothing is cut or written.

    None stands for the machine, the tolerance and the feed of the part file, and for the usual
    unknowns. The machine has a name or a path; the tables of some parts depend on the speed. With
    sections the features of the part's sheets are gauged, of independent machines.
    """
    if has_sections and n_runs < LEAST_CUTS:
        problem = f"--runs {n_runs}: too few for a bound of a section"
        raise CamtoolsError([f"{problem}; give at least {LEAST_CUTS}"])
    made = make(load(part_file), part_file, rpm=rpm)
    part = made.table.part
    if has_sections:
        refuse_zones(part, "--sections")
    own = Machine(f"{part.part.name}_machine.toml", made.kind.machine(part))
    machine = own if machine_name is None else find_machine(machine_name)
    tree = read_machine(machine.text, machine.name)
    unknowns, left_out = _unknowns(vary, tree)
    files, name = made.files(with_plots=False), part.part.name
    table, design = files[f"{name}.camtab"], files[f"{name}.json"]
    # The gauge judges by its own tolerance only whether a cut is good, which is done here.
    task = Task(table, design, (*words, "--tolerance-um", "1e6"), build_of(library_path("camsim")))
    _check(task, machine, name)
    _check_ends(task, tree, unknowns, str(vary or USUAL.name))
    if has_sections:
        heights_mm = made.kind.sections_mm(made.table, feed_mm or part.process.feed_mm)
        gauged = ("--sections-mm", ",".join(map(repr, heights_mm))) if heights_mm else ()
        task = task._replace(words=(*task.words, *gauged), sheets=made)
    inputs = draw(unknowns, n_runs, seed=seed, is_independent=has_sections)
    keys = [unknown.key for unknown in unknowns]
    drawn = (dict(zip(keys, map(float, row), strict=True)) for row in inputs)
    texts = [emit_machine(mistaken(tree, numbers)) for numbers in drawn]
    allowed_um = part.process.form_error_um if tolerance_um is None else tolerance_um
    allowed_um -= made.kind.taken_um(made.table)
    if allowed_um <= 0:
        raise CamtoolsError(["--tolerance-um: smoothing takes all of it; allow more"])
    cuts = (inputs, texts, [task.key(text) for text in texts], task, allowed_um, tuple(words))
    return ForecastPlan(made, machine, unknowns, left_out, *cuts, seed)


def _unknowns(vary: Path | None, tree: Tree) -> tuple[list[Unknown], list[str]]:
    if vary is None:
        return default_vary(tree)
    try:
        data = read_part_file(vary)
    except InputError as error:
        lines = [line.replace("a part file (TOML)", "a V.toml") for line in error.lines]
        raise CamtoolsError(lines) from error
    return read_vary(data, str(vary), tree), []


def _check(task: Task, machine: Machine, name: str) -> None:
    table = str(folder_of(task.table, task.design) / TABLE)
    try:
        with begun([table, *task.words], machine):
            pass
    except CamtoolsError as error:
        lines = [line.replace(table, f"{name}.camtab") for line in error.lines]
        raise CamtoolsError(lines) from error


def _check_ends(task: Task, tree: Tree, unknowns: Sequence[Unknown], file: str) -> None:
    """Refuse numbers that no machine file may have; what is only infeasible is cut and counted."""
    for unknown in unknowns:
        for end, value in (("low", unknown.low), ("high", unknown.high)):
            text = emit_machine(mistaken(tree, {unknown.key: value}))
            try:
                _check(task, Machine(_PROBE, text), _PROBE)
            except CamtoolsError as error:
                found = _LINE.match(str(error))
                if found is not None:
                    problem = f"reaches to {value:.6g}: {found.group(1)}"
                    raise CamtoolsError([f"{file}: {unknown.key}: {end} {problem}"]) from error
