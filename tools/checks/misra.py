"""Command line of the MISRA gate: what cppcheck finds in the firmware against its deviations.

A deviation is a row of firmware/MISRA.md. It covers the findings of its rules in the files of its
scope, if the line holds one of its words, where it has any; with the scope "in place" only lines
that name it, or that stand behind one that does.

>>> rows = parse_deviations("MISRA.md", "| D1 | 10.1 | required | `*.c` | `>>` | arithmetic |")
>>> rows[0].covers(Finding("a.c", 2, "10.1"), ["int a;", "a = b >> 1;"])
True
>>> rows[0].covers(Finding("a.c", 1, "10.1"), ["int a;", "a = b >> 1;"])
False
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Mapping
from fnmatch import fnmatch
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from camtools.base.command import Parser, run_command
from camtools.base.errors import CamtoolsError, InputError

FAILED = 1
IN_PLACE = "in place"
DEVIATIONS = "firmware/MISRA.md"
SOURCES = "firmware"
GENERATED = "firmware/remote/can"
INCLUDES = ("firmware/*/", "hal/include/")
OVER_ALL = ("2.3", "2.4", "2.5", "5.6", "5.7", "5.8", "5.9", "8.6", "8.7")  # of all files at once
CORE = {"__ARM_FEATURE_DSP": "1", "__ARM_ARCH_PROFILE": "'M'"}  # a compiler for it defines them

_ROW = re.compile(r"^\| (D\d+) \| ([^|]+) \| ([^|]+) \| ([^|]+) \| ([^|]*) \| ([^|]+) \|$")
_REMEDY = "write | Dn | rules | category | scope | words | reason |"
_CATEGORIES = ("required", "advisory", "cppcheck")  # nothing deviates from a mandatory rule


class Finding(NamedTuple):
    """A place that breaks a rule."""

    file: str
    line: int
    rule: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: rule {self.rule}"


class Deviation(NamedTuple):
    """A row of the table: rules that may be broken, where, and why."""

    number: str
    rules: tuple[str, ...]
    files: tuple[str, ...]
    words: tuple[str, ...]
    reason: str

    def covers(self, finding: Finding, lines: list[str]) -> bool:
        """Return whether a finding in a file of these lines is allowed."""
        if finding.rule not in self.rules:
            return False
        near = lines[max(finding.line - 2, 0) : finding.line]
        if self.files == (IN_PLACE,):
            return any(re.search(rf"// MISRA {self.number}\b", line) for line in near)
        if not any(fnmatch(finding.file, pattern) for pattern in self.files):
            return False
        return not self.words or any(word in near[-1] for word in self.words)


def _quoted(cell: str) -> tuple[str, ...]:
    return tuple(re.findall(r"`([^`]+)`", cell))


def parse_deviations(file: str, text: str) -> list[Deviation]:
    """Return the deviations of a Markdown table, whose numbers have no gap."""
    found: list[Deviation] = []
    for line in text.splitlines():
        if not line.startswith("| D"):
            continue
        row = _ROW.match(line)
        if row is None or row[3] not in _CATEGORIES or row[1] != f"D{len(found) + 1}":
            raise InputError(file, "deviation", line, "is not understood or out of order", _REMEDY)
        files = (IN_PLACE,) if row[4] == IN_PLACE else _quoted(row[4])
        if not files:
            raise InputError(file, row[1], row[4], "is no scope", _REMEDY)
        found.append(Deviation(row[1], tuple(row[2].split(", ")), files, _quoted(row[5]), row[6]))
    return found


def parse_findings(text: str) -> list[Finding]:
    """Return the findings in the output of cppcheck, written by the template file|line|id."""
    found = set()
    for line in text.splitlines():
        parts = line.split("|")
        if len(parts) != 3 or not parts[1].isdecimal():
            raise CamtoolsError([f"cppcheck: {line}; is the addon misra installed?"])
        found.add(Finding(parts[0], int(parts[1]), parts[2].removeprefix("misra-c2012-")))
    return sorted(found)


def of_the_core(root: Path, sources: list[Path]) -> list[Path]:
    """Return a source for each file that has lines of the core: itself, or one that includes it."""
    files = [*sources, *sorted(root.glob(f"{SOURCES}/**/*.h"))]
    names = [path.name for path in files if any(m in path.read_text("utf-8") for m in CORE)]
    found = set()
    for name in names:
        texts = ((path, path.read_text("utf-8")) for path in sources)
        found |= set([p for p, text in texts if p.name == name or f'"{name}"' in text][:1])
    return sorted(found)


def cppcheck(root: Path) -> list[Finding]:
    """Return what cppcheck finds in the firmware, its MISRA addon included.

    By itself cppcheck would read every file three times, since headers that nearly all include have
    a few lines for the core: those are read once. Raises CamtoolsError: it is not installed, or
    breaks down.
    """
    sources = sorted(p for p in root.glob(f"{SOURCES}/**/*.c") if p.parent != root / GENERATED)
    found = _findings(root, sources, [f"-U{name}" for name in CORE])
    core = of_the_core(root, sources)
    if core:
        more = _findings(root, core, [f"-D{name}={value}" for name, value in CORE.items()])
        found += [finding for finding in more if finding.rule not in OVER_ALL]
    return sorted(set(found))


def _findings(root: Path, sources: list[Path], macros: list[str]) -> list[Finding]:
    command = ["cppcheck", "--addon=misra", "--std=c11", "--platform=unix32", "-q", *macros]
    command += ["-UCAM_HARD_LIMITS_FILE"]  # a builder's own header, whose name is a macro
    command += ["--enable=warning,style,performance,portability", "--template={file}|{line}|{id}"]
    folders = [path.relative_to(root) for glob in INCLUDES for path in sorted(root.glob(glob))]
    command += [f"-I{folder}" for folder in folders]
    command += [path.relative_to(root).as_posix() for path in sources]
    try:
        with TemporaryDirectory() as folder:  # the addon's dumps would lie beside the sources
            command.insert(1, f"--cppcheck-build-dir={folder}")
            done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    except OSError as error:
        raise CamtoolsError([f"cppcheck: {error.strerror}; install it"]) from error
    if done.returncode or done.stdout:
        raise CamtoolsError(
            [f"cppcheck: {line}" for line in done.stdout.splitlines() or ["failed"]]
        )
    return parse_findings(done.stderr)


def judge(
    findings: Iterable[Finding], deviations: list[Deviation], texts: Mapping[str, list[str]]
) -> tuple[list[Finding], Counter[str]]:
    """Return the findings that no deviation covers, and how many each covers as the first."""
    left, covered = list[Finding](), Counter[str]()
    for finding in findings:
        lines = texts[finding.file]
        number = next(
            (deviation.number for deviation in deviations if deviation.covers(finding, lines)), None
        )
        if number is None:
            left.append(finding)
        else:
            covered[number] += 1
    return left, covered


def check(root: Path) -> int:
    """Print what is left; 0 if nothing is, and every deviation is still needed."""
    path = root / DEVIATIONS
    deviations = parse_deviations(DEVIATIONS, path.read_text("utf-8"))
    findings = cppcheck(root)
    files = {finding.file for finding in findings}
    texts = {file: (root / file).read_text("utf-8").splitlines() for file in files}
    left, covered = judge(findings, deviations, texts)
    for finding in left:
        print(f"{finding}: {texts[finding.file][finding.line - 1].strip()}")
    unused = [deviation.number for deviation in deviations if not covered[deviation.number]]
    for number in unused:
        print(f"{DEVIATIONS}: {number} covers nothing any more; take it out")
    counts = ", ".join(
        f"{deviation.number} {covered[deviation.number]}" for deviation in deviations
    )
    print(f"{len(findings)} findings, {len(left)} without a deviation; by deviation: {counts}")
    return FAILED if left or unused else 0


def main(argv: list[str] | None = None) -> int:
    """Run the gate; 0 it holds, 1 it does not, 2 it cannot be run."""
    parser = Parser(prog="tools/misra", description="Hold the firmware to MISRA C:2012.")
    parser.parse_args(argv)
    return run_command("misra", lambda: check(Path(__file__).resolve().parents[2]))


if __name__ == "__main__":
    sys.exit(main())
