"""The memory protection unit (Armv7-M Architecture Reference Manual, B3.5).

It answers where the core may read or fetch ahead by itself: wherever memory is normal and may be
accessed, or where code may run. The image's own accesses are not checked.
"""

from tests.stm32.models.bus import Reg, UnmodelledError

N_REGIONS = 16
ENABLE, VALID, EXECUTE_NEVER = 1 << 0, 1 << 4, 1 << 28
CODE_AND_SRAM = 0x40000000  # below it the default map has normal memory


def covers(base: int, rasr: int, address: int) -> bool:
    """Return whether an address is in an enabled eighth of a region, of 256 bytes or more."""
    log2_bytes = (rasr >> 1 & 31) + 1
    if not rasr & ENABLE or address >> log2_bytes != base >> log2_bytes:
        return False
    return not rasr >> 8 >> (address >> (log2_bytes - 3) & 7) & 1


def invites(rasr: int) -> bool:
    """Return whether the core may read or fetch ahead in a region."""
    tex, cached = rasr >> 19 & 7, rasr >> 17 & 1
    is_normal = tex not in (0, 2) or (tex == 0 and bool(cached))
    return bool(rasr >> 24 & 7) and (is_normal or not rasr & EXECUTE_NEVER)


class Mpu:
    """The regions that the image has set up."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all regions; the unit is off."""
        self.is_on = False
        self._regions: dict[int, tuple[int, int]] = {}  # MPU_RBAR and MPU_RASR by number
        self._selected = self._base = 0

    def registers(self) -> dict[int, Reg]:
        """Return the unit's registers."""
        regs = {0xD94: Reg("mpu_ctrl", 0, 7, rule="mpu"), 0xD9C: Reg("mpu_rbar", rule="mpu")}
        return regs | {0xDA0: Reg("mpu_rasr", rule="mpu")}

    def write(self, name: str, old: int, new: int) -> None:
        """Do what a store does; a region is selected by its number in MPU_RBAR."""
        if name == "mpu_ctrl":
            self.is_on = bool(new & ENABLE)
        elif name == "mpu_rasr":
            self._regions[self._selected] = self._base, new
        elif not new & VALID or new & 15 >= N_REGIONS:
            raise UnmodelledError(f"mpu.rbar 0x{new:x}: without the number of its region")
        else:
            self._selected, self._base = new & 15, new & ~31

    def invites(self, address: int) -> bool:
        """Return whether the core may read or fetch ahead here: the last region decides."""
        for number in sorted(self._regions, reverse=True) if self.is_on else ():
            base, rasr = self._regions[number]
            if covers(base, rasr, address):
                return invites(rasr)
        return address < CODE_AND_SRAM
