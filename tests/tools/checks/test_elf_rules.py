# SPDX-License-Identifier: Apache-2.0
"""elfcheck refuses what an interrupt may not reach, and knows its stack."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from checks.elf_isr import examine
from checks.elf_rules import forbidden_name
from tests.tools.cases.elf_cases import (
    HARD_FLOAT,
    assembled,
    examined,
    link,
    needs_gcc,
    only_problem,
)

LIBRARY_NAMES = [
    "__aeabi_ldivmod", "__aeabi_uldivmod", "__aeabi_idiv", "__aeabi_idivmod", "__aeabi_uidiv",
    "__divdi3", "__udivmoddi4", "__aeabi_fadd", "__aeabi_dmul", "__aeabi_d2iz", "__aeabi_l2f",
    "__aeabi_ui2d", "__aeabi_cdcmple", "__aeabi_memcpy4", "__addsf3", "__muldf3", "__floatsidf",
    "memcpy", "memset", "strlen", "strncpy", "printf", "snprintf", "_vfprintf_r", "malloc", "free",
    "_malloc_r", "calloc", "abort", "puts", "memcpy.constprop.0",
]  # fmt: skip
OWN_NAMES = ["cam_isr", "record", "hal_outputs_write_isr", "cam_move_profile_stop_isr.isra.0"]


@pytest.mark.parametrize("name", LIBRARY_NAMES)
def test_library_names_are_forbidden(name: str) -> None:
    """Division, floating point, heap and libc are known by name."""
    assert forbidden_name(name)


@pytest.mark.parametrize("name", OWN_NAMES)
def test_own_names_are_not(name: str) -> None:
    """A function of ours may be called what it is called."""
    assert forbidden_name(name) is None


@needs_gcc
@pytest.mark.parametrize(
    ("source", "reason"),
    [
        ("long long root(long long a, long long b) { return a / b; }", "64-bit or software div"),
        ("float root(float a, float b) { return a * b; }", "soft floating point"),
        ("double root(int a) { return a; }", "soft floating point"),
        ("int root(int a, int b) { return a / b; }", "sdiv r0, r0, r1: division"),
        (assembled("cpsid i\nbx lr"), "a lock"),
        (assembled("bkpt #171\nbx lr"), "leaves to a debugger"),
        (assembled("wfi\nbx lr"), "waiting"),
    ],
)
def test_forbidden_code_is_found(tmp_path: Path, source: str, reason: str) -> None:
    """Each is told with the chain of calls that leads there."""
    report = examined(link(tmp_path, source, "-mfloat-abi=soft"))
    found = [problem for problem in report.problems if reason in problem]
    assert found
    assert all(problem.startswith("root") for problem in found)


@needs_gcc
def test_floating_point_unit_is_found(tmp_path: Path) -> None:
    """An image with an FPU shows its instructions."""
    image = link(tmp_path, "float root(float a) { return a + a; }", *HARD_FLOAT)
    assert "floating-point unit" in only_problem(examined(image))
    assert image.has_float


@needs_gcc
def test_code_from_elsewhere_is_found(tmp_path: Path) -> None:
    """All that is reached must come from the folders named."""
    source = "long long root(long long a) { return a << (a & 7); }"
    image = link(tmp_path, source)
    name = tmp_path.name
    assert examine(image, "root", {}, [name], has_float=False).problems == []
    (problem,) = examine(image, "root", {}, ["firmware"], has_float=False).problems
    assert "not of our sources" in problem


STACK = """
    void take(volatile char *bytes);
    __attribute__((noinline)) void take(volatile char *bytes) { bytes[0] = 1; }
    __attribute__((noinline)) int middle(int n)
    { volatile char bytes[100]; take(bytes); return bytes[n & 3] * 3; }
    int root(int n)
    { volatile char bytes[4000]; take(bytes); int a = middle(n); return a + bytes[n] + middle(a); }
"""


@needs_gcc
@pytest.mark.parametrize("option", ["-O2", "-O0", "-Os"])
def test_stack_is_what_the_compiler_says(tmp_path: Path, option: str) -> None:
    """Function by function as in the compiler's own report, and added along the calls."""
    image = link(tmp_path, STACK, "-fstack-usage", option, "-fomit-frame-pointer")
    lines = next(tmp_path.glob("*.su")).read_text("utf-8").splitlines()
    said = {re.split(r"[:\t]", line)[3]: int(line.split("\t")[1]) for line in lines}
    report = examined(image)
    assert report.problems == []
    assert {cost.name: cost.own_stack_bytes for cost in report.functions} == said
    assert report.stack_bytes == said["root"] + said["middle"] + said["take"] + 32 + 4
    assert report.n_frames_compared == 3


@needs_gcc
def test_frame_of_the_floating_point_unit(tmp_path: Path) -> None:
    """26 words and the alignment, when the interrupted code may use it."""
    image = link(tmp_path, "void root(void) {}", *HARD_FLOAT)
    assert examine(image, "root", {}, has_float=True).stack_bytes == 104 + 4
    assert not image.has_float


@needs_gcc
def test_stack_of_unknown_size_is_refused(tmp_path: Path) -> None:
    """An array whose length the caller chooses."""
    source = """
        __attribute__((noinline)) void take(volatile char *bytes) { bytes[0] = 1; }
        void root(int n) { volatile char bytes[n]; take(bytes); }"""
    report = examined(link(tmp_path, source))
    assert any("changes the stack by an unknown amount" in one for one in report.problems)


@needs_gcc
@pytest.mark.parametrize(
    ("body", "problem"),
    [
        ("push {r4, lr}\nbx lr", "returns with 8 bytes on the stack"),
        ("cbz r0, 1f\nsub sp, #8\n1: add sp, #8\nbx lr", "another depth of the stack"),
        ("nop", "runs on into what is no instruction"),
    ],
)
def test_broken_functions_are_refused(tmp_path: Path, body: str, problem: str) -> None:
    """What the compiler would never write is not passed over."""
    report = examined(link(tmp_path, assembled(body), "-g0"))
    assert any(problem in one for one in report.problems), report.problems


@needs_gcc
def test_wrong_call_frames_are_found(tmp_path: Path) -> None:
    """The compiler does not see what assembler pushes, and the two disagree."""
    report = examined(link(tmp_path, assembled("push {r4, lr}\npop {r4, pc}")))
    assert only_problem(report) == "root: 8 bytes of stack, call frames say 0"
