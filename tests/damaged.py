"""Damage done to files, by seed: readers must say what is wrong or find sense in the rest.

As many files as `HYDROSIM_DAMAGE` says, 100 of each kind unless it is set.
"""

import os
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from hydrosim.errors import InputError

COUNT = int(os.environ.get("HYDROSIM_DAMAGE", "100"))
_NUMBER = re.compile(rb"(?<![\w.])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?(?![\w.])")
_INSTEAD = [b"NaN", b"inf", b"1e308", b"999999999", b"-1", b"0", b"", b"*****", b"1e-308", b"2.5"]


def damaged(content: bytes, seed: int) -> bytes:
    """Cut off, with wrong numbers, with junk, with lines lost or doubled."""
    random = np.random.default_rng(seed)
    at = int(random.integers(len(content)))
    if seed % 5 == 0:
        return content[:at]
    if seed % 5 == 1:
        return content[:at] + random.bytes(int(random.integers(1, 60))) + content[at:]
    if seed % 5 == 2:
        lines = content.split(b"\n")
        line = int(random.integers(len(lines)))
        return b"\n".join(lines[:line] + lines[line + 1 :] + lines[: int(random.integers(3))])
    numbers = list(_NUMBER.finditer(content[: 1500 if seed % 5 == 3 else None]))
    match = numbers[int(random.integers(len(numbers)))]
    instead = _INSTEAD[int(random.integers(len(_INSTEAD)))]
    return content[: match.start()] + instead + content[match.end() :]


def refused(read: Callable[[Path], object], path: Path, content: bytes, name: str) -> int:
    """How many damaged contents of ``path`` in a hundred are refused, by ``name``."""
    count = 0
    for seed in range(COUNT):
        path.write_bytes(damaged(content, seed))
        found = message(read, path)
        assert found is None or name in found, seed
        count += found is not None
    path.write_bytes(content)
    return 100 * count // COUNT


def message(read: Callable[[Path], object], path: Path) -> str | None:
    """What a reader raises about a file, if anything."""
    try:
        read(path)
    except InputError as error:
        return str(error)
    return None
