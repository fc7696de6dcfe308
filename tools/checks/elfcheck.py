"""Command line of the checks of an ARM image: its interrupt, its sizes.

>>> _arguments(["isr", "firmware.elf", "--stack-limit", "800"]).stack_limit
800
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from camtools.base.command import Parser, run_command
from camtools.base.errors import CamtoolsError, InputError
from camtools.base.files import write_all
from checks.elf_image import PREFIX, Image
from checks.elf_isr import IsrReport, examine, load_bounds
from checks.elf_sizes import compare, emit_sizes, measure, parse_sizes, table

FAILED = 1
STACK_LIMIT_BYTES = 640


def _isr_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--root", default="cam_isr", metavar="SYMBOL", help="of the interrupt, default cam_isr")
    loops = "why loops end, by function; repeatable"
    add("--loops", type=Path, action="append", default=[], metavar="TOML", help=loops)
    limit = f"entry of the interrupt included, default {STACK_LIMIT_BYTES}"
    add("--stack-limit", type=int, default=STACK_LIMIT_BYTES, metavar="BYTES", help=limit)


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = Parser(prog="tools/elfcheck", description="Check an ARM image.", allow_abbrev=False)
    commands = parser.add_subparsers(dest="command", required=True, metavar="isr | sizes")
    isr = commands.add_parser("isr", help="what the interrupt can reach and take")
    sizes = commands.add_parser("sizes", help="bytes of every module")
    for command in (isr, sizes):
        command.add_argument("image", type=Path, metavar="IMAGE.elf")
        folders = "folder of our sources; all code of the interrupt comes from them; repeatable"
        command.add_argument("--source", action="append", default=[], metavar="DIR", help=folders)
        command.add_argument("--prefix", default=PREFIX, help=f"of the binary utilities: {PREFIX}")
    _isr_arguments(isr)
    add = sizes.add_argument
    add("--recorded", type=Path, required=True, metavar="TOML", help="recorded sizes")
    add("--build", required=True, metavar="NAME", help="whose sizes, a name in the record")
    add("--record", action="store_true", help="write the sizes into the record")
    return parser.parse_args(argv)


def _read(path: Path) -> str:
    try:
        return path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), "", None, "cannot be read", "give another file") from error


def _print_isr(report: IsrReport) -> None:
    print(f"{'stack, callees included':42} bytes  (own)")
    for function in report.functions:
        print(f"{function.name:42} {function.stack_bytes:>5} {function.own_bytes:>6}")
    for loop in report.loops:
        print(f"loop: {loop}")


def _check_isr(arguments: argparse.Namespace) -> int:
    image = Image(arguments.image, arguments.prefix)
    bounds = {name: why for path in arguments.loops for name, why in load_bounds(path).items()}
    report = examine(image, arguments.root, bounds, arguments.source)
    _print_isr(report)
    entry = f"{report.entry_bytes} of them for the interrupt's entry"
    print(f"isr-stack {report.stack_bytes} bytes, {entry}, limit {arguments.stack_limit}")
    failures = list(report.problems)
    if report.stack_bytes > arguments.stack_limit:
        failures.append(f"{report.stack_bytes} bytes of stack, limit {arguments.stack_limit}")
    for name in sorted(bounds.keys() - report.bounds_used):
        print(f"note: no loop of {name} is reached, its bound is not needed here")
    for failure in failures:
        print(f"FAILED: {failure}", file=sys.stderr)
    return FAILED if failures else 0


def _check_sizes(arguments: argparse.Namespace) -> int:
    sizes = measure(Image(arguments.image, arguments.prefix), arguments.source)
    if not sizes:
        remedy = "build with -g, and name the folders with --source"
        raise CamtoolsError([f"{arguments.image}: no module of our sources in it; {remedy}"])
    print(table(sizes))
    if arguments.record:
        path = arguments.recorded
        builds = parse_sizes(str(path), _read(path)) if path.exists() else {}
        text = emit_sizes(builds | {arguments.build: sizes})
        write_all(path.parent, {path.name: text.encode()})
        return 0
    builds = parse_sizes(str(arguments.recorded), _read(arguments.recorded))
    if arguments.build not in builds:
        remedy = "record it with --record"
        raise InputError(str(arguments.recorded), arguments.build, None, "not there", remedy)
    changes = compare(sizes, builds[arguments.build])
    for change in changes:
        print(f"{'FAILED' if change.is_growth else 'smaller'}: {change}")
    if changes:
        folders = " ".join(f"--source {folder}" for folder in arguments.source)
        where = f"--recorded {arguments.recorded} --build {arguments.build}"
        print(f"to record anew: tools/elfcheck sizes {arguments.image} {folders} {where} --record")
    return FAILED if any(change.is_growth for change in changes) else 0


def main(argv: list[str] | None = None) -> int:
    """Run a check; 0 it holds, 1 it does not, 2 wrong usage or unreadable input."""
    arguments = _arguments(argv)
    check = {"isr": _check_isr, "sizes": _check_sizes}[arguments.command]
    return run_command("elfcheck", lambda: check(arguments))


if __name__ == "__main__":
    sys.exit(main())
