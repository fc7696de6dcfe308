"""Executed instructions as llvm-mca and Arm's cycle table see them.

>>> straight_line([Step(0, 4, "bl", "80 <f>"), Step(128, 2, "pop", "{r4, pc}")])
['b target', 'ldr r4, [sp]', 'bx lr']
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from camtools.base.errors import CamtoolsError
from checks.stepper import Step, run_tool

_CONDITION = "eq|ne|cs|hs|cc|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le"
_IT = re.compile(r"it([te]{0,3})")
_PREDICATED = re.compile(rf"(.+?)(?:{_CONDITION})((?:\.\w+)*)")
_TARGET = re.compile(r"\b[0-9a-f]+ <[^>]*>$")
_MANY = re.compile(r"(push|pop|ldmia|ldmdb|ldm|stmia|stmdb|stm|vpush|vpop|vldmia|vstmia|vstmdb)\b")
_REFILL = 3  # largest of the 1 .. 3 cycles that a taken branch costs
_SLOW = {"udiv": 12, "sdiv": 12, "vdiv": 14, "vsqrt": 14, "vmla": 3, "vmls": 3, "vfma": 3}


def _registers(operands: str) -> list[str]:
    """Return the registers of a list in braces, ranges of the floating-point unit spelled out."""
    found: list[str] = []
    for word in operands[operands.index("{") + 1 : operands.index("}")].split(","):
        first, _, last = word.strip().partition("-")
        numbers = range(int(first[1:]), int(last[1:]) + 1) if last else ()
        found += [f"{first[0]}{n}" for n in numbers] if last else [first]
    return found


def _one_by_one(instruction: Step) -> list[str]:
    """Return the transfers of several registers as single ones: one slot each, as Arm states."""
    name, operands = instruction.name, instruction.operands
    is_load = "pop" in name or "ldm" in name
    verb = ("v" if name[0] == "v" else "") + ("ldr" if is_load else "str")
    # The register that points to memory; push and pop name none.
    base = "sp" if operands[0] == "{" else operands.split(",")[0].rstrip("! ")
    place = f"[{base}]"
    registers = _registers(operands)
    return ["bx lr" if r == "pc" else f"{verb} {r}, {place}" for r in registers]


def straight_line(executed: Sequence[Step]) -> list[str]:
    """Return what was executed as assembly that llvm-mca takes.

    Its model stops at `it` and charges 100 cycles for every call, so predicated instructions lose
    their condition, `it` is left out (both cores fold it into its neighbour), and calls become
    jumps. It counts one slot for a transfer of many registers, so those are written one by one.

    Parameters
    ----------
    executed : sequence of Step
        In order; those whose condition failed among them.

    Returns
    -------
    list of str
        One instruction each.
    """
    lines: list[str] = []
    n_predicated = 0
    for instruction in executed:
        name, operands = re.sub(r"\.[nw]$", "", instruction.name), instruction.operands
        if block := _IT.fullmatch(name):
            n_predicated = 1 + len(block[1])
            continue
        if n_predicated > 0:
            n_predicated -= 1
            if bare := _PREDICATED.fullmatch(name):
                name = bare[1] + bare[2]
        if _MANY.match(name):
            lines += _one_by_one(Step(instruction.address, instruction.size, name, operands))
            continue
        if name.startswith("vmov.f"):  # objdump shows the code of a constant, not the constant
            operands = re.sub(r"#.*", "#1.0", operands)
        if name in ("bl", "blx"):
            name = "bx" if "x" in name else "b"
        lines.append(f"{name} {_TARGET.sub('target', operands)}".rstrip())
    return lines


def mca_cycles(lines: Sequence[str], cpu: str) -> int:
    """Return the cycles that llvm-mca gives for a straight line of instructions, run once."""
    command = ["llvm-mca-14", "-mtriple=thumbv7em-none-eabi", f"-mcpu={cpu}", "-iterations=1"]
    command += ["-instruction-info=0", "-resource-pressure=0"]
    report = run_tool(command, "".join(f"{line}\n" for line in lines))
    found = re.search(r"^Total Cycles: +(\d+)", report, re.MULTILINE)
    count = re.search(r"^Instructions: +(\d+)", report, re.MULTILINE)
    if not found or not count or int(count[1]) != len(lines):
        raise CamtoolsError(["llvm-mca-14 did not take every instruction"])
    return int(found[1])


def taken_branches(executed: Sequence[Step]) -> int:
    """Count the places where the program went elsewhere, the return of the last one included."""
    here = executed[:-1]
    jumps = sum(i.address + i.size != n.address for i, n in zip(here, executed[1:], strict=True))
    return jumps + 1


def table_cycles(executed: Sequence[Step]) -> int:
    """Return the cycles of Arm's table for the Cortex-M4, nothing overlapping.

    Loads and stores two cycles although most pipeline to one, a division 12, three cycles to
    refill after every taken branch.

    Source: Cortex-M4 Technical Reference Manual (100166), 3.3.1, and 7 for floating point.
    """
    return sum(map(_table, executed)) + _REFILL * taken_branches(executed)


def _table(instruction: Step) -> int:
    name = instruction.name
    if _MANY.match(name):
        return 1 + len(_registers(instruction.operands))
    if name.startswith(("ldrd", "strd")):
        return 3
    if name.startswith(("ldr", "str", "vldr", "vstr", "tbb", "tbh")):
        return 2
    return next((n for slow, n in _SLOW.items() if name.startswith(slow)), 1)
