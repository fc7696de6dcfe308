"""What was judged already: a campaign that was interrupted goes on behind it."""

import hashlib
import json
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:  # it needs universalmutator, which who only reads figures has not
    from tests.mutation.mutants import Mutant

# What a verdict depends on; the compiler's depends on the first alone.
_COMPILED = (
    "firmware",
    "hal",
    "tests/mutation/mutants.py",
    "tests/mutation/asserted.py",
    "tests/mutation/workshop.py",
    "CMakeLists.txt",
    "CMakePresets.json",
)
_JUDGES = (*_COMPILED, "host_sim", "tests/unit", "tests/scenarios")


class Judged(NamedTuple):
    """One mutant and what became of it."""

    file: str
    line: int
    was: str
    becomes: str
    verdict: str
    seconds: float  # by the clock

    @property
    def is_valid(self) -> bool:
        """Return whether it says something: it is another program, and the compiler takes it."""
        return self.verdict not in ("invalid", "same code")

    @property
    def is_refused_alone(self) -> bool:
        """Return whether the compiler refuses it, and has not met it in the text of a test."""
        return self.verdict == "invalid" and not self.file.endswith(".h")

    def told(self) -> str:
        """Return verdict, place and change in one line, for people."""
        change = f"{self.was.strip()} -> {self.becomes.strip()}"
        return f"{self.verdict:40} {self.file}:{self.line}: {change}"


def digest_of(root: Path, *settings: object) -> str:
    """Return what tells whether verdicts are those of this tree and these settings."""
    return _digest(root, _JUDGES, "*", repr(settings))


def digest_compiled(root: Path) -> str:
    """Return what tells whether the compiler would say the same of a source of the firmware."""
    return _digest(root, _COMPILED, "*.[ch]", "")


def _digest(root: Path, names: tuple[str, ...], pattern: str, words: str) -> str:
    whole = hashlib.blake2b(words.encode(), digest_size=16)
    for name in names:
        top = root / name
        for path in sorted(p for p in (top, *top.rglob(pattern)) if p.is_file()):
            if "__pycache__" not in path.parts:
                whole.update(path.relative_to(root).as_posix().encode() + b"\0")
                whole.update(path.read_bytes())
    return whole.hexdigest()


class Journal:
    """A file with a line for each judged mutant, behind one that says of what tree.

    Parameters
    ----------
    path : Path
        The file. What another tree or other settings left there is given up, but for what the
        compiler refused of the same firmware.
    key, compiled : str
        From digest_of() and digest_compiled().
    """

    def __init__(self, path: Path, key: str, compiled: str) -> None:
        self._path = path
        self.judged: dict[tuple[str, int, str], Judged] = {}
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        head = json.loads(lines[0]) if lines else {}
        if head.get("compiled") == compiled:
            for line in lines[1:]:
                if line.endswith("]"):  # else the process ended while it was written
                    one = Judged(*json.loads(line))
                    if head["of"] == key or one.is_refused_alone:
                        self._know(one)
        path.parent.mkdir(parents=True, exist_ok=True)
        head = {"of": key, "compiled": compiled}
        whole = [json.dumps(head), *(json.dumps(one) for one in self.judged.values())]
        path.write_text("".join(f"{line}\n" for line in whole), encoding="utf-8")

    def _know(self, one: Judged) -> None:
        self.judged[one.file, one.line, one.becomes] = one

    def add(self, one: Judged) -> None:
        """Keep a verdict at once."""
        self._know(one)
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(one) + "\n")


class Killers:
    """Tests that killed mutants, in this campaign or an earlier one: hints whom to ask first.

    Parameters
    ----------
    path : Path
        A file that keeps them, whatever else has changed.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._known: dict[tuple[str, str, str], str] = {}
        self._counts: Counter[tuple[str, str]] = Counter()
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        for line in lines:
            if line.endswith("]"):
                *key, test = json.loads(line)
                self._know((key[0], key[1], key[2]), test)

    def _know(self, key: tuple[str, str, str], test: str) -> None:
        self._known[key] = test
        self._counts[key[0], test] += 1

    def of(self, mutant: "Mutant") -> str | None:
        """Return the name of the test that killed it, or that none is known."""
        return self._known.get((mutant.file, mutant.was, mutant.becomes))

    def count(self, file: str, test: str) -> int:
        """Return how many mutants of a file a test killed."""
        return self._counts[file, test]

    def add(self, mutant: "Mutant", test: str) -> None:
        """Keep one at once."""
        key = mutant.file, mutant.was, mutant.becomes
        if self._known.get(key) != test:
            self._know(key, test)
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps([*key, test]) + "\n")
