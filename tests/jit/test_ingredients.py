"""An edit gives new names to the stored kernels whose machine code it changes, and to no others."""

import importlib
import sys
from collections.abc import Callable
from enum import Enum
from pathlib import Path
from types import FunctionType
from typing import Any

import numba
import numpy as np
import pytest
from command_line import printed
from numba import typeof
from numba.extending import intrinsic, register_jitable

from hydrosim.jit import kernels
from hydrosim.jit.ingredients import digest_of_kernel
from hydrosim.jit.refs import struct_reference

pytestmark = pytest.mark.kernels
Stored = Callable[..., dict[str, str]]
ROOT = Path(__file__).parents[2]
MACHINE = ("platform", "processor", "features")
NAME = "edited_kernels"
SOURCES = {
    "__init__.py": "",
    "sizes.py": """
from typing import NamedTuple
import numpy as np

FACTOR = 2.0
UNUSED = 1.0
SEGMENT = np.dtype([("start", float), ("slope", float)])

class Scale(NamedTuple):
    factor: float
    offset: float

class Pair(NamedTuple):
    low: float
    high: float
""",
    "parts.py": """
from hydrosim.jit.kernels import kernel, summing
from edited_kernels import sizes

@kernel
def inner(x):
    return sizes.FACTOR * x

@kernel
def outer(x, scale):
    '''What it does.'''
    return inner(x) + scale.offset

@kernel
def odd(n):
    return False if n == 0 else even(n - 1)

@kernel
def even(n):
    return True if n == 0 else odd(n - 1)
""",
    "roots.py": """
from hydrosim.jit.kernels import root, root_giving
from edited_kernels.parts import outer
from edited_kernels.sizes import Pair

@root_giving(float)
def total(segments, scale):
    return outer(segments[0].start, scale)

@root
def fill(segments, scale, values):
    # the whole in it has machine code of its own
    values[0] = total(segments, scale)

@root
def span(values):
    pair = Pair(values[0], values[1])
    values[0] = pair.high - pair.low
""",
    "decay.py": """
from hydrosim.jit.kernels import root

HALF = 0.5

@root
def halve(values):
    values[0] = HALF * values[0]
""",
}
TOTAL, OUTER, INNER = {"total"}, {"total", "outer"}, {"total", "outer", "inner"}
EDITS = [
    ("roots.py", "    # the whole in it", "\n\n    # this whole", set()),
    ("parts.py", "What it does.", "Something else.", set()),
    ("parts.py", "    '''What it does.'''\n", "", set()),
    ("sizes.py", "UNUSED = 1.0", "UNUSED = 2.0", set()),
    ("sizes.py", "FACTOR = 2.0", "FACTOR = 3.0", INNER),
    ("sizes.py", "FACTOR = 2.0", "FACTOR = 2", INNER),
    ("parts.py", "FACTOR * x", "FACTOR * x + 1.0", INNER),
    ("parts.py", "FACTOR * x", "FACTOR / x", INNER),
    ("parts.py", "@kernel\ndef inner", "@summing\ndef inner", INNER),
    ("parts.py", "inner(x) +", "inner(x) -", OUTER),
    ("parts.py", "if n == 0 else odd", "if n == 1 else odd", {"odd", "even"}),
    ("roots.py", "outer(segments[0].start", "-outer(segments[0].start", TOTAL),
    ("roots.py", "giving(float)", "giving(int)", {"total", "fill"}),
    (
        "roots.py",
        "def total(segments, scale)",
        "def total(segments, scale, n=1)",
        {"total", "fill"},
    ),
    ("roots.py", "values[0] = total", "values[1] = total", {"fill"}),
    ("sizes.py", '"slope"', '"rise"', {"total", "fill"}),
    ("sizes.py", "factor: float", "power: float", {"total", "fill", "outer"}),
    ("sizes.py", "low: float\n    high: float", "high: float\n    low: float", {"span"}),
    ("decay.py", "HALF = 0.5", "HALF = 0.25", {"halve"}),
]


