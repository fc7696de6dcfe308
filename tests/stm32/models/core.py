"""The core apart from its instructions (Armv7-M Architecture Reference Manual, B1, B3).

Exceptions: priorities after reset, pending, entry with a frame of 8 words, return by EXC_RETURN.
Registers: NVIC, SCB, DWT's cycle counter; the MPU's in mpu.py. Caches are always coherent here; the
process stack, frames with floating-point registers, floating point in an exception and faults
raised by the core are not modelled, except the bus fault of a flash word that cannot be read.
"""

from collections.abc import Callable

from unicorn import Uc
from unicorn import arm_const as arm

from tests.stm32.models.bus import WORD, Device, InsnClock, Reg, UnmodelledError
from tests.stm32.models.mpu import Mpu

NMI, HARD_FAULT, BUS_FAULT = 2, 3, 5
PRIORITIES = {NMI: -2, HARD_FAULT: -1}  # of all others: 0, as after reset
FIRST_IRQ = 16
VECTKEY, SYSRESETREQ = 0x05FA, 1 << 2
BFHFNMIGN, BUSFAULTENA = 1 << 8, 1 << 17  # of CCR, of SHCSR
THREAD = 256  # lower than every priority
IRQ_WORDS = 5  # of 150 interrupts
FRAME_REGS = (
    arm.UC_ARM_REG_R0,
    arm.UC_ARM_REG_R1,
    arm.UC_ARM_REG_R2,
    arm.UC_ARM_REG_R3,
    arm.UC_ARM_REG_R12,
    arm.UC_ARM_REG_LR,
)
FPCA, SPSEL = 1 << 2, 1 << 1
THUMB, PADDED = 1 << 24, 1 << 9
RETURN_HANDLER, RETURN_THREAD = 0xFFFFFFF1, 0xFFFFFFF9
FRAME_BYTES = 32
FPU_ON, FPU_SAVED = 0xF << 20, 3 << 30  # of CPACR, of FPCCR


def is_double_store(instruction: bytes) -> bool:
    """Return whether an instruction is STRD, the store of 64 bits (ARMv7-M ARM A7.7.166)."""
    half = int.from_bytes(instruction[:2], "little")
    return half & 0xFE50 == 0xE840 and bool(half & 0x120)


class Nvic(Device):
    """The system control space: which exception is due, and what may be written there."""

    def __init__(self, clock: InsnClock) -> None:
        super().__init__("system control space", 0xE000E000, clock, 0x1000)
        # interrupt number -> callable that returns whether the device raises its line
        self.lines: dict[int, Callable[[], bool]] = {}
        self.pending: set[int] = set()  # exception numbers; `active` in the order of their entry
        self.active: list[int] = []
        self.enabled: set[int] = set()
        # called when the image asks for a reset
        self.on_reset_request: Callable[[], None] = lambda: None
        self.mpu = Mpu()  # the memory protection unit
        self._write_mpu = self.mpu.write
        self.define(
            {
                0xD08: Reg("vtor", 0, 0xFFFFFF80),
                0xD0C: Reg("aircr", 0xFA050000),
                0xD14: Reg("ccr", 0x40200, 0x30110),
                0xD24: Reg("shcsr", 0, 0x70000),
                0xD80: Reg("ccsidr", 0xF00FE019, 0),
                0xD84: Reg("csselr", 0, 1),
                0xD88: Reg("cpacr", 0, FPU_ON),
                0xDFC: Reg("demcr", 0, 1 << 24),
                0xF34: Reg("fpccr", FPU_SAVED, FPU_SAVED),
                0xF50: Reg("iciallu"),
                0xF60: Reg("dcisw"),
            }
            | self.mpu.registers()
            | {0x100 + 4 * i: Reg(f"iser{i}", rule="iser") for i in range(IRQ_WORDS)}
        )

    def reset(self) -> None:
        """Take the state after a reset of the core."""
        super().reset()
        self.mpu.reset()
        self.pending.clear()
        self.active.clear()
        self.enabled.clear()

    @property
    def has_fpu_of_thread(self) -> bool:
        """Whether the floating-point unit is on, and exceptions save no registers of it."""
        return self.v["cpacr"] == FPU_ON and not self.v["fpccr"]

    def best(self) -> int | None:
        """Return the exception that is due if nothing is masked, None for none."""
        for irq in self.enabled:
            if self.lines[irq]() and irq + FIRST_IRQ not in self.active:
                self.pending.add(irq + FIRST_IRQ)
        if not self.pending:
            return None
        best = min(self.pending, key=lambda n: (PRIORITIES.get(n, 0), n))
        now = min([PRIORITIES.get(n, 0) for n in self.active], default=THREAD)
        return None if PRIORITIES.get(best, 0) >= now else best

    def fail_load(self, faultmask: int) -> None:
        """Let a load end with an error on the bus, which FAULTMASK and BFHFNMIGN suppress."""
        if faultmask & 1 and self.v["ccr"] & BFHFNMIGN:
            return
        own = self.v["shcsr"] & BUSFAULTENA and not self.active
        self.pending.add(BUS_FAULT if own else HARD_FAULT)
        self.clock.wake()

    def _write_iser(self, name: str, old: int, new: int) -> None:
        irqs = {32 * int(name[4:]) + bit for bit in range(32) if new >> bit & 1}
        if irqs - set(self.lines):
            raise UnmodelledError(f"nvic: no device raises interrupts {sorted(irqs)}")
        self.enabled |= irqs
        self.v[name] = old | new
        self.clock.wake()

    def _write_vtor(self, name: str, old: int, new: int) -> None:
        if new & 0x3FF:
            raise UnmodelledError(
                f"scb.vtor 0x{new:x}: 166 vectors need an address of a multiple of 1024"
            )
        self.v["vtor"] = new

    def _write_aircr(self, name: str, old: int, new: int) -> None:
        if new != VECTKEY << 16 | SYSRESETREQ:
            raise UnmodelledError(f"scb.aircr 0x{new:x}: no request of a reset with its key")
        self.on_reset_request()


