"""An STM32H743 that executes a real image: Unicorn for the instructions, models for the rest.

The clock counts instructions, one per cycle of the core; sleep lasts until the next event. An
exception is taken between two instructions. RAM is filled with a pattern at power-on and kept over
every other reset.
"""

import ctypes
import subprocess
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

from unicorn import (
    UC_ARCH_ARM,
    UC_HOOK_CODE,
    UC_HOOK_INTR,
    UC_HOOK_MEM_INVALID,
    UC_HOOK_MEM_READ,
    UC_HOOK_MEM_WRITE,
    UC_MEM_WRITE,
    UC_MEM_WRITE_PROT,
    UC_MODE_THUMB,
    UC_PROT_EXEC,
    UC_PROT_READ,
    Uc,
    UcError,
)
from unicorn import arm_const as arm
from unicorn.unicorn_py3.unicorn import uclib

from tests.stm32.image import Image
from tests.stm32.models.bus import InsnClock, UnmodelledError
from tests.stm32.models.core import Exceptions, is_double_store
from tests.stm32.models.devices import Devices
from tests.stm32.models.flash_pwr import DBECCERR, WORD_BYTES

HERE = Path(__file__).resolve().parent
FLASH, FLASH_BYTES = 0x08000000, 0x200000
NULL_BYTES = 0x1000  # at the bottom of ITCM: where null pointers lead; start-up clears it
ITCM, ITCM_BYTES = 0, 0x10000
DTCM, DTCM_BYTES = 0x20000000, 0x20000
AXI, AXI_BYTES = 0x24000000, 0x80000
RAMS = ((ITCM, ITCM_BYTES), (DTCM, DTCM_BYTES), (AXI, AXI_BYTES))
NOWHERE = 0xFFFFFFFE  # no code there: only hooks end a slice
PATTERN = b"\xa5"
WFI = b"\x30\xbf"
HELD_CYCLES = 24
MASKS = (arm.UC_ARM_REG_PRIMASK, arm.UC_ARM_REG_FAULTMASK, arm.UC_ARM_REG_CONTROL)
# Unicorn's numbers of a branch to EXC_RETURN: in an exception that it entered itself, and here,
# where it finds no instruction at the address.
EXCEPTION_EXITS, EXC_RETURNS = (8, 3), 0xFFFFFF00


