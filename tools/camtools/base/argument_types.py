# SPDX-License-Identifier: Apache-2.0
"""Types of numbers on a command line, each with its range in the refusal.

>>> positive("2.5"), not_negative("0"), finite("-1e3"), whole("-7")
(2.5, 0.0, -1000.0, -7)
"""

from __future__ import annotations

import argparse
import math


def finite(text: str) -> float:
    """Return a number that is neither infinite nor none."""
    value = float(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text}: give a finite number")
    return value


def positive(text: str) -> float:
    """Return a number above 0."""
    value = finite(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text}: give a number above 0")
    return value


def not_negative(text: str) -> float:
    """Return a number of at least 0."""
    value = finite(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text}: give a number, at least 0")
    return value


def whole(text: str) -> int:
    """Return a whole number."""
    try:
        return int(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text}: give a whole number") from error
