"""A report: what it states of learning, its page, where a result comes from."""

import re
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from itertools import combinations, pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from matplotlib.figure import Figure

from camtools.base import project
from camtools.base.errors import CamtoolsError
from camtools.base.project import VERSION, Origin, command_text, date_text, origin_of, version_text
from camtools.base.quantities import Floats
from camtools.plots.style import drawing, png_of
from camtools.report import motion
from camtools.report.board import board_data, board_of
from camtools.report.kind_report import page_of as page_of_kind
from camtools.report.learning_text import learning_rows, numbers_text
from camtools.report.page import css_text, json_script, script_texts
from camtools.report.views import LEARNING, draw_convergence
from camtools.sim.results import STATES, AnyCut, CutTrace, GaugedSurface
from camtools.skirt.report.outcome import SkirtOutcome
from camtools.skirt.report.report import REPORT
from camtools.skirt.table.generate import GeneratedSkirt
from tests.tools.cases.page_cases import PageReader, map_of
from tests.tools.cases.report_cases import made_up_summary, made_up_surface, made_up_trace

LEARNED: dict[str, Any] = {
    "is_on": True,
    "phase": "cutting",
    "reason": "all",
    "turns": 40,
    "masked": [7, 8, 9, 16],
    "k1_ns": 7738,
    "k2_us2": -93638,
    "friction_nm": -120,
    "chip_nm_per_mm2": 34500,
    "begin_error_um": 10.05,
    "error_um": 0.043,
    "correction_um": 4.5,
    "ripple_turns": 16,
    "ripple_nturn": 187628,
    "harmonics": [],
}


def learned(**changes: Any) -> dict[str, Any]:  # noqa: ANN401
    """Return a summary with what was learned, some of it changed."""
    return turns([], []) | {"learning": LEARNED | changes}


def turns(rehearsed: list[float], cut: list[float]) -> dict[str, Any]:
    """Return a summary with the errors of turns; ten turns lie between the two."""
    states = ["rehearsing"] * len(rehearsed) + ["cutting"] * len(cut)
    begin = len(rehearsed) + (10 if rehearsed else 0)
    where = [*range(len(rehearsed)), *range(begin, begin + len(cut))]
    return made_up_summary(
        error_per_turn_um=rehearsed + cut, error_per_turn={"turn": where, "state": states}
    )


def learned_text(summary: dict[str, Any]) -> str:
    """Return the sentence of the summary."""
    return learning_rows(summary)[0].value


def test_what_was_learned_and_masked_is_told() -> None:
    """Turns, error at first and at last, constants, correction, ripple, masks."""
    told = learned_text(learned())
    assert told.startswith("on, 40 turns used: rms error at the scale 10.1 µm at first, 43 nm at")
    assert "k1 corrected by +7.738 µs, k2 by -0.0936 ms²; " in told
    assert "friction corrected by -120 nm, the chip's force learned as 34.5 µm/mm²" in told
    assert "ripple of 1179 µrad learned from 16 turns" in told
    assert told.endswith("harmonics masked: 7 .. 9, 16")
    assert learned_text(learned(masked=[])).endswith("no harmonic is masked")
    assert "the mean of U is not corrected" in learned_text(learned(masked=[0]))
    assert "did not converge" in learned_text(learned(reason="diverged"))
    assert "ripple" not in learned_text(learned(ripple_turns=0))


@pytest.mark.parametrize(
    ("reason", "named"),
    [
        ("not_asked", "off: learn_harmonics = 0"),
        ("not_measured", "off: the port does not measure U"),
        ("modulated", "off: the table modulates"),
        ("slow_turn", "off: a turn has more ticks"),
        ("fast_turn", "off: a turn has too few ticks"),
        ("no_table", "off: no table"),
        ("all", "set rehearse_turns"),
    ],
)
def test_why_nothing_was_learned_is_told(reason: str, named: str) -> None:
    """Every reason of the controller has its words."""
    assert named in learned_text(learned(is_on=False, reason=reason))


