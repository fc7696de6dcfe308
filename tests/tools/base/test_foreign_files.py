"""A part file from somebody else names any file; an error about that one does not show it."""

from collections.abc import Callable

import pytest

from camtools.base.errors import InputError
from camtools.lobe.lift import CSV_HEADER
from camtools.lobe.lift import parse_points as parse_lift
from camtools.measured.points import HEADER as GAUGED_HEADER
from camtools.measured.points import parse_points as parse_gauged
from camtools.skirt.geometry.scan import HEADER as SCAN_HEADER
from camtools.skirt.geometry.scan import parse_sections
from camtools.table.points import parse_points

READERS: dict[str, tuple[Callable[[str, str], object], str]] = {
    "scan": (parse_sections, SCAN_HEADER),
    "points": (parse_points, "X_deg,Y_mm"),
    "lift": (parse_lift, CSV_HEADER),
    "gauged": (parse_gauged, GAUGED_HEADER),
}
SECRET = "operator,hunter2,7031"


@pytest.mark.parametrize("name", list(READERS))
def test_no_word_of_a_foreign_file_is_shown(name: str) -> None:
    """Neither as a header, nor behind a good one, with or without numbers."""
    read, header = READERS[name]
    for text in (SECRET, f"{header}\n{SECRET}", f"7031 4711 12\n{SECRET}", f"{header}\n1,2,x"):
        with pytest.raises(InputError) as info:
            read(text, "given.csv")
        said = info.value.lines[0]
        assert said.startswith("given.csv: ") and ";" in said
        assert not any(word in said for word in ("operator", "hunter2", "7031", "4711", "x'"))


@pytest.mark.parametrize("name", list(READERS))
def test_numbers_of_a_file_of_numbers_are_shown(name: str) -> None:
    """Whoever mistypes a number finds it again."""
    read, header = READERS[name]
    with pytest.raises(InputError, match=r"line 2 = '1 2 3 4 5\.5"):
        read(f"{header}\n1 2 3 4 5.5", "given.csv")
