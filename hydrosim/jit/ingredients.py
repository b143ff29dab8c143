"""What the machine code of a kernel is made of, besides the types of its arguments.

It is made of the bytecode of the kernel, of the values of all names that this reads, and of the
same of all parts that become a part of its code. A whole that it calls stays outside: only its
name, its parameters and its return types matter. Comments, docstrings, line numbers and files do
not matter, so an edit renames only the kernels that it changes.

Bytecode lists all names that it reads, those of globals and of attributes alike. Each is looked up
in the globals, and in every module found there. So rather too much counts than too
little. If the kind of a value is unknown, all sources of kernels count (`hydrosim.jit.kernels`).
"""

from __future__ import annotations

import dis
import hashlib
import os
import sys
from collections.abc import Iterable, Mapping
from enum import Enum
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple

import numpy as np
from numba.core import types
from numba.core.extending import _Intrinsic
from numba.core.typing.templates import builtin_registry

from hydrosim.files.cache import digest_of_sources

LIBRARIES = {"numpy", "numba", "llvmlite"} | sys.stdlib_module_names
"""Packages whose functions are known by name: numba compiles its own version of them."""

HERE = __name__.rpartition(".")[0] + "."
"""Functions of this folder are known by name: the name of the cache folder holds its sources."""

CONSTANTS = (int, float, bool, complex, str, bytes, type(None), type(Ellipsis))
NAMED = (BuiltinFunctionType, np.ufunc)


class Ingredients(NamedTuple):
    """Digest of a function and of the values that it reads, and the functions and kernels among
    them whose code becomes a part of it."""

    digest: str
    parts: list[Any]


_known: dict[Any, Ingredients] = {}


def digest_of_kernel(kernel: Any) -> str:
    """SHA-256 (hex) of all that the machine code of a kernel is made of, but for the types of its
    arguments. It is the same in every process."""
    inside = [kernel]
    numbers = {kernel: 0}
    digest = hashlib.sha256()
    for inner_kernel in inside:  # grows meanwhile; parts may call each other
        kernel_ingredients = ingredients_of(inner_kernel)
        for part in kernel_ingredients.parts:
            if part not in numbers:
                numbers[part] = len(inside)
                inside.append(part)
        digest.update(
            repr(
                (kernel_ingredients.digest, [numbers[part] for part in kernel_ingredients.parts])
            ).encode()
        )
    return digest.hexdigest()


def ingredients_of(kernel: Any) -> Ingredients:
    """Those of a kernel or function alone. They are looked up once in a process."""
    if kernel not in _known:
        function = getattr(kernel, "py_func", kernel)
        reading = _Reading(function)
        reading.add_options(kernel)
        reading.add_function()
        digest = hashlib.sha256(repr(reading.words).encode()).hexdigest()
        _known[kernel] = Ingredients(digest, reading.parts)
    return _known[kernel]


