"""What a part file may not do on the page: read other files, have hostile names, hide faults."""

import json
from pathlib import Path

import pytest

from camtools.base.errors import CamtoolsError
from camtools.panel.design.part_library import EXAMPLE, OWN, PartLibrary
from camtools.part.model import files_named, is_inside
from tests.tools.cases.preview_cases import PARTS, answers, problems, text_of

LEAVING = (
    *("/etc/passwd", "../secret.csv", "sub/../../secret.csv", "link.csv", "dir/secret.csv"),
    "{folder}/scan90.csv",  # a run of it would write its copy of the file over the file itself
    "a\0b.csv",
)
# They lead back into the folder, but not from the folder of a run, to which the part is copied.
ROUND = ("../parts/scan90.csv", "sub/../scan90.csv")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder of parts with a secret beside it, and links to that."""
    place = tmp_path / "parts"
    place.mkdir()
    (tmp_path / "secret.csv").write_text("angle_deg,z_mm,reduction_um\n0,0,4711\n")
    (place / "link.csv").symlink_to(tmp_path / "secret.csv")
    (place / "dir").symlink_to(tmp_path)
    (place / "scan90.csv").write_bytes((PARTS / "scan90.csv").read_bytes())
    return place


@pytest.mark.parametrize("path", [*LEAVING, *ROUND])
def test_a_path_that_leaves_the_folder_is_refused(path: str, folder: Path) -> None:
    """By whatever way; the line names the field and the remedy, and nothing of the file."""
    path = path.format(folder=folder)
    text = text_of("scan90").replace('"scan90.csv"', json.dumps(path))
    found = answers(text, folder)
    [line] = problems(found)
    assert line.startswith("piston.section.csv")
    assert "leads out of the folder" in line
    assert "4711" not in str(found)
    assert not is_inside(path, folder)


def test_cams_and_lists_of_files_are_confined_too(folder: Path) -> None:
    """Every place where a part file names a file."""
    lobe = text_of("cam-345").replace('law = "poly345"', 'law = "list"\ncsv = "../secret.csv"')
    assert any("leads out of the folder" in line for line in problems(answers(lobe, folder)))
    points = text_of("scan90").replace('shape = "table"', 'shape = "points"')
    points = points.replace('csv = "scan90.csv"', "").replace("harmonics = 15", "")
    points += '[[piston.section.files]]\nz_mm = 0\ncsv = "link.csv"\n'
    points += '[[piston.section.files]]\nz_mm = 60\ncsv = "scan90.csv"\n'
    assert any("leads out of the folder" in line for line in problems(answers(points, folder)))


def test_a_file_beside_the_part_is_read(folder: Path) -> None:
    """What lies in the folder is no foreign file, and goes along with a run."""
    assert problems(answers(text_of("scan90"), folder)) == []
    tree = {"piston": {"section": {"csv": "scan90.csv"}}}
    assert files_named(tree) == ["scan90.csv"]
    assert is_inside("scan90.csv", folder)


@pytest.mark.parametrize(
    ("change", "field", "told"),
    [
        (("feed_mm = 0.1 ", "feed_mm = 0 "), "process.feed_mm", "give at least"),
        (("spindle_rpm = 2500", "spindel_rpm = 2500"), "process.spindel_rpm", "spelling"),
        (('shape = "ellipse"', 'shape = "elipse"'), "piston.section.shape", "use one of"),
        (("0.15, 0.20, 0.30", "0.15, 0.20"), "piston.ovality.ovality_mm", "one value for each"),
        (("feed_mm = 0.1 ", "feed_mm = = 0.1 "), "", "not TOML"),
    ],
)
def test_a_wrong_field_is_told_with_its_line(
    change: tuple[str, str], field: str, told: str
) -> None:
    """Place, value and remedy; the line is that of the key, or where the parser stopped."""
    text = text_of("perkins240").replace(*change)
    wrong = [one for answer in answers(text) for one in answer.get("problems", [])]
    one = next(problem for problem in wrong if problem["field"] == field)
    assert told in one["text"]
    line = text.splitlines()[one["line"] - 1]
    assert line.startswith(field.rsplit(".", 1)[-1]) and (field or "= =" in line)


@pytest.mark.parametrize(
    "name",
    ["", ".", "..", "../a", "a/b", "a\\b", "-a", "a b", "a\n", "ä", "a" * 32, "a.toml", "\x00"],
)
def test_hostile_names_are_refused(name: str, tmp_path: Path) -> None:
    """Nothing is written or read under them, inside the folder or outside."""
    library = PartLibrary(tmp_path / "parts")
    with pytest.raises(CamtoolsError, match="not usable"):
        library.save(name, "x", replaces=True)
    with pytest.raises(CamtoolsError, match="not usable"):
        library.read(OWN, name)
    assert list(tmp_path.rglob("*")) == []


def test_nothing_is_overwritten_unasked(tmp_path: Path) -> None:
    """A second part of a name needs a yes, and a link is never followed."""
    library = PartLibrary(tmp_path / "parts")
    library.save("a", "one", replaces=False)
    with pytest.raises(CamtoolsError, match="this part exists"):
        library.save("a", "two", replaces=False)
    assert library.read(OWN, "a") == "one"
    library.save("a", "two", replaces=True)
    assert library.read(OWN, "a") == "two"
    (tmp_path / "target").write_text("mine")
    (tmp_path / "parts" / "b.toml").symlink_to(tmp_path / "target")
    with pytest.raises(CamtoolsError, match="link"):
        library.save("b", "theirs", replaces=True)
    with pytest.raises(CamtoolsError, match="link"):
        library.read(OWN, "b")
    assert (tmp_path / "target").read_text() == "mine"
    assert library.own() == ["a"]


def test_examples_are_read_only(tmp_path: Path) -> None:
    """They are read where they lie, and saved among one's own."""
    library = PartLibrary(tmp_path)
    assert "perkins240" in library.examples()
    assert library.read(EXAMPLE, "perkins240") == text_of("perkins240")
    library.save("perkins240", "mine", replaces=False)
    assert text_of("perkins240") != "mine"
