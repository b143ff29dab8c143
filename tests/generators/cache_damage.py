"""Damaged caches: whatever becomes of a file there, the same is computed as with an empty cache,
and what was damaged is made again, once.

    python -m tests.generators.cache_damage --number 100 --seed 1

Each trial damages one file of a whole cache, or all of them, and compiles `CASE` in a new process.
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

CASE = Path(__file__).parents[2] / "cases" / "sphere" / "decay.yaml"
PROGRAM = f"""
import hydrosim as hs
from hydrosim.studies.run.digest import digest
compiled = hs.compile_scene(hs.load_case("{CASE}").scene())
print(digest((compiled.model, compiled.state)))
"""
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


def computed(cache: Path) -> str:
    """What a process of its own computes of the case, to the bit, or what it says if it fails."""
    environment = {**os.environ, "HYDROSIM_CACHE_DIR": str(cache)}
    command = [sys.executable, "-c", PROGRAM]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    return done.stdout if done.returncode == 0 else f"{done.returncode}: {done.stderr[-500:]}"


def trial(cache: Path, right: str) -> list[str]:
    """Compute with a damaged cache, and again until all is whole: what nobody asks for is not made.
    What is wrong then."""
    found = list[str]()
    for _ in range(3):
        before = {name: (cache / name).stat().st_mtime_ns for name in names(cache)}
        damaged = set(not_whole(cache))
        result = computed(cache)
        after = {name: (cache / name).stat().st_mtime_ns for name in names(cache)}
        again = {name for name in after if after[name] != before.get(name)}
        found += [f"another result: {result}"] if result != right else []
        found += [f"made again though whole: {name}" for name in sorted(again - damaged)]
        if not not_whole(cache):
            return found
    return [*found, *(f"never made again: {name}" for name in not_whole(cache))]


def main() -> int:
    """Answer what the command line asks."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    asked.add_argument("--number", type=int, default=100, help="of trials")
    asked.add_argument("--seed", type=int, default=1)
    given = asked.parse_args()
    draw, wrong = np.random.default_rng(given.seed), 0
    with TemporaryDirectory() as name:
        folder, kinds = Path(name), Counter[str]()
        whole, cache = folder / "whole", folder / "cache"
        right = computed(whole)
        if ":" in right:
            raise SystemExit(right)
        computed(whole)  # what is needed where something is there is kept by the next one
        every = names(whole)
        for number in range(given.number):
            chosen = every if number % 25 == 24 else [every[int(draw.integers(len(every)))]]
            shutil.rmtree(cache, ignore_errors=True)
            shutil.copytree(whole, cache)
            for one in chosen:
                damage(cache, one, KINDS[int(draw.integers(len(KINDS)))], draw)
            found = trial(cache, right)
            kinds[chosen[0].split("/")[0].split("-")[0]] += 1
            wrong += bool(found)
            if found:
                print(f"trial {number}, {', '.join(chosen)}:", *found, sep="\n  ", flush=True)
    print(f"{given.number} damaged caches of {len(every)} files, {dict(kinds)}: {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
