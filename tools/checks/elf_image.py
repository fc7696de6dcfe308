r"""An ARM image as text of the binary utilities, read into functions of instructions.

>>> code = parse_code('''
... 00000100 <half>:
...      100:\tcmp\tr0, #0
...      102:\tit\tlt
...      104:\taddlt\tr0, #1
...      106:\tasrs\tr0, r0, #1
...      108:\tbx\tlr
... ''')
>>> [str(found) for found in code[0x100].instructions if found.is_conditional]
['104: addlt r0, #1']
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from camtools.base.errors import CamtoolsError

PREFIX = "arm-none-eabi-"

_HEADER = re.compile(r"^([0-9a-f]+) <(.+)>:$")
_LINE = re.compile(r"^\s*([0-9a-f]+):\t(\S+)(?:\t(.*))?$")
_TARGET = re.compile(r"^([0-9a-f]+) <")
_COLD = re.compile(r"\.cold(\.\d+)?$")
_DATA_BYTES = {".byte": 1, ".short": 2, ".word": 4}
_PLACE = re.compile(r"^(.*):(\d+|\?)(?: \(discriminator \d+\))?$")
_FRAME_START = re.compile(r"FDE .*pc=([0-9a-f]+)\.\.")
_FRAME_LINE = re.compile(r"^[0-9a-f]{8} (\w+)\+(\d+)\s")


@dataclass(frozen=True)
class ImageInstruction:
    """One line of a disassembly."""

    address: int
    mnemonic: str
    operands: str
    base: str  # mnemonic without width, type and, inside an IT block, condition
    is_conditional: bool  # it stands in an IT block

    def __str__(self) -> str:
        return f"{self.address:x}: {self.mnemonic} {self.operands}".rstrip()

    @property
    def target(self) -> int | None:
        """Address that the last operand names as a label."""
        found = _TARGET.match(self.operands.rsplit(", ", 1)[-1])
        return int(found[1], 16) if found else None


@dataclass
class Function:
    """Code between two symbols: instructions in order, and the bytes of data among them."""

    name: str
    address: int
    instructions: list[ImageInstruction] = field(default_factory=list)
    data: dict[int, int] = field(default_factory=dict)

    @cached_property
    def at(self) -> dict[int, ImageInstruction]:
        """Instructions by address."""
        return {instruction.address: instruction for instruction in self.instructions}


Code = dict[int, Function]


class Place(NamedTuple):
    """Where a source function holds an instruction."""

    function: str
    file: str
    line: int

    def __str__(self) -> str:
        return f"{self.function} ({Path(self.file).name}:{self.line})"


def _start(code: Code, address: int, name: str) -> Function:
    """Return the function that a symbol begins; the cold part belongs to what it was cut from."""
    whole = [function for function in code.values() if function.name == _COLD.sub("", name)]
    if _COLD.search(name) and len(whole) == 1:
        return whole[0]
    return code.setdefault(address, Function(name, address))


def parse_code(text: str) -> Code:
    """Return the functions of `objdump -d -z --no-show-raw-insn` by address."""
    code: Code = {}
    function: Function | None = None
    in_block = 0  # instructions left of an IT block
    for line in text.splitlines():
        if header := _HEADER.match(line):
            function, in_block = _start(code, int(header[1], 16), header[2]), 0
        elif (found := _LINE.match(line)) and function:
            address, mnemonic = int(found[1], 16), found[2]
            operands = re.split(r"\s*[@;]", found[3] or "", maxsplit=1)[0].strip()
            if mnemonic in _DATA_BYTES:
                data = int(operands, 16).to_bytes(_DATA_BYTES[mnemonic], "little")
                function.data.update(enumerate(data, address))
                continue
            word = mnemonic.split(".")[0]
            base = word[:-2] if in_block > 0 else word
            instruction = ImageInstruction(address, mnemonic, operands, base, in_block > 0)
            function.instructions.append(instruction)
            in_block = len(base) - 1 if re.fullmatch(r"it[te]{0,3}", base) else max(in_block - 1, 0)
    return code


@dataclass(frozen=True)
class Image:
    """An ELF file, and what the binary utilities of `prefix` print of it."""

    path: Path
    prefix: str = PREFIX

    def ask(self, tool: str, *words: str, given: str | None = None) -> str:
        """Return what one of the binary utilities prints."""
        command = [self.prefix + tool, *words]
        try:
            done = subprocess.run(command, input=given, capture_output=True, text=True, check=False)
        except OSError as error:
            remedy = "install binutils for Arm"
            raise CamtoolsError([f"{command[0]}: {error.strerror}; {remedy}"]) from error
        if done.returncode:
            raise CamtoolsError([f"{command[0]}: {done.stderr.strip() or 'failed'}"])
        return done.stdout

    @cached_property
    def code(self) -> Code:
        """Every function, by address."""
        return parse_code(self.ask("objdump", "-d", "-z", "--no-show-raw-insn", str(self.path)))

    def function(self, name: str) -> Function:
        """Return the one function of a name; it is an error when there is none, or several."""
        found = [function for function in self.code.values() if function.name == name]
        if len(found) != 1:
            remedy = "name another root" if found else "is it linked in?"
            raise CamtoolsError([f"{self.path}: {len(found)} functions {name}; {remedy}"])
        return found[0]

    def places(self, addresses: Sequence[int]) -> dict[int, list[Place]]:
        """Return where the source has instructions, innermost inlined function first."""
        given = "".join(f"{address:#x}\n" for address in addresses)
        text = self.ask("addr2line", "-a", "-f", "-i", "-e", str(self.path), given=given)
        return _parse_places(text.splitlines())

    def frames(self) -> dict[int, int | None]:
        """Return the deepest stack by the call frames, by address; None: it is not constant."""
        deepest: dict[int, int | None] = {}
        start = -1
        text = self.ask("readelf", "--debug-dump=frames-interp", str(self.path))
        for line in text.splitlines():
            if found := _FRAME_START.search(line):
                start = int(found[1], 16)
                deepest.setdefault(start, 0)
            elif (row := _FRAME_LINE.match(line)) and start in deepest:
                most = deepest[start]
                is_known = row[1] == "r13" and most is not None
                deepest[start] = max(most or 0, int(row[2])) if is_known else None
        return deepest


def _parse_places(lines: Iterable[str]) -> dict[int, list[Place]]:
    places: dict[int, list[Place]] = {}
    address, name = 0, ""
    for line in lines:
        if line.startswith("0x"):
            address, name = int(line, 16), ""
            places[address] = []
        elif not name:
            name = line
        else:
            frame = _PLACE.match(line)
            if frame and frame[1] != "??":
                number = 0 if frame[2] == "?" else int(frame[2])
                places[address].append(Place(name, frame[1], number))
            name = ""
    return places
