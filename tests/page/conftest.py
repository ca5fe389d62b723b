from __future__ import annotations

import os
import shutil
from contextlib import contextmanager
from pathlib import Path

import pytest

NAMES = ("chromium", "google-chrome", "chromium-browser")
FLAGS = (
    *("--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run"),
    *("--disable-component-update", "--disable-sync", "--disable-default-apps"),
)


def _refused(reason: str) -> None:
    if os.environ.get("SIMTIP_NEEDS_BROWSER") == "1":
        pytest.fail(reason)
    pytest.skip(reason)


@pytest.fixture(scope="session")
def chromium():
    """One headless Chromium for all tests."""
    named = os.environ.get("SIMTIP_BROWSER")
    program = named or next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        _refused("there is no Chromium: install one, or name it by SIMTIP_BROWSER")
    try:
        from playwright import sync_api
    except ImportError:
        _refused("there is no playwright: it comes with the test dependencies")
    with sync_api.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=program, args=list(FLAGS))
        yield browser
        browser.close()


@pytest.fixture
def opened(chromium):
    """Open a page as a reader would; whatever it complains of or asks for fails the test."""
    complaints: list[str] = []

    @contextmanager
    def open_page(file: Path, *, width: int = 1280, scheme: str = "light", touch: bool = False):
        context = chromium.new_context(
            viewport={"width": width, "height": 900}, color_scheme=scheme, has_touch=touch
        )
        page = context.new_page()
        page.on("console", lambda message: complaints.append(f"console: {message.text}"))
        page.on("pageerror", lambda error: complaints.append(f"error: {error}"))
        page.on("dialog", lambda dialog: complaints.append(f"dialog: {dialog.message}"))
        own = file.as_uri()

        def asked(request):
            if not request.url.startswith((own, "data:", "blob:")):
                complaints.append(f"request: {request.url}")

        page.on("request", asked)
        page.goto(own)
        page.wait_for_selector("html[data-ready]", state="attached", timeout=30_000)
        yield page
        context.close()

    yield open_page
    assert not complaints


@pytest.fixture(scope="session")
def ran(tmp_path_factory):
    """A folder of `run`, of small images."""
    import yaml
    from made_tables import scene_data
    from typer.testing import CliRunner

    from simtip.cli.program import app

    folder = tmp_path_factory.mktemp("ran")
    scene = folder / "scene.yaml"
    scene.write_text(yaml.safe_dump(scene_data(name="<i>small</i>")))
    done = CliRunner().invoke(app, ["run", str(scene), "-o", str(folder / "run"), "--seed", "5"])
    assert done.exit_code == 0, done.output
    return folder / "run"
