"""References to tuples in kernels: what is read through one is what the tuple holds."""

import struct
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest
import xarray as xr
from numba import jit
from numba.core.errors import NumbaError

from hydrosim.files.cache import cache_root
from hydrosim.jit.kernels import kernel_folder
from hydrosim.jit.linking import OPTIONS
from hydrosim.jit.refs import StructReference

pytestmark = pytest.mark.kernels
bare = jit(**OPTIONS)  # without numba's memory manager, as all kernels


class Inner(NamedTuple):
    x: np.ndarray
    flag: bool


class Outer(NamedTuple):
    inner: Inner
    several: tuple
    number: int


@bare
def leaf(inner, i):
    return inner.x[i] + (10.0 if inner.flag else 0.0)


@bare
def total(outer):
    several = outer.several
    return leaf(outer.inner, 1) + leaf(several[0], 0) + several[1][2] + outer.number


@bare
def fill(inner):
    inner.x[0] = 7.0


@bare
def through(outer):
    fill(outer.inner)
    return total(outer)


@bare
def taken_apart(mixed):
    return mixed.first, mixed.flags[0], mixed.flags[1], mixed.second, mixed.table[1, 2], mixed.last


class Mixed(NamedTuple):
    """Members of one byte and of eight, so that places in memory count."""

    first: bool
    flags: tuple
    nothing: tuple
    second: float
    table: np.ndarray
    last: bool


def test_reads_and_writes() -> None:
    first, second = Inner(np.array([1.0, 2.0]), True), Inner(np.array([5.0]), False)
    outer = Outer(first, (second, np.arange(3.0)), 3)
    expected = (2.0 + 10.0) + 5.0 + 2.0 + 3
    assert through(outer) == expected  # as a tuple of numba's own
    assert through(StructReference(outer)) == expected
    assert outer.inner.x[0] == 7.0


@pytest.mark.parametrize("first", [True, False])
@pytest.mark.parametrize("last", [True, False])
def test_members_of_one_byte_and_of_eight_lie_where_kernels_read_them(first, last):
    mixed = Mixed(first, (last, first), (), 2.5, np.arange(6.0).reshape(2, 3), last)
    assert taken_apart(StructReference(mixed)) == (first, last, first, 2.5, 5.0, last)


def test_what_kernels_cannot_read_is_refused() -> None:
    with pytest.raises(TypeError, match="kernels take no str in a tuple"):
        StructReference(Inner(np.zeros(1), "no"))  # type: ignore[arg-type]


def test_a_view_is_read_by_its_strides() -> None:
    table = np.arange(12.0).reshape(3, 4)
    mixed = Mixed(True, (True, True), (), 0.0, table[::2, 1:], True)
    assert taken_apart(StructReference(mixed))[4] == 11.0


# The time loop takes no memory from the heap, at a step, an event or a record: the machine code of
# kernels calls nothing but other kernels and mathematics.

KERNEL = "hydrosim."
ENTRY = ("Py", "_Py", "numba_")  # what unpacks the arguments of a call from Python
HARMLESS = {"cos", "sin", "sincos", "tan", "atan2", "hypot", "pow", "exp", "fmod", "floor"}
HARMLESS |= {"log", "log1p", "memset", "memcpy", "memmove"}
SYMBOLS, ENTRIES, UNDEFINED = 2, 24, 0  # ELF: type of the table, bytes of an entry, section of none


def makes_an_array(n):
    return np.zeros(n).sum()


def test_the_compiler_refuses_kernels_that_make_arrays() -> None:
    with pytest.raises(NumbaError):
        numba.jit(**OPTIONS)(makes_an_array)(3)
    assert numba.jit(**{**OPTIONS, "_nrt": True})(makes_an_array)(3) == 0.0


def test_the_loop_calls_no_allocator(base_run: xr.Dataset) -> None:
    assert base_run.attrs["status"] == "complete"
    files = (cache_root() / kernel_folder()).glob(f"{KERNEL}*.nbc")
    called = [(path.name.split("-")[0].removeprefix(KERNEL), calls(path)) for path in files]
    steps = {"integrate.loop.advance", "integrate.step.take_step", "integrate.dynamics.rhs"}
    assert steps <= {name for name, _ in called}
    for _, names in called:
        assert {name for name in names if not name.startswith((KERNEL, *ENTRY))} <= HARMLESS


def test_an_allocator_would_be_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    allowed = numba.njit(cache=True)(makes_an_array)
    assert allowed(3) == 0.0
    (path,) = tmp_path.rglob("*.nbc")
    assert any("NRT" in name and "alloc" in name.lower() for name in calls(path))


def calls(path: Path) -> set[str]:
    """Names of what the machine code in a file of the cache calls and does not hold."""
    cached = path.read_bytes()
    start = cached.find(b"\x7fELF\x02\x01")
    if start < 0:
        pytest.skip("the machine code is not in the format ELF")
    code = cached[start:]
    (at,), (count,) = struct.unpack_from("<Q", code, 40), struct.unpack_from("<H", code, 60)
    sections = [struct.unpack_from("<IIQQQQIIQQ", code, at + 64 * k) for k in range(count)]
    _, _, _, _, first, size, names, *_ = next(s for s in sections if s[1] == SYMBOLS)
    found = set()
    for k in range(1, size // ENTRIES):
        name, _, _, section = struct.unpack_from("<IBBH", code, first + ENTRIES * k)
        if section == UNDEFINED:
            begin = sections[names][4] + name
            found.add(code[begin : code.index(b"\0", begin)].decode())
    return found
