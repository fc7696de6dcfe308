"""The estimate of cycles: what is executed, how llvm-mca sees it, what is added to it."""

from __future__ import annotations

from dataclasses import replace
from shutil import which

import pytest

from camtools.base.errors import CamtoolsError
from checks.cycles import (
    HAL_HEADER,
    STM32G474,
    STM32H743,
    Estimate,
    Span,
    allowances,
    estimate,
    fetch_cycles,
    load_percent,
    table,
)
from checks.mca import mca_cycles, straight_line, table_cycles, taken_branches
from checks.stepper import (
    InstructionTrace,
    Step,
    parse_listing,
    parse_symbols,
    run_tool,
)

needs_mca = pytest.mark.skipif(which("llvm-mca-14") is None, reason="llvm-14 is not installed")

LISTING = """
00000100 <cam_isr>:
     100:\tb510      \tpush\t{r4, lr}
     102:\tf000 f87d \tbl\t200 <hal_clock_isr>
     106:\t2801      \tcmp\tr0, #1
     108:\tbfb4      \tite\tlt
     10a:\tf04f 30ff \tmovlt.w\tr0, #4294967295\t@ 0xffffffff
     10e:\t3001      \taddge\tr0, #1
     110:\te8bd 4010 \tldmia.w\tsp!, {r4, lr}
     114:\t4770      \tbx\tlr
     116:\tbf00      \tnop
     118:\t20080da0 \t.word\t0x20080da0

00000200 <hal_clock_isr>:
     200:\t4801      \tldr\tr0, [pc, #4]\t@ (208 <hal_clock_isr+0x8>)
     202:\t6800      \tldr\tr0, [r0, #0]
     204:\t4770      \tbx\tlr
"""
SYMBOLS = "00000100 00000018 T cam_isr\n00000200 0000000c T hal_clock_isr\n20000000 00000004 B x\n"
PATH = (0x100, 0x102, 0x200, 0x202, 0x204, 0x106, 0x108, 0x10A, 0x10E, 0x110, 0x114)


def executed() -> list[Step]:
    """Return the instructions of the small interrupt in the order of its run."""
    listing = parse_listing(LISTING)
    return [listing[a] for a in PATH]


def test_listing_gives_address_size_and_text() -> None:
    """Data words and comments are no instructions."""
    listing = parse_listing(LISTING)
    assert len(listing) == 12
    assert listing[0x10A] == Step(0x10A, 4, "movlt.w", "r0, #4294967295")
    assert listing[0x116] == Step(0x116, 2, "nop", "")
    assert 0x118 not in listing


def test_symbols_are_functions_only() -> None:
    """Data has no code."""
    assert parse_symbols(SYMBOLS) == {"cam_isr": (0x100, 0x18), "hal_clock_isr": (0x200, 0xC)}


def test_straight_line_has_no_condition_no_call_and_no_list() -> None:
    """What llvm-mca stops at or misjudges is rewritten."""
    assert straight_line(executed()) == [
        "str r4, [sp]",
        "str lr, [sp]",
        "b target",
        "ldr r0, [pc, #4]",
        "ldr r0, [r0, #0]",
        "bx lr",
        "cmp r0, #1",
        "mov r0, #4294967295",
        "add r0, #1",
        "ldr r4, [sp]",
        "ldr lr, [sp]",
        "bx lr",
    ]


def test_straight_line_keeps_conditional_branches() -> None:
    """Outside an IT block a condition belongs to the branch; only the target changes."""
    lines = straight_line(
        [
            Step(0, 2, "bls.n", "40 <f+0x4>"),
            Step(2, 2, "cbnz", "r3, 50 <f>"),
        ]
    )
    assert lines == ["bls target", "cbnz r3, target"]


def test_straight_line_spells_out_ranges() -> None:
    """Registers of the floating-point unit come as ranges."""
    assert straight_line([Step(0, 4, "vpush", "{d8-d10}")]) == [
        "vstr d8, [sp]",
        "vstr d9, [sp]",
        "vstr d10, [sp]",
    ]
    assert straight_line([Step(0, 4, "ldmia.w", "r1, {r2, r3}")]) == [
        "ldr r2, [r1]",
        "ldr r3, [r1]",
    ]


def test_straight_line_has_floating_point_constants() -> None:
    """Objdump writes the eight bits of their code; any constant takes the same time."""
    constant = Step(0, 4, "vmov.f32", "s11, #8")
    assert straight_line([constant]) == ["vmov.f32 s11, #1.0"]
    assert straight_line([Step(0, 4, "vmov", "s14, r3")]) == ["vmov s14, r3"]


