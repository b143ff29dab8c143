"""Kernels are compiled once: parts in their callers, wholes by name, also from the disk cache."""

import pickle
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from time import perf_counter, sleep
from typing import Any

import linked_kernels
import numpy as np
import pytest
from command_line import printed
from numba.core.codegen import JITCodeLibrary
from numba.core.errors import NumbaError

from hydrosim.files.cache import digest_of_sources
from hydrosim.jit import kernels
from hydrosim.jit.waiting import Torn, running_time

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
module = result.library._final_module
print(*(f.name for f in module.functions if not f.is_declaration), end=" | ")
print(*(one.name for one in (*module.functions, *module.global_variables) if one.is_declaration))
"""
CHOOSING = """
import numpy as np, linked_kernels
from linked_kernels import fill, filled, misspelt
for factor in (-1.0, 1.0):
    scale = linked_kernels.Scale(factor, np.array([1.0]))
    print(filled(np.zeros(3), scale, True), *(len(one.overloads) for one in (fill, misspelt)))
"""


def test_parts_and_wholes_compute_what_their_sources_say() -> None:
    assert linked_kernels.scaled(3.0, SCALE) == 7.0
    assert linked_kernels.summed(VALUES, SCALE) == 16.0
    assert linked_kernels.twice_summed(VALUES, SCALE) == EXPECTED


def test_a_whole_is_behind_a_door_and_a_part_is_inside(tmp_path: Path) -> None:
    (line,) = run(tmp_path, LISTING)
    defined, declared = (words.split() for words in line.split("|"))
    assert [name for name in declared if "linked_kernels.summed" in name]
    assert not [name for name in defined + declared if "scaled" in name]
    assert not [name for name in defined if "6summed" in name]  # as numba writes such a name


def test_cached_code_finds_the_wholes_that_it_calls(tmp_path: Path) -> None:
    """In a process of its own, where they lie at other addresses."""
    compiled, loaded = run(tmp_path), run(tmp_path)
    assert compiled[0] == loaded[0] == f"{EXPECTED} 16.0"
    # Python calls the same `summed` that the kernel calls
    assert compiled[1:] == ["0 1", "0 1"]
    assert loaded[1:] == ["1 0", "1 0"]


def test_a_whole_is_compiled_or_loaded_when_it_is_first_called(tmp_path: Path) -> None:
    """Also where its caller comes from the cache, and for the first time needs it."""
    assert run(tmp_path, CHOOSING) == run(tmp_path, CHOOSING) == ["0.0 0 0", "3.0 1 0"]
    assert [path for path in tmp_path.rglob("*.nbc") if ".fill-" in path.name]
    assert not [path for path in tmp_path.rglob("*.nbc") if "misspelt" in path.name]


def test_a_whole_that_cannot_be_compiled_ends_the_call_with_its_error() -> None:
    for _ in range(2):
        with pytest.raises(NumbaError, match="fil"):
            linked_kernels.filled(np.zeros(3), SCALE, False)
    assert linked_kernels.filled(np.zeros(3), SCALE, True) == 3.0


def test_a_whole_gives_what_it_says() -> None:
    for wrong in (kernels.root(doubled), kernels.root_giving(float, float)(doubled)):
        with pytest.raises(NumbaError):
            wrong(3.0)


def test_an_interrupt_while_others_wait_for_a_whole_tears_their_work(monkeypatch):
    values = np.zeros((2, 3))[:, 1:]  # arguments of types that are not compiled yet

    def interrupted(args: Any) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as meanwhile:
        meanwhile.setattr(linked_kernels.fill, "compile", interrupted)
        for _ in range(2):
            with pytest.raises(Torn):
                linked_kernels.filled(values[:, 0], SCALE, True)
    assert linked_kernels.filled(values[:, 0], SCALE, True) == 2.0


def test_the_clock_of_runs_stands_still_while_others_wait_for_a_whole(monkeypatch):
    """The whole cannot be compiled at all, which takes a second."""
    values = np.zeros((2, 2, 3))[::-1, 0, 0]
    linked_kernels.filled(values, SCALE._replace(factor=-1.0), True)

    def slow(args: Any) -> None:
        sleep(1.0)
        raise ValueError("no")

    monkeypatch.setattr(linked_kernels.misspelt, "compile", slow)
    begin, own = perf_counter(), running_time()
    with pytest.raises(ValueError, match="no"):
        linked_kernels.filled(values, SCALE, False)
    assert perf_counter() - begin > 1.0 > 2.0 * (running_time() - own)


def test_a_caller_whose_callee_is_gone_from_the_cache_has_it_compiled_again(tmp_path: Path) -> None:
    run(tmp_path)
    for file in tmp_path.rglob("linked_kernels.summed*"):
        file.unlink()
    again = run(tmp_path)
    assert again == [f"{EXPECTED} 16.0", "1 0", "0 1"]


def test_an_edit_recompiles_what_it_touches(tmp_path: Path) -> None:
    """A part of `summed` is edited, which `twice_summed` calls through its door."""
    here, cache = Path(linked_kernels.__file__), tmp_path / "cache"
    run(cache)
    edited = here.read_text().replace("scale.factor * x +", "-scale.factor * x +")
    (tmp_path / here.name).write_text(f"# a comment\n{edited}")
    result = 4.0 - 2.0 * 6.0
    assert run(cache, first=tmp_path) == [f"{result + 3.0 - 2.0 * 6.0} {result}", "1 0", "0 1"]
    assert run(cache) == [f"{EXPECTED} 16.0", "1 0", "1 0"]


def test_kernels_are_pickled_by_name() -> None:
    for one in (linked_kernels.scaled, linked_kernels.summed):
        assert pickle.loads(pickle.dumps(one)) is one


def test_any_edit_of_a_source_of_kernels_changes_the_digest_of_checkpoints(tmp_path, monkeypatch):
    monkeypatch.setattr(kernels, "PACKAGE", tmp_path)
    source, other = tmp_path / "integrate" / "dynamics.py", tmp_path / "cli.py"
    source.parent.mkdir()
    source.write_text("a = 1\n")
    other.write_text("")
    before = digest_anew()
    other.write_text("b = 1\n")
    assert digest_anew() == before
    source.write_text("a = 2\n")
    assert digest_anew() != before


def digest_anew() -> str:
    """The digest of the sources as a new process finds it."""
    digest_of_sources.cache_clear()
    return kernels.sources_digest()


@pytest.fixture
def engine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """LLVM's engine with its own cache; SIGTERM comes as it hands code over or asks for it."""
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(tmp_path))
    hooks = JITCodeLibrary._object_compiled_hook, JITCodeLibrary._object_getbuffer_hook
    set_hooks = linked_kernels.scaled.dispatcher.targetctx.codegen()._engine.set_object_cache
    coming: list[str] = []

    def signalled(hook: Callable[..., Any]) -> Callable[..., Any]:
        def called(*arguments: Any) -> Any:
            if coming and coming.pop():
                signal.raise_signal(signal.SIGTERM)
            return hook(*arguments)

        return called

    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    set_hooks(*map(signalled, hooks))
    yield coming
    set_hooks(*hooks)
    signal.signal(signal.SIGTERM, before)


