"""Registers that are known bit by bit, and the clock: the basis of every device model.

A model lists the registers and bits that the port uses, as in stm_reg.h, and the rules of the
manual for them; any other access ends the test (`UnmodelledError`).
"""

import ctypes
from collections.abc import Callable, Iterable
from dataclasses import dataclass

WORD = 0xFFFFFFFF
NEVER = 2**63
N_BARRIERS = 8192  # a power of two, as in insn_clock.c


class UnmodelledError(Exception):
    """The image did what no model knows, or what the reference manual forbids."""


class InsnClock(ctypes.Structure):
    """Time in cycles of the core; insn_clock.c counts it, one per instruction."""

    _fields_ = (
        ("now", ctypes.c_uint64),
        ("deadline", ctypes.c_uint64),
        ("stop", ctypes.c_void_p),
        ("barrier_at", ctypes.c_uint64),
        ("barriers", ctypes.c_uint32 * N_BARRIERS),
    )
    now: int
    deadline: int
    barrier_at: int

    def skip_to(self, at: int) -> None:
        """Let a load that finds a device busy take until an instant, or until something is due.

        Polling takes as long as before, but is not executed.
        """
        self.now = max(self.now, min(self.deadline, at))

    def know_barriers(self, addresses: Iterable[int]) -> None:
        """Let the clock note in `barrier_at` when an instruction DSB at an address begins."""
        for address in addresses:
            place = address >> 1 & (N_BARRIERS - 1)
            assert self.barriers[place] in (0, address), "two barriers share a place: more places"
            self.barriers[place] = address

    def wake(self) -> None:
        """Let the run loop look at events and interrupts before the next instruction."""
        self.deadline = self.now


@dataclass(frozen=True)
class Reg:
    """One 32-bit register, named as in the manual.

    A 1 written to a bit that is neither writable nor ignored, and does not read 1, is an error.
    The device's methods _write_NAME(name, old, new) and _read_NAME(name) act instead of a plain
    store and load; `rule` is their NAME where several registers share them.
    """

    name: str
    reset: int = 0
    writable: int = WORD
    ignored: int = 0  # bits that the hardware sets and software may write back
    rule: str = ""


class Device:
    """A block of registers; subclasses define them and add behaviour.

    `due` is when [cycles] advance() has something to do, NEVER for not at all.
    """

    def __init__(self, name: str, base: int, clock: InsnClock, size: int = 0x400) -> None:
        self.name, self.base, self.size, self.clock = name, base, size, clock
        self.regs: dict[int, Reg] = {}
        self.v: dict[str, int] = {}
        self.due = NEVER
        self._loads: dict[str, Callable[[str], int]] = {}
        self._stores: dict[str, Callable[[str, int, int], None]] = {}

    def define(self, regs: dict[int, Reg]) -> None:
        """Add registers by offset and give them their values after reset."""
        self.regs |= regs
        for reg in regs.values():
            self.v[reg.name] = reg.reset
            load = getattr(self, f"_read_{reg.rule or reg.name}", None)
            store = getattr(self, f"_write_{reg.rule or reg.name}", None)
            self._loads |= {reg.name: load} if load else {}
            self._stores |= {reg.name: store} if store else {}

    def reset(self) -> None:
        """Take the values after a system reset."""
        self.v = {reg.name: reg.reset for reg in self.regs.values()}
        self.due = NEVER

    def advance(self) -> None:
        """Do what is due at the clock's time."""

    def _reg(self, offset: int, size: int) -> Reg:
        reg = self.regs.get(offset)
        if reg is None or size != 4:
            raise UnmodelledError(f"{self.name}: no register of {size} bytes at 0x{offset:x}")
        return reg

    def read(self, offset: int, size: int) -> int:
        """Return what a load gives."""
        name = self._reg(offset, size).name
        act = self._loads.get(name)
        return self.v[name] if act is None else act(name)

    def write(self, offset: int, size: int, value: int) -> None:
        """Do what a store does."""
        reg = self._reg(offset, size)
        old = self.v[reg.name]
        kept = ~reg.writable
        if value & kept:
            foreign = value & kept & ~reg.ignored & ~old
            if foreign:
                raise UnmodelledError(f"{self.name}.{reg.name}: nobody models bits 0x{foreign:x}")
        new = (value & reg.writable) | (old & kept)
        act = self._stores.get(reg.name)
        if act is None:
            self.v[reg.name] = new
            return
        act(reg.name, old, new)
        clock = self.clock
        if self.due < clock.deadline:
            clock.deadline = max(self.due, clock.now)
