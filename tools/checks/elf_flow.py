# SPDX-License-Identifier: Apache-2.0
r"""Control flow of one function of an ARM image: where each instruction may go next.

>>> from checks.elf_image import parse_code
>>> code = parse_code('''
... 00000100 <twice>:
...      100:\tcbz\tr0, 106 <twice+0x6>
...      102:\tbl\t200 <once>
...      106:\tb.w\t200 <once>
... 00000200 <once>:
...      200:\tbx\tlr
... ''')
>>> flow = make_flow(code, code[0x100])
>>> flow.successors[0x100], sorted(flow.calls), flow.problems
([258, 262], [258, 262], [])
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from checks.elf_image import Code, Function, ImageInstruction

_CONDITION = re.compile("eq|ne|cs|cc|hs|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le")
_LOADS = frozenset({"pop", "ldm", "ldmia", "ldmdb", "ldr", "ldrd"})
_TRAPS = frozenset({"udf"})


@dataclass
class Flow:
    """The graph of one function.

    Attributes
    ----------
    successors : dict
        Of every instruction that can be reached; those of other functions are in `calls`.
    calls : dict
        Callee's address, by the address of the call; tail calls are calls without a successor.
    returns : set
        Instructions that may go back to the caller.
    problems : list
        What makes the graph incomplete, one line each.
    """

    function: Function
    successors: dict[int, list[int]] = field(default_factory=dict)
    calls: dict[int, int] = field(default_factory=dict)
    returns: set[int] = field(default_factory=set)
    problems: list[str] = field(default_factory=list)

    @property
    def ends(self) -> set[int]:
        """Instructions behind which the function may be over; all, if it never is."""
        last = {address for address, after in self.successors.items() if not after}
        return last | self.returns or set(self.successors)

    def complain(self, one: ImageInstruction, problem: str) -> None:
        """Note what the graph cannot show."""
        self.problems.append(f"{self.function.name}: {one}: {problem}")


def _branch(one: ImageInstruction) -> str:
    """Return "b", "bcond", "bl" or "" for anything else."""
    base = one.base
    if base in ("b", "bl"):
        return "bcond" if base == "b" and one.is_conditional else base
    return "bcond" if base[:1] == "b" and _CONDITION.fullmatch(base[1:]) else ""


def _is_return(one: ImageInstruction) -> bool:
    if one.base in ("bx", "mov"):
        return one.operands in ("lr", "pc, lr")
    if one.base == "ldr":
        return re.match(r"pc, \[sp\], #\d+$", one.operands) is not None
    return re.match(r"(sp!, )?\{", one.operands) is not None


def _writes_pc(one: ImageInstruction) -> bool:
    if one.base in ("bx", "bxj"):
        return True
    listed = re.search(r"\{.*\bpc\b.*\}", one.operands) is not None
    return (one.base in _LOADS and listed) or (
        one.base[:1] != "b" and one.base != "cmp" and one.operands.startswith("pc, ")
    )


def _table_size(flow: Flow, one: ImageInstruction) -> int | None:
    """Return how many entries a jump table has: its index was compared with the last one before.

    Behind the table constants of the function may stand, which are none of it.
    """
    index = one.operands.strip("[]").split(",")[1].strip()
    before = [flow.function.at[at] for at in sorted(flow.function.at) if at < one.address][-2:]
    if [instruction.base for instruction in before] != ["cmp", "bhi"]:
        return None
    found = re.match(rf"{index}, #(\d+)\b", before[0].operands)
    return int(found[1]) + 1 if found else None


def _table_targets(flow: Flow, one: ImageInstruction) -> list[int]:
    """Return where a jump table leads: the data that stands behind the instruction."""
    function, width = flow.function, 2 if one.base == "tbh" else 1
    start = function.following.get(one.address, one.address)
    size = _table_size(flow, one)
    targets, at = list[int](), start
    while all(at + i in function.data for i in range(width)) and len(targets) != size:
        entry = sum(function.data[at + i] << (8 * i) for i in range(width))
        is_padding = entry == 0 and at + width not in function.data and targets
        if not is_padding:
            targets.append(start + 2 * entry)
        at += width
    if not one.operands.startswith("[pc,") or not targets:
        flow.complain(one, "jump table not found")
    if bad := [target for target in targets if target not in function.at]:
        flow.complain(one, f"jump table leads to {bad[0]:x}, which is no instruction")
    return sorted({target for target in targets if target in function.at})


def _jump(flow: Flow, code: Code, one: ImageInstruction, target: int) -> list[int]:
    """Return the successor of a jump, or note the tail call that it is."""
    if target in flow.function.at:
        return [target]
    if target not in code:
        flow.complain(one, "jumps into the middle of another function")
    else:
        flow.calls[one.address] = target
    return []


def _next(flow: Flow, one: ImageInstruction) -> list[int]:
    after = flow.function.following.get(one.address)
    if after is None or after not in flow.function.at:
        flow.complain(one, "runs on into what is no instruction of the function")
        return []
    return [after]


def _leave(flow: Flow, one: ImageInstruction) -> list[int]:
    """Treat an instruction that writes the program counter from a register or memory."""
    if _is_return(one):
        flow.returns.add(one.address)
    else:
        flow.complain(one, "indirect jump")
    return _next(flow, one) if one.is_conditional else []


def _go(flow: Flow, code: Code, one: ImageInstruction) -> list[int]:
    kind = _branch(one)
    if kind == "bl":
        if one.target is None or one.target not in code:
            flow.complain(one, "calls what is no function")
        else:
            flow.calls[one.address] = one.target
    elif kind or one.base in ("cbz", "cbnz"):
        if one.target is None:
            flow.complain(one, "jump without a label")
            return []
        taken = _jump(flow, code, one, one.target)
        return taken if kind == "b" else _next(flow, one) + taken
    elif one.base in ("tbb", "tbh"):
        return _table_targets(flow, one)
    elif one.base == "blx":
        flow.complain(one, "indirect call")
    elif one.base in _TRAPS:
        return []
    elif _writes_pc(one):
        return _leave(flow, one)
    return _next(flow, one)


def make_flow(code: Code, function: Function) -> Flow:
    """Return the graph of a function, from its entry as far as it reaches.

    Parameters
    ----------
    code : Code
        All functions of the image.
    function : Function
        One of them.
    """
    flow, todo = Flow(function), [function.address]
    while todo:
        address = todo.pop()
        if address not in flow.successors:
            flow.successors[address] = _go(flow, code, function.at[address])
            todo += flow.successors[address]
    return flow
