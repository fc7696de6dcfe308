"""Numbers and units that every package shares.

>>> f"{omega_rad_s(60.0):.6f}"
'6.283185'
>>> length_unit(0.4), length_unit(12.0)
((1000.0, 'nm'), (1.0, 'µm'))
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Ints = npt.NDArray[np.int64]
FloatsLike = Floats | float
_ROUNDING = 5e-4  # three digits may round a number up by this share
NM_PER_MM = 1_000_000
UM_PER_MM = 1000.0
NM_PER_UM = 1000.0
MM_PER_M = 1000.0
DEG_PER_TURN = 360.0
DEG_PER_RAD = 180 / np.pi


def omega_rad_s(spindle_rpm: float) -> float:
    """Return the angular speed [rad/s] of a spindle speed [r/min]."""
    return 2 * np.pi * spindle_rpm / 60


class SectionValues(NamedTuple):
    """Radius reduction and its derivatives with respect to the angle; shapes as broadcast."""

    delta: Floats  # mm, 0 at the long axis
    d1: Floats  # mm/rad
    d2: Floats  # mm/rad^2
    d3: Floats  # mm/rad^3


def length_unit(largest_um: float) -> tuple[float, str]:
    """Return the factor from um and the unit in which lengths up to largest_um read well."""
    return (1.0, "µm") if largest_um >= 1 else (1000.0, "nm")


def length_text(value_um: float) -> str:
    """Return a length with the unit in which it reads well, in three digits.

    >>> length_text(0.0312), length_text(31.24), length_text(1.0)
    ('31.2 nm', '31.2 µm', '1 µm')
    >>> length_text(0.9997), length_text(-4218.0)
    ('1 µm', '-4.22 mm')
    """
    size_um = abs(value_um) * (1 + _ROUNDING)
    factor, unit = (1e-3, "mm") if size_um >= 1000 else length_unit(size_um)
    return f"{value_um * factor:.3g} {unit}"


def rounded_up(value: float) -> float:
    """Return a value rounded up to two digits, for a remedy.

    >>> rounded_up(421.4), rounded_up(1.2345)
    (430.0, 1.3)
    """
    step = 10.0 ** (np.floor(np.log10(value)) - 1)
    return float(f"{np.ceil(value / step) * step:.2g}")


def plain_number(value: float) -> str:
    """Return a number in three digits, without an exponent.

    >>> plain_number(1000.4), plain_number(0.5), plain_number(1.234e-5)
    ('1000', '0.5', '0.0000123')
    """
    return np.format_float_positional(float(f"{value:.3g}"), trim="-")
