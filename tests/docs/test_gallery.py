"""The gallery shows every case, by pictures that are small."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "gallery.md"
MAX_BYTES = 60_000


def test_every_case_has_a_picture() -> None:
    text = PAGE.read_text("utf-8")
    cases = {path.parent.name for path in (ROOT / "cases").glob("*/README.md")}
    assert set(re.findall(r"\(\.\./cases/(\w+)/README\.md\)", text)) == cases
    pictures = set(re.findall(r"\((gallery/\w+\.png)\)", text))
    assert {Path(picture).stem for picture in pictures} == cases
    files = [path for path in (ROOT / "docs" / "gallery").iterdir() if path.suffix == ".png"]
    assert {f"gallery/{path.name}" for path in files} == pictures
    assert max(path.stat().st_size for path in files) < MAX_BYTES
