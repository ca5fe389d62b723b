"""Files of the repository that lie outside docs/, as pages of the site, and links to them.

Links in the pages are those that lead somewhere in the repository (and so on GitHub). The site has
the pages of `PAGES` besides docs/, and one page for each folder of `FOLDERS` that shows its files.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[2]

PAGES = {
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "benchmarks/README.md": "speed.md",
    "assets/needle_18g/README.md": "needle_mesh.md",
}
"""Page of the site by file of the repository."""

FOLDERS = {
    "scenes": "files/scenes.md",
    "scenes/hard": "files/hard_scenes.md",
    "scenes/paper": "files/paper_scene.md",
    "scenes/sweeps": "files/sweeps.md",
    "examples/detectors": "files/detectors.md",
    "simtip/regress/standard": "files/standard_suite.md",
}
"""Page of the site by folder of the repository."""

LANGUAGES = {".yaml": "yaml", ".py": "python", ".cpp": "cpp", ".toml": "toml"}
"""Files that are shown, by the ends of their names."""

LINK = re.compile(r"(?<=\]\()(?!\w+:|#)(?P<path>[^)#\s]+)(?P<anchor>#[^)\s]*)?(?=\))")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are not in docs/."""
    for source, uri in PAGES.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        if uri == "index.md":  # which is alone in its part of the navigation
            text = f"---\nhide: [navigation]\n---\n{text}"
        files.append(File.generated(config, uri, content=text))
    for folder, uri in FOLDERS.items():
        files.append(File.generated(config, uri, content=folder_page(folder)))
    return files


def on_page_markdown(markdown: str, page: Page, **_: object) -> str:
    """Turn links within the repository into links within the site."""
    uri = page.file.src_uri
    sources = {site: source for source, site in (PAGES | FOLDERS).items()}
    folder = posixpath.dirname(sources.get(uri, f"docs/{uri}"))
    return LINK.sub(
        lambda link: site_link(link["path"], link["anchor"] or "", folder, uri), markdown
    )


def site_link(path: str, anchor: str, folder: str, uri: str) -> str:
    """Give the site's link for one of the repository.

    Parameters
    ----------
    path, anchor
        As written.
    folder
        Of the page, in the repository.
    uri
        Of the page, in the site.
    """
    target = posixpath.normpath(posixpath.join(folder, path))
    parent, name = posixpath.split(target)
    if target in PAGES:
        there = PAGES[target] + anchor
    elif target in FOLDERS:
        there = FOLDERS[target]
    elif parent in FOLDERS:
        there = f"{FOLDERS[parent]}#{name}"
    elif target.startswith("docs/"):
        there = target.removeprefix("docs/") + anchor
    else:
        return path + anchor  # the strict build names it
    return posixpath.relpath(there, posixpath.dirname(uri) or ".")


def folder_page(folder: str) -> str:
    """Write the page of a folder: its files, whole."""
    parts = [f"# {folder}"]
    for file in sorted((ROOT / folder).rglob("*")):
        within = file.parent.relative_to(ROOT).as_posix()
        has_its_own_page = within != folder and within in FOLDERS
        if file.suffix not in LANGUAGES or has_its_own_page:
            continue
        name = file.relative_to(ROOT / folder).as_posix()
        text = file.read_text(encoding="utf-8").rstrip()
        parts.append(f"## {name} {{: #{name} }}\n\n```{LANGUAGES[file.suffix]}\n{text}\n```")
    return "\n\n".join(parts) + "\n"
