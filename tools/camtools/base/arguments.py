"""Command lines from functions: a parameter is an argument, its annotation says how it is read.

A parameter whose type is a dataclass stands for the fields of that class; one without an `Option`
or a `Word` is no argument. Types are str, int, float and Path, bool (a switch), `X | None`, and
`tuple[X, ...]` (repeatable).

>>> def greet(
...     name: Annotated[str, Word("whom", "NAME")], times: Annotated[int, Option("", "N")] = 1
... ) -> int:
...     '''Greet somebody.'''
...     print(" ".join([f"hello {name}"] * times))
...     return 0
>>> command("demo", greet)(["you", "--times", "2"])
hello you hello you
0
>>> positive("2.5"), not_negative("0"), finite("-1e3"), whole("-7")
(2.5, 0.0, -1000.0, -7)
"""

from __future__ import annotations

import argparse
import inspect
import math
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, is_dataclass
from pathlib import Path
from textwrap import fill
from types import NoneType
from typing import Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints

from camtools.base.command import Parser, run_command


@dataclass(frozen=True)
class Option:
    """An option of a command line: the name of its parameter after --."""

    help: str
    metavar: str | None = None
    short: str = ""  # as "-o"
    read: Callable[[str], Any] | None = None  # of a text; default: the type of the parameter
    choices: Sequence[Any] | None = None
    one_of: str = ""  # set of options that exclude each other; a name with ! demands a choice
    name: str = ""  # where it is not that of the parameter


class Word(Option):
    """A positional argument."""


class Words(NamedTuple):
    """Marks the parameter that takes words as they were typed: all, or those after --."""

    is_after_dashes: bool = False


class UsageError(Exception):
    """Arguments do not go together; the text says which, and what to do."""


class Group(NamedTuple):
    """A command that has commands of its own."""

    help: str
    commands: Commands


Function = Callable[..., Any]
Commands = Mapping[str, "Function | Group"]

PartFile = Annotated[Path, Word("part file", "PART.toml")]
Folder = Annotated[Path, Option("folder for the results", "DIR", "-o")]


class _Parameter(NamedTuple):
    name: str
    kind: Any  # without None; of a tuple, that of its members
    is_many: bool
    about: Option | None  # nothing for a dataclass
    default: Any


def _parameters(function: Function) -> Iterator[_Parameter]:
    """Return those parameters that are arguments."""
    hints = get_type_hints(function, include_extras=True)
    for name, parameter in inspect.signature(function).parameters.items():
        kind, *marks = get_args(hint) if get_origin(hint := hints[name]) is Annotated else (hint,)
        about = next((mark for mark in marks if isinstance(mark, Option)), None)
        if about is not None:
            is_many = get_origin(kind) is tuple
            kinds = [k for k in get_args(kind) if k not in (NoneType, ...)] or [kind]
            yield _Parameter(name, kinds[0], is_many, about, parameter.default)
        elif is_dataclass(kind):
            yield _Parameter(name, kind, False, None, parameter.default)


def option_of(name: str, about: Option | None = None) -> str:
    """Return the option of a parameter: --step-deg of step_deg."""
    return f"--{(about and about.name) or name.replace('_', '-')}"


def _add(parser: argparse.ArgumentParser, function: Function, sets: dict[str, Any]) -> None:
    for name, kind, is_many, about, default in _parameters(function):
        if about is None:
            _add(parser, kind, sets)
            continue
        is_needed = default is inspect.Parameter.empty
        settings: dict[str, Any] = {"help": about.help}
        if kind is bool:
            settings |= {"action": "store_true"}
        else:
            reader = about.read or (None if kind is str else kind)
            settings |= {"metavar": about.metavar, "type": reader, "choices": about.choices}
            settings["default"] = None if is_needed else default
        if isinstance(about, Word):
            if is_many or not is_needed:
                settings["nargs"] = "+" if is_many else "?"
            parser.add_argument(name, **settings)
            continue
        if is_many:
            settings |= {"action": "append", "default": []}
        where = parser
        if about.one_of:
            if about.one_of not in sets:
                is_required = about.one_of.endswith("!")
                sets[about.one_of] = parser.add_mutually_exclusive_group(required=is_required)
            where = sets[about.one_of]
        elif is_needed:
            settings["required"] = True
        names = [*([about.short] if about.short else []), option_of(name, about)]
        where.add_argument(*names, dest=name, **settings)


