"""The report of a cut in a browser: its linked charts against the gauged surface, print, words."""

import itertools
import json
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from camtools.base.quantities import Floats
from tests.browser.accessible import grave_findings, told_um
from tests.browser.conftest import PICTURES, Keep
from tests.browser.windows import NO_3D, PHONE, OpenWindow
from tests.tools.cases.camsim_cases import columns_of

A4_WIDTH_PX, A4_MARGIN_MM = 794, 15.0
MOST_PAGES = 13  # a page for each of five sections and one for the profiles
_DATA = "id => document.getElementById(id).data.map(one => ({x: one.x, y: one.y, name: one.name}))"


def open_report(page: Page, folder: Path, *, has_3d: bool = False) -> None:
    """Open the report and wait until its charts are alive.

    Without a graphics card the part in space takes seconds, so that most tests go without it.
    """
    if not has_3d:
        page.add_init_script(NO_3D)
    page.goto((folder / "report.html").as_uri())
    expect(page.locator("#section-text")).to_contain_text("the error runs from")
    expect(page.locator("#profile .main-svg").first).to_be_visible()


@cache
def surface(folder: Path) -> dict[str, Floats]:
    """Read the gauged surface as a spreadsheet does."""
    return columns_of(folder / "surface.csv")


def test_report_tells_what_was_gauged(report_folder: Path, open_window: OpenWindow) -> None:
    """By its slider, at the pointer, and in words; the judge is surface.csv and summary.json."""
    page = open_window().page
    open_report(page, report_folder)
    check_slider(page, report_folder)
    check_pointer(page, report_folder)
    check_words(page, report_folder)


def check_slider(page: Page, report_folder: Path) -> None:
    """Compare the section at a chosen height with surface.csv."""
    page.locator("#height").focus()
    before = page.locator("#height-value").inner_text()
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    expect(page.locator("#height-value")).not_to_have_text(before)
    text = page.locator("#height-value").inner_text()
    z_mm = page.evaluate("part.z_mm[Number(document.getElementById('height').value)]")
    assert text == f"{z_mm:.2f} mm"
    y0 = page.evaluate("document.getElementById('error-map').layout.shapes[0].y0")
    assert y0 == pytest.approx(z_mm)
    line = page.evaluate(_DATA, "unrolled")[-1]
    cells = surface(report_folder)
    pitch_mm = page.evaluate("part.z_mm[1] - part.z_mm[0]")
    is_here = np.abs(cells["z_mm"] - z_mm) < 0.6 * pitch_mm
    angle_deg, error_um = 360 * cells["turn"][is_here], cells["error_nm"][is_here] / 1e3
    shown = np.array(line["x"], float), np.array(line["y"], float)
    per_um = page.evaluate("part.per_um")
    step = page.evaluate("part.error_step_um")
    nearest = np.array([np.argmin(np.abs(angle_deg - x)) for x in shown[0]])
    assert len(shown[0]) == page.evaluate("part.columns")
    assert np.max(np.abs(angle_deg[nearest] - shown[0])) < 0.01
    assert np.max(np.abs(error_um[nearest] * per_um - shown[1])) <= step * per_um


def check_pointer(page: Page, report_folder: Path) -> None:
    """Compare what is told at the pointer with surface.csv; a click brings the section there."""
    area = page.locator("#error-map .nsewdrag").first
    area.scroll_into_view_if_needed()
    box = area.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.2 * box["height"])
    hover = page.locator("#error-map .hoverlayer .hovertext")
    expect(hover).to_be_visible()
    told = (hover.text_content() or "").replace("\N{MINUS SIGN}", "-")
    numbers = [float(n) for n in re.findall(r"-?\d+(?:\.\d+)?", told)]
    assert len(numbers) == 4, told
    cells = surface(report_folder)
    off = np.hypot(360 * cells["turn"] - numbers[0], 10 * (cells["z_mm"] - numbers[1]))
    there = int(np.argmin(off))
    per_um = page.evaluate("part.per_um")
    assert numbers[3] == pytest.approx(cells["error_nm"][there] / 1e3 * per_um, rel=0.02, abs=0.6)
    page.mouse.click(box["x"] + 0.3 * box["width"], box["y"] + 0.2 * box["height"])
    expect(page.locator("#height-value")).to_have_text(f"{numbers[1]:.2f} mm")


def check_words(page: Page, report_folder: Path) -> None:
    """Compare form error and verdict, as a person reads them, with summary.json."""
    summary = json.loads((report_folder / "summary.json").read_text("utf-8"))
    assert summary["is_good"] == (page.locator("#verdict").get_attribute("data-kind") == "good")
    text = page.locator("#summary").inner_text().partition("max ")[2]
    assert told_um(text) == pytest.approx(summary["form_error_um"]["max"], rel=0.01)


