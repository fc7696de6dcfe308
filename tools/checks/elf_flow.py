r"""Calls, jumps and loops of one function of an ARM image.

>>> from checks.elf_image import parse_code
>>> code = parse_code('''
... 00000100 <twice>:
...      100:\tsubs\tr0, #1
...      102:\tbl\t200 <once>
...      106:\tbne.n\t100 <twice>
...      108:\tb.w\t200 <once>
... 00000200 <once>:
...      200:\tbx\tlr
... ''')
>>> flow = make_flow(code, code[0x100])
>>> flow.calls, loops(flow), flow.problems
({512}, [(262, 256)], [])
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from checks.elf_image import Code, Function, ImageInstruction

_JUMP = re.compile("cbn?z|b(eq|ne|cs|cc|hs|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)?")
_RETURN = re.compile(r"(bx|mov pc,) lr|ldr pc, \[sp\], #\d+|(pop|ldm\w*) (sp!, )?\{.*\bpc\}")
_INDIRECT = re.compile(r"bxj? .*|(?!cmp|b)\w+ pc, .*|ldm.*\{.*\bpc\}|tb[bh] \[(?!pc,).*")


@dataclass
class Flow:
    """The graph of one function."""

    function: Function
    # Of every instruction, inside the function; a jump to another function is a call.
    successors: dict[int, list[int]] = field(default_factory=dict)
    calls: set[int] = field(default_factory=set)  # addresses of callees
    problems: list[str] = field(default_factory=list)  # what makes the graph incomplete


def _table_targets(function: Function, instruction: ImageInstruction) -> list[int]:
    """Return the targets of a jump table: all the data after it, constants possibly among them."""
    width = 2 if instruction.base == "tbh" else 1
    start = at = instruction.address + 4
    targets = set()
    while all(at + i in function.data for i in range(width)):
        entry = sum(function.data[at + i] << (8 * i) for i in range(width))
        targets.add(start + 2 * entry)
        at += width
    return sorted(target for target in targets if target in function.at)


def _go(flow: Flow, code: Code, instruction: ImageInstruction, after: list[int]) -> list[int]:
    """Return where an instruction leads inside its function; `after` is the one below it."""
    text, problem = f"{instruction.base} {instruction.operands}", ""
    falls_through = after if instruction.is_conditional or instruction.base != "b" else []
    if instruction.base == "bl" or _JUMP.fullmatch(instruction.base):
        target = -1 if instruction.target is None else instruction.target
        if target in flow.function.at and instruction.base != "bl":
            return [*falls_through, target]
        if target in code:
            flow.calls.add(target)
            return falls_through
        problem = "leads to what is no function"
    elif instruction.base == "blx":
        problem = "indirect call"
    elif _RETURN.fullmatch(text) or instruction.base == "udf":
        return after if instruction.is_conditional else []
    elif _INDIRECT.fullmatch(text):
        problem, falls_through = "indirect jump", []
    elif instruction.base in ("tbb", "tbh"):
        falls_through = _table_targets(flow.function, instruction)
        problem = "" if falls_through else "jump table not found"
    if problem:
        flow.problems.append(f"{flow.function.name}: {instruction}: {problem}")
    return falls_through


def make_flow(code: Code, function: Function) -> Flow:
    """Return the graph of a function of an image."""
    flow = Flow(function)
    addresses = [instruction.address for instruction in function.instructions]
    for instruction, after in zip(function.instructions, [*addresses[1:], None], strict=True):
        below = [] if after is None else [after]
        flow.successors[instruction.address] = _go(flow, code, instruction, below)
    return flow


def loops(flow: Flow) -> list[tuple[int, int]]:
    """Return the jumps that close a loop, each with its target; every loop has one at least."""
    entry, found = flow.function.address, []
    path, seen = {entry: iter(flow.successors[entry])}, {entry}
    while path:
        at = next(reversed(path))
        after = next(path[at], None)
        if after is None:
            del path[at]
        elif after in path:
            found.append((at, after))
        elif after not in seen:
            seen.add(after)
            path[after] = iter(flow.successors[after])
    return found
