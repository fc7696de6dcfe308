# SPDX-License-Identifier: Apache-2.0
"""The page of a report: its structure, the numbers it holds, and what must never happen in it."""

import re
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from itertools import pairwise

import numpy as np
import pytest

from camtools.base.provenance import Origin
from camtools.report.board import board_data, board_of
from camtools.report.page_scripts import css_text, json_script, script_texts
from camtools.sim.results import CutTrace, GaugedSurface
from camtools.skirt.report.outcome import SkirtOutcome
from camtools.skirt.report.page import render
from camtools.skirt.table.generate import GeneratedSkirt
from tests.tools.cases.page_cases import PageReader, map_of
from tests.tools.cases.report_cases import made_up_summary, made_up_surface, made_up_trace

PIXEL = b"\x89PNG\r\n\x1a\n"
HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"'`${x} & \u2028 é"
PICTURES = ("map", "sections", "height", "skirt", "motion", "following", "sequence")


@pytest.fixture(scope="module")
def outcome(generated: GeneratedSkirt) -> SkirtOutcome:
    """Return a good cut with everything that is alive."""
    geometry = generated.geometry
    trace, surface = made_up_trace(geometry), made_up_surface(geometry)
    origin = Origin("2026-01-02 03:04 UTC", "v1-2-gabcdef0", "tools/run 'a part.toml'")
    return SkirtOutcome(generated, made_up_summary(), surface, trace, origin=origin)


def page_of(outcome: SkirtOutcome) -> str:
    """Return the page with pictures of nothing."""
    return render(outcome, dict.fromkeys(PICTURES, PIXEL))


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


def test_headings_tables_and_pictures_speak(reader: PageReader) -> None:
    """Headings go down one level at a time, cells of heads have a scope, charts have words."""
    levels = [int(one.tag[1]) for one in reader.elements if re.fullmatch("h[1-6]", one.tag)]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))
    assert all(one.attributes.get("scope") in ("row", "col") for one in reader.all("th"))
    for image in reader.all("img"):
        assert len(image.attributes["alt"].split()) >= 2
    alts = {one.attributes["alt"] for one in reader.all("img")}
    assert any("40 nm" in alt and "tolerance 5 µm" in alt for alt in alts)
    live = [one for one in reader.elements if one.attributes.get("class") == "live"]
    assert len(live) == 7
    assert all(one.attributes["aria-label"] for one in live)


def test_controls_have_labels(reader: PageReader) -> None:
    """Whoever cannot see the sliders is told what they are."""
    labelled = {one.attributes["for"] for one in reader.all("label")}
    controls = [one for tag in ("input", "select") for one in reader.all(tag)]
    assert {one.attributes["id"] for one in controls} == labelled
    assert all("".join(one.text).strip() for one in reader.all("button"))


def test_head_says_how_to_repeat_the_cut(page: str) -> None:
    """Date, version, command line, machine and seed stand in the head; part and date on paper."""
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


def test_page_holds_the_map(reader: PageReader, outcome: SkirtOutcome) -> None:
    """The largest error of the page's data is the one that the summary tells."""
    held = map_of(reader.data("part-data"))
    assert held.error_um.shape == (256, 360)
    largest_um = outcome.summary["form_error_um"]["max"]
    assert np.nanmax(np.abs(held.error_um)) == pytest.approx(largest_um, rel=1e-3)
    heat = reader.data("figures")["error-map"]["data"][0]
    assert heat["zmax"] == -heat["zmin"] >= largest_um


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


def test_scripts_are_those_that_the_policy_names(page: str, reader: PageReader) -> None:
    """The policy allows two scripts by their hashes, pictures in the page, and nothing else."""
    [policy] = [
        one.attributes["content"]
        for one in reader.all("meta")
        if one.attributes.get("http-equiv") == "Content-Security-Policy"
    ]
    scripts = ["".join(one.text) for one in reader.all("script") if "type" not in one.attributes]
    digests = [b64encode(sha256(one.encode()).digest()).decode() for one in scripts]
    allowed = re.search("script-src ([^;]*);", policy)
    assert allowed and allowed[1] == " ".join(f"'sha256-{one}'" for one in digests)
    assert "default-src 'none'" in policy and "unsafe-eval" not in policy
    assert "connect-src" not in policy and "http" not in policy
    assert scripts[1] == script_texts()[1] and "eval" not in scripts[1]


def test_nothing_is_fetched(reader: PageReader) -> None:
    """Every address in the page is a picture in the page itself."""
    addresses = [
        value
        for one in reader.elements
        for name, value in one.attributes.items()
        if name in ("src", "href", "srcset", "data", "action", "poster")
    ]
    assert len(addresses) == len(PICTURES)
    assert all(value.startswith("data:image/png;base64,") for value in addresses)
    assert not re.search(r"url\(|@import", "".join("".join(s.text) for s in reader.all("style")))


def test_page_is_the_same_twice_and_small(page: str, outcome: SkirtOutcome) -> None:
    """The same cut of the same origin gives the same bytes; its pictures apart, below 7 MB."""
    again = page_of(replace(outcome, surface=made_up_surface(outcome.generated.geometry)))
    assert again == page
    assert len(page) < 7e6
    assert "computing time" not in page


def test_json_cannot_end_its_element() -> None:
    """What ends a script element or opens a comment is spelled out."""
    assert not set(json_script({"<!--": HOSTILE})) & set("<>&\u2028")
