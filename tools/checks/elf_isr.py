# SPDX-License-Identifier: Apache-2.0
"""Everything that an interrupt can reach in an image: longest path, stack, what is forbidden."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from checks.elf_flow import Flow, make_flow
from checks.elf_image import Function, Image, Place
from checks.elf_longest import IrreducibleError, Loop, longest
from checks.elf_loops import Bounds, head_runs, places_of
from checks.elf_rules import forbidden_instruction, forbidden_name
from checks.elf_stack import deepest_frames, depths

# What the core stacks on entry (ARMv7-M manual, B1.5.6 and B1.5.7).
FRAME_BYTES = 8 * 4  # r0-r3, r12, lr, pc, xPSR
FLOAT_FRAME_BYTES = 26 * 4  # and s0-s15, FPSCR, a reserved word, if the interrupted code uses them
ALIGNMENT_BYTES = 4  # the frame begins on eight bytes


@dataclass(frozen=True)
class FunctionCost:
    """What one call of a function may take, callees included.

    Attributes
    ----------
    own_stack_bytes : int
        Without its callees.
    """

    name: str
    instructions: int
    stack_bytes: int
    own_stack_bytes: int


@dataclass(frozen=True)
class LoopReport:
    """A loop that is reached, and how often its head runs."""

    function: str
    head: int
    places: list[Place]
    head_runs: int

    def __str__(self) -> str:
        where = ", ".join(dict.fromkeys(str(place) for place in self.places))
        return f"{self.function} {self.head:x}: head runs {self.head_runs} times, {where}"


@dataclass
class IsrReport:
    """What was found; `functions` stands in the order of callees before callers."""

    root: str
    entry_bytes: int
    functions: list[FunctionCost] = field(default_factory=list)
    loops: list[LoopReport] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    n_frames_compared: int = 0
    bounds_used: set[str] = field(default_factory=set)

    @property
    def instructions(self) -> int:
        """Most instructions from the root's entry to its return."""
        return self.functions[-1].instructions

    @property
    def stack_bytes(self) -> int:
        """Deepest stack, interrupt entry included."""
        return self.functions[-1].stack_bytes + self.entry_bytes


@dataclass
class _Walk:
    """Visits callees before callers; a call that closes a ring is recursion."""

    image: Image
    bounds: Bounds
    report: IsrReport
    costs: dict[int, FunctionCost] = field(default_factory=dict)
    chain: list[Function] = field(default_factory=list)

    def visit(self, function: Function) -> None:
        """Add the cost of a function and of all that it calls."""
        if name := forbidden_name(function.name):
            self.report.problems.append(f"{self._chain_to(function)}: {name}")
        flow = make_flow(self.image.code, function)
        self.chain.append(function)
        for target in sorted(set(flow.calls.values())):
            callee = self.image.code[target]
            if callee in self.chain:
                self.report.problems.append(f"{self._chain_to(callee)}: recursion")
            elif target not in self.costs:
                self.visit(callee)
        self.chain.pop()
        for address in sorted(flow.successors):
            one = flow.function.at[address]
            if why := forbidden_instruction(one):
                self.report.problems.append(f"{self._chain_to(flow.function)}: {one}: {why}")
        self.costs[function.address] = cost = self._cost(flow)
        self.report.functions.append(cost)
        self.report.problems += flow.problems

    def _chain_to(self, function: Function) -> str:
        return " -> ".join(one.name for one in [*self.chain, function])

    def _cost(self, flow: Flow) -> FunctionCost:
        taken = depths(flow)
        stack, own, cost = 0, max(taken.values()), {}
        for address in flow.successors:
            called = self.costs.get(flow.calls.get(address, -1))
            cost[address] = 1 + (called.instructions if called else 0)
            stack = max(stack, taken[address] + (called.stack_bytes if called else 0))
        return FunctionCost(flow.function.name, self._longest(flow, cost), stack, own)

    def _longest(self, flow: Flow, cost: dict[int, int]) -> int:
        def rounds(loop: Loop) -> int:
            return self._rounds(flow, loop)

        try:
            return longest(flow.successors, flow.function.address, flow.ends, cost, rounds)
        except IrreducibleError as error:
            self.report.problems.append(f"{flow.function.name}: {error}")
            return sum(cost.values())

    def _rounds(self, flow: Flow, loop: Loop) -> int:
        places = places_of(self.image, loop)
        self.report.bounds_used |= {place.function for place in places} & self.bounds.keys()
        runs = head_runs(flow, loop, places, self.bounds)
        found = LoopReport(flow.function.name, loop.head, places, runs or 1)
        if runs is None:
            where = (
                ", ".join(dict.fromkeys(str(place) for place in places)) or "no debug information"
            )
            problem = f"loop at {loop.head:x} has no bound: {where}"
            self.report.problems.append(f"{self._chain_to(flow.function)}: {problem}")
        else:
            self.report.loops.append(found)
        return found.head_runs


def _check_sources(walk: _Walk, sources: Iterable[str]) -> None:
    """Complain of functions from elsewhere than the folders of our sources."""
    folders = tuple(f"{folder.rstrip('/')}/" for folder in sources)
    names = {address: walk.image.code[address].name for address in walk.costs}
    for address, stack in walk.image.places(sorted(names)).items():
        file = stack[-1].file if stack else "a library without debug information"
        if not any(file.startswith(folder) or f"/{folder}" in file for folder in folders):
            walk.report.problems.append(f"{names[address]}: from {file}, not of our sources")


def _compare_frames(walk: _Walk) -> None:
    frames = deepest_frames(walk.image)
    for address, cost in walk.costs.items():
        if address not in frames:
            continue
        walk.report.n_frames_compared += 1
        if frames[address] != cost.own_stack_bytes:
            problem = f"{cost.own_stack_bytes} bytes of stack, call frames say {frames[address]}"
            walk.report.problems.append(f"{cost.name}: {problem}")


def examine(
    image: Image, root: str, bounds: Bounds, sources: Iterable[str] = (), *, has_float: bool
) -> IsrReport:
    """Return what the interrupt that begins at a function can reach and take.

    Parameters
    ----------
    image : Image
        Linked; with debug information if bounds, sources or call frames are to be seen.
    root : str
        Symbol of the interrupt.
    bounds : Bounds
        Of its loops.
    sources : iterable of str
        Folders that all reachable code must come from; empty: not checked.
    has_float : bool
        The interrupted code may use the floating-point unit, so its registers are stacked too.

    Raises
    ------
    CamtoolsError
        There is no such root, or the binary utilities fail.
    """
    report = IsrReport(root, ALIGNMENT_BYTES + (FLOAT_FRAME_BYTES if has_float else FRAME_BYTES))
    walk = _Walk(image, bounds, report)
    walk.visit(image.function(root))
    if sources := tuple(sources):
        _check_sources(walk, sources)
    _compare_frames(walk)
    return report
