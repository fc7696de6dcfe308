"""Runs that are kept: a folder each, with the part file, what it was cut with, and the results.

Of the panel's own runs the newest 40 are kept, and 4 GB of them at most; what goes first is the
oldest. Runs of tools/run in build/run are shown too, and never changed.

>>> RunOptions(machine="real").text()
'machine real, speed and feed of the part, seed 1'
"""

import json
import re
import shutil
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from itertools import chain
from pathlib import Path
from typing import Any, Self

from camtools.base.errors import CamtoolsError
from camtools.base.files import write_all
from camtools.base.text import Json
from camtools.sim.results import SUMMARY, is_beyond

OF_THE_PART = ""  # a machine with the limits of the part file
_MAX_SEED = 2**31 - 1
_MAX_RPM, _MAX_FEED_MM = 60_000.0, 10.0


@dataclass(frozen=True)
class RunOptions:
    """What a cut is done with."""

    machine: str = OF_THE_PART  # a name of host_sim/machines, or of a machine file of one's own
    rpm: float | None = None  # of the part by default, as is the feed
    feed_mm: float | None = None
    learns: bool = True  # the controller may learn, where it measures U
    seed: int = 1  # of the encoder's noise

    def check(self) -> None:
        """Refuse what no cut can be done with."""
        _check("speed", self.rpm, _MAX_RPM, "r/min")
        _check("feed", self.feed_mm, _MAX_FEED_MM, "mm per turn")
        if not 0 <= self.seed <= _MAX_SEED:
            raise CamtoolsError([f"seed {self.seed}: give a whole number of 0 .. {_MAX_SEED}"])

    def words(self, part: str, machine: str | None = None) -> list[str]:
        """Return the words of tools/run, results in the working folder.

        The machine may be given by a path instead of its name.
        """
        given: dict[str, object] = {"--rpm": self.rpm, "--feed": self.feed_mm}
        given["--machine"] = (machine or self.machine) if self.machine != OF_THE_PART else None
        options = {name: str(value) for name, value in given.items() if value is not None}
        found = [part, "-o", ".", *chain(*options.items()), "--", "--seed", str(self.seed)]
        return found if self.learns else [*found, "--no-learning"]

    def text(self) -> str:
        """Return them in a line for people."""
        found = [f"machine {self.machine}" if self.machine else "machine of the part"]
        if self.rpm is None and self.feed_mm is None:
            found.append("speed and feed of the part")
        else:
            found.append("speed of the part" if self.rpm is None else f"{self.rpm:g} r/min")
            found.append("feed of the part" if self.feed_mm is None else f"{self.feed_mm:g} mm")
        found += [] if self.learns else ["learning off"]
        return ", ".join([*found, f"seed {self.seed}"])

    @classmethod
    def of(cls, kept: dict[str, Any]) -> Self:
        """Return what was kept of them; keys of another version are left out."""
        return cls(**{name: kept[name] for name in cls.__dataclass_fields__ if name in kept})


def _check(name: str, value: float | None, most: float, unit: str) -> None:
    if value is not None and not 0 < value <= most:
        problem = f"{name} {value:g}: must be above 0 and at most {most:g}"
        raise CamtoolsError([f"{problem}; give {unit}, or leave it empty for the part's own"])


PART = "part.toml"
ABOUT = "run.panel.json"  # no name of a part has a point, so none of its files is called that
REPORT = "report.html"
MOST_RUNS, MOST_BYTES = 40, 4 << 30
WAITING, RUNNING, DONE, FAILED, STOPPED = "waiting", "running", "done", "failed", "stopped"
OWN, OTHER = "own", "tools-run"
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,60}\Z")
_NUMBERED = re.compile(r"(.+)-(\d{3,})\Z")
_MOST_SUMMARY_BYTES = 50_000_000


@dataclass(frozen=True)
class Run:
    """What is known about a run."""

    place: str  # OWN, or OTHER for those of tools/run
    name: str  # of its folder
    folder: Path
    part: str
    at_s: float  # when it was asked for [s of time.time]
    options: RunOptions
    status: str  # waiting, running, done, failed or stopped
    told: str = ""  # last line of the command, where it failed
    took_s: float | None = None  # how long it took
    verdict: str = ""
    form_um: float | None = None
    following_um: float | None = None
    machine: str = ""
    has_report: bool = False

    @property
    def key(self) -> str:
        """Return what no other run has."""
        return f"{self.place}/{self.name}"


