# SPDX-License-Identifier: Apache-2.0
"""elfcheck follows every way through an interrupt: calls, jumps, tables, loops."""

from __future__ import annotations

from pathlib import Path

import pytest

from checks.elf_longest import IrreducibleError, Loop, components, longest
from tests.tools.cases.elf_cases import LOOP, assembled, examined, link, needs_gcc, only_problem

pytestmark = needs_gcc


def test_longest_of_two_branches_counts(tmp_path: Path) -> None:
    """Four instructions on the longer way, the skipped one of an IT block counted."""
    source = assembled(
        """cbz r0, 1f
        it gt
        addgt r0, #1
        1: bx lr"""
    )
    report = examined(link(tmp_path, source))
    assert (report.instructions, report.problems) == (4, [])


def test_callee_counts_at_its_call(tmp_path: Path) -> None:
    """A call costs itself and the longest path of the callee, a tail call too."""
    source = """
        __attribute__((noinline)) void leaf(void) { __asm volatile("nop\\nnop\\nnop"); }
        __attribute__((naked, used)) void root(void)
        { __asm volatile("push {r4, lr}\\nbl leaf\\npop {r4, lr}\\nb leaf"); }"""
    report = examined(link(tmp_path, source, "-g0"))
    assert (report.instructions, report.problems) == (4 + 4 + 4, [])


@pytest.mark.parametrize("conditional", ["popeq {r4, pc}", "popeq.w {r4, pc}"])
def test_conditional_return_goes_on(tmp_path: Path, conditional: str) -> None:
    """A return in an IT block is passed when its condition fails."""
    source = assembled(f"push {{r4, lr}}\ncmp r0, #0\nit eq\n{conditional}\nnop\npop {{r4, pc}}")
    report = examined(link(tmp_path, source, "-g0"))
    assert (report.instructions, report.problems, report.stack_bytes) == (6, [], 8 + 36)


@pytest.mark.parametrize(("table", "n_nops"), [("tbb", 20), ("tbh", 400)])
def test_jump_tables_are_followed(tmp_path: Path, table: str, n_nops: int) -> None:
    """Every case of a switch is on some way, so the costliest decides."""
    nops = "\\n".join(["nop"] * n_nops)
    cases = "".join(
        f'case {i}: __asm volatile("{nops if i == 3 else "nop"}"); g[{i}] = n * {i}; break;'
        for i in range(9)
    )
    source = f"volatile int g[9]; int root(int n) {{ switch (n) {{ {cases} }} return n; }}"
    image = link(tmp_path, source)
    assert table in image.ask("objdump", "-d", str(image.path))
    report = examined(image)
    assert report.problems == []
    assert n_nops < report.instructions < n_nops + 15


def test_constants_behind_a_jump_table_are_none_of_it(tmp_path: Path) -> None:
    """The compiler may put constants of the function right behind the table."""
    source = assembled(
        "cmp r0, #1\nbhi 4f\ntbb [pc, r0]\n1: .byte (2f - 1b) / 2, (3f - 1b) / 2\n"
        ".byte 0, 0xC6\n.word 0x200E13D0\n2: nop\n3: nop\n4: bx lr"
    )
    report = examined(link(tmp_path, source, "-g0"))
    assert (report.instructions, report.problems) == (6, [])


@pytest.mark.parametrize(
    "body", ["return n < 2 ? n : root(n - 1) + root(n - 2);", "return deeper(n) * 3;"]
)
def test_recursion_is_refused(tmp_path: Path, body: str) -> None:
    """A function that may call itself, itself or through others, has no longest path."""
    source = f"""
        int root(int n);
        __attribute__((noinline)) int deeper(int n) {{ return n < 0 ? 0 : root(n - 1) + 1; }}
        int root(int n) {{ {body} }}"""
    options = ("-fno-optimize-sibling-calls", "-fno-partial-inlining", "-fno-inline")
    report = examined(link(tmp_path, source, *options))
    assert any("recursion" in problem and "root" in problem for problem in report.problems)


