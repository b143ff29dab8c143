"""Kernels are compiled once: parts in their callers, wholes by name, also from the disk cache."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import linked_kernels
import numpy as np
import pytest

from hydrosim.jit import kernels

pytestmark = pytest.mark.kernels
VALUES, SCALE = np.arange(4.0), linked_kernels.Scale(2.0, np.array([1.0]))
EXPECTED = (2.0 * 6.0 + 4.0) + (2.0 * 6.0 + 3.0)
PROGRAM = """
import test_linking as here, linked_kernels
from linked_kernels import summed, twice_summed
print(twice_summed(here.VALUES, here.SCALE), summed(here.VALUES, here.SCALE))
for one in (twice_summed, summed):
    print(sum(one.stats.cache_hits.values()), sum(one.stats.cache_misses.values()))
"""
LISTING = """
import test_linking as here, linked_kernels
linked_kernels.twice_summed(here.VALUES, here.SCALE)
(result,) = linked_kernels.twice_summed.overloads.values()
functions = list(result.library._final_module.functions)
print(*(f.name for f in functions if not f.is_declaration), end=" | ")
print(*(f.name for f in functions if f.is_declaration))
"""


def test_parts_and_wholes_compute_what_their_sources_say() -> None:
    assert linked_kernels.scaled(3.0, SCALE) == 7.0
    assert linked_kernels.summed(VALUES, SCALE) == 16.0
    assert linked_kernels.twice_summed(VALUES, SCALE) == EXPECTED


def test_a_whole_is_called_by_name_and_a_part_is_inside(tmp_path: Path) -> None:
    (line,) = run(tmp_path, LISTING)
    defined, declared = (words.split() for words in line.split("|"))
    assert [name for name in declared if "linked_kernels.summed" in name]
    assert not [name for name in defined + declared if "scaled" in name]
    assert not [name for name in defined if "6summed" in name]  # as numba writes such a name


def test_cached_code_finds_the_wholes_that_it_calls(tmp_path: Path) -> None:
    """In a process of its own, where they lie at other addresses."""
    compiled, loaded = run(tmp_path), run(tmp_path)
    assert compiled[0] == loaded[0] == f"{EXPECTED} 16.0"
    # of `summed` there are two: for references to a scale, and for a scale from Python
    assert compiled[1:] == ["0 1", "0 2"]
    assert loaded[1:] == ["1 0", "2 0"]


def test_a_caller_whose_callee_is_gone_from_the_cache_has_it_compiled_again(tmp_path: Path) -> None:
    run(tmp_path)
    for file in tmp_path.rglob("linked_kernels.summed*"):
        file.unlink()
    again = run(tmp_path)
    assert again == [f"{EXPECTED} 16.0", "1 0", "0 2"]


def test_kernels_are_pickled_by_name() -> None:
    for one in (linked_kernels.scaled, linked_kernels.summed):
        assert pickle.loads(pickle.dumps(one)) is one


def test_any_edit_of_a_source_of_kernels_makes_a_new_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernels, "PACKAGE", tmp_path)
    source, other = tmp_path / "stepping" / "dynamics.py", tmp_path / "cli.py"
    source.parent.mkdir()
    source.write_text("a = 1\n")
    other.write_text("")
    before = kernels.sources_digest.__wrapped__()
    other.write_text("b = 1\n")
    assert kernels.sources_digest.__wrapped__() == before
    source.write_text("a = 2\n")
    assert kernels.sources_digest.__wrapped__() != before


def run(cache: Path, program: str = PROGRAM) -> list[str]:
    """What a program prints in a new process with this cache folder."""
    here = Path(__file__).parent
    paths = {"PYTHONPATH": f"{here.parents[1]}:{here}", "HYDROSIM_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", program], env=paths, capture_output=True, text=True, check=True
    )
    return done.stdout.splitlines()
