"""Small changes of the firmware's sources, drawn at random from all that the rules make.

The rules are those of universalmutator for languages like C: an operator becomes another one, a
number another number, a condition its opposite, true or false, a statement goes.
"""

import contextlib
import hashlib
import io
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

_RULES = ["universal.rules", "c_like.rules", "c.rules"]
_LEFT_OUT = [
    r"^\s*(#|///|return \"|\")",  # texts for people
    r"static const char|static inline.*\($|__asm|^\s*case [a-z_]+:$",
]
# A number within a name or a type changes: s(0-1), int(32+1)_t, int0_t.
_BROKEN = re.compile(r"[A-Za-z_]\(\d+[-+]\d+\)|int(?!(8|16|32|64)_t)-?\d+_t")


class Mutant(NamedTuple):
    """One changed line of one file."""

    file: str  # from the root of the tree
    line: int  # from 1
    was: str  # the line without its end
    becomes: str

    def __str__(self) -> str:
        """Return place and change."""
        return f"{self.file}:{self.line}: {self.was.strip()} -> {self.becomes.strip()}"

    @property
    def is_broken(self) -> bool:
        """Return whether it obviously does not compile."""
        return _BROKEN.search(self.becomes) is not None and _BROKEN.search(self.was) is None

    def applied(self, text: str) -> str:
        """Return the text of the file with the change."""
        lines = text.splitlines(keepends=True)
        assert lines[self.line - 1] == self.was + "\n"
        lines[self.line - 1] = self.becomes + "\n"
        return "".join(lines)


def _squeezed(line: str) -> str:
    """Return roughly what the compiler sees of a line."""
    code = re.sub(r"//.*|/\*.*?\*/", "", line)
    if re.match(r"\s*(X\(|\{cam_err_)", code):  # a list entry, whose text is for people
        code = re.sub(r'"[^"]*"', "", code)
    return re.sub(r"\s*(\W)\s*", r"\1", re.sub(r"\s+", " ", code)).strip()


def _untested(lines: Sequence[str]) -> set[int]:
    r"""Return the numbers, from 1, of lines that only the compiler or only a Cortex-M evaluates.

    >>> text = "int a;|_Static_assert(A &&|  B, 0);|#if defined(__ARM_X)|a();|#else|b();|#endif"
    >>> sorted(_untested(text.split("|")))
    [2, 3, 4, 5]
    """
    numbers: set[int] = set()
    end = ""  # where the part that has begun ends
    for number, line in enumerate(lines, start=1):
        if "_Static_assert(" in line:
            end = r"\);"
        elif line.startswith("#if defined(__ARM_"):
            end = "^#(else|endif)"
        is_last = end != "" and re.search(end, line) is not None
        if end and not (is_last and end.startswith("^")):
            numbers.add(number)
        end = "" if is_last else end
    return numbers


def _is_same(was: str, becomes: str) -> bool:
    """Return whether a change is none: errors are below cam_ok, nothing is above.

    >>> _is_same("if (err == cam_ok) {", "if (err >= cam_ok) {")
    True
    """
    squeezed = _squeezed(becomes).replace(">=cam_ok", "==cam_ok")
    return _squeezed(was) == re.sub(r"(?<![<=])<cam_ok", "!=cam_ok", squeezed)


def mutants_of(root: Path, file: str) -> list[Mutant]:
    """Return all mutants of a file, in the order of its lines."""
    from universalmutator import mutator  # which only tools/verify installs

    lines = (root / file).read_text(encoding="utf-8").splitlines(keepends=True)
    with contextlib.redirect_stdout(io.StringIO()):
        found = mutator.mutants_regexp(lines, list(_RULES), ignorePatterns=list(_LEFT_OUT))
    left_out = _untested(lines)
    made = []
    for number, text, *_ in found:
        was, becomes = lines[number - 1].rstrip("\n"), text.rstrip("\n")
        if number not in left_out and "\n" not in becomes and not _is_same(was, becomes):
            made.append(Mutant(file, number, was, becomes))
    return made


def sources(root: Path) -> list[str]:
    """Return the sources to change: not main(), which never returns, nor what is generated."""
    files = sorted(p.relative_to(root).as_posix() for p in (root / "firmware").rglob("*.[ch]"))
    return [file for file in files if not re.match("firmware/(main.c$|remote/can/)", file)]


def _rank(seed: int, *words: str) -> bytes:
    """Return the position of words in the order of a seed, whatever other words there are."""
    return hashlib.blake2b("\0".join((str(seed), *words)).encode(), digest_size=16).digest()


def drawn(root: Path, seed: int, files: list[str]) -> Iterator[Mutant]:
    """Yield each mutant once, in an order that depends on the seed.

    A line is drawn, then one of its changes, so that lines with many operators do not outweigh the
    others. The order depends on the text of each line alone: a change elsewhere does not alter it.
    """
    by_line: dict[tuple[str, int], list[Mutant]] = {}
    for file in files:
        for one in mutants_of(root, file):
            by_line.setdefault((one.file, one.line), []).append(one)
    seen: Counter[tuple[str, str]] = Counter()
    ranked = []
    for (file, _), choices in sorted(by_line.items()):
        line = choices[0].was.strip()
        seen[file, line] += 1
        choices.sort(key=lambda one: _rank(seed, one.becomes))
        ranked.append((_rank(seed, file, line, str(seen[file, line])), choices))
    ranked.sort()
    for turn in zip_longest(*(choices for _, choices in ranked)):
        yield from filter(None, turn)