@pytest.mark.long
def test_part_in_space_is_drawn(report_folder: Path, open_window: OpenWindow, keep: Keep) -> None:
    """By WebGL, whose picture is not empty and turns under the pointer."""
    page = open_window(viewport={"width": 320, "height": 320}).page  # the processor draws it all
    open_report(page, report_folder, has_3d=True)
    space = page.locator("#space")
    space.scroll_into_view_if_needed()
    expect(space.locator("canvas").first).to_be_visible()
    first = space.screenshot()
    box = space.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] / 4, box["y"] + box["height"] / 2, steps=4)
    page.mouse.up()
    keep(page, "Report, part in space")
    assert space.screenshot() != first


@pytest.mark.long
def test_report_without_scripts_has_its_numbers(
    report_folder: Path, open_window: OpenWindow, keep: Keep
) -> None:
    """Without JavaScript tables and sheets are visible, with a notice about the charts."""
    page = open_window(java_script_enabled=False).page
    page.goto((report_folder / "report.html").as_uri())
    keep(page, "Report, without scripts", is_whole=True)
    assert page.locator("#board").is_hidden()
    assert page.locator("img:visible").count() >= 5
    assert page.locator("#summary").is_visible()
    assert page.locator("#no-charts").is_visible()


@pytest.mark.long
def test_report_prints_to_a4(report_folder: Path, open_window: OpenWindow, keep: Keep) -> None:
    """Nothing is wider than the paper, and there are as many pages as a person will turn."""
    page = open_window().page
    open_report(page, report_folder)
    pdf = page.pdf(format="A4", print_background=True, prefer_css_page_size=True)
    (PICTURES / "report.pdf").write_bytes(pdf)
    n_pages = len(re.findall(rb"/Type\s*/Page\b(?!s)", pdf))
    assert 2 <= n_pages <= MOST_PAGES
    page.emulate_media(media="print")
    paper_px = A4_WIDTH_PX - round(2 * A4_MARGIN_MM / 25.4 * 96)
    page.set_viewport_size({"width": paper_px, "height": 1000})
    page.wait_for_function(  # until the charts have followed
        """() => [...document.querySelectorAll("body *:not(.live *)")]
        .filter(e => e.checkVisibility())
        .every(e => e.getBoundingClientRect().right <= document.documentElement.clientWidth + 1)"""
    )


@pytest.mark.long
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_report_has_no_grave_finding(
    report_folder: Path, open_window: OpenWindow, keep: Keep, scheme: str
) -> None:
    """Axe finds nothing serious, and on a phone nothing is beyond the edge."""
    page = open_window(color_scheme=scheme).page
    open_report(page, report_folder)
    keep(page, f"Report, {scheme}", is_whole=True)
    assert not grave_findings(page)
    page.set_viewport_size(PHONE)
    keep(page, f"Report, phone, {scheme}", is_whole=True)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]


_BOXES = """() => [...document.querySelectorAll(".js-plotly-plot")].filter(one => one.offsetParent)
    .map(one => ["legend", "modebar-group"].map(name => [...one.querySelectorAll("." + name)]
        .map(part => part.getBoundingClientRect().toJSON())))"""
_INKS = """() => [...document.querySelectorAll(".js-plotly-plot .gtitle, .js-plotly-plot .xtitle")]
    .map(one => getComputedStyle(one).fill)"""


@pytest.mark.long
def test_charts_follow_the_light_and_bars_cover_no_legend(
    report_folder: Path, open_window: OpenWindow
) -> None:
    """Text stays legible when the scheme changes; bars are shown at the pointer only."""
    page = open_window().page
    open_report(page, report_folder)
    for scheme in ("dark", "light"):
        page.emulate_media(color_scheme=scheme)
        ink = page.evaluate("getComputedStyle(document.body).color")
        page.wait_for_function(
            f"ink => new Set(({_INKS})()).size === 1 && ({_INKS})()[0] === ink", arg=ink
        )
    page.locator("#picture-following").scroll_into_view_if_needed()
    shown = page.locator("#following .modebar-group").first
    expect(shown).to_have_css("opacity", "0")
    page.locator("#following .nsewdrag").first.hover()
    expect(shown).not_to_have_css("opacity", "0")
    assert page.locator("[data-title*=Share]").count() == 0  # nothing sends a chart away
    for legends, bars in page.evaluate(_BOXES):
        for a, b in itertools.product(legends, bars):
            is_beside = b["left"] >= a["right"] or b["right"] <= a["left"]
            assert is_beside or b["top"] >= a["bottom"] or b["bottom"] <= a["top"], (a, b)
