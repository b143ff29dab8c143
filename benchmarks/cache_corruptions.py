"""Damaged caches: whatever becomes of a file there, a run gives what it gives with an empty cache,
and what was damaged is made again, once.

    python -m benchmarks.cache_corruptions --number 100 --seed 1

Each trial damages one file of a whole cache, or all of them, and runs `CASE` in a new process.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from hydrosim.cache import DIGEST, stored
from hydrosim.compare.exact import differences, read_result

CASE = Path(__file__).parents[1] / "cases" / "sphere" / "decay.yaml"
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


def not_whole(cache: Path) -> list[str]:
    """What would not be taken from a cache."""
    os.environ["HYDROSIM_CACHE_DIR"] = str(cache)
    return [name for name in names(cache) if stored(name) is None]


def run(cache: Path, result: Path) -> str:
    """Run the case in a process of its own; what it says if it fails."""
    command = [sys.executable, "-m", "hydrosim", "run", str(CASE), "-o", str(result)]
    environment = {**os.environ, "HYDROSIM_CACHE_DIR": str(cache)}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    return "" if done.returncode == 0 else f"exit code {done.returncode}: {done.stderr[-500:]}"


def trial(whole: Path, folder: Path, chosen: list[str], draw: np.random.Generator) -> list[str]:
    """Damage what is ``chosen`` in a copy of a ``whole`` cache; what is wrong then."""
    cache, result = folder / "cache", folder / "run.nc"
    shutil.rmtree(cache, ignore_errors=True)
    shutil.copytree(whole, cache)
    for name in chosen:
        damage(cache, name, KINDS[int(draw.integers(len(KINDS)))], draw)
    before = {name: (cache / name).stat().st_mtime_ns for name in names(cache)}
    said = run(cache, result)
    if said:
        return [said]
    apart = differences(read_result(folder / "empty.nc"), read_result(result))
    again = [n for n in names(cache) if (cache / n).stat().st_mtime_ns != before.get(n)]
    more = [name for name in again if name not in chosen]
    left = (f"not made again: {name}" for name in not_whole(cache))
    return [*apart, *(f"made again: {name}" for name in more), *left]


def main() -> int:
    """Answer what the command line asks."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    asked.add_argument("--number", type=int, default=100, help="of trials")
    asked.add_argument("--seed", type=int, default=1)
    given = asked.parse_args()
    draw, wrong = np.random.default_rng(given.seed), 0
    with TemporaryDirectory() as name:
        folder, kinds = Path(name), Counter[str]()
        whole = folder / "whole"
        # what a run needs that finds something there is kept by the next one
        for result in ("empty.nc", "second.nc", "third.nc"):
            if said := run(whole, folder / result):
                raise SystemExit(said)
        every = names(whole)
        for number in range(given.number):
            chosen = every if number % 25 == 24 else [every[int(draw.integers(len(every)))]]
            found = trial(whole, folder, chosen, draw)
            kinds[chosen[0].split("/")[0].split("-")[0]] += 1
            wrong += bool(found)
            if found:
                print(f"trial {number}, {', '.join(chosen)}:", *found, sep="\n  ")
    print(f"{given.number} damaged caches of {len(every)} files, {dict(kinds)}: {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
