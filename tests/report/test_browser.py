"""Pages as a browser shows them: no error, numbers equal to Python's, nothing cut off, readable by all."""

import math
from pathlib import Path

import pytest
import xarray as xr

from browser import MISSING, OVERLAPS, browser, complaints, open_page, resize, violations
from warpdamp.report.calculator import Calculator
from warpdamp.report.design_page import write_design_report
from warpdamp.report.film_page import write_film_page
from warpdamp.report.report_page import write_report
from warpdamp.study.again import stored_config
from warpdamp.sweep.cases import Cases

pytestmark = pytest.mark.skipif(bool(MISSING), reason=MISSING)

WIDTHS = (1100, 390)


@pytest.fixture(scope="module")
def driver():
    with browser() as opened:
        yield opened


@pytest.fixture(scope="module")
def axe():
    package = pytest.importorskip("axe_core_python", reason="axe-core is not installed")
    return (Path(package.__path__[0]) / "axe.min.js").read_text()


@pytest.fixture(scope="module")
def pages(results, film, spheroids, beside, answer, tmp_path_factory):
    """Paths of pages: of films, of the reports of a study, of a sweep over two more scalars, and of a design."""
    folder, dataset = tmp_path_factory.mktemp("pages"), xr.load_dataset(results)
    modes = next(Cases(stored_config(dataset, results)).points()).modes
    write_film_page(film, folder / "film.html")
    write_film_page(spheroids, folder / "spheroids.html")
    write_film_page(beside, folder / "beside.html")
    write_report(dataset, folder / "report.html", modes=modes, film=film)
    write_report(swept(dataset), folder / "sweep.html", modes="None.", film="None.")
    write_report(sampled(dataset), folder / "sample.html", modes="None.", film="None.")
    write_design_report(answer, folder / "design.html")
    return {path.stem: path for path in folder.iterdir()}


def swept(dataset):
    """Results as of a sweep over friction and restitution: the same cases, with energies that tell them apart."""
    one = dataset.drop_dims("mode")
    rows = []
    for friction in (0.2, 0.5, 0.9):
        scaled = []
        for restitution in (0.4, 0.6):
            own = one.copy(deep=True)
            own["effectiveness"] = own["effectiveness"] * friction * restitution
            scaled.append(own.expand_dims(restitution=[restitution]))
        rows.append(xr.concat(scaled, "restitution").expand_dims(friction=[friction]))
    whole = xr.concat(rows, "friction")
    whole["friction"].attrs = {"units": "1", "long_name": "coefficient of friction"}
    return whole.transpose("frequency", "gamma", "friction", "restitution", "seed")


def sampled(dataset):
    """Results as of random points: one dimension, along which friction and frequency change together."""
    one = dataset.drop_dims("mode").isel(gamma=slice(2, 3)).rename(frequency="case")
    own = {"friction": ("case", [0.3, 0.7]), "frequency": ("case", dataset["frequency"].values)}
    return one.assign_coords(case=[0, 1]).assign_coords(own)


PAGES = ("film", "spheroids", "beside", "report", "sweep", "sample", "design")


@pytest.mark.parametrize("name", PAGES)
def test_a_page_opens_without_a_complaint_and_loads_nothing(driver, pages, name):
    open_page(driver, pages[name])
    assert complaints(driver) == []
    assert driver.execute_script("return performance.getEntriesByType('resource').map((r) => r.name)") == []


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", PAGES)
def test_nothing_is_cut_off_or_lies_on_something_else(driver, pages, name, width):
    open_page(driver, pages[name], width)
    assert driver.execute_script(OVERLAPS) == []


@pytest.mark.parametrize("name", ["film", "beside", "report", "sweep", "design"])
def test_contrast_names_and_alternatives(driver, pages, axe, name):
    open_page(driver, pages[name])
    assert violations(driver, axe) == []


def set_field(driver, name, value):
    driver.execute_script(
        "const f = document.querySelector(`form [name=${arguments[0]}]`); f.value = arguments[1];"
        "f.dispatchEvent(new Event(f.tagName === 'SELECT' ? 'change' : 'input', { bubbles: true }));",
        name,
        str(value),
    )


def computed(driver):
    out = "document.querySelector('[data-result=calculator]').dataset"
    return [float(x) for x in driver.execute_script(f"return [{out}.zeta, {out}.half]")]


def test_the_calculator_is_that_of_python(driver, pages, results):
    calculator = Calculator.of(xr.load_dataset(results))
    open_page(driver, pages["report"])
    low, high = calculator.frequency[[0, -1]]
    cases = [
        (24.0, 1.66, low, 6),
        (1.25, 0.3, high, 8),
        (3.0, 0.77, 0.3 * low + 0.7 * high, 5.3),
        (24.0, 1.66, 1.01 * high, 6),
        (24.0, 1.66, low, 9),
    ]
    for mass, phi, f, gamma in cases:
        for name, value in {"m": mass, "phi": phi, "f": repr(float(f)), "gamma": gamma}.items():
            set_field(driver, name, value)
        expected = calculator.damping(mass / 1e3, phi, f, gamma)
        assert computed(driver) == pytest.approx(expected, rel=1e-12, nan_ok=True)
    assert math.isnan(computed(driver)[0])


