"""Damage done to files of a cache."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from hydrosim.files.cache import DIGEST

Damage = Callable[[bytes, bytes, np.random.Generator], bytes]
HEAD = DIGEST().digest_size


def truncated(content: bytes, other: bytes, draw: np.random.Generator) -> bytes:
    """Cut off, as by a full disk."""
    return content[: int(draw.integers(len(content)))]


def flipped(content: bytes, other: bytes, draw: np.random.Generator) -> bytes:
    """One to eight bits."""
    changed = np.frombuffer(content, np.uint8).copy()
    at = draw.integers(len(content), size=draw.integers(1, 9))
    changed[at] ^= 1 << draw.integers(8, size=at.size).astype(np.uint8)
    return changed.tobytes()


def swapped(content: bytes, other: bytes, draw: np.random.Generator) -> bytes:
    """Another whole file."""
    return other


def of_another_version(content: bytes, other: bytes, draw: np.random.Generator) -> bytes:
    """What has the digest that it had under another version's name."""
    return DIGEST(b"kernels-0/other.nbc\0" + content[HEAD:]).digest() + content[HEAD:]


def bare(content: bytes, other: bytes, draw: np.random.Generator) -> bytes:
    """As a version before kept it, or something else: without a digest."""
    return content[HEAD:]


def random(content: bytes, other: bytes, draw: np.random.Generator) -> bytes:
    """Any bytes."""
    return draw.bytes(len(content))


def longer(content: bytes, other: bytes, draw: np.random.Generator) -> bytes:
    """With more at its end."""
    return content + draw.bytes(int(draw.integers(1, 1000)))


KINDS: tuple[Damage, ...] = (
    *(truncated, flipped, swapped, of_another_version),
    *(bare, random, longer),
)


def names(cache: Path) -> list[str]:
    """All that is kept in a cache."""
    return sorted(str(path.relative_to(cache)) for path in cache.rglob("*") if path.is_file())


def damage(cache: Path, name: str, kind: Damage, draw: np.random.Generator) -> None:
    """Damage one file."""
    path, others = cache / name, [other for other in names(cache) if other != name]
    other = (cache / others[int(draw.integers(len(others)))]).read_bytes()
    path.write_bytes(kind(path.read_bytes(), other, draw))