class _Reading:
    """Collects, as ``words``, what the machine code of one function depends on. Their `repr` is the
    same in every process."""

    def __init__(self, function: Any) -> None:
        self.function = function
        self.words: list[Any] = []
        self.parts: list[Any] = []

    def add_options(self, kernel: Any) -> None:
        """Add the options that a kernel is compiled with."""
        self.words.append(type(kernel).__name__)
        if hasattr(kernel, "fastmath"):
            self.words += (sorted(kernel.fastmath), str(getattr(kernel, "returns", None)))
        else:  # compiled by numba's own decorators
            self.add_value(getattr(kernel, "targetoptions", None))

    def add_function(self) -> None:
        """Add the code, and the value of each name that it reads."""
        function = self.function
        self.words.append(f"{function.__module__}.{function.__qualname__}")
        self._add_parameters(function)
        self._add_code(function.__code__, function.__doc__)
        names = tuple(dict.fromkeys(_names_in_code(function.__code__)))
        closure = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
        read = {name: _content_of_cell(cell) for name, cell in closure}
        read |= {name: function.__globals__[name] for name in names if name in function.__globals__}
        self._add_named(read, names)

    def _add_code(self, code: CodeType, docstring: str | None = None) -> None:
        raw = code.co_code
        self.words += (raw, code.co_exceptiontable, code.co_flags, code.co_names)
        self.words += (code.co_varnames, code.co_cellvars, code.co_freevars)
        constants = code.co_consts
        has_docstring = docstring is not None and constants[:1] == (docstring,)
        if has_docstring and not _may_load_first(raw):
            constants = (None, *constants[1:])
        self._add_sequence(constants)

    def _add_parameters(self, function: Any) -> None:
        """Add what a caller must know of a function: names and default values of its
        parameters."""
        code = function.__code__
        counts = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount)
        self.words += (counts, code.co_varnames[: sum(counts[::2])])
        self.add_value(function.__defaults__)
        self.add_value(function.__kwdefaults__)

    def _add_named(self, values: Mapping[str, Any], names: tuple[str, ...]) -> None:
        self.words.append(f"{len(values)} values")
        for name, value in values.items():
            self.words.append(name)
            self.add_value(value, names)

    def add_value(self, value: Any, names: tuple[str, ...] = ()) -> None:
        """Add a value that machine code may hold. Of a module only the attributes ``names``
        are read."""
        if type(value) in CONSTANTS:
            self.words.append(value)
            return
        self.words.append(type(value).__name__)
        if isinstance(value, ModuleType):
            self._add_module(value, names)
        elif isinstance(value, type):
            self._add_class(value)
        elif hasattr(value, "py_func"):
            self._add_kernel(value)
        elif isinstance(value, Enum):
            self.words.append(f"{_name_of(type(value))}.{value.name}")
            self.add_value(value.value)
        elif isinstance(value, CONSTANTS):
            self.words.append(repr(value))
        elif isinstance(value, tuple | list):
            self._add_sequence(value, names)
        elif isinstance(value, set | frozenset):  # in another order in each process
            self.words.append(sorted(map(repr, value)))
        elif isinstance(value, dict):
            self._add_sequence(sorted(value.items(), key=repr), names)
        elif isinstance(value, CodeType):
            self._add_code(value)
        elif isinstance(value, np.dtype):
            self.words += (repr(value), value.itemsize, value.alignment)
        elif isinstance(value, np.ndarray | np.generic):
            self.words += (repr(value.dtype), value.shape, value.strides, value.tobytes())
        elif isinstance(value, types.Type):
            self.words.append(describe_type(value))
        elif isinstance(value, NAMED):
            self.words.append(_name_of(value))
        else:
            self._add_callable(value)

    def _add_sequence(self, values: Iterable[Any], names: tuple[str, ...] = ()) -> None:
        items = tuple(values)
        self.words.append(len(items))
        for value in items:
            self.add_value(value, names)

    def _add_module(self, module: ModuleType, names: tuple[str, ...]) -> None:
        self.words.append(module.__name__)
        if not _is_of_library(module.__name__):
            content = vars(module)
            read = {name: content[name] for name in names if name in content}
            if "__getattr__" in content:  # it may import what it has not
                others = [name for name in names if name not in content and hasattr(module, name)]
                read |= {name: getattr(module, name) for name in others}
            self._add_named(read, names)

    def _add_class(self, kind: type) -> None:
        self.words.append(_name_of(kind))
        if issubclass(kind, Enum):
            self._add_sequence(kind.__members__.items())
        elif hasattr(kind, "_fields"):
            self.words.append(kind._fields)
            self.add_value(getattr(kind, "_field_defaults", None))
        elif not (_is_of_library(kind.__module__) or issubclass(kind, BaseException)):
            self._add_all_sources()

    def _add_kernel(self, kernel: Any) -> None:
        returns = getattr(kernel, "returns", None)
        if returns is None:
            self._add_part(kernel)
        else:  # a whole
            self.words += (_name_of(kernel.py_func), str(returns))
            self._add_parameters(kernel.py_func)

    def _add_part(self, part: Any) -> None:
        self.words.append(f"part {len(self.parts)}")
        self.parts.append(part)

    def _add_callable(self, value: Any) -> None:
        if isinstance(value, _Intrinsic):
            self._add_intrinsic(value._defn)
        elif not isinstance(value, FunctionType):
            self._add_all_sources()
        elif _is_compiled(value):
            self._add_part(value)
        else:
            self.words.append(_name_of(value))

    def _add_intrinsic(self, function: Any) -> None:
        self.words.append(_name_of(function))
        if not _is_of_library(function.__module__):
            self._add_all_sources()

    def _add_all_sources(self) -> None:
        from hydrosim.jit.kernels import sources_digest

        self.words.append(sources_digest())
        home, name = os.path.split(self.function.__code__.co_filename)
        self.words.append(digest_of_sources(Path(home), name))


def _names_in_code(code: CodeType) -> Iterable[str]:
    """All names that code reads, with the code inside it."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names_in_code(constant)


def _may_load_first(raw: bytes) -> bool:
    """Whether bytecode may load its first constant, which is otherwise its docstring. Other bytes
    may look like it, and then the docstring counts."""
    return any(bytes((operation, 0)) in raw for operation in dis.hasconst)


def _content_of_cell(cell: Any) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # not assigned yet
        return None


def _name_of(value: Any) -> str:
    name = getattr(value, "__qualname__", None) or value.__name__
    return f"{getattr(value, '__module__', '')}.{name}"


def _is_compiled(function: FunctionType) -> bool:
    """Whether numba compiles a plain function for kernels. It does so only for functions that were
    registered (`numba.extending.register_jitable`), and refuses all others."""
    if _is_of_library(function.__module__ or ""):
        return False
    return any(value is function for value, _ in builtin_registry.globals)


def _is_of_library(module: str) -> bool:
    return module.partition(".")[0] in LIBRARIES or module.startswith(HERE)


_described: dict[int, tuple[Any, str]] = {}
"""Descriptions by the id of a type, which stays alive here."""


def describe_type(typ: Any) -> str:
    """A type of numba as text, the same in every process. numba's own name of a named tuple lacks
    its fields, and the name of a kernel is an address."""
    if isinstance(typ, types.Dispatcher):
        return f"kernel {digest_of_kernel(typ.dispatcher)}"
    if not isinstance(typ, types.BaseTuple):
        return str(typ)
    if id(typ) not in _described:
        _described[id(typ)] = typ, _describe_tuple(typ)
    return _described[id(typ)][1]


def _describe_tuple(typ: Any) -> str:
    kind = getattr(typ, "instance_class", tuple)
    items = ", ".join(map(describe_type, typ.types))
    return f"{_name_of(kind)}{getattr(kind, '_fields', '')}({items})"
