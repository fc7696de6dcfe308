"""elfcheck follows calls, jumps and loops of an interrupt, and refuses what it may not reach."""

import re
from pathlib import Path

import pytest

from checks.elf_isr import examine, forbidden_name
from tests.tools.cases.elf_cases import (
    HARD_FLOAT,
    LOOP,
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
    """Each is reported with the chain of calls that leads there."""
    report = examined(link(tmp_path, source, "-mfloat-abi=soft"))
    found = [problem for problem in report.problems if reason in problem]
    assert found
    assert all(problem.startswith("root") for problem in found)


@needs_gcc
def test_floating_point_unit_is_found(tmp_path: Path) -> None:
    """An image with an FPU shows its instructions."""
    image = link(tmp_path, "float root(float a) { return a + a; }", *HARD_FLOAT)
    assert "floating-point unit" in only_problem(examined(image))


@needs_gcc
def test_code_from_elsewhere_is_found(tmp_path: Path) -> None:
    """All that is reached must come from the folders named."""
    source = "long long root(long long a) { return a << (a & 7); }"
    image = link(tmp_path, source)
    name = tmp_path.name
    assert examine(image, "root", {}, [name]).problems == []
    (problem,) = examine(image, "root", {}, ["firmware"]).problems
    assert "not of our sources" in problem


STACK = """
    void take(volatile char *bytes);
    __attribute__((noinline)) void take(volatile char *bytes) { bytes[0] = 1; }
    struct five { int a[5]; } five;
    __attribute__((noinline)) int middle(struct five f)
    { volatile char bytes[100]; take(bytes); return bytes[f.a[0] & 3] * f.a[4]; }
    int root(int n)
    { volatile char bytes[4000]; take(bytes); return bytes[n] + middle(five); }
"""


@needs_gcc
@pytest.mark.parametrize("option", ["-O2", "-O0", "-Os"])
def test_stack_is_added_along_the_calls(tmp_path: Path, option: str) -> None:
    """As in gcc's own report; its 12.2 omits the 16 bytes of arguments stacked from registers."""
    image = link(tmp_path, STACK, "-fstack-usage", option, "-fomit-frame-pointer")
    lines = next(tmp_path.glob("*.su")).read_text("utf-8").splitlines()
    own = {re.split(r"[:\t]", line)[3]: int(line.split("\t")[1]) for line in lines}
    own["middle"] += 16
    report = examined(image)
    assert report.problems == []
    assert {one.name: one.own_bytes for one in report.functions} == own
    assert report.stack_bytes == own["root"] + own["middle"] + own["take"] + 32 + 4


VARIABLE = """
    __attribute__((noinline)) void take(volatile char *bytes) { bytes[0] = 1; }
    void root(int n) { volatile char bytes[n]; take(bytes); }"""


@needs_gcc
@pytest.mark.parametrize(
    ("source", "options", "problem"),
    [
        (VARIABLE, (), "the call frames do not show how deep its stack is"),
        (assembled("push {r4, lr}\npop {r4, pc}"), (), "the call frames do not show"),
        ("void root(void) {}", ("-g0",), "no call frames; build with -g"),
    ],
)
def test_unknown_stack_is_refused(
    tmp_path: Path, source: str, options: tuple[str, ...], problem: str
) -> None:
    """An array whose length the caller chooses, assembler, no debug information."""
    assert problem in only_problem(examined(link(tmp_path, source, *options)))


@needs_gcc
@pytest.mark.parametrize(
    "body", ["return n < 2 ? n : root(n - 1) + root(n - 2);", "return deeper(n) * 3;"]
)
def test_recursion_is_refused(tmp_path: Path, body: str) -> None:
    """A function that may call itself, directly or through others."""
    source = f"""
        int root(int n);
        __attribute__((noinline)) int deeper(int n) {{ return n < 0 ? 0 : root(n - 1) + 1; }}
        int root(int n) {{ {body} }}"""
    options = ("-fno-optimize-sibling-calls", "-fno-partial-inlining", "-fno-inline")
    report = examined(link(tmp_path, source, *options))
    assert any("recursion" in problem and "root" in problem for problem in report.problems)


def switch(table: str) -> str:
    """Return a root() with a jump table, one case of which closes a loop."""
    ways = "(3f - 2b) / 2, (4f - 2b) / 2"
    return assembled(f"1: cmp r0, #1\nbhi 4f\n{table} {ways}\n3: b 1b\n4: bx lr")


def conditional(ending: str) -> str:
    """Return a root() that leaves its loop in an IT block, which may be skipped."""
    other = '__attribute__((noinline, used)) void other(void) { __asm volatile("nop"); }'
    return other + assembled(f"1: cmp r0, #0\nit eq\n{ending}\nb 1b")


# What leads where: a source, its one problem or "", and the function whose bound solves it.
FLOWS = [
    (switch("tbb [pc, r0]\n2: .byte"), "has no bound: root", "root"),
    (switch("tbh [pc, r0, lsl #1]\n2: .hword"), "has no bound: root", "root"),
    # The compiler may put constants of the function directly after the table.
    (
        assembled(
            "cmp r0, #1\nbhi 4f\ntbb [pc, r0]\n1: .byte (2f - 1b) / 2, (3f - 1b) / 2\n"
            ".byte 0, 0xC6\n.word 0x200E13D0\n2: nop\n3: nop\n4: bx lr"
        ),
        "",
        "",
    ),
    # Pointers, whether called or jumped to, and jumps into the middle of a function.
    ("int (*volatile f)(int); int root(int n) { return f(n) + 1; }", "indirect call", ""),
    ("int (*volatile f)(int); int root(int n) { return f(n); }", "indirect jump", ""),
    (assembled("ldr pc, [r0]"), "indirect jump", ""),
    (assembled("ldmia r0, {r1, pc}"), "indirect jump", ""),
    (assembled("tbb [r1, r0]"), "indirect jump", ""),
    (assembled("tbb [pc, r0]\nnop"), "jump table not found", ""),
    (
        """__attribute__((naked, used)) void other(void) { __asm volatile("nop\\nbx lr"); }
        __attribute__((naked, used)) void root(void) { __asm volatile("b other + 2"); }""",
        "leads to what is no function",
        "",
    ),
    *((conditional(end), "bound: root", "") for end in ("popeq {r4, pc}", "bxeq lr", "beq other")),
    # The compiler puts rare code at the end of a function, from where it jumps back.
    (assembled("cbz r0, 2f\n1: bx lr\n2: nop\nb 1b"), "", ""),
    (LOOP, "has no bound: root (tiny.c:1)", "root"),
    # Two entries, whichever comes first.
    (assembled("cbz r0, 2f\n1: subs r0, #1\n2: adds r0, #2\nbne 1b\nbx lr"), "has no bound", ""),
    # A bound belongs to the source function, wherever the compiler puts its loop.
    (
        """volatile int g[8];
        static inline void fill(int n) { for (int i = 0; i < n; i++) { g[i] = i; } }
        void root(int n) { fill(n & 7); }""",
        "root: loop",
        "fill",
    ),
]


@needs_gcc
@pytest.mark.parametrize(("source", "problem", "bounded"), FLOWS)
def test_what_leads_where(tmp_path: Path, source: str, problem: str, bounded: str) -> None:
    """What cannot be followed, or has no bound, is refused."""
    image = link(tmp_path, source)
    if problem:
        assert problem in only_problem(examined(image))
    if bounded or not problem:
        assert examined(image, bounded).problems == []