class RunStore:
    """The folders of runs."""

    def __init__(self, folder: Path, others: Path) -> None:
        self._folders = {OWN: folder, OTHER: others}
        self._n_changes = 0

    def version(self) -> tuple[int, int]:
        """Return what changes when the list of runs does."""
        others = self._folders[OTHER]
        return self._n_changes, others.stat().st_mtime_ns if others.is_dir() else 0

    def new(
        self,
        name: str,
        text: str,
        options: RunOptions,
        *,
        at_s: float,
        files: dict[str, bytes] | None = None,
    ) -> Path:
        """Return a new folder NAME-NNN with a part file, what it names, and how it will be cut."""
        if not _NAME.match(name):
            raise CamtoolsError([f"name {name[:40]!r}: not usable; give letters and digits"])
        place = self._folders[OWN]
        place.mkdir(parents=True, exist_ok=True)
        taken = [_NUMBERED.match(path.name) for path in place.iterdir()]
        last = max((int(match[2]) for match in taken if match and match[1] == name), default=0)
        folder = place / f"{name}-{last + 1:03d}"
        folder.mkdir()
        for file, data in (files or {}).items():
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            (folder / file).write_bytes(data)
        (folder / PART).write_bytes(text.encode("utf-8"))
        about = {"part": name, "at_s": at_s, "options": asdict(options), "status": WAITING}
        self.note(folder, about)
        return folder

    def note(self, folder: Path, about: Json) -> None:
        """Write what is known about a run, over what was known before."""
        self._n_changes += 1
        known = _about(folder) | about
        write_all(folder, {ABOUT: json.dumps(known, indent=1).encode("ascii")})

    def runs(self) -> list[Run]:
        """Return all runs, the newest first."""
        found = [
            run
            for place, folder in self._folders.items()
            if folder.is_dir()
            for path in folder.iterdir()
            if (run := _read(place, path)) is not None
        ]
        return sorted(found, key=lambda run: (-run.at_s, run.name))

    def run(self, key: str) -> Run:
        """Return a run by its key; raise CamtoolsError where there is none."""
        place, _, name = key.partition("/")
        folder = self._folders.get(place)
        if folder is not None and (found := _read(place, folder / name)) is not None:
            return found
        raise CamtoolsError([f"run {key[:80]!r}: no such run; it may have been removed"])

    def remove(self, key: str) -> None:
        """Remove a run of the panel that has ended."""
        run = self.run(key)
        if run.place != OWN:
            raise CamtoolsError([f"{run.name}: made by tools/run; remove it with tools/run --keep"])
        if run.status in (WAITING, RUNNING):
            raise CamtoolsError([f"{run.name}: is {run.status}; stop it first"])
        self._n_changes += 1
        shutil.rmtree(run.folder)

    def tidy(self, most_runs: int = MOST_RUNS, most_bytes: int = MOST_BYTES) -> list[str]:
        """Remove the oldest finished runs beyond what is kept; return their names."""
        ended = [
            run for run in self.runs() if run.place == OWN and run.status not in (WAITING, RUNNING)
        ]
        n_bytes, removed = 0, []
        for i, run in enumerate(ended):
            n_bytes += sum(f.lstat().st_size for f in run.folder.rglob("*") if f.is_file())
            if i >= most_runs or (n_bytes > most_bytes and i > 0):
                shutil.rmtree(run.folder, ignore_errors=True)
                removed.append(run.name)
        self._n_changes += len(removed)
        return removed

    def end_lost(self) -> None:
        """Mark runs as stopped that an earlier panel did not end."""
        for run in self.runs():
            if run.place == OWN and run.status in (WAITING, RUNNING):
                message = "the panel was closed before the run ended"
                self.note(run.folder, {"status": STOPPED, "told": message})


def _about(folder: Path) -> Json:
    try:
        found: Any = json.loads((folder / ABOUT).read_bytes())
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


@lru_cache(maxsize=256)
def _summary(path: Path, _stamped: tuple[int, int]) -> Json:
    found: Json = json.loads(path.read_bytes())
    return found


def summary_of(folder: Path) -> Json | None:
    """Return the summary of a cut, nothing where there is none."""
    path = folder / SUMMARY
    try:
        state = path.stat()
        stamp = state.st_mtime_ns, state.st_size
        if stamp[1] > _MOST_SUMMARY_BYTES:
            return None
        return _summary(path, stamp)
    except (OSError, ValueError):
        return None


def verdict_word(summary: Json) -> str:
    """Return the verdict of a cut in a few words."""
    if "fault" in summary:
        return "fault: " + ", ".join(summary.get("first_faults", []))
    form = summary["form_error_um"]
    if form["max"] is None:
        return "nothing cut"
    if summary.get("certified"):
        return str(summary["verdict"])
    if is_beyond(summary):
        return "out of tolerance"
    if summary["end"] != "done":
        return f"incomplete: {summary['end']}"
    if summary.get("sheets_out_of_tolerance"):
        return "out of tolerance"
    return "within tolerance" if summary["is_good"] else "not gauged"


def _read(place: str, folder: Path) -> Run | None:
    if not _NAME.match(folder.name) or not folder.is_dir() or folder.is_symlink():
        return None
    about, summary = _about(folder), summary_of(folder)
    if place == OTHER and (summary is None or "run_wall_time_s" not in summary):
        return None
    if place == OWN and "part" not in about:
        return None
    at_s = about["at_s"] if "at_s" in about else (folder / SUMMARY).stat().st_mtime
    run = Run(
        *(place, folder.name, folder),
        part=str(about.get("part", (summary or {}).get("part", folder.name))),
        at_s=float(at_s),
        options=RunOptions.of(about.get("options", {})),
        status=str(about.get("status", DONE)),
        told=str(about.get("told", "")),
        took_s=about.get("took_s"),
        has_report=(folder / REPORT).is_file(),
    )
    if summary is None:
        return run
    form, following = summary["form_error_um"], summary["following_error_um"]
    return replace(
        run,
        verdict=verdict_word(summary),
        form_um=form["max"],
        following_um=following["max"],
        machine=str(summary.get("machine", "")),
        took_s=run.took_s or summary.get("run_wall_time_s"),
    )
