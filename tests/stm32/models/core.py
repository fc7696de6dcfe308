# SPDX-License-Identifier: Apache-2.0
"""What an Armv7-M core has beside its instructions (Armv7-M Architecture Reference Manual, B1, B3).

Exceptions: priorities, pending, entry with a frame of 8 words, or of 26 when the floating-point
unit was used (stored at once, not lazily), return by EXC_RETURN. Registers: NVIC, SCB, DWT's cycle
counter; the MPU's in mpu.py. Caches are always coherent here; the process stack, SysTick and faults
raised by the core are not modelled, but for the bus fault of a flash word that cannot be read.
"""

from collections.abc import Callable

from unicorn import Uc
from unicorn import arm_const as arm

from tests.stm32.models.bus import WORD, Device, InsnClock, Reg, UnmodelledError
from tests.stm32.models.mpu import Mpu

NMI, HARD_FAULT, BUS_FAULT, SYSTICK = 2, 3, 5, 15
FIRST_IRQ = 16
N_IRQS = 150
VECTKEY = 0x05FA
BFHFNMIGN, BUSFAULTENA = 1 << 8, 1 << 17  # of CCR, of SHCSR
SYSRESETREQ = 1 << 2
THREAD = 256  # lower than every priority
IRQ_WORDS = (N_IRQS + 31) // 32

FRAME_REGS = (
    arm.UC_ARM_REG_R0,
    arm.UC_ARM_REG_R1,
    arm.UC_ARM_REG_R2,
    arm.UC_ARM_REG_R3,
    arm.UC_ARM_REG_R12,
    arm.UC_ARM_REG_LR,
)
FP_REGS = tuple(arm.UC_ARM_REG_S0 + i for i in range(16))
FPCA, SPSEL = 1 << 2, 1 << 1
THUMB = 1 << 24
RETURN_HANDLER, RETURN_THREAD = 0xFFFFFFF1, 0xFFFFFFF9
NO_FP_BIT = 1 << 4  # of EXC_RETURN: set when the frame has 8 words


def is_double_store(instruction: bytes) -> bool:
    """Return whether an instruction is STRD, the store of 64 bits (ARMv7-M ARM A7.7.166)."""
    half = int.from_bytes(instruction[:2], "little")
    return half & 0xFE50 == 0xE840 and bool(half & 0x120)


