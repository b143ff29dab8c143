"""What the site is made of besides `docs/`: pages of cases, databases and benchmarks with their
pictures. Links hold in the site as in the repository.
"""

from __future__ import annotations

import re
from os.path import relpath
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
BESIDE = ("cases", "hydro_db", "benchmarks")
SHOWN = {".md", ".png", ".yaml"}
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]+)(#[^)\s]*)?\)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the pages and pictures beside `docs/`."""
    for path in (p for folder in BESIDE for p in sorted((ROOT / folder).rglob("*"))):
        if path.suffix in SHOWN:
            own = path.relative_to(ROOT).as_posix()
            files.append(File.generated(config, own, abs_src_path=str(path)))
    return files


def on_page_markdown(text: str, page: Page, files: Files, **_: Any) -> str:
    """Links as they hold in the repository, changed to hold in the site; those to files that the
    site has not become plain text. PluginError where a link leads nowhere."""
    real = Path(page.file.abs_src_path or DOCS / page.file.src_uri)

    def changed(found: re.Match[str]) -> str:
        picture, words, target, anchor = found.groups()
        if "://" in target or target.startswith("mailto:"):
            return found[0]
        place = (real.parent / target).resolve()
        own = place.relative_to(ROOT).as_posix().removeprefix("docs/").replace(".ipynb", ".md")
        there = files.get_file_from_path(own) is not None
        if not (place.exists() or there):
            raise PluginError(f"{page.file.src_uri}: a link leads to {target}, which is not there")
        if not there:
            return words
        way = relpath(own, Path(page.file.src_uri).parent)
        return f"{picture}[{words}]({way}{anchor or ''})"

    return LINK.sub(changed, text)
