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
    """The graph of one function.

    successors: of every instruction, inside the function; calls: addresses of callees; a jump to
    another function is a call; problems: what makes the graph incomplete, one line each.
    """

    function: Function
    successors: dict[int, list[int]] = field(default_factory=dict)
    calls: set[int] = field(default_factory=set)
    problems: list[str] = field(default_factory=list)


def _table_targets(function: Function, one: ImageInstruction) -> list[int]:
    """Return the targets of a jump table: all the data after it, constants possibly among them."""
    width = 2 if one.base == "tbh" else 1
    start = at = one.address + 4
    targets = set()
    while all(at + i in function.data for i in range(width)):
        entry = sum(function.data[at + i] << (8 * i) for i in range(width))
        targets.add(start + 2 * entry)
        at += width
    return sorted(target for target in targets if target in function.at)


def _go(flow: Flow, code: Code, one: ImageInstruction, after: list[int]) -> list[int]:
    """Return where an instruction leads inside its function; `after` is the one below it."""
    text, problem = f"{one.base} {one.operands}", ""
    falls_through = after if one.is_conditional or one.base != "b" else []
    if one.base == "bl" or _JUMP.fullmatch(one.base):
        target = -1 if one.target is None else one.target
        if target in flow.function.at and one.base != "bl":
            return [*falls_through, target]
        if target in code:
            flow.calls.add(target)
            return falls_through
        problem = "leads to what is no function"
    elif one.base == "blx":
        problem = "indirect call"
    elif _RETURN.fullmatch(text) or one.base == "udf":
        return after if one.is_conditional else []
    elif _INDIRECT.fullmatch(text):
        problem, falls_through = "indirect jump", []
    elif one.base in ("tbb", "tbh"):
        falls_through = _table_targets(flow.function, one)
        problem = "" if falls_through else "jump table not found"
    if problem:
        flow.problems.append(f"{flow.function.name}: {one}: {problem}")
    return falls_through


def make_flow(code: Code, function: Function) -> Flow:
    """Return the graph of a function of an image."""
    flow = Flow(function)
    addresses = [one.address for one in function.instructions]
    for one, after in zip(function.instructions, [*addresses[1:], None], strict=True):
        below = [] if after is None else [after]
        flow.successors[one.address] = _go(flow, code, one, below)
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
