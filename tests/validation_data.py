"""Where the tests find other programs' results: in `tests/data`, whose README says what they are.

There every file is compressed, without loss. The first who asks has all of them unpacked into a
temporary folder, which goes when the process ends.
"""

import lzma
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

DATA = Path(__file__).parent / "data"


def unpacked(name: str) -> Path:
    """The file or folder ``name`` of `tests/data`, ready to be read."""
    return Path(_folder().name) / name


@cache
def _folder() -> TemporaryDirectory[str]:
    folder = TemporaryDirectory(prefix="hydrosim-validation-")
    for path in DATA.rglob("*.xz"):
        out = Path(folder.name) / path.relative_to(DATA).with_suffix("")
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_bytes(lzma.decompress(path.read_bytes()))
    return folder