def test_taken_branches_count_calls_and_returns() -> None:
    """Call, return from it, and the return of the interrupt."""
    assert taken_branches(executed()) == 3


def test_table_adds_loads_lists_and_refills() -> None:
    """By hand, in the order of the run; at last three refills."""
    assert table_cycles(executed()) == 3 + 1 + (2 + 2 + 1) + (1 + 1 + 1 + 1) + 3 + 1 + 3 * 3


def test_fetch_counts_units_by_the_kind_of_memory() -> None:
    """A cache keeps a line; without one every entry into a unit waits again."""
    run = executed()
    kept = replace(STM32H743, fetch_bytes=32, fetch_cycles=10)
    assert fetch_cycles(run, kept) == 20
    # units of 8 bytes: 0x100, 0x200, 0x100 again with 0x106, 0x108, 0x110
    assert fetch_cycles(run, replace(STM32G474, fetch_bytes=8, fetch_cycles=4)) == 5 * 4


def test_every_function_of_the_interrupt_has_an_allowance() -> None:
    """The header states a longest time for each, so the upper end is never short of one."""
    allowed = allowances(HAL_HEADER.read_text(encoding="utf-8"))
    assert set(allowed) >= {"hal_clock_isr", "hal_encoder_read_isr", "hal_axis_write_isr"}
    assert min(allowed.values()) > 0


def test_function_without_allowance_is_an_error() -> None:
    """An allowance of the function before does not count for the next one."""
    header = "/// <= 9 cycles\nvoid hal_a_isr(void);\nvoid hal_b_isr(void);\n"
    with pytest.raises(CamtoolsError, match="hal_b_isr"):
        allowances(header)


@needs_mca
def test_estimate_tells_port_and_firmware_apart() -> None:
    """The port's three instructions become the allowance of hal.h at the upper end."""
    symbols = parse_symbols(SYMBOLS)
    trace = InstructionTrace("small", len(PATH), PATH)
    e = estimate(trace, parse_listing(LISTING), symbols, STM32G474, {"hal_clock_isr": 1000})
    assert (e.instructions, e.port_instructions) == (11, 3)
    assert e.port.high == 1000
    assert e.interrupt == Span(22, 22)
    assert e.core.low <= e.core.high
    assert e.total.high == e.core.high + 1022


@needs_mca
def test_estimate_charges_for_floating_point_state() -> None:
    """One instruction of the floating-point unit makes the core save its registers."""
    listing = parse_listing(LISTING.replace("ldr\tr0, [r0, #0]", "vldr\ts0, [r0]"))
    symbols = parse_symbols(SYMBOLS)
    trace = InstructionTrace("small", len(PATH), PATH)
    e = estimate(trace, listing, symbols, STM32H743, {"hal_clock_isr": 10})
    assert e.interrupt == Span(22, 22 + 2 + 34)


@needs_mca
def test_estimate_needs_a_visible_port() -> None:
    """With the port inlined nothing could be said of it."""
    with pytest.raises(CamtoolsError, match="link-time"):
        estimate(InstructionTrace("s", 1, (0x106,)), parse_listing(LISTING), {}, STM32H743, {})


@needs_mca
def test_mca_knows_dual_issue_and_dependence() -> None:
    """Hundred dependent additions take hundred cycles; independent ones half on the M7 only."""
    chain = ["add r0, r0, r1"] * 100
    pairs = ["add r0, r1, r2", "add r3, r1, r2"] * 50
    assert 100 <= mca_cycles(chain, "cortex-m7") <= 106
    assert 50 <= mca_cycles(pairs, "cortex-m7") <= 56
    assert 100 <= mca_cycles(pairs, "cortex-m4") <= 106


@needs_mca
def test_mca_error_is_told() -> None:
    """An instruction that it does not know is no zero."""
    with pytest.raises(CamtoolsError, match="llvm-mca"):
        mca_cycles(["frobnicate r0"], "cortex-m4")


def test_missing_tool_is_told() -> None:
    """One line that names the command."""
    with pytest.raises(CamtoolsError, match="no-such-tool cannot be run"):
        run_tool(["no-such-tool"])


def test_table_shows_every_session_and_the_load() -> None:
    """Ten per cent of 24 000 cycles are 2400."""
    e = Estimate("cut", 900, 80, 30, Span(2000, 4000), Span(300, 600), Span(100, 200), 2400)
    text = table(STM32H743, [e, e])
    assert "| STM32H743 at 480 MHz | cut | cut |" in text
    assert "| load at 20 kHz, % | 10.0 .. 20.0 | 10.0 .. 20.0 |" in text
    assert "| load with these, at most, % | 30.0 | 30.0 |" in text
    assert load_percent(8500.0, STM32G474) == 100.0