def test_a_signal_while_code_is_handed_over_comes_after_it(engine: list[str]) -> None:
    """The kernel is compiled, and at its second making loaded from the disk."""
    for _ in range(2):
        double = kernels.kernel(doubled)
        engine.append("code")
        with pytest.raises(KeyboardInterrupt):
            double(3.0)
        assert double(3.0) == 6.0


def doubled(x):
    return 2.0 * x


def run(cache: Path, program: str = PROGRAM, first: Path | None = None) -> list[str]:
    """What a program prints in a new process with this cache; ``first`` replaces modules."""
    here = Path(__file__).parent
    folders = [*([first] if first else []), here.parents[1], here.parent, here]
    paths = {"PYTHONPATH": ":".join(map(str, folders)), "HYDROSIM_CACHE_DIR": str(cache)}
    return printed(program, **paths).splitlines()


# Which roots a scene compiles.

CASES = Path(__file__).parents[2] / "cases"
PROGRAM_OF_NEEDS = """
import gc, sys
import hydrosim as hs
from hydrosim.jit.linking import CompiledKernel
hs.simulate(hs.load_case(*sys.argv[1:2], {"duration": 20.0}))
for one in gc.get_objects():
    if isinstance(one, CompiledKernel) and one.overloads:
        print(one.py_func.__module__ + "." + one.py_func.__qualname__)
"""
WATER = {"hydrosim.elements.linear_mooring.add_energy", "hydrosim.water.loads.wave_loads"}
EVERY_STAGE = {
    "hydrosim.elements.linear_mooring.add_force",
    "hydrosim.water.radiation.memory.radiation_states",
    "hydrosim.multibody.mass.accelerate_freely",
    "hydrosim.multibody.kinematics.acceleration_map",
    "hydrosim.integrate.dynamics.add_constraints",
    "hydrosim.integrate.dynamics.find_mass",
}


@pytest.mark.slow
def test_a_dry_block_with_friction_needs_nothing_of_the_water() -> None:
    dry, wet = roots("friction_block/exact"), roots("reverse_float_over/base")
    assert wet >= WATER
    assert not WATER & dry


@pytest.mark.slow
def test_what_every_stage_calls_is_no_root() -> None:
    """The door of one costs some percent of a step."""
    assert not EVERY_STAGE & roots("reverse_float_over/base")
    assert not EVERY_STAGE & roots("friction_block/exact")


def roots(case: str) -> set[str]:
    """Those that a run of a case calls."""
    return set(printed(PROGRAM_OF_NEEDS, str(CASES / f"{case}.yaml")).split())