@pytest.fixture
def stored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Stored:
    """Function that returns the names under which kernels of the package are stored after an
    edit."""

    def names(file: str = "__init__.py", old: str = "", new: str = "") -> dict[str, str]:
        home = tmp_path / str(len(list(tmp_path.iterdir())))  # names do not depend on the folder
        (home / NAME).mkdir(parents=True)
        for name, source in SOURCES.items():
            if name == file:
                assert old in source
                source = source.replace(old, new, 1)
            (home / NAME / name).write_text(source)
        for module in [name for name in sys.modules if name.partition(".")[0] == NAME]:
            monkeypatch.delitem(sys.modules, module)
        with monkeypatch.context() as meanwhile:
            meanwhile.syspath_prepend(str(home))
            return stored_names()

    return names


def stored_names() -> dict[str, str]:
    names = ("sizes", "parts", "roots", "decay")
    sizes, parts, roots, decay = (importlib.import_module(f"{NAME}.{name}") for name in names)
    segments, values = np.zeros(2, sizes.SEGMENT).view(np.recarray), np.zeros(2)
    scale = sizes.Scale(1.0, 0.0)
    calls = {parts.inner: (1.0,), parts.outer: (1.0, scale), parts.odd: (1,), parts.even: (1,)}
    calls = {kernel.dispatcher: args for kernel, args in calls.items()}
    calls |= {roots.total: (segments, scale), roots.fill: (segments, scale, values)}
    calls |= {roots.span: (values,), decay.halve: (values,)}
    return {
        kernel.py_func.__name__: kernel._cache._name(
            tuple(typeof(struct_reference(a)) for a in args), MACHINE
        )
        for kernel, args in calls.items()
    }


@pytest.mark.parametrize(("file", "old", "new", "changed"), EDITS)
def test_an_edit_changes_the_names_of_the_kernels_that_hold_it(stored, file, old, new, changed):
    before, after = stored(), stored(file, old, new)
    assert {name for name in before if before[name] != after[name]} == changed


class Colour(Enum):
    RED = 1


class Shade(Enum):
    RED = 2


class Plain:
    pass


def reads(value: Any) -> FunctionType:
    """A function that reads this value as a global."""
    return FunctionType((lambda: constant).__code__, {"constant": value}, "reads")  # type: ignore[name-defined] # noqa: F821


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (1, 1.0),
        (1, True),
        (0.0, -0.0),
        ("a", "b"),
        (np.float64(1.0), 1.0),
        (np.float64(1.0), np.float32(1.0)),
        ((1, 2), (1, 3)),
        ((1, 2), [1, 2]),
        ((1, (2,)), ((1, 2),)),
        (np.array([1, 2]), np.array([1, 3])),
        (np.array([1, 2]), np.array([1.0, 2.0])),
        (np.zeros((2, 3)), np.zeros((3, 2))),
        (np.zeros((2, 3)), np.zeros((3, 2)).T),
        (frozenset({1, 2}), frozenset({1, 3})),
        (Colour, Shade),
        (Colour.RED, Shade.RED),
        (np.dtype("f8"), np.dtype("f4")),
        (np.dtype("i1,f8"), np.dtype("i1,f8", align=True)),
        (np.sin, np.cos),
        (np.int64, np.int32),
        (numba.float64, numba.float32),
        (numba.njit(lambda x: x), numba.njit(lambda x: -x)),
        (numba.njit(lambda x: x), numba.njit(fastmath=True)(lambda x: x)),
        (register_jitable(lambda x: x), register_jitable(lambda x: -x)),
        (kernels.kernel(lambda x: x), kernels.summing(lambda x: x)),
        (kernels.kernel(lambda x: x), kernels.root_giving(float)(lambda x: x)),
    ],
)
def test_values_that_differ_are_told_apart(one: Any, other: Any) -> None:
    assert digest_of_kernel(reads(one)) != digest_of_kernel(reads(other))
    assert digest_of_kernel(reads(one)) == digest_of_kernel(reads(one))


