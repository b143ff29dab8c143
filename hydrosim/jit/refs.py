"""Wide tuples passed to kernels by reference.

A model is a tuple of tuples of a hundred arrays. numba passes every word of it to every kernel that
receives it. That costs time at each call, and most of the compile time. So a kernel takes a named
tuple as one pointer. Fields are read where they are used; fields that are tuples are pointers
again.

`StructReference` is a tuple laid out in memory like numba's structures: numbers are copied, arrays
are shared. A call from Python makes one for each tuple and keeps the last few. Code with a large,
short-lived tuple makes its own.

Kernels do not count references to arrays; numba's own memory manager would lose count.
"""

from __future__ import annotations

import ctypes
import hashlib
import struct
from threading import Lock
from typing import Any

import numpy as np
from llvmlite import ir
from numba import typeof
from numba._dispatcher import compute_fingerprint
from numba.core import types
from numba.core.typing.templates import (
    AbstractTemplate,
    AttributeTemplate,
    infer,
    infer_getattr,
    signature,
)
from numba.extending import (
    NativeValue,
    lower_builtin,
    lower_getattr_generic,
    models,
    register_model,
    unbox,
)

from hydrosim.jit.ingredients import describe_type


class Ref(types.Type):
    """Type of a reference to a tuple of type ``target``."""

    def __init__(self, target: Any) -> None:
        self.target = target
        # short: type names are part of all kernel names, and are compared all the time
        digest = hashlib.sha256(describe_type(target).encode()).hexdigest()
        super().__init__(name=f"Ref({digest[:16]})")


class StructReference:
    """A tuple of arrays, numbers and tuples in memory, for kernels: valid while it lives."""

    def __init__(self, value: tuple) -> None:
        words: list[Any] = []
        layout = _lay_out(value, words)
        self.value = value  # keeps the arrays alive
        self.memory = ctypes.create_string_buffer(struct.pack(layout, *words))
        self.address = ctypes.addressof(self.memory)
        self._numba_type_ = Ref(_type_of(value))


MAX_LAID_OUT = 16  # the tuples passed last: to lay out a model takes longer than most kernels
_kept: dict[int, StructReference] = {}
_keeping = Lock()


def struct_reference(value: Any) -> Any:
    """A named tuple in the form that kernels take; any other value unchanged."""
    if not (isinstance(value, tuple) and hasattr(value, "_fields")):
        return value
    held = _kept.get(id(value))  # keeps the tuple alive, so that no other tuple gets its id
    if held is None:
        held = StructReference(value)
        with _keeping:
            if len(_kept) >= MAX_LAID_OUT:
                del _kept[next(iter(_kept))]
            _kept[id(value)] = held
    return held


def clear_references() -> None:
    """Let go of the tuples that were passed last, whose arrays may be large."""
    with _keeping:
        _kept.clear()


def _lay_out(value: Any, words: list[Any]) -> str:
    """Add the words of a value to ``words``; returns their `struct` format."""
    if isinstance(value, tuple):
        layout = "".join(_lay_out(item, words) for item in value)
        # a structure is aligned like its widest member: "0q" pads to eight bytes
        return layout if set(layout) <= {"?"} else f"0q{layout}0q"
    if isinstance(value, np.ndarray):
        # numba's array: owner, parent, size, bytes an item, data, shape, strides
        words += (0, 0, value.size, value.itemsize, value.ctypes.data)
        words += value.shape
        words += value.strides
        return "q" * (5 + 2 * value.ndim)
    words.append(value)
    if isinstance(value, bool | np.bool_):
        return "?"
    if isinstance(value, int | np.int64):
        return "q"
    if isinstance(value, float):
        return "d"
    raise TypeError(f"kernels take no {type(value).__name__} in a tuple")


_types: dict[bytes, types.Type] = {}


def _type_of(value: Any) -> types.Type:
    """numba's type of a value. numba takes 16 ms to find the type of a wide tuple, and 0.1 ms to
    compare two. Here each part is looked up by its fingerprint."""
    key = compute_fingerprint(value)
    if key not in _types:
        _types[key] = _tuple_type(value) if isinstance(value, tuple) else typeof(value)
    return _types[key]


def _tuple_type(value: tuple) -> types.Type:
    return types.BaseTuple.from_types([_type_of(item) for item in value], type(value))


@register_model(Ref)
class _RefModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Ref) -> None:
        pointee = dmm.lookup(fe_type.target).get_value_type()
        super().__init__(dmm, fe_type, pointee.as_pointer())


@unbox(Ref)
def _take_address(typ: Ref, held: Any, c: Any) -> Any:
    """Pointer to a tuple that Python holds."""
    attribute = c.pyapi.object_getattr_string(held, "address")
    address = c.pyapi.long_as_longlong(attribute)
    c.pyapi.decref(attribute)
    return NativeValue(c.builder.inttoptr(address, c.context.get_value_type(typ)))


def _item_type(target: Any, index: int) -> types.Type:
    """Type of an item that is read: a reference for a tuple, else the value."""
    item = target.types[index]
    return Ref(item) if isinstance(item, types.BaseTuple) else item


def _read_item(builder: Any, target: Any, pointer: Any, index: int) -> Any:
    place = [ir.Constant(ir.IntType(32), 0), ir.Constant(ir.IntType(32), index)]
    item = builder.gep(pointer, place, inbounds=True)
    return item if isinstance(_item_type(target, index), Ref) else builder.load(item)


@infer_getattr
class _RefAttribute(AttributeTemplate):
    key = Ref

    def generic_resolve(self, typ: Ref, attr: str) -> Any:  # type: ignore[override]
        if attr not in getattr(typ.target, "fields", ()):
            return None
        return _item_type(typ.target, typ.target.fields.index(attr))


@lower_getattr_generic(Ref)
def _get_attribute(context: Any, builder: Any, typ: Ref, value: Any, attr: str) -> Any:
    return _read_item(builder, typ.target, value, typ.target.fields.index(attr))


@infer
class _RefItem(AbstractTemplate):
    key = "static_getitem"

    def generic(self, args: Any, kws: Any) -> Any:
        typ, index = args
        if isinstance(typ, Ref) and isinstance(index, int):
            return signature(_item_type(typ.target, index), *args)
        return None


@lower_builtin("static_getitem", Ref, types.IntegerLiteral)
def _get_item(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _read_item(builder, sig.args[0].target, args[0], args[1])
