"""Names and values that hold HTML, script and quotes: are they shown as text, and no more?"""

from __future__ import annotations

import pytest
from made_tables import HOSTILE, make, page, row, written

HEAD = HOSTILE[:60]


@pytest.fixture
def hostile(tmp_path):
    """A sweep in which every text that a user has a say in is hostile."""
    rows = []
    for k in range(12):
        more = {
            "needle.tip": f"{HOSTILE}{k % 3}",
            "lamps[0].name": HOSTILE,
            "detect.threshold": k % 4,
        }
        one = row(k, 0.1 * (k + 1) if k else None, detector=HOSTILE if k % 2 else "lin2020", **more)
        rows.append({**one, "reason": HOSTILE} if not k else one)
    columns = [("needle.tip", "text"), ("lamps[0].name", "text"), ("detect.threshold", "int")]
    return make(tmp_path / "<b>sweep", columns, rows, name=HOSTILE[:200])


def test_no_markup_comes_from_the_results(hostile):
    text = page(hostile)
    assert "<img" not in text
    assert "alert(1)</script>" not in text
    assert text.count("<script") == text.count("</script>") == 3  # settings, data, the page's own
    assert "\u2028" in text, "a text is shown as it is"


@pytest.mark.slow
def test_the_browser_shows_it_and_runs_nothing(hostile, opened):
    with opened(written(hostile)) as shown:
        title = shown.locator("h1").inner_text()
        assert title.startswith("</script><script>alert(1)</script>\"'&<img src=x")
        assert shown.locator("img").count() == 0
        assert shown.locator("script").count() == 3
        shown.locator("label:has-text('By') select").last.select_option("needle.tip")
        options = shown.locator(".controls select option").all_inner_texts()
        assert any(text.startswith("</script><script>") for text in options)
        first = shown.locator(".trials td").filter(has_text="<img src=x").first
        assert first.is_visible()
        shown.locator(".map svg").focus()
        shown.keyboard.press("ArrowRight")
        shown.keyboard.press("Enter")
        assert shown.locator(".said.wrong").count() == 0
        assert shown.locator(".pager span").inner_text().endswith("of 1 trial")
        assert shown.evaluate("document.querySelectorAll('*').length") < 4000


@pytest.mark.slow
def test_the_page_forbids_what_is_not_its_own(hostile, chromium):
    """The policy is tried: the same page with one more script must not run it."""
    file = written(hostile)
    text = file.read_text(encoding="utf-8")
    own = "<script>window.planted = true; fetch('https://example.org/')</script></body>"
    file.write_text(text.replace("</body>", own), encoding="utf-8")
    context = chromium.new_context()
    tab = context.new_page()
    said = []
    tab.on("console", lambda message: said.append(message.text))
    tab.goto(file.as_uri())
    tab.wait_for_selector("html[data-ready]", state="attached")
    assert tab.evaluate("window.planted") is None
    assert any("Content Security Policy" in text for text in said)
    context.close()


def test_a_file_of_the_results_cannot_be_named_elsewhere(tmp_path):
    """The truth of boards names images: none of another folder may come into the page."""
    import json

    from simtip.errors import InputError

    folder = tmp_path / "boards"
    folder.mkdir()
    view = {"name": "01", "t_mm": [0, 0, 0]}
    view |= {side: {"file": "../secret.png", "visible": [True]} for side in ("left", "right")}
    truth = {"views": [view], "target": "x", "image_size": {"left": [1, 1], "right": [1, 1]}}
    truth["plate"] = {"points_mm": [], "bow_mm": 0}
    (folder / "truth.json").write_text(json.dumps(truth))
    with pytest.raises(InputError, match=r"no file of its folder"):
        page(folder)
