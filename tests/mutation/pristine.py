"""The project as it is, built once: where objects, programs and their commands are found.

Nothing here is ever built anew for a mutant. A workshop compiles what a mutant changes into a
folder of its own and links that ahead of these archives, which then serve the rest.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Lock

BUILD_LIMIT_S, TEST_LIMIT_S = 300.0, 60.0
CAMSIM = "host_sim/camsim"
_TEST_NAMES = "test_cam_*.c", "test_learn*.c"


def run(words: list[str], cwd: Path, limit_s: float, build: Path | None = None) -> int | None:
    """Return the exit status of a silent command, None when it took too long."""
    env = os.environ | ({"CAMTURN_BUILD": str(build)} if build else {})
    null = subprocess.DEVNULL
    with subprocess.Popen(
        words, cwd=cwd, env=env, stdin=null, stdout=null, stderr=null, start_new_session=True
    ) as process:
        try:
            return process.wait(limit_s)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return None


def digest(path: Path) -> str:
    """Return what tells whether two files are the same."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def copy_tree(root: Path, folder: Path) -> None:
    """Copy the tracked files; one that is the same already keeps its time."""
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=root, capture_output=True, check=True, text=True
    ).stdout.split("\0")
    for name in filter(None, listed):
        source, target = root / name, folder / name
        if not source.exists():
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists() or target.read_bytes() != source.read_bytes():
            shutil.copy(source, target)


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
        found = [p for name in _TEST_NAMES for p in (tree / "tests/unit").glob(f"*/{name}")]
        self.sources = {
            path.stem: path for path in found if (root / path.relative_to(tree)).exists()
        }
        made = run(["cmake", "--preset", preset], tree, BUILD_LIMIT_S)
        ninja = ["ninja", "-C", str(self.build), CAMSIM, *sorted(self.sources)]
        if made != 0 or run(ninja, tree, 6 * BUILD_LIMIT_S) != 0:
            raise RuntimeError(f"{tree}: {preset} does not build before it is changed")
        self.needs = self._needs()
        self.compiled = self._commands()
        self.times: dict[str, float] = {}
        self._lock = Lock()
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
        """Learn how long each test takes, in seconds; all of them pass before a change."""
        file = self.build / "mutation_times.json"
        known = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}

        def timed(name: str) -> tuple[str, float]:
            program = self.build / "tests/unit" / name
            now, (then, took_s) = digest(program), known.get(name, ("", 0.0))
            if now == then:
                return now, took_s
            begin = time.monotonic()
            if run([str(program)], self.tree, TEST_LIMIT_S) != 0:
                raise RuntimeError(f"{name} fails before anything is changed")
            return now, time.monotonic() - begin

        with ThreadPoolExecutor(2) as pool:
            known = dict(zip(self.sources, pool.map(timed, self.sources), strict=True))
        file.write_text(json.dumps(known), encoding="utf-8")
        self.times = {name: took_s for name, (_, took_s) in known.items()}
