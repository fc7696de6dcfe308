# SPDX-License-Identifier: Apache-2.0
"""The steps of tools/test, a line each; step_runner.py runs them and adds everything up.

A gate (a build, a formatter, a linter) counts as one test; ctest and pytest tell their own
numbers in JUnit files. A step is added by one line in the list that it belongs to.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
from pathlib import Path

from step_runner import Runner, Step

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build"
PYTHON = sys.executable
PYPROJECT = "tools/pyproject.toml"
LINT_IMPORTS = Path(PYTHON).with_name("lint-imports")
C_FOLDERS = ("firmware", "hal", "host_sim", "tests")
Command = tuple[str | Path, ...]
MAX_CORES = 8
N_CORES = min(len(os.sched_getaffinity(0)), MAX_CORES)
# A process per core; all tests of a file in one process, since they share what is costly to make.
# A crash is reported and ends its process for good.
PARALLEL = ("-n", str(N_CORES), "--dist", "loadfile", "--max-worker-restart=0")
NOTHING = r"^\b$"  # closing line of a step that has none worth reading
MIN_LINE_PERCENT = "99"
MIN_BRANCH_PERCENT = "97"


def gate(
    name: str,
    *command: str | Path,
    needs: tuple[str, ...] = (),
    closing: str | None = None,
    wide: bool = False,
) -> Step:
    """Return a step that counts as one test."""
    return Step(name, command, needs, is_wide=wide, closing=closing)


def tool(
    name: str,
    module: str,
    *words: str | Path,
    needs: tuple[str, ...] = (),
    closing: str | None = None,
) -> Step:
    """Return a step that is a Python module of ours or of others."""
    return gate(name, PYTHON, "-m", module, *words, needs=needs, closing=closing)


def build(preset: str, target: str = "") -> Step:
    """Return the build of a preset by the function that tools/run uses too."""
    script = 'set -euo pipefail; source "$1/tools/setup.sh"; camturn_build "$2" ${3:+"$3"}'
    words = ("bash", "-c", script, "bash", ROOT, preset, target)
    return gate(f"build {preset}", *words, wide=True, closing=NOTHING)


def ctest(preset: str, *options: str, clears: str = "", wide: bool = True) -> Step:
    """Return the C tests of a preset, on all cores or, beside other steps, on one."""
    report = BUILD / "reports" / f"ctest-{preset}.xml"
    jobs = str(N_CORES if wide else 1)
    words: Command = ("ctest", "--preset", preset, "-j", jobs, "--output-junit", report)
    needs = (f"build {preset}",)
    said = "tests passed"
    return Step(
        f"ctest {preset}",
        (*words, *options),
        needs,
        is_wide=wide,
        report=report,
        closing=said,
        clears=clears,
    )


def pytest(
    name: str,
    *words: str,
    needs: tuple[str, ...],
    preset: str = "host",
    wide: bool = False,
    alone: bool = False,
) -> Step:
    """Return tests in Python; those that start the simulator take it from a preset."""
    report = BUILD / "reports" / f"pytest-{name.replace(' ', '-')}.xml"
    runner = (PYTHON, "-m", "pytest", "-c", PYPROJECT, f"--rootdir={ROOT}", "-q")
    return Step(
        f"pytest {name}",
        (*runner, f"--junitxml={report}", *(PARALLEL if wide else ()), *words),
        needs,
        is_wide=wide,
        is_alone=alone,
        report=report,
        environment={"CAMTURN_BUILD": str(BUILD / preset)},
    )


def sources() -> list[Path]:
    """Return our C files."""
    return sorted(p for f in C_FOLDERS for p in (ROOT / f).rglob("*.[ch]"))


def files_with(mark: str) -> list[str]:
    """Return the files of tests that use a mark of pytest: no others need be imported for it."""
    files = sorted((ROOT / "tests").rglob("test_*.py"))
    return [str(f.relative_to(ROOT)) for f in files if f"pytest.mark.{mark}" in f.read_text()]


def tools_steps(is_fast: bool) -> list[Step]:
    """Return the tests of the tools, and the scenarios, with the simulator of the host."""
    paths = (
        "tests/tools",
        "tests/scenarios",
        "tests/fuzz",
        "tests/campaign",
        "tests/mutation",
    )
    needs = ("build host",)
    rest = " and not slow" if is_fast else ""
    # Those that judge the clock run one by one. A computer that is held up makes one of them fail
    # all the same: it is tried again, which the last line tells.
    alone = ("--reruns", "2", *files_with("alone"))
    return [
        pytest("tools", *paths, "-m", f"not alone{rest}", needs=needs, wide=True),
        pytest("alone", "-m", f"alone{rest}", *alone, needs=needs, alone=True),
    ]


def browser_step() -> Step:
    """Return the tests of pages in Chromium, whose windows share one process."""
    return pytest("browser", "tests/browser", needs=("build host",))


def fast_steps() -> list[Step]:
    """Return the steps of tools/test --fast: build, unit tests, tests of the tools, scenarios.

    Pages are tested where there is a Chromium; only the whole tools/test asks for one.
    """
    browser = [browser_step()] if shutil.which("chromium") else []
    return [build("host"), ctest("host"), *browser, *tools_steps(is_fast=True)]


def source_steps() -> list[Step]:
    """Return the checks that need no build."""
    ruff = ("--config", PYPROJECT, "tools", "tests")
    return [
        gate("clang-format", "clang-format-14", "--dry-run", "--Werror", *sources()),
        tool("ruff format", "ruff", "format", "--check", *ruff),
        tool("ruff check", "ruff", "check", *ruff),
        tool("mypy", "mypy", "--config-file", PYPROJECT, "tools", "tests"),
        gate("misra", ROOT / "tools" / "misra"),
        gate("imports", LINT_IMPORTS, "--config", PYPROJECT, "--no-cache", closing="Contracts:"),
    ]


def clang_tidy(preset: str, files: str, *options: str) -> Step:
    """Return an analysis of files of this tree with the compile commands of a build."""
    tidy: Command = ("run-clang-tidy-14", "-quiet", "-j", "1", "-p", BUILD / preset)
    needs = (f"build {preset}",)
    names = rf"^{re.escape(str(ROOT))}/{files}$"
    return gate(f"clang-tidy {preset}", *tidy, *options, names, needs=needs, closing=NOTHING)


def host_steps() -> list[Step]:
    """Return what the builds for this computer are for."""
    simulator = (
        "tests/scenarios",
        "tests/tools/sim/test_camsim_run.py",
        "tests/tools/sim/test_camsim_eval.py",
    )
    # main() never returns and runs on machines only.
    files = ("--filter", "firmware/", "--exclude", r"firmware/main\.c")
    both = ("build host", "build host-asan")  # tables are judged by the library of the host
    # Lines of loops are passed more than 2^32 times, which gcovr takes for a defect of gcov.
    hits = ("--gcov-suspicious-hits-threshold", "0")
    limits = (
        *hits,
        "--fail-under-line",
        MIN_LINE_PERCENT,
        "--fail-under-branch",
        MIN_BRANCH_PERCENT,
    )
    gcovr = ("--root", ROOT, *files, *limits, "--print-summary", BUILD / "host-cov")
    # The firmware is covered by its own tests; the simulator's run in two other builds.
    own_tests = ("-L", "^firmware$")
    return [
        *tools_steps(is_fast=False),
        build("host-asan"),
        ctest("host-asan"),
        pytest("host-asan", *simulator, needs=both, preset="host-asan", wide=True),
        clang_tidy("host-asan", r"(firmware|hal|host_sim)/.*\.c"),
        build("host-tsan"),
        ctest("host-tsan", "-R", r"^unit\.test_cam_status$"),
        build("host-cov", "firmware_tests"),
        ctest("host-cov", *own_tests, clears="build/host-cov/**/*.gcda"),
        tool("coverage of firmware", "gcovr", *gcovr, needs=("ctest host-cov",), closing=r"^\w+: "),
    ]


def fuzz_steps() -> list[Step]:
    """Return the short form of the fuzzing: ten seconds for each target, two of them at a time."""
    run = (ROOT / "tests" / "fuzz" / "run", "--short", "--jobs", str(min(N_CORES, 2)))
    needs = ("build host-fuzz",)
    return [
        build("host-fuzz", "fuzz"),
        gate("fuzz", *run, needs=needs, closing="executions, ", wide=True),
    ]


def linux_steps() -> list[Step]:
    """Return the port for Linux, with both versions of libgpiod and on a kernel, and LinuxCNC's."""
    # The compile commands are gcc's: clang does not know all of its optimisations.
    known = "-extra-arg=-Wno-ignored-optimization-argument"
    start = ("tests/linux/test_uml.py", "tests/linux/test_linux_start.py")
    needs = ("build host", "build linux", "build linux-gpiod2")
    return [
        build("linux"),
        # The first time it builds the kernel, beside other steps.
        pytest("linux kernel", *start, "tests/linux/test_kernel.py", needs=needs),
        pytest("linux", "tests/linux/test_linux.py", needs=(*needs, "pytest linux kernel")),
        # The port's rooms are in the build host-asan, too; one file knows the version of libgpiod.
        clang_tidy("linux", r"hal/linux/[^/]*\.c", known),
        build("linux-gpiod2"),
        clang_tidy("linux-gpiod2", r"hal/linux/gpio_v2\.c", known),
        pytest("linuxcnc", "tests/linuxcnc", needs=("build host",)),
    ]