def test_no_learning_has_no_row_and_no_picture() -> None:
    """A controller on a bus does not say."""
    assert learning_rows(made_up_summary()) == []
    found = [made_up_summary(), turns([], [1.0]), turns([], [1.0, 2.0])]
    cuts = [cast(AnyCut, SimpleNamespace(summary=one)) for one in found]
    assert [LEARNING.when(cut) for cut in cuts] == [False, False, True]


STEADY = [1.0] * 100


@pytest.mark.parametrize(
    ("um", "changes", "cause"),
    [
        (
            [5.0, *STEADY],
            {"reason": "limited"},
            "of a correction at its limit; drive constants that match",
        ),
        ([5.0, *STEADY], {}, "of the first turns, elsewhere 1 µm; a longer feed_ramp_turns helps"),
        ([*STEADY, 5.0], {}, "of the last turns, elsewhere 1 µm; a longer feed_ramp_turns"),
        (STEADY, {"better_rpm": 2987.0}, "of encoder counts that do not average; 2987 r/min"),
        (STEADY, {"rms_not_turned": 0.1}, "an angle by which the whole part is turned, +300 µrad"),
        (STEADY, {"error_um": 0.9}, "seen by U's scale but not learned: friction"),
        (STEADY, {}, "not seen by U's scale: run-out"),
    ],
)
def test_what_remains_has_a_likely_cause(
    um: list[float], changes: dict[str, Any], cause: str
) -> None:
    """One cause for each kind of remaining error, in the order of their certainty."""
    form = {"max": max(um), "rms": 0.4, "rms_not_turned": 0.4, "turned_urad": 300.0}
    found = (
        turns([], um) | changes | {"form_error_um": form | changes, "learning": LEARNED | changes}
    )
    row = learning_rows(found)[1]
    assert row.name == "what remains"
    assert row.value.startswith(f"{max(um):g} µm, likely {cause}")


def ticks(figure: Figure) -> list[float]:
    """Return the numbers at the y axis that are seen."""
    axes = figure.axes[0]
    low, high = axes.get_ylim()
    return [t for t in axes.get_yticks() if low <= t <= high]


def test_picture_has_all_turns_and_honest_ticks() -> None:
    """No error is cut off, every 1, 2 and 5 is written out, the tolerance is a line."""
    rehearsed, cut = list(np.geomspace(54.0, 0.06, 30)), [0.5, 0.2, 0.1, 0.08]
    with drawing():
        figure = draw_convergence(turns(rehearsed, cut))
        assert png_of(figure)[:4] == b"\x89PNG"
    axes = figure.axes[0]
    drawn = np.concatenate([np.asarray(line.get_ydata()) for line in axes.lines[:2]])
    assert drawn == pytest.approx(rehearsed + cut)
    low, high = axes.get_ylim()
    assert low < 0.06 and high > 54.0
    assert axes.get_yscale() == "log"
    assert ticks(figure) == pytest.approx([0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100], rel=1e-9)
    written = [label.get_text() for label in axes.get_yticklabels()]
    assert {"0.05", "0.1", "50"} <= set(written)
    assert np.asarray(axes.lines[2].get_ydata()) == pytest.approx(5.0)  # of the form error
    names = {one.get_text() for one in axes.texts}
    assert {"rehearsal", "engage", "cut"} <= names
    assert any("tolerance 5 µm" in name for name in names)


def test_picture_of_many_turns_and_of_passes() -> None:
    """Names of narrow spans do not overlap; two rehearsals are two lines, 0 is the lower end."""
    with drawing():
        figure = draw_convergence(turns([2.0] * 30, [0.2] * 700))
        png_of(figure)
    boxes = [one.get_window_extent() for one in figure.axes[0].texts]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    one, two = turns([3.0, 2.0], [1.0, 0.0]), turns([3.0, 2.0], [1.0])
    both = one["error_per_turn"]["state"] + two["error_per_turn"]["state"]
    where = [*one["error_per_turn"]["turn"], *(t + 30 for t in two["error_per_turn"]["turn"])]
    summary = made_up_summary(
        error_per_turn_um=one["error_per_turn_um"] + two["error_per_turn_um"],
        error_per_turn={"turn": where, "state": both},
    )
    with drawing():
        assert len(draw_convergence(summary).axes[0].lines) == 5
        png_of(draw_convergence(turns([], [5.0, 5.0])))
        png_of(draw_convergence(turns([], [0.0, 0.0])))