def _given(function: Function, found: argparse.Namespace) -> dict[str, Any]:
    """Return what was given for the parameters of a function."""
    given = {}
    for name, kind, is_many, about, _ in _parameters(function):
        if about is None:
            given[name] = kind(**_given(kind, found))
        else:
            value = getattr(found, name)
            given[name] = tuple(value) if is_many else value
    return given


def description_of(function: Function) -> str:
    """Return the text of a docstring, without its sections."""
    text = re.split(r"\n\n(Parameters|Returns|Raises)\n", inspect.cleandoc(function.__doc__ or ""))
    return " ".join(text[0].split())


def _add_commands(parser: argparse.ArgumentParser, commands: Commands, metavar: str) -> None:
    below = parser.add_subparsers(required=True, metavar=metavar)
    for name, command in commands.items():
        if isinstance(command, Group):
            _add_commands(below.add_parser(name, help=command.help), command.commands, "ACTION")
            continue
        text = description_of(command).removesuffix(".")
        child = below.add_parser(name, help=text[:1].lower() + text[1:])
        _add(child, command, {})
        child.set_defaults(chosen=command)


def make_parser(
    prog: str,
    function: Function,
    commands: Commands | None = None,
    **settings: Any,  # noqa: ANN401
) -> Parser:
    """Return the parser of a command whose arguments are a function's parameters."""
    settings = {"description": description_of(function), "allow_abbrev": False} | settings
    if "epilog" in settings:
        settings["description"] = fill(description_of(function))
        settings["formatter_class"] = argparse.RawDescriptionHelpFormatter
    parser = Parser(prog, **settings)
    _add(parser, function, {})
    if commands is not None:
        _add_commands(parser, commands, "COMMAND")
    return parser


def read_arguments(
    parser: Parser, function: Function, argv: Sequence[str] | None
) -> dict[str, Any]:
    """Return the arguments of a function from a command line.

    With commands, `chosen` is the function of the command that is given, with its arguments. Ends
    with status 2 and a line on what is wrong.
    """
    typed, words = list(sys.argv[1:] if argv is None else argv), {}
    after: list[str] = []
    for name, hint in get_type_hints(function, include_extras=True).items():
        marks = [mark for mark in get_args(hint)[1:] if isinstance(mark, Words)]
        if marks and marks[0].is_after_dashes and "--" in typed:
            after = typed[typed.index("--") + 1 :]
        if marks:
            words[name] = tuple(after if marks[0].is_after_dashes else typed)
    found = parser.parse_args(typed[: len(typed) - len(after) - bool(after)])
    try:
        given = _given(function, found) | words
        if hasattr(found, "chosen"):
            given["chosen"] = (found.chosen, _given(found.chosen, found))
    except UsageError as error:
        parser.error(str(error))
    return given


def command(
    prog: str,
    function: Callable[..., int],
    *,
    kept: str = "nothing was written",
    **settings: Any,  # noqa: ANN401
) -> Callable[..., int]:
    """Return the main function of a command: it takes a command line and gives the exit status.

    `prog` is the name as people start it. The function may raise CamtoolsError or UsageError.
    `kept` is what a signal leaves, for its line; settings are those of `make_parser`.
    """

    def main(argv: Sequence[str] | None = None) -> int:
        parser = make_parser(prog, function, **settings)

        def act() -> int:
            given = read_arguments(parser, function, argv)
            try:
                return function(**given)
            except UsageError as error:
                parser.error(str(error))

        return run_command(prog.removeprefix("tools/"), act, kept=kept)

    return main


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


def whole_within(low: int, high: int) -> Callable[[str], int]:
    """Return the reader of a whole number of a range."""

    def read(text: str) -> int:
        value = whole(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text}: give {low} .. {high}")
        return value

    return read
