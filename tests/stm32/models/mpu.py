# SPDX-License-Identifier: Apache-2.0
"""The memory protection unit (Armv7-M Architecture Reference Manual, B3.5).

What regions say about an address, for models that ask what the core may do there by itself: it
reads and fetches ahead wherever memory is normal and may be accessed, or where code may run. The
image's own accesses are not checked.
"""

from dataclasses import dataclass

from tests.stm32.models.bus import Reg, UnmodelledError

N_REGIONS = 16
VALID = 1 << 4
EXECUTE_NEVER = 1 << 28
CODE_AND_SRAM = 0x40000000  # below it the default map says normal memory


@dataclass(frozen=True)
class Region:
    """What MPU_RBAR and MPU_RASR hold for one region."""

    base: int
    rasr: int

    def covers(self, address: int) -> bool:
        """Return whether an address lies in an enabled eighth of the region."""
        log2_bytes = (self.rasr >> 1 & 31) + 1
        if not self.rasr & 1 or address >> log2_bytes != self.base >> log2_bytes:
            return False
        eighth = address >> (log2_bytes - 3) & 7
        return log2_bytes < 8 or not self.rasr >> (8 + eighth) & 1

    @property
    def invites(self) -> bool:
        """Whether the core may read or fetch ahead here."""
        tex, cached = self.rasr >> 19 & 7, self.rasr >> 17 & 1
        is_normal = tex not in (0, 2) or (tex == 0 and cached)
        can_access = bool(self.rasr >> 24 & 7)
        return can_access and (bool(is_normal) or not self.rasr & EXECUTE_NEVER)


class Mpu:
    """The regions that the image has set up."""

    def __init__(self) -> None:
        self._regions: dict[int, Region] = {}
        self._selected = 0
        self._base = 0
        self._control = 0

    def reset(self) -> None:
        """Forget all regions; the unit is off."""
        self._regions.clear()
        self._control = 0

    @property
    def is_on(self) -> bool:
        """Whether the unit is enabled."""
        return bool(self._control & 1)

    def registers(self) -> dict[int, Reg]:
        """Return the unit's registers."""
        return {
            0xD90: Reg("mpu_type", N_REGIONS << 8, 0),
            0xD94: Reg("mpu_ctrl", 0, 7, rule="mpu"),
            0xD9C: Reg("mpu_rbar", rule="mpu"),
            0xDA0: Reg("mpu_rasr", rule="mpu"),
        }

    def write(self, name: str, old: int, new: int) -> None:
        """Do what a store does; a region is selected by its number in MPU_RBAR."""
        if name == "mpu_ctrl":
            self._control = new
        elif name == "mpu_rasr":
            self._regions[self._selected] = Region(self._base, new)
        elif not new & VALID or new & 15 >= N_REGIONS:
            raise UnmodelledError(f"mpu.rbar 0x{new:x}: without the number of its region")
        else:
            self._selected, self._base = new & 15, new & ~31

    def invites(self, address: int) -> bool:
        """Return whether the core may read or fetch ahead here: the last region decides."""
        if self._control & 1:
            for number in sorted(self._regions, reverse=True):
                if self._regions[number].covers(address):
                    return self._regions[number].invites
        return address < CODE_AND_SRAM