def test_numbers_are_joined_to_ranges() -> None:
    """Two neighbours are no range."""
    assert numbers_text([]) == ""
    assert numbers_text([1, 2]) == "1, 2"
    assert numbers_text([1, 2, 3, 9]) == "1 .. 3, 9"


def test_sequence_has_a_colour_for_every_state() -> None:
    """A cut that rehearses is drawn like any other."""
    assert len(motion.STATE_COLOURS) == len(STATES)
    n = 90 * len(STATES)
    time_s: Floats = np.arange(n, dtype=np.float64) * 50e-6
    state = np.repeat(np.arange(len(STATES), dtype=np.float64), 90)
    zero = np.zeros(n)
    trace = CutTrace(time_s, time_s, zero, zero, zero, state, zero, zero, zero, zero)
    with drawing():
        assert png_of(motion.draw_sequence(trace))[:4] == b"\x89PNG"


PIXEL = b"\x89PNG\r\n\x1a\n"
HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"'`${x} & \u2028 é"
PICTURES = ("sequence",)


@pytest.fixture(scope="module")
def outcome(generated: GeneratedSkirt) -> SkirtOutcome:
    """Return a good cut with everything that is alive."""
    geometry = generated.geometry
    trace, surface = made_up_trace(geometry), made_up_surface(geometry)
    origin = Origin("2026-01-02 03:04 UTC", "v1-2-gabcdef0", "tools/run 'a part.toml'")
    return SkirtOutcome(generated, made_up_summary(), surface, trace, origin=origin)


def page_of(outcome: SkirtOutcome) -> str:
    """Return the page with pictures of nothing."""
    return page_of_kind(REPORT, outcome, dict.fromkeys(PICTURES, PIXEL))


@pytest.fixture(scope="module")
def page(outcome: SkirtOutcome) -> str:
    """Return the page of the good cut."""
    return page_of(outcome)


@pytest.fixture(scope="module")
def reader(page: str) -> PageReader:
    """Return the page, read."""
    return PageReader(page)


def test_page_has_what_others_stand_on(reader: PageReader) -> None:
    """The stable names of the template are there, each once, and no chart is without its place."""
    assert reader.all("html")[0].attributes["lang"] == "en"
    for name in ("verdict", "origin", "summary", "margins", "board", "height", "angle", "section"):
        reader.by_id(name)
    names = [one.attributes["id"] for one in reader.elements if "id" in one.attributes]
    assert len(names) == len(set(names))
    assert set(reader.data("figures")) <= set(names)
    assert {"error-map", "unrolled", "profile", "space", "motion", "following"} <= set(names)


def test_page_speaks(reader: PageReader, page: str) -> None:
    """Headings go down one level at a time, cells of heads have a scope, charts have words.

    Controls have labels. The head has date, version, command line, machine and seed.
    """
    levels = [int(one.tag[1]) for one in reader.elements if re.fullmatch("h[1-6]", one.tag)]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))
    assert all(one.attributes.get("scope") in ("row", "col") for one in reader.all("th"))
    alts = [one.attributes["alt"] for one in reader.all("img")]
    assert all(len(alt.split()) >= 2 for alt in alts)
    live = [one for one in reader.elements if one.attributes.get("class") == "live"]
    assert len(live) == 7
    assert all(one.attributes["aria-label"] for one in live)
    labelled = {one.attributes["for"] for one in reader.all("label")}
    controls = [one for tag in ("input", "select") for one in reader.all(tag)]
    assert {one.attributes["id"] for one in controls} == labelled
    assert all("".join(one.text).strip() for one in reader.all("button"))
    head = page[: page.index("Can the machine do it?")]
    for words in ("2026-01-02 03:04 UTC, version v1-2-gabcdef0", "default, seed 1"):
        assert words in head
    assert "tools/run &#39;a part.toml&#39;" in head
    assert css_text("perkins240: within tolerance") in head


