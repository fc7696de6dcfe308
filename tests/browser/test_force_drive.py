# SPDX-License-Identifier: Apache-2.0
"""The loop of a U that takes forces is measured and set in the browser."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import expect

from tests.browser.accessible import grave_findings
from tests.browser.gallery import Gallery
from tests.browser.panel_page import command, order
from tests.browser.panel_session import PanelSession, panel_session
from tests.browser.windows import OpenWindow
from tests.tools.cases.part_cases import ROOT

_MACHINE = ROOT / "tests" / "scenarios" / "cases" / "machines" / "force.toml"
_WEAK = "[controller]\nservo_crossover_hz = 60\nservo_lead_percent = 2000\nservo_pole_hz = 1000\n"


@pytest.fixture(scope="module")
def force_session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PanelSession]:
    """Run a lathe whose U takes forces, and its panel."""
    folder = tmp_path_factory.mktemp("force")
    machine = folder / "weak.toml"
    machine.write_text(_MACHINE.read_text("utf-8") + _WEAK + "servo_integral_mHz = 3000\n")
    with panel_session(folder, ("--machine", machine)) as one:
        yield one


def test_a_loop_is_measured_and_applied(
    force_session: PanelSession, open_window: OpenWindow, gallery: Gallery
) -> None:
    """Measure is on in ready, Apply after it; the card shows report and picture."""
    page = open_window().page
    command(page, force_session)
    card, apply = page.get_by_test_id("card-drive"), order(page, "apply_loop")
    expect(page.get_by_test_id("drive-loop")).to_contain_text("crossover 60 Hz")
    expect(order(page, "measure_loop")).to_be_disabled()
    order(page, "enable").click()
    expect(order(page, "measure_loop")).to_be_enabled()
    expect(apply).to_be_disabled()
    order(page, "measure_loop").click()
    page.get_by_test_id("question-yes").click()
    expect(apply).to_be_enabled(timeout=600_000)
    expect(page.get_by_test_id("drive-report")).to_contain_text("as it is (measured): crossover")
    picture = page.get_by_test_id("drive-picture")
    expect(picture).to_be_visible()
    assert picture.evaluate("img => img.decode().then(() => img.naturalWidth)") > 500
    card.scroll_into_view_if_needed()
    gallery.keep(page, "Operate, drive of U", is_whole=True)
    assert not grave_findings(page)
    apply.click()
    page.get_by_test_id("question-yes").click()
    expect(page.get_by_test_id("last-order")).to_contain_text("parameters are set")
    expect(page.get_by_test_id("drive-loop")).not_to_contain_text("crossover 60 Hz")
    expect(apply).to_be_disabled()
    assert force_session.status().state == "off"


def test_a_drive_of_positions_has_no_card(session: PanelSession, open_window: OpenWindow) -> None:
    """Where no parameter of a loop is set."""
    page = open_window().page
    command(page, session)
    expect(page.get_by_test_id("params-state")).to_contain_text("checksum")
    expect(page.get_by_test_id("card-drive")).to_be_hidden()
