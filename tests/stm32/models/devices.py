"""The peripherals of the chip, at their addresses and wired to each other."""

from collections.abc import Callable

from tests.stm32.models.bus import Device, InsnClock, UnmodelledError
from tests.stm32.models.core import NMI, Dwt, Nvic
from tests.stm32.models.fdcan import Ccu, Fdcan, MessageRam
from tests.stm32.models.flash_pwr import Dbgmcu, Flash, Pwr, Syscfg
from tests.stm32.models.gpio import Gpio
from tests.stm32.models.pulse_timer import PulseTimer
from tests.stm32.models.ramecc import Ramecc
from tests.stm32.models.rcc import Rcc
from tests.stm32.models.spi_dac import Dac1, Spi
from tests.stm32.models.timers import Timer
from tests.stm32.models.usart import Usart
from tests.stm32.models.watchdogs import Iwdg, Wwdg

IRQ_TIM4, IRQ_ECC = 30, 145
REVISION_V = 0x2003
ALWAYS_ON = ("cr", 0)  # as long as the HSI
GATES: dict[str, tuple[str, int]] = {
    "tim2": ("apb1lenr", 0),
    "tim3": ("apb1lenr", 1),
    "tim4": ("apb1lenr", 2),
    "tim5": ("apb1lenr", 3),
    "spi3": ("apb1lenr", 15),
    "usart3": ("apb1lenr", 18),
    "dac1": ("apb1lenr", 29),
    "fdcan1": ("apb1henr", 8),
    "fdcan message ram": ("apb1henr", 8),
    "fdcan ccu": ("apb1henr", 8),
    "tim1": ("apb2enr", 0),
    "tim8": ("apb2enr", 1),
    **{f"tim{i}": ("apb2enr", i + 1) for i in (16, 17)},
    "wwdg1": ("apb3enr", 6),
    "syscfg": ("apb4enr", 1),
    **{f"gpio{chr(ord('a') + i)}": ("ahb4enr", i) for i in range(5)},
}


class Devices:
    """All of them, by name."""

    def __init__(self, clock: InsnClock, hse_hz: int) -> None:
        # called with the reason when a device asks for a reset
        self.on_request: Callable[[str], None] = lambda reason: None
        self.clock = clock
        self.rcc = Rcc(clock, hse_hz)
        self.syscfg, self.flash = Syscfg(clock), Flash(clock)
        self.pwr = Pwr(clock, self.syscfg)
        self.dbgmcu, self.ramecc = Dbgmcu(clock, REVISION_V), Ramecc(clock)
        self.gpio = Gpio(clock)
        bases = {1: 0x40010000, 2: 0x40000000, 3: 0x40000400, 4: 0x40000800, 5: 0x40000C00}
        self.tim = {
            i: Timer(clock, self.rcc, f"tim{i}", base, 32 if i in (2, 5) else 16)
            for i, base in bases.items()
        }
        bases = {16: 0x40014400, 17: 0x40014800}
        self.pulses = {i: PulseTimer(clock, self.rcc, f"tim{i}", bases[i]) for i in bases}
        self.pulses[8] = PulseTimer(clock, self.rcc, "tim8", 0x40010400, channel=3)
        self.spi3 = Spi(clock, self.rcc, "spi3", 0x40003C00)
        self.dac1 = Dac1(clock)
        self.can_ram = MessageRam(clock)
        self.ccu = Ccu(clock)
        self.fdcan1 = Fdcan(clock, self.rcc, self.can_ram, self.ccu)
        self.usart3 = Usart(clock, self.rcc)
        self.iwdg1 = Iwdg(clock, self.rcc, lambda: self.on_request("watchdog"))
        self.wwdg1 = Wwdg(clock, self.rcc, lambda: self.on_request("window"))
        self.nvic, self.dwt = Nvic(clock), Dwt(clock)
        self._wire()
        self._place()

    def _wire(self) -> None:
        self.nvic.lines[IRQ_TIM4] = self.tim[4].irq
        self.nvic.lines[IRQ_ECC] = self.ramecc.irq
        self.nvic.on_reset_request = lambda: self.on_request("software")
        self.rcc.on_css = lambda: self.nvic.pending.add(NMI)
        self.rcc.check_supply = self._check_supply
        self.flash.invites = self.nvic.mpu.invites
        self.tim[4].on_trigger = self.dac1.trigger

    def _check_supply(self, core_hz: int, axi_hz: int) -> None:
        self.pwr.check(core_hz)
        self.flash.check(axi_hz, self.pwr.scale())

    def _place(self) -> None:
        """Give every device its addresses."""
        devices: list[Device] = [self.rcc, self.syscfg, self.flash, self.pwr, self.dbgmcu]
        devices += [self.ramecc, self.spi3, self.dac1]
        devices += [self.can_ram, self.ccu, self.fdcan1, self.usart3]
        devices += [self.iwdg1, self.wwdg1, self.nvic, self.dwt]
        devices += [*self.tim.values(), *self.pulses.values(), *self.gpio.ports.values()]
        self.at_kb: dict[int, Device] = {}  # by kilobyte of the address space
        for device in devices:
            for kb in range(device.base >> 10, (device.base + device.size) >> 10):
                assert kb not in self.at_kb, f"{device.name} overlaps {self.at_kb[kb].name}"
                self.at_kb[kb] = device
        self.models = devices
        # those that have something to do at a time of their own
        self.timed = [d for d in devices if type(d).advance is not Device.advance]

    def device_at(self, address: int) -> Device:
        """Return the device of an address; raise where there is none or its clock is off."""
        kb = address >> 10
        device = self.rcc.reachable.get(kb)
        if device is None:
            if kb not in self.at_kb:
                raise UnmodelledError("no device")
            device, (register, bit) = self.at_kb[kb], GATES.get(self.at_kb[kb].name, ALWAYS_ON)
            if not self.rcc.v[register] >> bit & 1:
                raise UnmodelledError(f"{device.name} used without its clock")
            self.rcc.reachable[kb] = device
        return device
