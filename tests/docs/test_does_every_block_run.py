"""Does every command and every block of code of the documentation run as written?

Each page is read from the top in a folder of its own. In what such a folder differs from a
reader's, say `small_scenes` and `reader`.
"""

from __future__ import annotations

import os
import shutil

import pytest
from pages import PAGES, ROOT, blocks_of
from reader import furnish, read

RUN = {"sh", "python"}
WHOLE = {"docs/calibration.md"}
"""Pages whose Python holds boards before the cameras, without a render: their scenes stay whole."""

PAGES_THAT_RUN = [
    page
    for page in PAGES
    if any(b.language in RUN and not b.not_run and not b.file for b in blocks_of(page))
]


@pytest.fixture(scope="session")
def furnished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("furnished")
    furnish(folder)
    return folder


@pytest.fixture(scope="session")
def shared_cache(tmp_path_factory):
    """Give one cache to all pages, in whichever process of pytest-xdist they are read."""
    own = tmp_path_factory.getbasetemp()
    return (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "cache_of_pages"


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES_THAT_RUN, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_a_page_read_from_the_top_works(page, furnished, shared_cache, tmp_path, monkeypatch):
    folder = tmp_path / "reader"
    shutil.copytree(furnished, folder)
    if page.relative_to(ROOT).as_posix() in WHOLE:
        shutil.copytree(ROOT / "scenes", folder / "scenes", dirs_exist_ok=True)
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.setenv("SIMTIP_CACHE", str(shared_cache))
    monkeypatch.setenv("COLUMNS", "120")
    read(blocks_of(page), folder)
