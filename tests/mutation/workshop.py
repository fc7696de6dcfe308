"""A copy of the tree in which mutants are built and judged by the tests."""

from __future__ import annotations

import shutil
import sys
from functools import cache
from itertools import product
from pathlib import Path

from mutants import Mutant
from pristine import BUILD_LIMIT_S, CAMSIM, TEST_LIMIT_S, Pristine, copy_tree, digest, run


class RefusedError(Exception):
    """The compiler refuses the mutant."""


class Bench:
    """Compiles what a mutant changes, and links programs with it.

    Parameters
    ----------
    pristine : Pristine
        Serves all that is not changed.
    tree : Path
        Copy of the tree, whose folder `build` is that of the pristine one.
    """

    def __init__(self, pristine: Pristine, tree: Path) -> None:
        self._pristine, self._tree = pristine, tree
        self.out = tree.parent / f"{tree.name}-{pristine.build.name}"
        self._changed: dict[str, bool] = {}  # of the present mutant, by object
        self._own = cache(self._digest_before)

    def forget(self) -> None:
        """Begin with the next mutant."""
        shutil.rmtree(self.out, ignore_errors=True)
        self._changed.clear()

    def _compile(self, name: str, target: Path, tree: Path) -> bool:
        target.parent.mkdir(parents=True, exist_ok=True)
        words = [
            word if word.startswith("-D") else word.replace(f"{self._pristine.tree}/", f"{tree}/")
            for word in self._pristine.compiled[name]
        ]
        words[words.index("-o") + 1] = str(target)
        return run(words, self._pristine.build, BUILD_LIMIT_S) == 0

    def _digest_before(self, name: str) -> str:
        target = self.out / "before.o"
        if not self._compile(name, target, self._pristine.tree):
            raise RuntimeError(f"{name} does not compile before it is changed")
        return digest(target)

    def is_changed(self, name: str) -> bool:
        """Return whether the mutant makes another object of it."""
        if name not in self._changed:
            target = self.out / name
            if not self._compile(name, target, self._tree):
                raise RefusedError
            self._changed[name] = digest(target) != self._own(name)
        return self._changed[name]

    def linked(self, program: str, needs: set[str]) -> Path | None:
        """Return the program with the mutant in it; None when it is the same program."""
        words, members = self._pristine.link(program)
        changed = {name for name in sorted(members & needs) if self.is_changed(name)}
        if not changed:
            return None
        target = self.out / program
        target.parent.mkdir(parents=True, exist_ok=True)
        ahead = [str(self.out / name) for name in sorted(changed - set(words))]
        words = [str(self.out / word) if word in changed else word for word in words]
        at = words.index("-o")
        words = [*words[:at], *ahead, "-fno-lto", "-o", str(target), *words[at + 2 :]]
        if run(words, self._pristine.build, BUILD_LIMIT_S) != 0:
            raise RefusedError
        return target


class Workshop:
    """Judges one mutant after the other.

    Parameters
    ----------
    root, folder : Path
        The project, and where the copy goes.
    builds : list of Pristine
        Without sanitizers, and with them; if there is none with them, only unit tests judge.
    """

    def __init__(self, root: Path, folder: Path, builds: list[Pristine]) -> None:
        self._tree, self._pristine = folder, builds[0]
        copy_tree(root, folder)
        build = folder / "build"
        if not build.is_symlink():
            build.symlink_to(self._pristine.tree / "build")
        self._bench = Bench(builds[0], folder)
        self._checked = [Bench(build, folder) for build in builds[1:]]

    def judge(self, mutant: Mutant) -> str:
        """Return `invalid`, `same code`, `survived`, or `killed by` what."""
        path = self._tree / mutant.file
        text = path.read_text(encoding="utf-8")
        for bench in (self._bench, *self._checked):
            bench.forget()
        try:
            path.write_text(mutant.applied(text), encoding="utf-8")
            return self._test(mutant)
        except RefusedError:
            return "invalid"
        finally:
            path.write_text(text, encoding="utf-8")

    def _ordered(self, mutant: Mutant) -> tuple[list[str], list[str]]:
        """Return the tests of the module, and the others: those that name it, then quick ones."""
        module, times = Path(mutant.file).stem, self._pristine.times
        own = [name for name in times if f"{name}_".startswith(f"test_{module}_")]
        naming = {
            name
            for name, path in self._pristine.sources.items()
            if f"{module}_" in path.read_text(encoding="utf-8")
        }
        others = [name for name in times if name not in own]
        return (
            sorted(own, key=lambda name: times[name]),
            sorted(others, key=lambda name: (times[name] > 1, name not in naming, times[name])),
        )

    def _test(self, mutant: Mutant) -> str:
        own, others = self._ordered(mutant)
        needs = self._pristine.needs.get(mutant.file, set())
        for name in (*own, *others):
            program = self._bench.linked(f"tests/unit/{name}", needs)
            if program is None:
                continue
            limit_s = 5 + 10 * self._pristine.times[name]
            status = run([str(program)], self._tree, min(limit_s, TEST_LIMIT_S))
            if status != 0:
                return f"killed by {name}" + (" (time)" if status is None else "")
        return self._test_slowly(own, needs)

    def _test_slowly(self, own: list[str], needs: set[str]) -> str:
        """Judge by what takes longer: own tests with sanitizers, then whole cuts on camsim."""
        camsim = self._bench.linked(CAMSIM, needs)
        if camsim is None and not any(map(self._bench.is_changed, needs)):
            return "same code"
        for bench, name in product(self._checked, own):
            program = bench.linked(f"tests/unit/{name}", needs)
            if program and run([str(program)], self._tree, 2 * TEST_LIMIT_S) != 0:
                return f"killed by {name} with sanitizers"
        if camsim is None or not self._checked:
            return "survived"
        pytest = [sys.executable, "-m", "pytest", "-c", "tools/pyproject.toml", "-q", "-x"]
        words = [*pytest, f"--rootdir={self._tree}", "-p", "no:cacheprovider", "tests/scenarios"]
        status = run(words, self._tree, 10 * TEST_LIMIT_S, self._bench.out)
        return "survived" if status == 0 else "killed by scenarios"