def board_steps() -> list[Step]:
    """Return what runs on emulated cores: tests, images, their bytes and cycles."""
    boards = ("mcu-qemu", "mcu-qemu-m4")
    built = tuple(f"build {board}" for board in boards)
    same = {board: ("checks.same_bytes", board, "test_budget") for board in boards}
    return [
        build("mcu-stm32h743"),
        # The flashable image in an emulator, compared with a program of the host build.
        pytest("stm32", "tests/stm32", needs=("build host", "build mcu-stm32h743"), wide=True),
        *(build(board) for board in boards),
        # Half of the time of each is one test, so the boards run side by side.
        *(ctest(board, wide=False) for board in boards),
        *(tool(f"same bytes {b}", *same[b], needs=(f"build {b}",)) for b in boards),
        pytest("figures", "tests/bench", needs=("build host", *(f"ctest {b}" for b in boards))),
        tool("cycles", "checks.cycles", BUILD, needs=built),
        pytest("pil", "tests/pil", needs=("build host", *built)),
    ]


def all_steps() -> list[Step]:
    """Return every step, in the order in which they begin as far as there is room.

    Builds come first, with checks that need none beside them; then what takes long.
    """
    steps = [build("host"), ctest("host"), browser_step()]
    steps += [*source_steps(), *linux_steps(), *host_steps(), *fuzz_steps(), *board_steps()]
    return sorted(steps, key=lambda step: not step.name.startswith("build "))


def main() -> int:
    """Run all steps, or with --fast the quick ones; return the exit status."""
    os.environ.setdefault("CTEST_OUTPUT_ON_FAILURE", "1")
    # Hundreds of commands in Python are started: without what it keeps of their modules, each of
    # them would compile them anew.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    steps = fast_steps() if "--fast" in sys.argv[1:] else all_steps()
    print(f"{len(steps)} steps, {N_CORES} at a time; build/steps holds what each says", flush=True)
    return Runner(steps, ROOT, BUILD / "steps", N_CORES).run()


if __name__ == "__main__":
    sys.exit(main())
