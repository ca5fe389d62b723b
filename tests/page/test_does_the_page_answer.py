"""A sweep's page in a browser: does everything that looks as if it answered answer?"""

from __future__ import annotations

import math

import pytest
from made_tables import grid, make, row, written

from simtip.sweep.summary import grouped
from simtip.sweep.table import Table

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    folder = grid(tmp_path_factory.mktemp("page") / "sweep")
    return folder, written(folder)


def cells(page):
    """Give the map's numbers by the names of their levels, as the page has worked them out."""
    return page.evaluate(
        """() => {
            const found = {};
            document.querySelectorAll(".map [data-cell]").forEach((cell) => {
                const over = { bubbles: true, clientX: 9, clientY: 9 };
                cell.dispatchEvent(new PointerEvent("pointermove", over));
                const tip = document.getElementById("tip");
                const names = [...tip.querySelectorAll("dt")].map((one) => one.textContent);
                const values = [...tip.querySelectorAll("dd")].map((one) => one.textContent);
                found[tip.querySelector("b").textContent] =
                    Object.fromEntries(names.map((name, k) => [name, values[k]]));
            });
            return found;
        }"""
    )


def in_mm(text):
    if text == "\N{EN DASH}":
        return math.nan
    number, unit = text.split()
    return float(number) * {"mm": 1.0, "\N{MICRO SIGN}m": 1e-3}[unit]


def test_the_map_shows_what_simtip_results_finds(swept, opened):
    folder, file = swept
    frame = Table.open(folder).frame()
    own = frame[frame["detector"] == "lin2020"]
    stats = ["detection_rate", "error_norm_mm:max", "error_norm_mm:rms", "error_norm_mm:p95"]
    told = grouped(own, ["detect.threshold", "lamps[0].power"], stats)
    with opened(file) as page:
        shown = cells(page)
    assert len(shown) == len(told) == 20
    for _, expected in told.iterrows():
        name = f"detect.threshold {expected['detect.threshold']}, lamps[0].power "
        name += f"{expected['lamps[0].power']:.3g}"
        cell = shown[name]
        assert int(cell["trials"]) == expected["n"]
        rate = float(cell["detected"].split()[0]) / 100
        assert rate == pytest.approx(expected["detection_rate"], abs=6e-4)
        for label, stat in (("largest", "max"), ("RMS", "rms"), ("95 %", "p95")):
            value = expected[f"error_norm_mm:{stat}"]
            assert in_mm(cell[label]) == pytest.approx(value, rel=6e-3), (name, label)


def test_the_envelope_is_where_every_trial_is_found_and_good(swept, opened):
    folder, file = swept
    frame = Table.open(folder).frame()
    own = frame[frame["detector"] == "lin2020"]
    by = ["detect.threshold", "lamps[0].power"]
    told = grouped(own, by, ["detection_rate", "error_norm_mm:max"])
    limit = 0.32
    within = told["error_norm_mm:max"] <= limit
    good = within & (told["detection_rate"] == 1)
    assert 0 < good.sum() < within.sum() < len(told)
    with opened(file) as page:
        page.fill("input.limit-number", str(limit))
        said = page.locator(".explorer[data-kind=map] .said").inner_text()
        assert said.startswith(f"Operating envelope: {good.sum()} of {len(told)} cells")
        drawn = page.locator("path.envelope").get_attribute("d")
        page.fill("input.limit-number", "0.0001")
        said = page.locator(".explorer[data-kind=map] .said").inner_text()
        assert said.startswith("No operating envelope")
        assert page.locator("path.envelope").get_attribute("d") != drawn


def test_a_cell_lists_its_trials(swept, opened):
    _, file = swept
    with opened(file) as page:
        page.locator(".map svg").focus()
        page.keyboard.press("ArrowRight")
        page.keyboard.press("ArrowUp")
        assert page.locator("#tip").is_visible()
        page.keyboard.press("Enter")
        condition = page.locator("[aria-label='Only trials with']").input_value()
        assert condition == 'detect.threshold==60 and lamps[0].power==1 and detector=="lin2020"'
        assert page.locator(".pager span").inner_text() == "1 to 3 of 3 trials"