class Nvic(Device):
    """The system control space: which exception is due, and what may be written there."""

    def __init__(self, clock: InsnClock) -> None:
        super().__init__("system control space", 0xE000E000, clock, 0x1000)
        # interrupt number -> callable that tells whether the device raises its line
        self.lines: dict[int, Callable[[], bool]] = {}
        self.pending: set[int] = set()  # exception numbers; `active` in the order of their entry
        self.active: list[int] = []
        self.enabled: set[int] = set()
        # called when the image asks for a reset
        self.on_reset_request: Callable[[], None] = lambda: None
        self.mpu = Mpu()  # the memory protection unit
        self._write_mpu = self.mpu.write
        self.define(self._scb() | self.mpu.registers() | self._nvic() | self._systick())

    def reset(self) -> None:
        """Take the state behind a reset of the core."""
        super().reset()
        self.mpu.reset()
        self.pending.clear()
        self.active.clear()
        self.enabled.clear()

    # Which exception is due

    def priority(self, number: int) -> int:
        """Return the priority of an exception, a lower number goes first."""
        if number < 4:
            return {1: -3, NMI: -2, HARD_FAULT: -1}[number]
        if number < FIRST_IRQ:
            return self.v[f"shpr{number // 4}"] >> 8 * (number % 4) & 0xF0
        irq = number - FIRST_IRQ
        return self.v[f"ipr{irq // 4}"] >> 8 * (irq % 4) & 0xF0

    def best(self) -> int | None:
        """Return the exception that is due if nothing is masked, None for none."""
        for irq in self.enabled:
            line = self.lines.get(irq)
            if line is not None and line() and irq + FIRST_IRQ not in self.active:
                self.pending.add(irq + FIRST_IRQ)
        candidates = [n for n in self.pending if n < FIRST_IRQ or n - FIRST_IRQ in self.enabled]
        best = min(candidates, key=lambda n: (self.priority(n), n), default=None)
        now = min([self.priority(n) for n in self.active], default=THREAD)
        return None if best is None or self.priority(best) >= now else best

    def is_masked(self, number: int, primask: int, basepri: int, faultmask: int) -> bool:
        """Return whether the core's masks hold an exception back."""
        limits = [basepri] if basepri else []
        limits += [0] if primask & 1 else []
        limits += [self.priority(HARD_FAULT)] if faultmask & 1 else []
        return bool(limits) and self.priority(number) >= min(limits)

    def fail_load(self, faultmask: int) -> None:
        """Let a load end with an error on the bus, which FAULTMASK and BFHFNMIGN suppress."""
        if faultmask & 1 and self.v["ccr"] & BFHFNMIGN:
            return
        own = self.v["shcsr"] & BUSFAULTENA and not self.active
        self.pending.add(BUS_FAULT if own else HARD_FAULT)
        self.clock.wake()

    def wakes(self) -> bool:
        """Return whether WFI ends: an exception would be due if nothing were masked."""
        return self.best() is not None

    # Registers

    def _scb(self) -> dict[int, Reg]:
        fixed = {
            0xD00: ("cpuid", 0x411FC271),
            0xD04: ("icsr", 0),
            0xD78: ("clidr", 0x09000003),
            0xD7C: ("ctr", 0x8303C003),
            0xD80: ("ccsidr", 0xF00FE019),
        }
        regs = {at: Reg(name, value, 0) for at, (name, value) in fixed.items()}
        regs[0xD04] = Reg("icsr", 0, 1 << 27 | 1 << 25)
        regs[0xD08] = Reg("vtor", 0, 0xFFFFFF80)
        regs[0xD0C] = Reg("aircr", 0xFA050000)
        regs[0xD10] = Reg("scr", 0, 0)
        regs[0xD14] = Reg("ccr", 0x40200, 0x70318)
        regs |= {0xD14 + 4 * i: Reg(f"shpr{i}", sizes=(1, 2, 4)) for i in (1, 2, 3)}
        regs[0xD24] = Reg("shcsr", 0, 0x70000)
        for at, name in ((0xD28, "cfsr"), (0xD2C, "hfsr")):
            regs[at] = Reg(name, rule="by_one")
        regs |= {0xD34: Reg("mmfar"), 0xD38: Reg("bfar")}
        regs[0xD84] = Reg("csselr", 0, 1)
        regs[0xD88] = Reg("cpacr", 0, 0xF << 20)
        regs[0xDFC] = Reg("demcr", 0, 1 << 24)
        regs |= {0xF34: Reg("fpccr", 0xC0000000, 0xC0000000), 0xF3C: Reg("fpdscr")}
        regs |= {at: Reg(f"cache_{at:x}") for at in range(0xF50, 0xF7C, 4)}  # maintenance
        regs |= {0xF90: Reg("itcmcr", 0x41, 7), 0xF94: Reg("dtcmcr", 0x41, 7)}
        regs |= {0xF98: Reg("ahbpcr", 0x7, 1), 0xF9C: Reg("cacr", 0, 7)}
        return regs

    def _nvic(self) -> dict[int, Reg]:
        regs: dict[int, Reg] = {}
        for i in range(IRQ_WORDS):
            for at, name in ((0x100, "iser"), (0x180, "icer"), (0x200, "ispr"), (0x280, "icpr")):
                regs[at + 4 * i] = Reg(f"{name}{i}", rule="irqs")
        ipr = {0x400 + 4 * i: Reg(f"ipr{i}", sizes=(1, 2, 4)) for i in range((N_IRQS + 3) // 4)}
        return regs | ipr

    def _systick(self) -> dict[int, Reg]:
        """SysTick must stay off: the image has no use for it."""
        return {0x10: Reg("syst_csr", 0, 0), 0x14: Reg("syst_rvr", 0, 0xFFFFFF)}

    def _write_irqs(self, name: str, old: int, new: int) -> None:
        kind, word = name[:4], int(name[4:])
        irqs = {32 * word + bit for bit in range(32) if new >> bit & 1}
        if kind == "iser":
            foreign = irqs - set(self.lines)
            if foreign:
                raise UnmodelledError(f"nvic: no device raises interrupts {sorted(foreign)}")
            self.enabled |= irqs
        elif kind == "icer":
            self.enabled -= irqs
        elif kind == "ispr":
            self.pending |= {irq + FIRST_IRQ for irq in irqs}
        else:
            self.pending -= {irq + FIRST_IRQ for irq in irqs}
        self.v[f"iser{word}"] = sum(1 << irq % 32 for irq in self.enabled if irq // 32 == word)
        self.clock.wake()

    def _read_icsr(self, name: str) -> int:
        return self.active[-1] if self.active else 0

    def _write_icsr(self, name: str, old: int, new: int) -> None:
        raise UnmodelledError("scb.icsr: exceptions pended by software")

    def _write_vtor(self, name: str, old: int, new: int) -> None:
        if new & 0x3FF:
            raise UnmodelledError(
                f"scb.vtor 0x{new:x}: 166 vectors need an address of a multiple of 1024"
            )
        self.v["vtor"] = new

    def _write_aircr(self, name: str, old: int, new: int) -> None:
        if new >> 16 != VECTKEY:
            raise UnmodelledError(f"scb.aircr 0x{new:x} without its key")
        if new & 0xFF & ~SYSRESETREQ:
            raise UnmodelledError(f"scb.aircr 0x{new:x}")
        self.v["aircr"] = 0xFA050000 | (new & 0x700)
        if new & SYSRESETREQ:
            self.on_reset_request()

    def _write_by_one(self, name: str, old: int, new: int) -> None:
        self.v[name] = old & ~new


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
        self.is_held = False
        if best is None:
            return None
        masks = (arm.UC_ARM_REG_PRIMASK, arm.UC_ARM_REG_BASEPRI, arm.UC_ARM_REG_FAULTMASK)
        self.is_held = self.nvic.is_masked(best, *(self.uc.reg_read(mask) for mask in masks))
        return None if self.is_held else best

    def _word(self, address: int) -> int:
        return int.from_bytes(self.uc.mem_read(address, 4), "little")

    def enter(self, number: int, pc: int) -> int:
        """Push the frame and take an exception; return where it begins."""
        uc = self.uc
        control = uc.reg_read(arm.UC_ARM_REG_CONTROL)
        if control & SPSEL:
            raise UnmodelledError("the process stack is in use")
        has_fp = bool(control & FPCA)
        if has_fp and not self.nvic.v["cpacr"]:
            raise UnmodelledError("floating point used before it was enabled in CPACR")
        sp = uc.reg_read(arm.UC_ARM_REG_SP) & ~3
        n_words = 26 if has_fp else 8
        base = (sp - 4 * n_words) & ~7
        xpsr = uc.reg_read(arm.UC_ARM_REG_XPSR) | THUMB
        padded = (sp - 4 * n_words) & 4
        words = [uc.reg_read(reg) for reg in FRAME_REGS]
        words += [pc & ~1, (xpsr & ~(1 << 9)) | (1 << 9 if padded else 0)]
        if has_fp:
            words += [uc.reg_read(reg) for reg in FP_REGS]
            words += [uc.reg_read(arm.UC_ARM_REG_FPSCR), 0]
        uc.mem_write(base, b"".join(word.to_bytes(4, "little") for word in words))
        uc.reg_write(arm.UC_ARM_REG_SP, base)
        back = RETURN_HANDLER if self.nvic.active else RETURN_THREAD
        uc.reg_write(arm.UC_ARM_REG_LR, back & ~NO_FP_BIT if has_fp else back)
        uc.reg_write(arm.UC_ARM_REG_XPSR, THUMB | number)
        if has_fp:
            uc.reg_write(arm.UC_ARM_REG_CONTROL, control & ~FPCA)
        self.nvic.pending.discard(number)
        self.nvic.active.append(number)
        return self._word(self.nvic.v["vtor"] + 4 * number)

    def leave(self, exc_return: int) -> int:
        """Pop the frame; return where the interrupted code goes on."""
        uc = self.uc
        nested = len(self.nvic.active) > 1
        wanted = (RETURN_HANDLER if nested else RETURN_THREAD) & ~NO_FP_BIT & ~1
        if not self.nvic.active or exc_return & ~NO_FP_BIT & ~1 != wanted:
            raise UnmodelledError(f"exception return with 0x{exc_return:08x}")
        self.nvic.active.pop()
        base = uc.reg_read(arm.UC_ARM_REG_SP)
        has_fp = not exc_return & NO_FP_BIT
        n_words = 26 if has_fp else 8
        raw = uc.mem_read(base, 4 * n_words)
        words = [int.from_bytes(raw[i : i + 4], "little") for i in range(0, 4 * n_words, 4)]
        for reg, word in zip(FRAME_REGS, words, strict=False):
            uc.reg_write(reg, word)
        xpsr = words[7]
        uc.reg_write(arm.UC_ARM_REG_XPSR, xpsr & ~(1 << 9))
        if has_fp:
            for reg, word in zip(FP_REGS, words[8:], strict=False):
                uc.reg_write(reg, word)
            uc.reg_write(arm.UC_ARM_REG_FPSCR, words[24])
        uc.reg_write(arm.UC_ARM_REG_SP, base + 4 * n_words + (4 if xpsr >> 9 & 1 else 0))
        return words[6] | 1