@pytest.mark.parametrize(
    ("body", "problem"), [("return f(n) + 1;", "indirect call"), ("return f(n);", "indirect jump")]
)
def test_function_pointers_are_refused(tmp_path: Path, body: str, problem: str) -> None:
    """The target of a pointer is unknown, whether called or jumped to."""
    source = f"int (*volatile f)(int); int root(int n) {{ {body} }}"
    assert only_problem(examined(link(tmp_path, source))).endswith(problem)


def test_jump_into_another_function_is_refused(tmp_path: Path) -> None:
    """What is neither a call nor a way inside the function is reported."""
    source = """
        __attribute__((naked, used)) void other(void)
        { __asm volatile("nop\\n.global inside\\n.type inside, %notype\\nnop\\nbx lr"); }
        __attribute__((naked, used)) void root(void) { __asm volatile("b other + 2"); }"""
    assert "middle of another function" in only_problem(examined(link(tmp_path, source)))


def test_loop_without_bound_is_refused(tmp_path: Path) -> None:
    """The report says which function the loop stands in, and its line."""
    problem = only_problem(examined(link(tmp_path, LOOP)))
    assert "has no bound: root (tiny.c:1)" in problem


def test_loop_costs_its_rounds(tmp_path: Path) -> None:
    """A loop that decides at its end runs as often as it is said to: 1 + 5 * 2 + 1."""
    report = examined(link(tmp_path, LOOP), {"root": 5})
    assert (report.instructions, report.problems) == (12, [])


def test_loop_that_decides_first_tests_once_more(tmp_path: Path) -> None:
    """Five rounds of four instructions, and the sixth test leaves: 1 + 5 * 4 + 2 + 1."""
    source = assembled(
        """movs r0, #5
        1: cmp r0, #0
        beq 2f
        subs r0, #1
        b 1b
        2: bx lr"""
    )
    report = examined(link(tmp_path, source), {"root": 5})
    assert (report.instructions, report.problems) == (24, [])


def test_nested_loops_multiply(tmp_path: Path) -> None:
    """Three rounds of an inner loop in each of three: 1 + 3 * (1 + 3 * 2 + 2) + 1."""
    source = assembled(
        """movs r0, #3
        1: movs r1, #3
        2: subs r1, #1
        bne 2b
        subs r0, #1
        bne 1b
        bx lr"""
    )
    report = examined(link(tmp_path, source), {"root": 3})
    assert (report.instructions, report.problems) == (29, [])


def test_inlined_loop_is_known_by_the_function_that_writes_it(tmp_path: Path) -> None:
    """A bound belongs to the source function, wherever the compiler puts its loop."""
    source = """
        volatile int g[8];
        static inline void fill(int n) { for (int i = 0; i < n; i++) { g[i] = i; } }
        void root(int n) { fill(n & 7); }"""
    report = examined(link(tmp_path, source), {"fill": 7})
    assert report.problems == []
    assert [loop.function for loop in report.loops] == ["root"]
    assert report.instructions >= 7 * 3


def test_loop_with_two_entries_is_refused(tmp_path: Path) -> None:
    """Without one head there is nothing to count."""
    source = assembled(
        """cbz r0, 2f
        1: subs r0, #1
        2: adds r0, #2
        bne 1b
        bx lr"""
    )
    problem = only_problem(examined(link(tmp_path, source), {"root": 5}))
    assert "loop with entries" in problem


def test_components_and_bounds_of_a_graph() -> None:
    """Components come behind what they lead to; the worst latch decides a round."""
    graph = {1: [2, 5], 2: [3, 4], 3: [2], 4: [2, 5], 5: []}
    assert [sorted(nodes) for nodes in components(graph)] == [[5], [2, 3, 4], [1]]
    seen: list[Loop] = []

    def rounds(loop: Loop) -> int:
        seen.append(loop)
        return 10

    cost = {1: 1, 2: 1, 3: 100, 4: 1, 5: 1}
    assert longest(graph, 1, {5}, cost, rounds) == 1 + 9 * 101 + 2 + 1
    assert [(loop.head, loop.latches) for loop in seen] == [(2, [3, 4])]
    with pytest.raises(IrreducibleError):
        longest({1: [2, 3], 2: [3], 3: [2]}, 1, {3}, dict.fromkeys((1, 2, 3), 1), rounds)