def test_the_calculator_of_a_sweep_follows_its_scalars(driver, pages, results):
    dataset = swept(xr.load_dataset(results))
    open_page(driver, pages["sweep"])
    set_field(driver, "friction", 2)
    set_field(driver, "restitution", 1)
    calculator = Calculator.of(dataset.isel(friction=2, restitution=1))
    f = float(calculator.frequency[0])
    for name, value in {"m": 2, "phi": 1.5, "f": repr(f), "gamma": 3}.items():
        set_field(driver, name, value)
    assert computed(driver) == pytest.approx(calculator.damping(2e-3, 1.5, f, 3), rel=1e-12)


def test_a_mode_of_the_study_fills_the_calculator(driver, pages, results):
    dataset = xr.load_dataset(results)
    open_page(driver, pages["report"])
    set_field(driver, "preset", 1)
    set_field(driver, "gamma", 4)
    expected = float(dataset["damping_ratio"].isel(mode=1).sel(gamma=4))
    assert computed(driver)[0] == pytest.approx(expected, rel=1e-6)  # phi with eight digits; modes to a microhertz


def test_pointing_at_a_curve_tells_its_numbers(driver, pages, results):
    from selenium.webdriver.common.action_chains import ActionChains

    dataset = xr.load_dataset(results)
    open_page(driver, pages["report"])
    chart = driver.find_element("css selector", "[data-chart=curves] svg")
    driver.execute_script("arguments[0].scrollIntoView({ block: 'center' })", chart)
    ActionChains(driver).move_to_element_with_offset(chart, chart.size["width"] // 2 - 25, 0).perform()
    said = driver.execute_script("return document.querySelector('[data-chart=curves] .tip').textContent")
    first = 100 * float(dataset["damping_ratio"].isel(mode=0, gamma=-1))
    assert "Γ [-]: 8" in said
    assert f"{first:.4g}" in said


def pointed_at(driver, name):
    """What a chart says of the point that its middle is nearest to."""
    from selenium.webdriver.common.action_chains import ActionChains

    chart = driver.find_element("css selector", f"[data-chart={name}] svg")
    driver.execute_script("arguments[0].scrollIntoView({ block: 'center' })", chart)
    ActionChains(driver).move_to_element(chart).perform()
    return driver.execute_script(f"return document.querySelector('[data-chart={name}] .tip').textContent")


def test_the_charts_of_a_design_tell_its_numbers(driver, pages, answer):
    open_page(driver, pages["design"])
    said = pointed_at(driver, "curve")
    near = int(abs(answer["gamma"].values[0] - 4.2).argmin())  # the middle, in ratios, of 2 to 8 and a margin
    assert f"mode 1, 40 Hz: {100 * float(answer['damping_ratio_mean'][0, near]):.4g}" in said
    assert "±" in said
    masses = [f"{1e3 * float(mass):.5g}" for mass in answer["particle_mass"]]
    said = pointed_at(driver, "front")
    assert any(f"mass of the particles [g]: {mass}\n" in said for mass in masses)
    assert "height" in said


def pixels(driver):
    return driver.execute_script("return document.querySelector('.film canvas').toDataURL()")


BLANK = """
const there = document.querySelector(".film canvas"), empty = document.createElement("canvas");
[empty.width, empty.height] = [there.width, there.height];
return empty.toDataURL();
"""


def test_cavities_beside_each_other_turn_together(driver, pages):
    open_page(driver, pages["beside"])
    each = "return [...document.querySelectorAll('.film canvas')].map((c) => c.toDataURL())"
    before = driver.execute_script(each)
    assert len(set(before)) == 2
    second = "document.querySelectorAll('.film canvas')[1]"
    driver.execute_script(f"{second}.dispatchEvent(new KeyboardEvent('keydown', {{ key: 'ArrowLeft' }}));")
    resize(driver, 1100)
    after = driver.execute_script(each)
    assert before[0] != after[0]
    assert before[1] != after[1]
    assert complaints(driver) == []


def test_the_film_plays_turns_and_changes_its_colours(driver, pages):
    open_page(driver, pages["film"])
    seen = [pixels(driver)]
    assert seen[0] != driver.execute_script(BLANK)

    def changed(script):
        driver.execute_script("const q = (s) => document.querySelector(s);" + script)
        resize(driver, 1100)
        seen.append(pixels(driver))
        return seen[-1] != seen[-2]

    assert changed("const s = q('input[type=range]'); s.value = 5; s.dispatchEvent(new Event('input'));")
    assert changed("const s = q('.film select'); s.value = 'energy'; s.dispatchEvent(new Event('change'));")
    assert changed("q('.film canvas').dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowLeft' }));")
    assert changed("q('.film input[type=checkbox]').click();")
    driver.execute_script("document.querySelector('.film .play button').click();")
    before = driver.execute_script("return document.querySelector('input[type=range]').value")
    from selenium.webdriver.support.ui import WebDriverWait

    now = "return document.querySelector('input[type=range]').value"
    WebDriverWait(driver, 20).until(lambda d: d.execute_script(now) != before)
    assert complaints(driver) == []
