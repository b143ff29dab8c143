"""What the tests of all readers share: other programs' files, damage, and comparison."""

from collections.abc import Callable, Iterator
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from damaged import COUNT
from validation_data import unpacked

from hydrosim.database import HydroDatabase


@pytest.fixture(scope="session")
def validation() -> Path:
    """The folder of other programs' results."""
    return unpacked("")


@pytest.fixture(scope="session")
def differences() -> Callable[[HydroDatabase, HydroDatabase], dict[str, float]]:
    """Arrays that are not the same bit for bit, with the largest difference relative to the
    largest number; infinite where one database lacks the array or has another shape."""

    def compare(a: HydroDatabase, b: HydroDatabase) -> dict[str, float]:
        found = {}
        for name in (item.name for item in fields(HydroDatabase)):
            x, y = getattr(a, name), getattr(b, name)
            if isinstance(x, np.ndarray) and isinstance(y, np.ndarray) and x.shape == y.shape:
                if x.tobytes() != y.tobytes() and (x != y).any():
                    found[name] = float(abs(x - y).max() / abs(x).max())
            elif isinstance(x, np.ndarray) or isinstance(y, np.ndarray):
                found[name] = np.inf
        return found

    return compare


@pytest.fixture(scope="session")
def damaged() -> Callable[[bytes, int], Iterator[bytes]]:
    """A number of damaged copies: cut off, bytes changed, junk put in, pieces lost or doubled, and
    in text numbers that are not numbers, huge or of another kind."""

    def damage(content: bytes, count: int) -> Iterator[bytes]:
        random = np.random.default_rng(851)
        tokens = [b"NaN", b"inf", b"1e300", b"999999999", b"-7", b"x", b"0", b"*****", b"1e-300"]
        for number in range(count * COUNT // 100):
            start, end = sorted(random.integers(0, len(content), 2).tolist())
            kind = number % 6
            if kind == 0:
                yield content[:start]
            elif kind == 1:
                changed = bytearray(content)
                for place in random.integers(0, len(content), 12):
                    changed[place] = random.integers(0, 256)
                yield bytes(changed)
            elif kind == 2:
                yield content[:start] + random.bytes(200) + content[start:]
            elif kind == 3:
                yield content[:start] + content[end:]
            elif kind == 4:
                yield content[:end] + content[start:]
            else:
                words = content.split(b" ")
                for place in random.integers(0, len(words), 1 + number % 3):
                    words[place] = tokens[random.integers(0, len(tokens))]
                yield b" ".join(words)

    return damage
