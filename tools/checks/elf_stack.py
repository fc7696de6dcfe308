# SPDX-License-Identifier: Apache-2.0
r"""Stack that one function of an ARM image takes, from its instructions and from its call frames.

>>> from checks.elf_image import parse_code
>>> code = parse_code('''
... 00000100 <f>:
...      100:\tpush\t{r4, lr}
...      102:\tsub\tsp, #16
...      104:\tadd\tsp, #16
...      106:\tpop\t{r4, pc}
... ''')
>>> max(depths(make_flow(code, code[0x100])).values())
24
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from checks.elf_flow import Flow, make_flow
from checks.elf_image import Image, ImageInstruction

__all__ = ["deepest_frames", "depths", "make_flow"]

_PUSHES = frozenset({"push", "vpush"})
_POPS = frozenset({"pop", "vpop"})
_STORES = frozenset({"stmdb", "vstmdb"})
_LOADS = frozenset({"ldmia", "ldm", "vldmia"})
_INDEXED = re.compile(r"\[sp(?:\], #|, #)(-?\d+)(\]!)?")
_FRAME_START = re.compile(r"FDE .*pc=([0-9a-f]+)\.\.")
_FRAME_LINE = re.compile(r"^[0-9a-f]{8} (\w+)\+(\d+)\s")


def _list_bytes(registers: str) -> int:
    total = 0
    for word in re.sub(r"[{} ]", "", registers).split(","):
        first, _, last = word.partition("-")
        n = int(last[1:]) - int(first[1:]) + 1 if last else 1
        total += n * (8 if first[0] == "d" else 4)
    return total


def _taken(one: ImageInstruction) -> int | None:
    """Return by how many bytes an instruction deepens the stack; None: it is not known."""
    base, operands = one.base, one.operands
    if base in _PUSHES | _POPS:
        return _list_bytes(operands) * (1 if base in _PUSHES else -1)
    if base in _STORES | _LOADS and operands.startswith("sp!"):
        return _list_bytes(operands.partition(", ")[2]) * (1 if base in _STORES else -1)
    if indexed := _INDEXED.search(operands):
        is_written = indexed[2] or "[sp], #" in operands
        return -int(indexed[1]) if is_written else 0
    constant = re.match(r"sp, (?:sp, )?#(\d+)$", operands)
    if base in ("sub", "subw", "add", "addw") and constant:
        return int(constant[1]) * (1 if base[:3] == "sub" else -1)
    is_written = operands.startswith("sp, ") and base not in ("cmp", "cmn", "tst", "str", "push")
    return None if is_written else 0


def depths(flow: Flow) -> dict[int, int]:
    """Return how many bytes the function itself has taken behind each instruction.

    What is not known is added to the problems of the flow.
    """
    entry, behind = flow.function.address, dict[int, int]()
    before, todo = {entry: 0}, [entry]
    while todo:
        address = todo.pop()
        one = flow.function.at[address]
        change = _taken(one)
        is_conditional_return = one.is_conditional and address in flow.returns
        if change is None or (change and one.is_conditional and not is_conditional_return):
            flow.complain(one, "changes the stack by an unknown amount")
            change = 0
        behind[address] = before[address] + change
        if address in flow.returns and behind[address]:
            flow.complain(one, f"returns with {behind[address]} bytes on the stack")
        passed = before[address] if is_conditional_return else behind[address]
        for after in flow.successors[address]:
            if before.setdefault(after, passed) != passed:
                flow.complain(one, f"reaches {after:x} with another depth of the stack")
            if after not in behind and after not in todo:
                todo.append(after)
    return behind


def deepest_frames(image: Image) -> Mapping[int, int]:
    """Return by function address what the compiler's call frame information says of the stack."""
    deepest: dict[int, int] = {}
    function: int | None = None
    for line in image.ask("readelf", "--debug-dump=frames-interp", str(image.path)).splitlines():
        if start := _FRAME_START.search(line):
            function = int(start[1], 16)
            deepest.setdefault(function, 0)
        elif not line.strip():
            function = None
        elif function is not None and (row := _FRAME_LINE.match(line)):
            # Relative to another register than the stack pointer it says nothing of the depth.
            n_bytes = int(row[2]) if row[1] == "r13" else 0
            deepest[function] = max(deepest.get(function, 0), n_bytes)
    return deepest