class Dwt(Device):
    """The cycle counter; one instruction counts as one cycle."""

    def __init__(self, clock: InsnClock) -> None:
        super().__init__("dwt", 0xE0001000, clock, 0x1000)
        self._zero_at = 0
        self.define({0x000: Reg("ctrl", 0x40000000, 1), 0x004: Reg("cyccnt"), 0xFB0: Reg("lar")})

    def _read_cyccnt(self, name: str) -> int:
        running = self.v["ctrl"] & 1
        return (self.clock.now - self._zero_at) & WORD if running else self.v["cyccnt"]

    def _write_ctrl(self, name: str, old: int, new: int) -> None:
        frozen = self._read_cyccnt(name)
        self.v["ctrl"] = new
        self._write_cyccnt(name, 0, frozen)

    def _write_cyccnt(self, name: str, old: int, new: int) -> None:
        self.v["cyccnt"] = new
        self._zero_at = self.clock.now - new


class Exceptions:
    """Entry and return, on the registers and the stack of the emulated core."""

    def __init__(self, uc: Uc, nvic: Nvic) -> None:
        self.uc, self.nvic = uc, nvic
        self.is_held = False  # an exception is due, but masked

    def due(self) -> int | None:
        """Return the exception that the core takes before its next instruction."""
        best = self.nvic.best()
        self.is_held = best is not None and self._is_masked(PRIORITIES.get(best, 0))
        return None if self.is_held else best

    def _is_masked(self, priority: int) -> bool:
        """Return whether PRIMASK or FAULTMASK holds a priority back."""
        is_prim = priority >= 0 and self.uc.reg_read(arm.UC_ARM_REG_PRIMASK) & 1
        is_fault = priority >= -1 and self.uc.reg_read(arm.UC_ARM_REG_FAULTMASK) & 1
        return bool(is_prim or is_fault)

    def enter(self, number: int, pc: int) -> int:
        """Push the frame and take an exception; return where it begins."""
        uc = self.uc
        control = uc.reg_read(arm.UC_ARM_REG_CONTROL)
        has_float = bool(control & FPCA)
        if control & SPSEL or (has_float and not self.nvic.has_fpu_of_thread):
            raise UnmodelledError("the process stack or a unit that is off is in use")
        sp = uc.reg_read(arm.UC_ARM_REG_SP) & ~3
        base = (sp - FRAME_BYTES) & ~7
        xpsr = (uc.reg_read(arm.UC_ARM_REG_XPSR) | THUMB) & ~PADDED
        words = [uc.reg_read(reg) for reg in FRAME_REGS]
        words += [pc & ~1, xpsr | (PADDED if sp & 4 else 0)]
        uc.mem_write(base, b"".join(word.to_bytes(4, "little") for word in words))
        uc.reg_write(arm.UC_ARM_REG_SP, base)
        uc.reg_write(arm.UC_ARM_REG_LR, RETURN_HANDLER if self.nvic.active else RETURN_THREAD)
        uc.reg_write(arm.UC_ARM_REG_CONTROL, control & ~FPCA)
        uc.reg_write(arm.UC_ARM_REG_XPSR, THUMB | number)
        self.nvic.pending.discard(number)
        self.nvic.active.append(number)
        return int.from_bytes(uc.mem_read(self.nvic.v["vtor"] + 4 * number, 4), "little")

    def leave(self, exc_return: int) -> int:
        """Pop the frame; return where the interrupted code continues."""
        uc = self.uc
        nested = len(self.nvic.active) > 1
        wanted = (RETURN_HANDLER if nested else RETURN_THREAD) & ~1
        if not self.nvic.active or exc_return & ~1 != wanted:
            raise UnmodelledError(f"exception return with 0x{exc_return:08x}")
        control = uc.reg_read(arm.UC_ARM_REG_CONTROL)
        if control & FPCA:
            raise UnmodelledError("an exception used floating-point registers")
        self.nvic.active.pop()
        base = uc.reg_read(arm.UC_ARM_REG_SP)
        raw = uc.mem_read(base, FRAME_BYTES)
        words = [int.from_bytes(raw[i : i + 4], "little") for i in range(0, FRAME_BYTES, 4)]
        for reg, word in zip(FRAME_REGS, words, strict=False):
            uc.reg_write(reg, word)
        uc.reg_write(arm.UC_ARM_REG_XPSR, words[7] & ~PADDED)
        uc.reg_write(arm.UC_ARM_REG_SP, base + FRAME_BYTES + (4 if words[7] & PADDED else 0))
        return words[6] | 1
