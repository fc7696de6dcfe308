"""What files cite lies in the repository: equations of MATHS.md, documents, headings, tests."""

import re
import subprocess
from functools import cache
from urllib.parse import unquote

import pytest

from tests.tools.cases.part_cases import ROOT

MATHS = "tools/docs/MATHS.md"
OWN = "tests/tools/test_citations.py"
_RUN = (
    r"\(\d+\)(?:[\s/#*]*(?:,|\.\.|and)[\s/#*]*\(\d+\))*"  # (1), (3) .. (5), over lines of comment
)
CITATION = re.compile(rf"MATHS\.md[\s/#*]+({_RUN})")
WITHIN = re.compile(rf"equations? ({_RUN})")
ENTRY = re.compile(r"^\*\*\((\d+)\)\*\*", re.MULTILINE)
DOCUMENT = re.compile(r"(?<![\w.*{}/-])((?:[\w.-]+/)*[\w-]+\.md)\b(?!\.?\w)")
LINK = re.compile(r"!?\[[^\]]*\]\(([^()\s]+)\)")
INLINE = re.compile(r"\$([^$]*)\$")
WRITTEN = {"notes.md", "refit_notes.md", "papers.md"}  # by tools/analyse and tools/papers


@cache
def texts() -> dict[str, str]:
    """Return every text file of the repository by its path, as git lists them."""
    command = ["git", "ls-files", "-co", "--exclude-standard", "-z"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    found: dict[str, str] = {}
    for name in filter(None, listed.stdout.split("\0")):
        path = ROOT / name
        if path.is_file() and not path.is_symlink() and b"\0" not in (data := path.read_bytes()):
            found[name] = data.decode("utf-8", errors="replace")
    return found


def numbers(run: str) -> set[int]:
    """Return the equations that a run of numbers names.

    >>> sorted(numbers("(2), (4) .. (6) and (9)"))
    [2, 4, 5, 6, 9]
    """
    words = re.findall(r"\d+|\.\.", run)
    named: set[int] = set()
    for before, word in zip(["", *words], words, strict=False):
        if word == "..":
            continue
        named.add(int(word))
        if before == "..":
            named |= set(range(max(n for n in named if n < int(word)), int(word)))
    return named


def cited(text: str, pattern: re.Pattern[str] = CITATION) -> set[int]:
    """Return the equations that a text cites."""
    return set().union(*(numbers(run) for run in pattern.findall(text)))


def entries() -> dict[int, str]:
    """Return the text of each equation, up to the next one."""
    parts = ENTRY.split(texts()[MATHS])
    return {int(n): text for n, text in zip(parts[1::2], parts[2::2], strict=True)}


def test_equations_are_numbered_in_order() -> None:
    """Rising, each once, so that a citation has one meaning."""
    found = [int(n) for n in ENTRY.findall(texts()[MATHS])]
    assert found == sorted(set(found))


def test_cited_equations_exist() -> None:
    """Every number that any file cites stands in the document, and its own references, too."""
    known = set(entries())
    stray = {
        name: sorted(cited(text) - known) for name, text in texts().items() if cited(text) - known
    }
    assert stray == {}
    assert cited(texts()[MATHS], WITHIN) <= known


def test_equations_are_needed() -> None:
    """The product cites each equation, or an equation that is needed refers to it."""
    outside = ("tests/", "tools/docs/", "tools/parts/")
    code = [
        text
        for name, text in texts().items()
        if not name.startswith(outside) and not name.endswith(".md")
    ]
    needed = set().union(*(cited(text) for text in code))
    todo, known = list(needed), entries()
    while todo:
        more = cited(known[todo.pop()], WITHIN) - needed
        needed |= more
        todo += more
    assert sorted(set(known) - needed) == []


def test_tests_that_are_named_exist() -> None:
    """The tests that assert the worked numbers are there, and their names mean one file each."""
    named = set(re.findall(r"`([\w/-]+\.(?:py|c|toml))`", texts()[MATHS]))
    found = {name: [one for one in texts() if f"/{one}".endswith(f"/{name}")] for name in named}
    assert len(named) > 10
    assert {name: files for name, files in found.items() if len(files) != 1} == {}


def test_documents_that_are_named_exist() -> None:
    """No file names a document that is not in the repository, by its name or by its path."""
    documents = {name for name in texts() if name.endswith(".md")}
    stray = [
        f"{name}: {found}"
        for name, text in texts().items()
        if name != OWN
        for found in DOCUMENT.findall(text)
        if found.rpartition("/")[2] not in WRITTEN
        and not any(f"/{one}".endswith(f"/{found}") for one in documents)
        if not (ROOT / name).parent.joinpath(found).is_file()
    ]
    assert stray == []


def slugs(text: str) -> set[str]:
    r"""Return the anchors of a document's headings as GitHub makes them.

    >>> sorted(slugs("# C-X-Z: `a_b`, c\n## Twice\n## Twice"))
    ['c-x-z-a_b-c', 'twice', 'twice-1']
    """
    found: set[str] = set()
    for title in re.findall(
        r"^#+ +(.+?) *#*$", re.sub(r"(?ms)^```.*?^```", "", text), re.MULTILINE
    ):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title)
        slug = re.sub(r"[^\w\- ]", "", plain.lower()).replace(" ", "-")
        copies = sum(1 for one in found if re.fullmatch(rf"{re.escape(slug)}(-\d+)?", one))
        found.add(f"{slug}-{copies}" if copies else slug)
    return found


@pytest.mark.parametrize("name", sorted(name for name in texts() if name.endswith(".md")))
def test_links_resolve(name: str) -> None:
    """Relative links lead to files of the repository, and their anchors to headings there."""
    text = re.sub(r"(?ms)^```.*?^```", "", texts()[name])
    for target in LINK.findall(text):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = unquote(target).partition("#")
        place = (ROOT / name).parent.joinpath(path).resolve() if path else ROOT / name
        assert place.exists(), f"{target} leads nowhere"
        if anchor:
            assert anchor in slugs(place.read_text(encoding="utf-8")), f"{target}: no such heading"


def test_maths_renders() -> None:
    """Braces and fences pair up, and inline formulas have nothing that Markdown would eat."""
    text = texts()[MATHS]
    blocks = re.findall(r"(?ms)^```math\n(.*?)^```$", text)
    assert len(blocks) == len(entries()) == text.count("```") // 2
    outside = re.sub(r"(?ms)^```.*?^```", "", text)
    inline = INLINE.findall(outside)
    assert "$" not in INLINE.sub("", outside)
    for formula in [*blocks, *inline]:
        assert formula.count("{") == formula.count("}"), formula
        assert len(re.findall(r"\\left\b", formula)) == len(re.findall(r"\\right\b", formula)), (
            formula
        )
    for formula in inline:
        assert formula == formula.strip(), formula
        assert "\n" not in formula, formula
        assert not re.search(r"\\[\\{},;!*_]", formula), formula
    glued = re.search(r"\w\x02|\x02\w", INLINE.sub("\x02", outside))
    assert glued is None, outside[glued.start() - 40 : glued.end() + 40]
