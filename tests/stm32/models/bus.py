# SPDX-License-Identifier: Apache-2.0
"""What every device model stands on: registers that are known bit by bit, and the clock.

A model lists its registers; whatever it does not list does not exist, and an access to it ends the
test (`UnmodelledError`). So a port cannot rely on something that nobody has written down here.
"""

import ctypes
from collections.abc import Iterable
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
    sizes: tuple[int, ...] = (4,)  # [bytes] of accesses


class Device:
    """A block of registers; subclasses define them and add behaviour.

    `due` is when [cycles] advance() has something to do, NEVER for not at all.
    """

    def __init__(self, name: str, base: int, clock: InsnClock, size: int = 0x400) -> None:
        self.name, self.base, self.size, self.clock = name, base, size, clock
        self.regs: dict[int, Reg] = {}
        self.v: dict[str, int] = {}
        self.due = NEVER

    def define(self, regs: dict[int, Reg]) -> None:
        """Add registers by offset and give them their values after reset."""
        self.regs |= regs
        self.v |= {reg.name: reg.reset for reg in regs.values()}

    def reset(self) -> None:
        """Take the values after a system reset."""
        self.v = {reg.name: reg.reset for reg in self.regs.values()}
        self.due = NEVER

    def advance(self) -> None:
        """Do what is due at the clock's time."""

    def _reg(self, offset: int, size: int) -> Reg:
        reg = self.regs.get(offset & ~3)
        if reg is None:
            raise UnmodelledError(f"{self.name}: no register at offset 0x{offset:x}")
        if size not in reg.sizes or offset % size:
            raise UnmodelledError(f"{self.name}.{reg.name}: access of {size} bytes at 0x{offset:x}")
        return reg

    def read(self, offset: int, size: int) -> int:
        """Return what a load gives."""
        reg = self._reg(offset, size)
        act = getattr(self, f"_read_{reg.rule or reg.name}", None)
        value = self.v[reg.name] if act is None else act(reg.name)
        return int(value) >> 8 * (offset & 3) & ((1 << 8 * size) - 1)

    def write(self, offset: int, size: int, value: int) -> None:
        """Do what a store does; a narrow one keeps the other bytes of the register."""
        reg = self._reg(offset, size)
        old = self.v[reg.name]
        shift = 8 * (offset & 3)
        mask = ((1 << 8 * size) - 1) << shift
        new = (old & ~mask) | (value << shift & mask)
        foreign = new & ~reg.writable & ~reg.ignored & ~old
        if foreign:
            raise UnmodelledError(f"{self.name}.{reg.name}: nobody models bits 0x{foreign:x}")
        new = (new & reg.writable) | (old & ~reg.writable)
        act = getattr(self, f"_write_{reg.rule or reg.name}", None)
        if act is None:
            self.v[reg.name] = new
        else:
            act(reg.name, old, new)
            self.clock.deadline = min(self.clock.deadline, max(self.due, self.clock.now))


class Bus:
    """Finds the device of an address, at a grain of 1 KB."""

    def __init__(self) -> None:
        self.models: list[Device] = []
        self.by_kb: dict[int, Device] = {}  # kilobyte of the address space -> its device

    def add(self, model: Device) -> None:
        """Place a device; its size is a multiple of 1 KB."""
        for kb in range(model.base >> 10, (model.base + model.size) >> 10):
            assert kb not in self.by_kb, f"{model.name} overlaps {self.by_kb[kb].name}"
            self.by_kb[kb] = model
        self.models.append(model)

    def _model(self, address: int) -> Device:
        model = self.by_kb.get(address >> 10)
        if model is None:
            raise UnmodelledError(f"no device at 0x{address:08x}")
        return model

    def name_at(self, address: int) -> str:
        """Return the name of the device at an address."""
        return self._model(address).name

    def read(self, address: int, size: int) -> int:
        """Load from a device."""
        model = self._model(address)
        return model.read(address - model.base, size)

    def write(self, address: int, size: int, value: int) -> None:
        """Store into a device."""
        model = self._model(address)
        model.write(address - model.base, size, value)
