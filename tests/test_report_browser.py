"""Reports in a browser: everything is there and fits, nothing is fetched, and they print.

Needs Debian's chromium and chromium-driver; without them the tests are skipped.
"""

from __future__ import annotations

import base64
import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import closed_form_mechanism
import pytest
from click.testing import CliRunner
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

from fivebar_atlas.cli import main

BROWSER, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(
    BROWSER is None or DRIVER is None,
    reason="needs chromium and chromedriver (Debian: chromium, chromium-driver)",
)

_FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
_PHONE, _SCREEN = 360, 1280

# Elements that stick out of the page, but for what is scrolled in a box of its own.
_STICKING_OUT = """
const boxes = [...document.querySelectorAll('.scroll, pre')];
return [...document.body.querySelectorAll('*')]
  .filter(each => !each.closest('svg') || each.tagName === 'svg')
  .filter(each => !boxes.some(box => box !== each && box.contains(each)))
  .filter(each => getComputedStyle(each).position !== 'absolute')
  .filter(each => {
    const box = each.getBoundingClientRect();
    return box.width > 0 && (box.left < -0.5 || box.right > innerWidth + 0.5);
  })
  .map(each => each.tagName + ' ' + each.textContent.slice(0, 60));
"""
# The part of each figure that is drawn, in page coordinates.
_FIGURES = """
return [...document.querySelectorAll('figure')].map(figure => {
  const whole = figure.querySelector('svg').getBoundingClientRect();
  const drawn = figure.querySelector('svg > g').getBoundingClientRect();
  const caption = figure.querySelector('figcaption').getBoundingClientRect();
  return {width: whole.width, height: whole.height, drawn: drawn.width,
          bottom: whole.bottom, caption: caption.top};
});
"""
# Text smaller than this, in pixels, cannot be read.
_SMALLEST = """
const sizes = [...document.body.querySelectorAll('p, th, td, li, figcaption, code')]
  .map(each => parseFloat(getComputedStyle(each).fontSize));
return Math.min(...sizes);
"""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[webdriver.Chrome]:
    """Start a browser that notes every request."""
    options = webdriver.ChromeOptions()
    options.binary_location = str(BROWSER)
    for flag in (*_FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('browser')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"performance": "ALL", "browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(DRIVER))
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def reports(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Make a report of every kind of run."""
    folder = tmp_path_factory.mktemp("reports")
    atlas = str(closed_form_mechanism.write(folder / "small.h5", "five-bar"))
    commands = {
        "size": ["26", "30", "16", "--rectangle", "300x200", "--clearance", "10", "--force", "10"],
        "evaluate": ["26", "30", "16", "--mode", "all", "--lci", "0.3", "--lci", "0.5"],
        "optimum": [
            atlas, "--where", "usable_workspace_area>=24", "--where", "gci>=0.62", "--refine",
            "--maximise", "gci", "--pareto", "usable_workspace_area,gci",
        ],
    }  # fmt: skip
    made = {}
    for name, arguments in commands.items():
        made[name] = folder / f"{name}.html"
        words = ["report", name, *arguments, "-o", str(made[name])]
        result = CliRunner().invoke(main, words, prog_name="atlas")
        assert result.exit_code == 0, result.output
    return made


def open_page(browser: webdriver.Chrome, file: Path, width: int) -> list[dict[str, Any]]:
    """Open a page in a window of some width; return what the browser did on the network."""
    metrics = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": width == _PHONE}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    browser.get_log("performance")
    browser.get(file.as_uri())
    entries = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    return [entry for entry in entries if entry["method"].startswith("Network.")]


@pytest.mark.parametrize("width", [_PHONE, _SCREEN])
@pytest.mark.parametrize("name", ["size", "evaluate", "optimum"])
def test_a_report_fits_and_everything_is_there(
    browser: webdriver.Chrome, reports: dict[str, Path], name: str, width: int
) -> None:
    open_page(browser, reports[name], width)
    assert browser.execute_script("return innerWidth") == width
    overflow = (
        "return document.scrollingElement.scrollWidth <= document.documentElement.clientWidth"
    )
    assert browser.execute_script(overflow)
    assert browser.execute_script(_STICKING_OUT) == []
    assert browser.execute_script(_SMALLEST) >= 12.0
    figures = browser.execute_script(_FIGURES)
    assert len(figures) == {"size": 3, "evaluate": 9, "optimum": 3}[name]
    for figure in figures:
        assert figure["width"] > 300.0
        assert figure["height"] > 100.0
        assert figure["drawn"] > 0.9 * figure["width"]
        assert figure["caption"] >= figure["bottom"]
    text = browser.execute_script("return document.body.innerText")
    for part in ("INPUTS", "CHOICES", "FIGURES", "PROVENANCE", "DATA", f"atlas report {name}"):
        assert part.lower() in text.lower()
    messages = [entry["message"] for entry in browser.get_log("browser")]
    assert messages == []


@pytest.mark.parametrize("name", ["size", "evaluate", "optimum"])
def test_nothing_is_fetched(browser: webdriver.Chrome, reports: dict[str, Path], name: str) -> None:
    events = open_page(browser, reports[name], _SCREEN)
    urls = [
        event["params"]["request"]["url"]
        for event in events
        if event["method"] == "Network.requestWillBeSent"
    ]
    assert reports[name].as_uri() in urls
    assert {url for url in urls if not url.startswith("data:")} == {reports[name].as_uri()}


def test_the_data_open_and_scroll_in_a_box_of_their_own(
    browser: webdriver.Chrome, reports: dict[str, Path]
) -> None:
    open_page(browser, reports["size"], _PHONE)
    browser.execute_script("document.querySelector('details').open = true")
    assert browser.execute_script(_STICKING_OUT) == []
    text = browser.execute_script("return document.querySelector('details pre').innerText")
    assert json.loads(text)["mode"] == "+-/up"


@pytest.mark.parametrize("name", ["size", "evaluate", "optimum"])
def test_a_report_prints_on_paper(
    browser: webdriver.Chrome, reports: dict[str, Path], name: str
) -> None:
    open_page(browser, reports[name], _SCREEN)
    printed = browser.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True})
    content = base64.b64decode(printed["data"])
    assert content.startswith(b"%PDF")
    assert len(content) > 20_000
    sizes = re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", content)
    assert sizes
    for width, height in sizes:
        assert float(width) == pytest.approx(210.0 * 72.0 / 25.4, abs=1.0)
        assert float(height) == pytest.approx(297.0 * 72.0 / 25.4, abs=1.0)


def test_nothing_is_wider_than_the_paper(
    browser: webdriver.Chrome, reports: dict[str, Path]
) -> None:
    try:
        for file in reports.values():
            # the width of A4 without its margins, in pixels
            open_page(browser, file, 665)
            browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
            width = browser.execute_script("return document.scrollingElement.scrollWidth")
            assert width <= 665
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
