"""Links in what people read lead somewhere."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = (".", "docs", "cases", "hydro_db", "benchmarks", "tests/data")
LINK = re.compile(r"\]\(([^)\s#]+)(?:#[^)\s]*)?\)")
PAGES = sorted({p for f in FOLDERS for p in (ROOT / f).glob("*.md" if f == "." else "**/*.md")})


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for target in LINK.findall(page.read_text()):
        if "://" not in target:
            assert (page.parent / target).exists(), target


def test_pages_of_the_site_have_titles_of_their_own() -> None:
    """Titles as the navigation shows them."""
    named = re.findall(r"[\w/]+\.md", (ROOT / "mkdocs.yml").read_text().split("nav:")[1])
    files = [
        path for name in named for path in (ROOT / "docs" / name, ROOT / name) if path.exists()
    ]
    titles = [path.read_text().split("\n")[0].removeprefix("# ") for path in files]
    assert sorted(set(titles)) == sorted(titles)


def test_every_page_is_in_the_book() -> None:
    """Pages of `docs/` stand in the navigation."""
    nav = (ROOT / "mkdocs.yml").read_text().split("nav:")[1]
    pages = {path.relative_to(ROOT / "docs").as_posix() for path in (ROOT / "docs").rglob("*.md")}
    assert sorted(pages - set(re.findall(r"[\w/]+\.md", nav))) == []
