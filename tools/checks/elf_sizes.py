"""Sizes of the modules of an image, by source file, against recorded ones.

Code counts for the file it is written in, wherever it was inlined; constants and variables for
the file that defines them. Not counted is what has no name, as the texts of messages; after
link-time optimisation the binary utilities find no file for constants and variables either, and
constants must stand in a section of their own (.rodata), not in .text.

>>> grown = compare({"a.c": Size(code=1200)}, {"a.c": Size(code=1100)})
>>> [str(change) for change in grown]
['a.c: code 1100 -> 1200 bytes']
"""

from __future__ import annotations

import re
import tomllib
from collections import defaultdict
from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import NamedTuple

from camtools.base.errors import InputError
from checks.elf_image import Image

MOST_PERCENT = 2
MOST_BYTES = 64

_SYMBOL = re.compile(r"^([0-9a-f]+) ([0-9a-f]+) ([a-zA-Z]) (\S+)(?:\t(.*):\d+)?$")
_KINDS = {"t": "constants", "r": "constants", "d": "data", "b": "bss"}
_REMEDY = "record it with tools/elfcheck sizes --record"


class Size(NamedTuple):
    """Bytes of one module: instructions and literals, constants, data, zeroed data."""

    code: int = 0
    constants: int = 0
    data: int = 0
    bss: int = 0


class Change(NamedTuple):
    """A size that is not what was recorded."""

    module: str
    kind: str
    before: int
    after: int

    def __str__(self) -> str:
        return f"{self.module}: {self.kind} {self.before} -> {self.after} bytes"

    @property
    def is_growth(self) -> bool:
        """Whether the module became larger."""
        return self.after > self.before


Sizes = dict[str, Size]


def _module(file: str, sources: Iterable[str]) -> str | None:
    """Return a file's name from one of the folders on, if it lies in one."""
    for folder in sources:
        if found := re.search(rf"(?:^|/)({re.escape(folder.rstrip('/'))}/.*)", file):
            return found[1].replace("/./", "/")
    return None


def _code_bytes(image: Image, begin: int, end: int) -> dict[int, int]:
    """Return the bytes from each instruction of a function to the next, literals included."""
    function = image.code.get(begin)
    starts = [instruction.address for instruction in function.instructions] if function else []
    edges = [*(start for start in starts if start < end), end]
    return {start: after - start for start, after in pairwise(edges)}


def measure(image: Image, sources: Iterable[str]) -> Sizes:
    """Return the sizes of the modules whose sources lie in folders of the debug information."""
    total: dict[str, dict[str, int]] = defaultdict(lambda: defaultdict(int))
    sources, n_bytes = tuple(sources), dict[int, int]()
    for line in image.ask("nm", "-S", "-l", str(image.path)).splitlines():
        if not (found := _SYMBOL.match(line)):
            continue
        address, size, kind = int(found[1], 16), int(found[2], 16), found[3].lower()
        address &= ~1 if kind == "t" else ~0
        code = _code_bytes(image, address, address + size) if kind in "tw" else {}
        n_bytes |= code
        module = _module(found[5] or "", sources)
        if not code and module and kind in _KINDS:
            total[module][_KINDS[kind]] += size
    for address, stack in image.places(sorted(n_bytes)).items():
        if stack and (module := _module(stack[0].file, sources)):
            total[module]["code"] += n_bytes[address]
    return {module: Size(**kinds) for module, kinds in sorted(total.items())}


def compare(measured: Sizes, recorded: Mapping[str, Size]) -> list[Change]:
    """Return what differs by more than 64 bytes and more than 2 %."""
    changes = []
    for module in sorted(measured.keys() | recorded.keys()):
        before, after = recorded.get(module, Size()), measured.get(module, Size())
        for kind, old, new in zip(Size._fields, before, after, strict=True):
            if abs(new - old) > max(MOST_BYTES, old * MOST_PERCENT / 100):
                changes.append(Change(module, kind, old, new))
    return changes


def parse_sizes(file: str, text: str) -> dict[str, Sizes]:
    """Return the recorded sizes by name of the build, then by module."""
    try:
        builds = tomllib.loads(text)
        return {
            build: {module: Size(**size) for module, size in modules.items()}
            for build, modules in builds.items()
        }
    except (tomllib.TOMLDecodeError, TypeError, AttributeError) as error:
        raise InputError(file, "", None, str(error), _REMEDY) from error


def emit_sizes(builds: Mapping[str, Sizes]) -> str:
    """Return a record as TOML, the same text for the same sizes."""
    lines = [
        "# SPDX-License-Identifier: Apache-2.0",
        "# Bytes by source file; written by tools/elfcheck sizes --record.",
    ]
    for build, sizes in sorted(builds.items()):
        lines += ["", f"[{build}]"]
        for module, size in sorted(sizes.items()):
            values = ", ".join(f"{kind} = {n}" for kind, n in size._asdict().items())
            lines.append(f'"{module}" = {{ {values} }}')
    return "\n".join(lines) + "\n"


def table(sizes: Sizes) -> str:
    """Return the sizes as a table with a sum."""
    sums = [sum(column) for column in zip(*sizes.values(), strict=True)] or [0] * len(Size._fields)
    width = max(len(module) for module in [*sizes, "all"])
    lines = [f"{'':{width}}" + "".join(f"{kind:>11}" for kind in Size._fields)]
    for module, size in [*sizes.items(), ("all", sums)]:
        lines.append(f"{module:{width}}" + "".join(f"{n:>11}" for n in size))
    return "\n".join(lines)