def test_the_filter_is_that_of_simtip_results(swept, opened):
    from simtip.sweep.conditions import filtered

    folder, file = swept
    frame = Table.open(folder).frame()
    with opened(file) as page:
        box = page.locator("[aria-label='Only trials with']")
        for conditions in (
            ["error_norm_mm<0.15"],
            ["detect.threshold>=100", "detector!=other"],
            ["status==ok", "lamps[0].power==0.5"],
            ["reason=='left: it touches the border'"],
        ):
            box.fill(" and ".join(conditions))
            expected = len(filtered(frame, conditions))
            assert 0 < expected < len(frame)
            page.wait_for_function(
                "said => document.querySelector('.pager span').textContent.endsWith(said)",
                arg=f" of {expected} trials",
                timeout=3000,
            )
        box.fill("no_such_column<3")
        page.wait_for_selector(".said.wrong")
        assert "there is no column" in page.locator(".said.wrong").inner_text()


def test_the_table_sorts_turns_pages_and_is_saved(swept, opened):
    folder, file = swept
    frame = Table.open(folder).frame()
    with opened(file) as page:
        page.click(".trials th button[title=error_x_mm]")
        first = [
            page.locator(f".trials tbody tr:nth-child({k}) td:first-child").inner_text()
            for k in (1, 2)
        ]
        ranked = frame.sort_values("error_x_mm", ascending=False, kind="stable")["trial"]
        assert first == [str(k) for k in ranked.head(2)]
        page.click(".pager button:has-text('Next')")
        assert page.locator(".pager span").inner_text().startswith("26 to 50 of 120")
        with page.expect_download() as saving:
            page.click(".pager button:has-text('Save as CSV')")
        lines = saving.value.path().read_text().splitlines()
        assert len(lines) == 1 + len(frame)
        assert lines[0].startswith("trial,detect.threshold,lamps[0].power,detector,repeat,status")


def test_other_factors_and_figures_are_drawn(swept, opened):
    _, file = swept
    with opened(file) as page:
        before = page.locator(".map").inner_html()
        page.locator("label:has-text('Colour') select").select_option("error_y_mm:mean")
        assert page.locator(".map").inner_html() != before
        page.locator("label:has-text('Up') select").select_option("")
        assert page.locator(".map svg path").count() >= 1
        assert page.locator(".map svg circle").count() == 5  # a point a threshold
        page.locator("label:has-text('By') select").last.select_option("detect.threshold")
        assert page.locator(".explorer[data-kind=distributions] .ridge").count() == 5


@pytest.mark.parametrize(("width", "scheme"), [(1280, "light"), (400, "dark")])
def test_nothing_is_wider_than_the_window(swept, opened, width, scheme):
    _, file = swept
    with opened(file, width=width, scheme=scheme, touch=width < 500) as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        paper = page.evaluate("getComputedStyle(document.body).backgroundColor")
        assert paper == ("rgb(255, 255, 255)" if scheme == "light" else "rgb(20, 23, 27)")
        page.click("#theme")
        page.click("#theme")  # dark, whatever the system has
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 23, 27)"


def test_it_prints(swept, opened):
    _, file = swept
    with opened(file, scheme="dark") as page:
        assert page.pdf(format="A4").startswith(b"%PDF")
        page.emulate_media(media="print")
        assert (
            page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
        )


def test_a_factor_alone_makes_a_curve(tmp_path, opened):
    rows = [row(k, 0.1 + 0.01 * k, **{"detect.threshold": 60 + k}) for k in range(6)]
    folder = make(tmp_path / "sweep", [("detect.threshold", "int")], rows)
    with opened(written(folder, limit_mm=0.125)) as page:
        assert page.locator(".map .band").count() == 3
        page.locator(".map svg").focus()
        page.keyboard.press("ArrowRight")
        assert page.locator("#tip b").inner_text() == "detect.threshold 60"
