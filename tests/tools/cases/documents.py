"""The commands of the documents: lines of their blocks, and code within the text."""

import re
import shlex
from collections.abc import Iterator
from itertools import groupby
from typing import NamedTuple

_OF_SHELLS = "cd cp cut echo export kill mkdir sed sleep sudo"
_OF_OTHERS = "caddy cantools cmake cpack ctest dask journalctl make pip python3 ssh"
_OF_MACHINES = "camctl camsim candump cansend halcmd linuxcnc openocd pyocd st-flash"
PROGRAMS = frozenset(f"{_OF_SHELLS} {_OF_OTHERS} {_OF_MACHINES}".split())
_FOLDERS = ("tools/", "tests/", "build/", "hal/")
_PREFIX = re.compile(r"[(\s]*(?:\w+=\S*\s+)*[(\s]*")  # settings, and the begin of a subshell
_NOTE = re.compile(r"\s#(?:\s.*)?$")
_FENCE = re.compile(r"\s*```(\w*)$")
_INLINE = re.compile(r"`([^`\n]+(?:\n[^`\n]+)?)`")


class Documented(NamedTuple):
    """A simple command, without settings before it and redirections."""

    page: str
    line: int
    words: tuple[str, ...]
    is_inline: bool  # within the text; it may be incomplete

    def __str__(self) -> str:
        return f"{self.page}:{self.line}: {shlex.join(self.words)}"


class Block(NamedTuple):
    """Lines of a page that stand alone, without their indentation."""

    line: int  # number of the first one
    lines: list[str]
    language: str  # of a fence


def blocks_of(text: str) -> Iterator[Block]:
    """Return the indented blocks of a page and those in fences; blank lines divide the former."""
    fence, marked = None, []
    for number, line in enumerate(text.splitlines(), start=1):
        mark = _FENCE.fullmatch(line)
        is_mark = mark is not None
        if mark is not None:
            fence = f"{number} {mark[1]}" if fence is None else None
        is_code = not is_mark and (fence is not None or line.startswith("    "))
        marked.append((fence if is_code else None, is_code and bool(line.strip()), number, line))
    for (kind, is_code), group in groupby(marked, key=lambda one: (one[0], one[1])):
        if is_code:
            rows = list(group)
            language = kind.partition(" ")[2] if kind else ""
            yield Block(rows[0][2], [line.strip() for *_, line in rows], language)


def is_command(line: str) -> bool:
    """Return whether a line begins with a program of the repository or of PROGRAMS."""
    first = _PREFIX.sub("", line, count=1).split(maxsplit=1)
    return bool(first) and (first[0] in PROGRAMS or first[0].startswith(_FOLDERS))


def _simple(text: str) -> Iterator[tuple[str, ...]]:
    """Return the words of each simple command; brackets of what may be left out are dropped."""
    lexer = shlex.shlex(text, posix=True, punctuation_chars=True)
    lexer.whitespace_split, lexer.commenters = True, ""
    words: list[str] = []
    drops = False
    for word in [*lexer, ";"]:
        if set(word) <= set("<>"):
            drops = True
        elif set(word) <= set("();|&"):
            if words:
                yield tuple(words)
            words = []
        elif drops or (not words and re.fullmatch(r"\w+=.*", word)):
            drops = False
        elif plain := word.strip("[]").removesuffix(".."):
            words.append(plain)


def _whole(block: Block) -> Iterator[tuple[int, str]]:
    """Return the commands of a block, those on several lines as one."""
    begun, first = "", block.line
    for number, line in enumerate(block.lines, start=block.line):
        first = first if begun else number
        begun += _NOTE.sub("", line)
        if begun.endswith("\\"):
            begun = begun[:-1]
        elif begun.count("'") % 2 == 0:
            yield first, begun
            begun = ""
        else:
            begun += "\n"


def files_of(text: str) -> dict[str, str]:
    """Return the TOML files that a page prints, by the names that stand in the line above."""
    return dict(
        re.findall(r"`([\w-]+\.toml)`[^`\n]*\n\n```toml\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    )


def commands_of(page: str, text: str) -> Iterator[Documented]:
    """Return the commands of a page."""
    for block in blocks_of(text):
        if not block.language and any(map(is_command, block.lines)):
            for line, whole in _whole(block):
                for words in _simple(whole):
                    yield Documented(page, line, words, is_inline=False)
    without = re.sub(r"(?ms)^```.*?^```", lambda found: "\n" * found[0].count("\n"), text)
    for code in _INLINE.finditer(without):
        if is_command(code[1]) and (" " in code[1] or code[1].startswith("tools/")):
            line = without.count("\n", 0, code.start()) + 1
            for words in _simple(code[1].replace("\\|", " ")):
                yield Documented(page, line, words, is_inline=True)
