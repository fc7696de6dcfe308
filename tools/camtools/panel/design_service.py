"""What the pages of design and runs share: previews, the library of parts, the runs.

>>> DesignService.__name__
'DesignService'
"""

import asyncio
import secrets
import time
from functools import cache
from pathlib import Path

from nicegui import app

from camtools.base.errors import CamtoolsError
from camtools.base.files import write_all
from camtools.panel.context import AppContext
from camtools.panel.design.part_library import EXAMPLE, PartLibrary
from camtools.panel.design.part_library import OWN as OWN_PARTS
from camtools.panel.design.preview_engine import Engine
from camtools.panel.orders.commander import Visitor
from camtools.panel.orders.order import Outcome
from camtools.panel.runs.run_queue import RunQueue
from camtools.panel.runs.store import DONE, OWN, REPORT, RunOptions, RunStore
from camtools.part.model import files_named, is_inside, read_tree
from camtools.pipeline.job import RUNS
from camtools.pipeline.load import parse
from camtools.sim.machine_file import names

_MAX_FILE_BYTES = 20_000_000


class DesignService:
    """Previews, parts and runs of one panel."""

    def __init__(self, context: AppContext) -> None:
        self.engine = Engine()
        self.library = PartLibrary(context.parts)
        self.machines = context.parts.parent / "machines"
        self.store = RunStore(context.runs, RUNS)
        self.queue = RunQueue(self.store)
        self.report_key = secrets.token_urlsafe()  # shows reports, and opens nothing else
        self._log = context.log

    async def close(self) -> None:
        """End all processes."""
        await self.queue.close()
        await self.engine.close()

    def report_address(self, run: str) -> str:
        """Return where the report of a run is served; the run's key is `Run.key`."""
        return f"/{self.report_key}/{run}/{REPORT}"

    def note(self, visitor: Visitor, what: str, arguments: dict[str, object], outcome: str) -> None:
        """Log what a visitor did."""
        self._log.add(visitor, what, arguments, Outcome(True, outcome))

    def stop_runs(self, visitor: Visitor, chosen: list[str]) -> None:
        """Stop the chosen runs that wait or run, by default the running one."""
        running = [] if self.queue.running is None else [self.queue.running.name]
        there = [*running, *self.queue.waiting]
        for name in [name for name in chosen if name in there] or running:
            self.queue.stop(name)
            self.note(visitor, "stop a run", {"run": name}, "asked to stop")

    def machine_names(self) -> list[str]:
        """Return the machines of the simulator, and those of one's own."""
        return [*names(), *self.own_machines()]

    def own_machines(self) -> list[str]:
        """Return the names of the machine files of one's own."""
        return sorted(path.stem for path in self.machines.glob("*.toml") if not path.is_symlink())

    def keep_machine(self, name: str, data: bytes) -> None:
        """Keep a machine file of one's own, which has no name of the simulator's."""
        if name in names():
            problem = "the simulator has a machine of this name; give another name"
            raise CamtoolsError([f"{name}: {problem}"])
        read_tree(data, f"{name}.toml")
        write_all(self.machines, {f"{name}.toml": data})

    def bring_files(self, text: str) -> None:
        """Put the files that the text of an example names beside one's own parts, unless there."""
        folder = self.library.folder(EXAMPLE)
        try:
            names = files_named(read_tree(text.encode("utf-8", "replace"), "part.toml"))
            found = _files(names, folder) if all(is_inside(name, folder) for name in names) else {}
        except CamtoolsError:
            return  # the text is no part yet, which is shown beside it
        for name, data in found.items():
            if not (self.library.folder(OWN_PARTS) / name).exists():
                self.library.save_file(name, data, replaces=False)

    def last_took_s(self, folder: Path) -> float | None:
        """Return how long the last run of the same part on the same machine took [s]."""
        try:
            this = self.store.run(f"{OWN}/{folder.name}")
        except CamtoolsError:
            return None
        alike = (
            run.took_s
            for run in self.store.runs()
            if run.status == DONE and run.part == this.part
            if run.options.machine == this.options.machine
            if run.options.rpm == this.options.rpm and run.options.feed_mm == this.options.feed_mm
        )
        return next(alike, None)

    async def cut(self, text: str, source: str, options: RunOptions) -> str:
        """Let a part be cut; return the name of the run, or raise CamtoolsError."""
        options.check()
        self.queue.check_room()
        folder = self.library.folder(source)
        data = text.encode("utf-8", "replace")
        machine = self._own_machine(options.machine)
        name, files = await asyncio.to_thread(_checked, data, folder)
        self.queue.check_room()
        if machine is not None:
            files["machine.toml"] = machine.read_bytes()
        place = self.store.new(name, text, options, at_s=time.time(), files=files)
        self.queue.add(place, options, None if machine is None else "machine.toml")
        return place.name

    def _own_machine(self, name: str) -> Path | None:
        if not name or name in names():
            return None
        if name in self.own_machines():
            return self.machines / f"{name}.toml"
        known = ", ".join(self.machine_names())
        raise CamtoolsError([f"machine {name[:40]!r}: no such machine; choose one of {known}"])


def _checked(data: bytes, folder: Path) -> tuple[str, dict[str, bytes]]:
    """Return the name of a part and the files that it names."""
    name: str = parse(data, "part.toml", folder, is_confined=True).part.part.name
    return name, _files(files_named(read_tree(data, "part.toml")), folder)


def _files(names: list[str], folder: Path) -> dict[str, bytes]:
    """Return the content of files beside a part by their names, or raise CamtoolsError."""
    found: dict[str, bytes] = {}
    for name in names:
        try:
            with (folder / name).open("rb") as stream:
                found[name] = stream.read(_MAX_FILE_BYTES)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise CamtoolsError([f"{name!r}: cannot be read: {reason}"]) from error
    return found


@cache
def design_service_of(context: AppContext) -> DesignService:
    """Return the design service of a panel, which begins and ends with it."""
    designs = DesignService(context)
    app.on_startup(designs.store.end_lost)
    app.on_shutdown(designs.close)
    return designs