@cache
def build_hook() -> ctypes.CDLL:
    """Compile insn_clock.c and load it, once for all chips."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "insn_clock.so"
        source = HERE / "insn_clock.c"
        subprocess.run(
            ["gcc", "-std=c11", "-O2", "-shared", "-fPIC", "-o", library, source], check=True
        )
        return ctypes.CDLL(str(library))


class Chip(Devices):
    """The microcontroller; its `clock` counts cycles of the core."""

    def __init__(self, image: Image, *, hse_hz: int) -> None:
        self.image = image
        self.resets: list[str] = []  # reason of every reset since the object exists
        # called with the reason of a reset before it takes effect
        self.on_reset: Callable[[str], None] = lambda reason: None
        self._failure: Exception | None = None
        self._asked: str | None = None
        self._stall: tuple[int | None, int] = (None, 0)
        self._intr: int | None = None
        self._is_asleep = False
        # interrupts after which the main loop sleeps on, as a slow one would; it is most work
        self.naps = self._naps = 7
        self._hooks: list[int] = []
        self.is_fault_of_flips = False  # a load of a RAM's double error is a bus fault, too
        self._pc = 0
        self.uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB)  # UC_MODE_MCLASS would be a Cortex-M33
        self.uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M7)
        stop = ctypes.cast(uclib.uc_emu_stop, ctypes.c_void_p).value
        super().__init__(InsnClock(0, 0, stop), hse_hz)
        self.clock.know_barriers(image.barriers)
        self.exceptions = Exceptions(self.uc, self.nvic)
        self.on_request, self.pwr.on_ready = self._ask, self._check_ram
        self._map()
        self.load_flash()

    def _check_ram(self) -> None:
        """Raise when RAM was written before the supply's voltage was valid (RM0433 6.4.1)."""
        for base, size in RAMS:
            content = self.read_memory(base, size)
            if content != PATTERN * size:
                at = next(i for i in range(size) if content[i : i + 1] != PATTERN)
                raise UnmodelledError(f"RAM at 0x{base + at:08x} written before ACTVOSRDY")

    def _map(self) -> None:
        uc = self.uc
        for base, size in RAMS:
            uc.mem_map(base, size)
        uc.mem_map(FLASH, FLASH_BYTES, UC_PROT_READ | UC_PROT_EXEC)
        for base, size in ((0x40000000, 0x20000000), (0xE0000000, 0x00100000)):
            uc.mmio_map(base, size, self._load, base, self._store, base)
        hook = build_hook()
        handle = ctypes.c_size_t()
        status = uclib.uc_hook_add(
            uc._uch,
            ctypes.byref(handle),
            UC_HOOK_CODE,
            ctypes.cast(hook.insn_clock_hook, ctypes.c_void_p),
            ctypes.byref(self.clock),
            ctypes.c_uint64(1),
            ctypes.c_uint64(0),
        )
        assert status == 0, f"uc_hook_add: {status}"
        self._hook = hook  # keeps the library loaded
        uc.hook_add(UC_HOOK_INTR, self._on_intr)
        uc.hook_add(UC_HOOK_MEM_INVALID, self._on_invalid)
        anything = UC_HOOK_MEM_READ | UC_HOOK_MEM_WRITE
        uc.hook_add(anything, self._on_null, None, 0, NULL_BYTES - 1)
        uc.hook_add(UC_HOOK_CODE, self._on_null_code, None, 0, NULL_BYTES - 1)
        self.flash.load, self.flash.save = self.read_memory, self.write_flash
        self.flash.on_cut = lambda: self._ask("power_on")
        self.flash.on_torn = self.ramecc.on_flipped = self._watch

    def load_flash(self) -> None:
        """Erase all flash and write the image into it."""
        self.write_flash(FLASH, b"\xff" * FLASH_BYTES)
        for address, content in self.image.segments:
            if not FLASH <= address <= FLASH + FLASH_BYTES - len(content):
                raise UnmodelledError(
                    f"a segment of the image loads to 0x{address:08x}, not into flash"
                )
            self.write_flash(address, content)

    def write_flash(self, address: int, content: bytes) -> None:
        """Write flash as a programmer would."""
        self.uc.mem_write(address, content)
        self.flash.heal(address, len(content))

    def read_memory(self, address: int, size: int) -> bytes:
        """Return bytes of a memory, as a debugger would."""
        return bytes(self.uc.mem_read(address, size))

    def write_memory(self, address: int, content: bytes) -> None:
        """Change a memory, as a debugger would."""
        self.uc.mem_write(address, content)

    def stall(self, address: int, cycles: int) -> None:
        """Let the next load from a device's register take so long, as a slow bus would."""
        self._stall = (address, cycles)

    def put_instructions(self, address: int, instructions: bytes) -> None:
        """Change what the core executes, as a debugger would."""
        self.write_memory(address, instructions)
        self.uc.ctl_flush_tb()

    @property
    def pc(self) -> int:
        """Address of the next instruction."""
        return self._pc & ~1

    # Called by Unicorn: an exception must not pass through it

    def _load(self, uc: Uc, offset: int, size: int, base: int) -> int:
        try:
            if base + offset == self._stall[0]:
                self.clock.now += self._stall[1]
                self._stall = (None, 0)
            device = self.device_at(base + offset)
            return device.read(base + offset - device.base, size)
        except Exception as error:
            self._fail(error, base + offset)
            return 0

    def _store(self, uc: Uc, offset: int, size: int, value: int, base: int) -> None:
        try:
            device = self.device_at(base + offset)
            device.write(base + offset - device.base, size, value)
        except Exception as error:
            self._fail(error, base + offset)

    def _fail(self, error: Exception, address: int) -> None:
        pc = self.uc.reg_read(arm.UC_ARM_REG_PC)
        where = f"{error} (address 0x{address:08x}, pc 0x{pc:08x}, {self.function_at(pc)})"
        if self._failure is None:
            self._failure = UnmodelledError(where)
            self._failure.__cause__ = error
        self.clock.wake()

    def function_at(self, address: int) -> str:
        """Return the symbol before an address."""
        below = [(v, n) for n, v in self.image.symbols.items() if v <= address | 1 and n[:1] != "$"]
        return max(below, default=(0, "?"))[1]

    def _on_intr(self, uc: Uc, number: int, user: object) -> None:
        self._intr = number
        uc.emu_stop()

    def _on_invalid(
        self, uc: Uc, access: int, address: int, size: int, value: int, user: object
    ) -> bool:
        if access == UC_MEM_WRITE_PROT and FLASH <= address < FLASH + FLASH_BYTES:
            self._program(address, size, value)
            return True
        self._fail(UnmodelledError("no memory there"), address)
        return False

    def _on_null(
        self, uc: Uc, access: int, address: int, size: int, value: int, user: object
    ) -> None:
        code = bytes(uc.mem_read(uc.reg_read(arm.UC_ARM_REG_PC), 2))
        if access != UC_MEM_WRITE or not is_double_store(code) or self.nvic.mpu.is_on:
            self._fail(UnmodelledError("null pointer"), address)

    def _on_null_code(self, uc: Uc, address: int, size: int, user: object) -> None:
        self._fail(UnmodelledError("null pointer"), address)

    def _program(self, address: int, size: int, value: int) -> None:
        try:
            content = (value & (1 << 8 * size) - 1).to_bytes(size, "little")
            self.flash.store(address, size)
            self.uc.mem_write(address, content)
        except Exception as error:
            self._fail(error, address)

    def _watch(self) -> None:
        """Have the hooks called at the words that cannot be read, and at those with wrong bits."""
        while self._hooks:
            self.uc.hook_del(self._hooks.pop())
        anything = UC_HOOK_MEM_READ | UC_HOOK_MEM_WRITE
        for kind, hook, words, size in (
            (UC_HOOK_MEM_READ, self._on_torn, self.flash.torn, WORD_BYTES),
            (anything, self._on_flipped, self.ramecc.flipped, 4),
        ):
            for word in sorted(words):
                self._hooks.append(self.uc.hook_add(kind, hook, None, word, word + size - 1))

    def _on_torn(
        self, uc: Uc, access: int, address: int, size: int, value: int, user: object
    ) -> None:
        self.flash.note_ecc(address, DBECCERR)
        self.nvic.fail_load(uc.reg_read(arm.UC_ARM_REG_FAULTMASK))

    def _on_flipped(
        self, uc: Uc, access: int, address: int, size: int, value: int, user: object
    ) -> None:
        if access == UC_MEM_WRITE:
            self.ramecc.repair(address)
        elif not self.ramecc.load(address) and self.is_fault_of_flips:
            self.nvic.fail_load(uc.reg_read(arm.UC_ARM_REG_FAULTMASK))

    # Resets

    def power_on(self) -> None:
        """Switch the supply on: RAM is lost."""
        for base, size in RAMS:
            self.uc.mem_write(base, PATTERN * size)
        self.pwr.power_cycle()
        self.reset("power_on")

    def reset(self, reason: str) -> None:
        """Reset as for a reason of rcc.RESET_FLAGS, and start at the reset vector."""
        self._asked = None
        self._is_asleep, self._naps = False, 0
        self.resets.append(reason)
        self.on_reset(reason)
        for model in self.models:
            if model is not self.rcc:
                model.reset()
        self.rcc.restart(reason)
        self.nvic.v["vtor"] = FLASH
        uc = self.uc
        for register in MASKS:
            uc.reg_write(register, 0)
        uc.reg_write(arm.UC_ARM_REG_XPSR, 1 << 24)
        stack, start = (self._flash_word(FLASH + at) for at in (0, 4))
        uc.reg_write(arm.UC_ARM_REG_SP, stack)
        uc.reg_write(arm.UC_ARM_REG_LR, 0xFFFFFFFF)
        self._pc = start

    def _flash_word(self, address: int) -> int:
        return int.from_bytes(self.uc.mem_read(address, 4), "little")

    def _ask(self, reason: str) -> None:
        self._asked = reason
        self.clock.wake()

    # Time

    def seconds(self, duration_s: float) -> int:
        """Return cycles of a time at the present clock."""
        return round(duration_s * self.rcc.core_hz())

    def run(self, cycles: int) -> None:
        """Let time pass."""
        self.run_until(lambda: False, cycles)

    def run_until(self, is_done: Callable[[], bool], most_cycles: int) -> bool:
        """Let time pass until a condition holds; return whether it did in time."""
        end = self.clock.now + most_cycles
        while True:
            due = self._settle()
            if is_done():
                return True
            if self.clock.now >= end:
                return False
            deadline = min(end, due)
            if self._is_asleep:
                self.clock.now = max(self.clock.now, deadline)
            else:
                self._execute(deadline)

    def _settle(self) -> int:
        """Do what is due: devices, resets, exceptions. Return when the next device is due."""
        due = min([device.due for device in self.timed])
        if due <= self.clock.now:
            for device in self.timed:
                if device.due <= self.clock.now:
                    device.advance()
            due = min([device.due for device in self.timed])
        if self._failure is not None:
            raise self._failure
        if self._asked is not None:
            self.reset(self._asked)
            due = min([device.due for device in self.timed])
        if self._is_asleep and self.nvic.best() is not None:
            self._is_asleep = False
        if not self._is_asleep:
            number = self.exceptions.due()
            if number is not None:
                self._pc = self.exceptions.enter(number, self._pc)
            elif self.exceptions.is_held:  # until the core no longer masks it
                due = min(due, self.clock.now + HELD_CYCLES)
        return due

    def _execute(self, deadline: int) -> None:
        """Execute instructions until a time, or until something stops them."""
        self.clock.deadline = deadline
        self._intr = None
        try:
            self.uc.emu_start(self._pc | 1, NOWHERE)
        except UcError as error:
            self._fail(UnmodelledError(f"the core stopped: {error}"), self._pc)
        self._pc = self.uc.reg_read(arm.UC_ARM_REG_PC)
        if self._failure is not None:
            raise self._failure
        if self._intr in EXCEPTION_EXITS and self._pc >= EXC_RETURNS:
            self._pc = self.exceptions.leave(self._pc | 1)
            if not self.nvic.active and self._naps:
                self._naps -= 1
                self._is_asleep = True
        elif self._intr is not None:
            self._fail(UnmodelledError(f"exception {self._intr} of Unicorn"), self._pc)
        elif self.clock.now < self.clock.deadline:
            if self.read_memory(self._pc - 2, 2) != WFI:
                self._fail(UnmodelledError("stopped for no reason"), self._pc)
            self._is_asleep, self._naps = True, self.naps
