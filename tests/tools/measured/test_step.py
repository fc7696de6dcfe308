# SPDX-License-Identifier: Apache-2.0
"""How much a round takes off, on machines that answer a correction more or less than expected."""

import numpy as np
import pytest

from camtools.cut.correction import N_NODES, Complexes, Correction
from camtools.measured.correction_step import take

ENDS = (0.0, 10.0)
FLAT = np.ones(N_NODES, dtype=np.complex128)


def course(answer: complex, gain: float, rounds: int) -> list[float]:
    """Return the error of a machine that answers with a factor, before and after each round."""
    error: Complexes = 1e-3 * FLAT * np.exp(0.7j)
    left: dict[int, Complexes] = {}
    found = [1.0]
    for _ in range(rounds):
        step = take(Correction(ENDS, {3: error}), left, gain)
        left = step.left_mm
        error = error - answer * step.taken.waves_mm[3]
        found.append(1e3 * float(np.abs(error).max()))
    return found


def test_two_parts_that_agree() -> None:
    """A machine that answers as expected has nothing left after two rounds."""
    assert course(1.0, 0.7, 2) == pytest.approx([1.0, 0.3, 0.0], abs=1e-12)


@pytest.mark.parametrize("answer", [0.5, 0.8, 1.2, 1.5, 1.9, 0.9 + 0.3j, 1.2 - 0.4j])
def test_wrong_answers_converge(answer: complex) -> None:
    """Whatever it answers between 0 and 2, also turned in phase, the error goes."""
    found = course(answer, 0.7, 12)
    assert found[-1] < 0.02
    assert max(found[1:]) < 1.0


def test_second_round_by_formula() -> None:
    """MATHS.md (160): (1 - gain G)(1 - G) of a machine with G = 1.2."""
    assert course(1.2, 0.7, 2)[2] == pytest.approx(0.16 * 0.2)


def test_what_was_not_expected_gets_the_gain() -> None:
    """An error across what was left, or against it, is of this part alone."""
    for turned in (1j, -1.0):
        step = take(Correction(ENDS, {1: turned * FLAT}), {1: FLAT}, 0.7)
        assert step.taken.waves_mm[1] == pytest.approx(0.7 * turned * FLAT)
