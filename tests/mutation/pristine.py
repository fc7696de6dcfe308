"""The project as it is, built once: where objects, programs and their commands are found.

Nothing here is ever built anew for a mutant. A workshop compiles what a mutant changes into a
folder of its own and links that ahead of these archives, which then serve the rest.
"""

import contextlib
import hashlib
import json
import math
import os
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from threading import Lock

# Of the processor and not of the clock, so that a busy machine does not look like a killed mutant.
BUILD_LIMIT_S, TEST_LIMIT_S = 300.0, 60.0
_WAITS = 30  # times as long by the clock: then it hangs without computing
CAMSIM = "host_sim/camsim"
_JUDGE = "judge_library"  # of the build host: tables are made with it
_TEST_NAMES = "test_cam_*.c", "test_learn*.c"


def run(words: list[str], cwd: Path, limit_s: float, build: Path | None = None) -> int | None:
    """Return the exit status of a silent command, None when it took too long.

    No process of it may compute for longer than the limit.
    """
    env = os.environ | ({"CAMTURN_BUILD": str(build)} if build else {})
    null = subprocess.DEVNULL
    with subprocess.Popen(
        words, cwd=cwd, env=env, stdin=null, stdout=null, stderr=null, start_new_session=True
    ) as process:
        most_s = math.ceil(limit_s)
        with contextlib.suppress(ProcessLookupError):  # it has ended already
            resource.prlimit(process.pid, resource.RLIMIT_CPU, (most_s, most_s + 1))
        try:
            status = process.wait(_WAITS * limit_s)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return None
    return None if status in (-signal.SIGXCPU, -signal.SIGKILL) else status


