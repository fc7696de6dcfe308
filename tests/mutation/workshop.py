"""A copy of the tree in which mutants are built and judged by the tests."""

import shutil
from functools import cache
from itertools import product
from pathlib import Path
from typing import Literal

from tests.mutation.journal import Killers
from tests.mutation.mutants import Mutant
from tests.mutation.pristine import (
    BUILD_LIMIT_S,
    CAMSIM,
    TEST_LIMIT_S,
    Pristine,
    copy_tree,
    digest,
    play_scenarios,
    run,
)

_LONG_S = 0.5  # a test that computes for longer is asked late
Care = Literal["all", "own", "deaf"]


def _is_own(test: str, module: str) -> bool:
    """Return whether a test has the name of the module, or one of the two begins with the other."""
    name, whole = f"{test}_", f"test_{module}_"
    short = f"test_cam_{module.removeprefix('cam_machine_')}_"
    return name.startswith((whole, short)) or whole.startswith(name)


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
        words.append(f"-ffile-prefix-map={tree}/=")  # where the tree lies is no difference
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
    killers : Killers
        The test that killed a mutant before is asked first.
    n_others : int or None
        Most tests of other modules that judge.
    """

    def __init__(
        self,
        root: Path,
        folder: Path,
        builds: list[Pristine],
        killers: Killers,
        n_others: int | None,
    ) -> None:
        self._tree, self._pristine = folder, builds[0]
        copy_tree(root, folder)
        build = folder / "build"
        if not build.is_symlink():
            build.symlink_to(self._pristine.tree / "build")
        self._bench = Bench(builds[0], folder)
        self._checked = [Bench(build, folder) for build in builds[1:]]
        self._killers, self._n_others = killers, n_others
        self._texts = {
            name: path.read_text(encoding="utf-8") for name, path in builds[0].sources.items()
        }

    def judge(self, mutant: Mutant, care: Care = "all") -> str:
        """Return `invalid`, `same code`, `survived`, or `killed by` what.

        With the care `own` only the module's own tests judge; with `deaf` even their assertions are
        not heard: only a crash or a time-out kills.
        """
        path = self._tree / mutant.file
        text = path.read_text(encoding="utf-8")
        for bench in (self._bench, *self._checked):
            bench.forget()
        try:
            path.write_text(mutant.applied(text), encoding="utf-8")
            return self._test(mutant, care)
        except RefusedError:
            return "invalid"
        finally:
            path.write_text(text, encoding="utf-8")

    def _ordered(self, mutant: Mutant) -> tuple[list[str], list[str]]:
        """Return the tests of the module, and the others.

        Of these those come first that killed mutants of its file, then those that name the module,
        then the quick ones.
        """
        module, times = Path(mutant.file).stem, self._pristine.times
        own = [name for name in times if _is_own(name, module)]
        others = [name for name in times if name not in own]
        others.sort(
            key=lambda name: (
                times[name] > _LONG_S,
                -self._killers.count(mutant.file, name),
                f"{module}_" not in self._texts[name],
                times[name],
            )
        )
        return sorted(own, key=lambda name: times[name]), others[: self._n_others]

    def _test(self, mutant: Mutant, care: Care) -> str:
        own, others = self._ordered(mutant)
        tests = own
        if care == "all":
            killer = self._killers.of(mutant)
            known = [killer] if killer in self._pristine.times else []
            tests = list(dict.fromkeys([*known, *own, *others]))
        needs = self._pristine.needs.get(mutant.file, set())
        for name in tests:
            program = self._bench.linked(f"tests/unit/{name}", needs)
            if program is None:
                continue
            limit_s = 2 + 10 * self._pristine.times[name]
            status = run([str(program)], self._tree, min(limit_s, TEST_LIMIT_S))
            if status is None or status < 0 or (status > 0 and care != "deaf"):
                self._pristine.assure(name)
                how = "time" if status is None else "crash" if status < 0 else ""
                if care == "all":
                    self._killers.add(mutant, name)
                return f"killed by {name}" + (f" ({how})" if how else "")
        return self._test_slowly(own, needs) if care == "all" else "survived"

    def _test_slowly(self, own: list[str], needs: set[str]) -> str:
        """Judge by what takes longer: own tests with sanitizers, then whole cuts on camsim."""
        camsim = self._bench.linked(CAMSIM, needs) if self._checked else None
        changed = {name for name in sorted(needs) if self._bench.is_changed(name)}
        if not changed:
            return "same code"
        for bench, name in product(self._checked, own):
            program = bench.linked(f"tests/unit/{name}", changed)
            if program and run([str(program)], self._tree, 2 * TEST_LIMIT_S) != 0:
                return f"killed by {name} with sanitizers"
        if camsim is None or not self._checked:
            return "survived"
        status = play_scenarios(self._tree, self._bench.out)
        return "survived" if status == 0 else "killed by scenarios"
