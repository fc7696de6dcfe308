"""Everything that an interrupt can reach in an image: its stack, and what is forbidden.

>>> forbidden_name("__aeabi_uldivmod"), forbidden_name("cam_tick_isr")
('64-bit or software division', None)
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from camtools.base.errors import InputError
from checks.elf_flow import Flow, loops, make_flow
from checks.elf_image import Function, Image, ImageInstruction

# What the core stacks on entry where it saves no floating-point registers, FPCCR.ASPEN = 0
# (ARMv7-M manual, B1.5.6, B1.5.7 and B3.2.21).
FRAME_BYTES = 8 * 4  # r0-r3, r12, lr, pc, xPSR
ALIGNMENT_BYTES = 4  # the frame begins on eight bytes
_PUSH = re.compile(r"v?push .*|v?stmdb sp!.*|subw? sp, .*|.*\[sp, #-\d+\]!")

Bounds = Mapping[str, str]

_NAMES = (
    ("64-bit or software division", r"__aeabi_u?l?i?div(mod)?|__u?(div|mod|divmod)[sdt]i[34]"),
    ("soft floating point", r"__aeabi_(c?[dfh]|u?[il]2[dfh])\w*"),
    ("soft floating point", r"__\w+[sd]f([sdt][if])?[234]?"),
    ("the heap", r"_?(malloc|calloc|realloc|free|memalign|aligned_alloc|sbrk)(_r)?"),
    ("libc", r"_*(mem(cpy|move|set|cmp|chr|rchr)|str[a-z]+|a?to[ilf]\w*|abort|exit|qsort)(_r)?"),
    (
        "libc",
        r"__aeabi_mem\w+|_*[a-z]*(printf|scanf|puts|putc|putchar|write|read)(_r)?|__assert\w*",
    ),
)
_FORBIDDEN_NAMES = [(why, re.compile(names)) for why, names in _NAMES]

_INSTRUCTIONS = (
    ("division", r"[su]div"),
    ("floating-point unit", r"(v|fld|fst)[a-z0-9]+"),
    ("a lock", r"cps\w*|msr"),
    ("waiting", r"wf[ei]"),
    ("leaves to a debugger or a supervisor", r"bkpt|svc|hlt"),
)
_FORBIDDEN_INSTRUCTIONS = [(why, re.compile(names)) for why, names in _INSTRUCTIONS]


def forbidden_name(name: str) -> str | None:
    """Return why a function of this name may not be called, if so."""
    plain = re.sub(r"\.(isra|part|constprop|lto_priv)\.\d+.*$", "", name)
    return next((why for why, names in _FORBIDDEN_NAMES if names.fullmatch(plain)), None)


def forbidden_instruction(instruction: ImageInstruction) -> str | None:
    """Return why an instruction may not stand there, if so."""
    return next(
        (why for why, names in _FORBIDDEN_INSTRUCTIONS if names.fullmatch(instruction.base)), None
    )


@dataclass(frozen=True)
class FunctionStack:
    """Bytes that a call of a function may take, with its callees and without."""

    name: str
    stack_bytes: int
    own_bytes: int


@dataclass
class IsrReport:
    """What was found; `functions` stands in the order of callees before callers."""

    entry_bytes: int
    functions: list[FunctionStack] = field(default_factory=list)
    loops: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    bounds_used: set[str] = field(default_factory=set)

    @property
    def stack_bytes(self) -> int:
        """Deepest stack, interrupt entry included."""
        return self.functions[-1].stack_bytes + self.entry_bytes


def load_bounds(path: Path) -> Bounds:
    """Return the reason why the loops of a source function end, by function."""
    remedy = 'give FUNCTION = "why its loops end" below [loops]'
    try:
        bounds = tomllib.loads(path.read_text("utf-8"))["loops"]
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, KeyError) as error:
        raise InputError(str(path), "", None, f"no table of loops: {error}", remedy) from error
    if not isinstance(bounds, dict):
        raise InputError(str(path), "loops", bounds, "is no table", remedy)
    for name, why in bounds.items():
        if not isinstance(why, str) or not why.strip():
            raise InputError(str(path), name, why, "is no reason", remedy)
    return bounds


@dataclass
class _Walk:
    """Visits callees before callers; a call that closes a ring is recursion."""

    image: Image
    bounds: Bounds
    report: IsrReport
    frames: Mapping[int, int | None]
    stacks: dict[int, int] = field(default_factory=dict)
    chain: list[Function] = field(default_factory=list)

    def visit(self, function: Function) -> None:
        """Add the stack of a function and of all that it calls."""
        if why := forbidden_name(function.name):
            self._complain(function, why)
        flow = make_flow(self.image.code, function)
        self.chain.append(function)
        for target in sorted(flow.calls):
            callee = self.image.code[target]
            if callee in self.chain:
                self._complain(callee, "recursion")
            elif target not in self.stacks:
                self.visit(callee)
        self.chain.pop()
        for instruction in function.instructions:
            if why := forbidden_instruction(instruction):
                self._complain(function, f"{instruction}: {why}")
        self._check_loops(flow)
        self.report.problems += flow.problems
        own = self._own_bytes(function)
        deepest = own + max((self.stacks.get(target, 0) for target in flow.calls), default=0)
        self.stacks[function.address] = deepest
        self.report.functions.append(FunctionStack(function.name, deepest, own))

    def _complain(self, function: Function, problem: str) -> None:
        chain = " -> ".join(caller.name for caller in [*self.chain, function])
        self.report.problems.append(f"{chain}: {problem}")

    def _own_bytes(self, function: Function) -> int:
        found = [self.frames[at] for at in function.at if at in self.frames]
        known = [n_bytes for n_bytes in found if n_bytes is not None]
        pushes = any(
            _PUSH.match(f"{instruction.base} {instruction.operands}")
            for instruction in function.instructions
        )
        if not found:
            self._complain(function, "no call frames; build with -g")
        elif len(known) < len(found) or (pushes and not any(known)):
            self._complain(function, "the call frames do not show how deep its stack is")
        return max(known, default=0)

    def _check_loops(self, flow: Flow) -> None:
        for latch, head in loops(flow):
            stacks = self.image.places([latch, head]).values()
            places = [stack[0] for stack in stacks if stack]
            # What the compiler makes of a function for some callers has a name after a full stop.
            names = {place.function.partition(".")[0] for place in places} & self.bounds.keys()
            where = ", ".join(dict.fromkeys(map(str, places))) or "no debug information"
            self.report.bounds_used |= names
            if names:
                self.report.loops.append(f"{where}: {self.bounds[min(names)]}")
            else:
                self._complain(flow.function, f"loop at {head:x} has no bound: {where}")


def _check_sources(walk: _Walk, sources: Iterable[str]) -> None:
    """Complain of functions from elsewhere than the folders of our sources."""
    folders = tuple(f"{folder.rstrip('/')}/" for folder in sources)
    names = {address: walk.image.code[address].name for address in walk.stacks}
    for address, stack in walk.image.places(sorted(names)).items():
        file = stack[-1].file if stack else "a library without debug information"
        if not any(file.startswith(folder) or f"/{folder}" in file for folder in folders):
            walk.report.problems.append(f"{names[address]}: from {file}, not of our sources")


def examine(image: Image, root: str, bounds: Bounds, sources: Iterable[str] = ()) -> IsrReport:
    """Return what the interrupt that begins at a function can reach and take.

    The image has debug information. With `sources` all reachable code must come from these folders.
    Raises CamtoolsError: there is no such root, or the binary utilities fail.
    """
    report = IsrReport(ALIGNMENT_BYTES + FRAME_BYTES)
    walk = _Walk(image, bounds, report, image.frames())
    walk.visit(image.function(root))
    if sources := tuple(sources):
        _check_sources(walk, sources)
    return report
