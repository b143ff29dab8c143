"""Links in what people read lead somewhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# by docs/hooks.py, for the site
MADE = {"keys.md", "studies_keys.md", "recipes_keys.md", "commands.md"}
FOLDERS = (".", "docs", "cases", "hydro_db", "benchmarks", "tests/data")
LINK = re.compile(r"\]\(([^)\s#]+)(?:#[^)\s]*)?\)")
PAGES = sorted(
    {p for f in FOLDERS for p in (ROOT / f).glob("*.md" if f in (".", "docs") else "**/*.md")}
)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for target in LINK.findall(page.read_text()):
        if "://" not in target and target not in MADE:
            assert (page.parent / target).exists(), target