def test_a_value_in_a_closure_counts() -> None:
    def adding(amount: float) -> FunctionType:
        return lambda x: x + amount  # type: ignore[return-value]

    assert digest_of_kernel(adding(1.0)) != digest_of_kernel(adding(2.0))


def test_a_string_that_is_also_the_docstring_counts() -> None:
    def first():
        """one"""
        return "one"

    def second():
        """two"""
        return "two"

    second.__qualname__ = first.__qualname__
    assert digest_of_kernel(first) != digest_of_kernel(second)


@pytest.mark.parametrize(
    "value", [Plain, Plain(), {1: Plain()}, intrinsic(lambda context, x: None)]
)
def test_all_sources_count_for_a_value_of_another_kind(value, monkeypatch):
    before = digest_of_kernel(reads(value))
    monkeypatch.setattr(kernels, "sources_digest", lambda: "edited")
    assert digest_of_kernel(reads(value)) != before


EVERY_ROOT = """
import gc
from hydrosim.jit.ingredients import digest_of_kernel
from hydrosim.jit.linking import CompiledKernel
import hydrosim.integrate.loop, hydrosim.linear
for one in gc.get_objects():
    if isinstance(one, CompiledKernel):
        print(one.py_func.__module__, one.py_func.__qualname__, digest_of_kernel(one))
"""


def test_digests_are_the_same_in_every_process() -> None:
    """Also where strings in sets come in another order."""
    outputs = [printed(EVERY_ROOT, PYTHONPATH=str(ROOT), PYTHONHASHSEED=seed) for seed in "12"]
    first, second = (output.splitlines() for output in outputs)
    assert sorted(first) == sorted(second)
    assert len(first) > 50


EDITED_FOLDERS = """
import gc, sys, types
import hydrosim as hs
import hydrosim.elements.roll_decay  # no kernel of the case reads it
from hydrosim.jit import ingredients
from hydrosim.jit.linking import _Kernel
hs.simulate(hs.load_case(sys.argv[1], {"duration": 10.0}))
every = [o for o in gc.get_objects() if isinstance(o, types.FunctionType)]
used = [o for o in gc.get_objects() if isinstance(o, _Kernel) and o.overloads]
digests = lambda: {k.py_func.__qualname__: ingredients.digest_of_kernel(k) for k in used}
print(len(used))
for module in sys.argv[2:]:
    edited = [f for f in every if f"{f.__module__}.".startswith(f"hydrosim.{module}.")]
    before, code = digests(), [f.__code__ for f in edited]
    for f in edited:
        f.__code__ = f.__code__.replace(co_consts=(*f.__code__.co_consts, "edited"))
    ingredients._known.clear()
    after = digests()
    for f, old in zip(edited, code):
        f.__code__ = old
    ingredients._known.clear()
    print(module, len(edited), *sorted(k for k in before if before[k] != after[k]))
"""


@pytest.mark.slow
def test_an_edit_recompiles_few_kernels_of_the_base_case(figure):
    """Every function of a folder or file is edited at once."""
    unused = ("elements.roll_decay", "elements.viscous_roll", "tanks")
    folders = (*unused, "water.loads", "elements.linear_mooring", "integrate")
    case = str(ROOT / "cases" / "reverse_float_over" / "base.yaml")
    told = printed(EDITED_FOLDERS, case, *folders, PYTHONPATH=str(ROOT)).splitlines()
    (used,), *lines = map(str.split, told)
    recompiled = {folder: names for folder, edited, *names in lines if int(edited) > 0}
    assert set(recompiled) == set(folders)
    for folder, names in recompiled.items():
        figure(f"kernels of {used} recompiled, {folder}", float(len(names)))
    assert not any(recompiled[folder] for folder in unused)
    assert recompiled["water.loads"] == ["rhs", "wave_loads", "write_record"]
    assert "rhs" in recompiled["elements.linear_mooring"]
    assert len(recompiled["elements.linear_mooring"]) <= 0.2 * int(used)
    assert {"advance", "rhs", "take_step"} <= set(recompiled["integrate"])