def worst_by_cell(
    surface: GaugedSurface, z_mm: tuple[float, float], shape: tuple[int, int]
) -> dict[tuple[int, int], int]:
    """Return the point with the largest error of each cell, by going through them one by one."""
    worst: dict[tuple[int, int], int] = {}
    low, high = z_mm
    for i, (turn, z, _, error) in enumerate(zip(*(one.tolist() for one in surface), strict=True)):
        row = min(shape[0] - 1, int((z - low) / (high - low) * shape[0]))
        cell = row, min(shape[1] - 1, int(turn * shape[1]))
        if cell not in worst or abs(error) >= abs(surface.error_um[worst[cell]]):
            worst[cell] = i
    return worst


def test_map_of_the_page_is_the_surface() -> None:
    """Error, radius and angle of each cell are those of its worst point, within the rounding."""
    rng = np.random.default_rng(17)
    n = 30_000
    error_um = rng.normal(0, 0.05, n)
    error_um[1234] = -0.73  # must survive the thinning
    surface = GaugedSurface(rng.random(n), rng.uniform(0, 4, n), 46 - rng.random(n), error_um)
    board = board_of(surface, (0.0, 4.0), 0.1, 0.2)
    assert board is not None and board.start == (
        int(surface.z_mm[1234] / 4 * 32),
        int(surface.turn[1234] * 360),
    )
    held = map_of(board_data(board))
    assert np.nanmin(held.error_um) == pytest.approx(-0.73, rel=1e-12)
    worst = worst_by_cell(surface, (0.0, 4.0), (32, 360))
    assert np.isfinite(held.error_um).sum() == len(worst) < 32 * 360
    for cell, i in worst.items():
        assert held.error_um[cell] == pytest.approx(error_um[i], abs=0.73 / 65534 * 1.001)
        assert held.radius_mm[cell] == pytest.approx(surface.radius_mm[i], abs=2e-6)
        assert held.turn[cell] == pytest.approx(surface.turn[i], abs=1 / 360 / 65536)


def test_page_holds_the_map_and_is_the_same_twice(
    reader: PageReader, outcome: SkirtOutcome, page: str
) -> None:
    """With the largest error that the summary states; below 7 MB without its pictures."""
    held = map_of(reader.data("part-data"))
    assert held.error_um.shape == (256, 360)
    largest_um = outcome.summary["form_error_um"]["max"]
    assert np.nanmax(np.abs(held.error_um)) == pytest.approx(largest_um, rel=1e-3)
    heat = reader.data("figures")["error-map"]["data"][0]
    assert heat["zmax"] == -heat["zmin"] >= largest_um
    again = page_of(replace(outcome, surface=made_up_surface(outcome.generated.geometry)))
    assert again == page
    assert len(page) < 7e6
    assert "computing time" not in page


def test_cut_without_error_and_without_surface(outcome: SkirtOutcome) -> None:
    """An exact surface does not break a scale; without a surface there is no board."""
    exact = outcome.surface._replace(error_um=np.zeros(outcome.surface.turn.size))
    held = map_of(PageReader(page_of(replace(outcome, surface=exact))).data("part-data"))
    assert not held.error_um.any()
    summary = made_up_summary(form_error_um={"max": None, "rms": None, "tolerance": 5.0})
    nothing, none = GaugedSurface(*np.empty((4, 0))), CutTrace(*np.empty((10, 0)))
    bare = PageReader(page_of(replace(outcome, summary=summary, surface=nothing, trace=none)))
    assert bare.data("part-data") == {}
    assert list(bare.data("figures")) == ["motion"]