def digest(path: Path) -> str:
    """Return what tells whether two files are the same."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def copy_tree(root: Path, folder: Path) -> None:
    """Copy the tracked files; one that is the same already keeps its time, others go."""
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=root, capture_output=True, check=True, text=True
    ).stdout.split("\0")
    names = set(listed)
    for path in folder.glob("*/**/*") if folder.exists() else ():
        place = path.relative_to(folder)
        if place.parts[0] != "build" and path.is_file() and str(place) not in names:
            path.unlink()
    for name in filter(None, listed):
        source, target = root / name, folder / name
        if not source.exists():
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists() or target.read_bytes() != source.read_bytes():
            shutil.copy(source, target)


def judging_tests(tree: Path) -> dict[str, Path]:
    """Return the unit tests that judge mutants, by the name of their program."""
    found = (path for name in _TEST_NAMES for path in (tree / "tests/unit").rglob(name))
    return {path.stem: path for path in found}


class Pristine:
    """A build of the tracked files with one preset.

    Parameters
    ----------
    root : Path
        The project.
    tree : Path
        Where the copy is; what is there of an earlier campaign is used again.
    preset : str
        `host` or `host-asan`.
    """

    def __init__(self, root: Path, tree: Path, preset: str) -> None:
        self.tree, self.build = tree, tree / "build" / preset
        copy_tree(root, tree)
        for name in ("_unity", "_monocypher"):
            fetched, link = root / "build" / name, tree / "build" / name
            link.parent.mkdir(exist_ok=True)
            if fetched.exists() and not link.exists():
                link.symlink_to(fetched.resolve())
        self.sources = {
            name: path
            for name, path in judging_tests(tree).items()
            if (root / path.relative_to(tree)).exists()
        }
        made = run(["cmake", "--preset", preset], tree, BUILD_LIMIT_S)
        ninja = ["ninja", "-C", str(self.build), CAMSIM, *sorted(self.sources)]
        if made != 0 or run(ninja, tree, 6 * BUILD_LIMIT_S) != 0:
            raise RuntimeError(f"{tree}: {preset} does not build before it is changed")
        host = ["cmake", "--preset", "host"], ["ninja", "-C", str(tree / "build" / "host"), _JUDGE]
        if any(run(words, tree, BUILD_LIMIT_S) != 0 for words in host):
            raise RuntimeError(f"{tree}: {_JUDGE} does not build before it is changed")
        self.needs = self._needs()
        self.compiled = self._commands()
        self.times: dict[str, float] = {}
        self._lock = Lock()
        self._passed: set[str] = set()
        self._links: dict[str, tuple[list[str], set[str]]] = {}

    def _ninja(self, *words: str) -> str:
        tool = ["ninja", "-C", str(self.build), "-t", *words]
        return subprocess.run(tool, capture_output=True, check=True, text=True).stdout

    def _needs(self) -> dict[str, set[str]]:
        """Return the objects that are made of a file, by the file's name from the root."""
        needs: dict[str, set[str]] = {}
        target = ""
        for line in self._ninja("deps").splitlines():
            if line.startswith(" "):
                path = Path(os.path.normpath(self.build / line.strip()))
                if path.is_relative_to(self.tree):
                    needs.setdefault(path.relative_to(self.tree).as_posix(), set()).add(target)
            else:
                target = line.partition(":")[0]
        return needs

    def _commands(self) -> dict[str, list[str]]:
        """Return the command that makes an object; without code for the linker to optimize."""
        text = (self.build / "compile_commands.json").read_text(encoding="utf-8")
        commands = {}
        for entry in json.loads(text):
            words = shlex.split(entry["command"])
            words = [word for word in words if word not in ("-flto", "-ffat-lto-objects")]
            commands[words[words.index("-o") + 1]] = words
        return commands

    def link(self, program: str) -> tuple[list[str], set[str]]:
        """Return the command that links a program, and the objects that are then in it."""
        with self._lock:
            if program not in self._links:
                self._links[program] = self._link(program)
            return self._links[program]

    def _link(self, program: str) -> tuple[list[str], set[str]]:
        last = self._ninja("commands", "-s", program).splitlines()[-1]
        words = [word for word in shlex.split(last) if word not in (":", "&&", "-flto=auto")]
        traced = subprocess.run(
            [*words, "-fno-lto", "-Wl,-t,-t", "-o", "/dev/null"],
            cwd=self.build,
            capture_output=True,
            check=True,
            text=True,
        ).stdout
        members = {word for word in words if word.endswith(".o")}
        for folder, archive, member in re.findall(r"(\S*?)lib(\w+)\.a[)(]+(\S+?\.o)", traced):
            members.add(f"{folder.lstrip('(')}CMakeFiles/{archive}.dir/{member}")
        return words, members & self.compiled.keys()

    def measure(self) -> None:
        """Learn for how many seconds each test computes, roughly: an earlier build told it too."""
        file = self.build / "mutation_times.json"
        known = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
        for name in self.sources:
            if name not in known:
                begin_s = _computed_s()
                self.assure(name)
                known[name] = _computed_s() - begin_s
        file.write_text(json.dumps(known), encoding="utf-8")
        self.times = {name: known[name] for name in self.sources}

    def assure(self, name: str) -> None:
        """Raise unless a test passes before a change; it is asked before its first verdict."""
        with self._lock:
            if name not in self._passed:
                program = self.build / "tests/unit" / name
                if run([str(program)], self.tree, TEST_LIMIT_S) != 0:
                    raise RuntimeError(f"{name} fails before anything is changed")
                self._passed.add(name)

    def check_scenarios(self) -> None:
        """Raise unless all of them pass before a change; else each would notice every mutant."""
        if play_scenarios(self.tree, self.build) != 0:
            raise RuntimeError("tests/scenarios fail before anything is changed")


def play_scenarios(tree: Path, build: Path) -> int | None:
    """Return the exit status of the scenarios with the simulator of a build."""
    pytest = [sys.executable, "-m", "pytest", "-c", "tools/pyproject.toml", "-q", "-x"]
    words = [*pytest, f"--rootdir={tree}", "-p", "no:cacheprovider", "tests/scenarios"]
    return run(words, tree, 10 * TEST_LIMIT_S, build)


def _computed_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
