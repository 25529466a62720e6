"""A headless browser for the tests of pages; which one, and why there is none."""

import importlib.util
import json
import shutil
import tempfile
from contextlib import contextmanager

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
DRIVER = shutil.which("chromedriver")
MISSING = next(
    (
        why
        for why, missing in {
            "there is no Chromium here: apt-get install chromium chromium-driver": not CHROMIUM or not DRIVER,
            "selenium is not installed": importlib.util.find_spec("selenium") is None,
        }.items()
        if missing
    ),
    "",
)
"""Why no page can be opened; empty where it can."""

FLAGS = (
    "--headless=new --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --hide-scrollbars"
)


@contextmanager
def browser():
    """Browser with a fresh profile."""
    from selenium import webdriver

    with tempfile.TemporaryDirectory(prefix="browser-", ignore_cleanup_errors=True) as profile:
        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        for flag in (*FLAGS.split(), f"--user-data-dir={profile}", "--disable-dev-shm-usage"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
        driver.set_script_timeout(60)
        try:
            yield driver
        finally:
            driver.quit()


def resize(driver, width: int, height: int = 800) -> None:
    """Give the page a size, and wait until it has been drawn anew."""
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    driver.execute_async_script(
        "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)));"
    )


def open_page(driver, path, width: int = 1100) -> None:
    """Open a page and wait until it says that it is ready."""
    from selenium.webdriver.support.ui import WebDriverWait

    resize(driver, width)
    driver.get(path.as_uri())
    WebDriverWait(driver, 60).until(lambda d: d.execute_script("return !!document.querySelector('[data-ready]')"))


def complaints(driver) -> list[str]:
    """What the page wrote to the console."""
    return [entry["message"] for entry in driver.get_log("browser")]


def violations(driver, axe: str) -> list[str]:
    """What axe finds wrong with the page, as lines of text."""
    driver.execute_script(axe)
    found = driver.execute_async_script("const done = arguments[0]; axe.run().then((r) => done(r.violations));")
    return [f"{v['id']}: {v['help']}: {json.dumps([node['html'][:90] for node in v['nodes'][:3]])}" for v in found]


OVERLAPS = """
const found = [];
for (const svg of document.querySelectorAll("svg[role=img]")) {
  const outer = svg.getBoundingClientRect();
  const boxes = [...svg.querySelectorAll("text")].map((t) => [t.textContent, t.getBoundingClientRect()]);
  boxes.forEach(([text, a], i) => {
    if (a.left < outer.left - 1 || a.right > outer.right + 1 || a.top < outer.top - 1 || a.bottom > outer.bottom + 1)
      found.push(`cut off: ${text}`);
    for (const [other, b] of boxes.slice(i + 1))
      if (Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 3)
        found.push(`overlap: ${text} / ${other}`);
  });
}
if (document.documentElement.scrollWidth > window.innerWidth) found.push(`wider than the window: ${document.documentElement.scrollWidth}`);
return found;
"""
"""Script that returns texts of charts that are cut off or lie on each other, and a page wider than its window."""