def test_hostile_words_stay_words(outcome: SkirtOutcome) -> None:
    """Source, machine, command line and names of faults are shown and never executed."""
    info = outcome.generated.part.part.model_copy(update={"source": HOSTILE, "name": HOSTILE})
    part = outcome.generated.part.model_copy(update={"part": info})
    generated = GeneratedSkirt(**(vars(outcome.generated) | {"part": part}))
    summary = made_up_summary(
        machine=HOSTILE, injected=[{"kind": HOSTILE, "at_s": 1, "happened": 1}]
    )
    origin = Origin(HOSTILE, HOSTILE, HOSTILE)
    page = page_of(replace(outcome, generated=generated, summary=summary, origin=origin))
    reader = PageReader(page)
    kinds = [one.attributes.get("type", "ours") for one in reader.all("script")]
    assert kinds == ["application/json", "application/json", "ours", "ours"]
    assert not any(name.startswith("on") for one in reader.elements for name in one.attributes)
    assert "".join(reader.all("h1")[0].text) == HOSTILE
    style = "".join("".join(one.text) for one in reader.all("style"))
    assert "alert(" not in style and "</" not in style
    assert "alert(1)" not in re.sub(r"&lt;script&gt;alert\(1\)", "", page)


def test_nothing_is_fetched_or_run_but_its_own(page: str, reader: PageReader) -> None:
    """Two scripts by their hashes, pictures in the page itself, and nothing else."""
    heads = [one.attributes for one in reader.all("meta")]
    [policy] = [one["content"] for one in heads if one.get("http-equiv", "").endswith("Policy")]
    scripts = ["".join(one.text) for one in reader.all("script") if "type" not in one.attributes]
    digests = [b64encode(sha256(one.encode()).digest()).decode() for one in scripts]
    allowed = re.search("script-src ([^;]*);", policy)
    assert allowed and allowed[1] == " ".join(f"'sha256-{one}'" for one in digests)
    assert "default-src 'none'" in policy and "unsafe-eval" not in policy
    assert "connect-src" not in policy and "http" not in policy
    assert scripts[1] == script_texts()[1] and "eval" not in scripts[1]
    fetching = {"src", "href", "srcset", "data", "action", "poster"}
    pairs = [pair for one in reader.elements for pair in one.attributes.items()]
    addresses = [value for name, value in pairs if name in fetching]
    assert len(addresses) == len(PICTURES)
    assert all(value.startswith("data:image/png;base64,") for value in addresses)
    assert not set(json_script({"<!--": HOSTILE})) & set("<>&\u2028")
    assert not re.search(r"url\(|@import", "".join("".join(s.text) for s in reader.all("style")))


def test_date_is_that_of_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """SOURCE_DATE_EPOCH fixes the date, whatever the zone; other words are refused."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    monkeypatch.setenv("TZ", "Asia/Tokyo")
    assert date_text() == "2023-11-14 22:13 UTC"
    for wrong in ("tomorrow", "", "1e9", "9" * 30):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", wrong)
        with pytest.raises(CamtoolsError, match=r"SOURCE_DATE_EPOCH = .*: not a time; give whole"):
            date_text()
    monkeypatch.delenv("SOURCE_DATE_EPOCH")
    assert date_text()[:2] == "20"


def test_version_without_git_is_said(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A project that was copied without its history does not invent a version."""
    monkeypatch.setattr(project, "ROOT", tmp_path)
    assert version_text() == VERSION
    (tmp_path / ".git").touch()
    assert version_text() == "unknown (git cannot tell)"
    monkeypatch.setenv("PATH", "")
    assert version_text() == "unknown (git cannot be run)"


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ((), "tools/run"),
        (("a.toml", "-o", "out", "--rpm", "9"), "tools/run a.toml --rpm 9"),
        (("--output=x", "it's.toml"), "tools/run 'it'\"'\"'s.toml'"),
        (("-o", "-o", "a.toml"), "tools/run a.toml"),
        (("-o", "x", "--", "-o", "7"), "tools/run -- -o 7"),
    ],
)
def test_command_is_told_without_the_folder(words: tuple[str, ...], text: str) -> None:
    """Where the results go does not change them, and tells of the computer they were made on."""
    assert command_text("tools/run", words) == text
    assert origin_of("tools/run", words).command == text
