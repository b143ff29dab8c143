"""Wide tuples handed to kernels by reference.

A model is a tuple of tuples of a hundred arrays. numba hands every word of it to every kernel that
is called with it, which costs time at each call and most of the time to compile. ``ref(model)`` is
one pointer; fields are read where they are used, and those that are tuples are references again.

A reference is to the stack of the kernel that made it: hand it down, never return it. It is for
kernels, which do not count references to arrays; numba's own memory manager would lose count.
"""

from __future__ import annotations

import hashlib
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import (
    AbstractTemplate,
    AttributeTemplate,
    infer,
    infer_getattr,
    signature,
)
from numba.extending import (
    intrinsic,
    lower_builtin,
    lower_getattr_generic,
    models,
    register_model,
)


class Ref(types.Type):
    """Type of a reference to a tuple of type ``target``."""

    def __init__(self, target: Any) -> None:
        self.target = target
        # short: names of types are part of the names of all kernels, and are compared all the time
        super().__init__(name=f"Ref({hashlib.sha256(str(target).encode()).hexdigest()[:16]})")


@register_model(Ref)
class _RefModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Ref) -> None:
        pointee = dmm.lookup(fe_type.target).get_value_type()
        super().__init__(dmm, fe_type, pointee.as_pointer())


def _ref(typingctx: Any, value: Any) -> Any:
    """A reference to a tuple, or to what one refers to already."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        known = isinstance(value, Ref)
        return args[0] if known else cgutils.alloca_once_value(builder, args[0])

    return (value if isinstance(value, Ref) else Ref(value))(value), codegen


ref: Any = intrinsic(_ref)


def _item(target: Any, index: int) -> types.Type:
    """Type of what is read: a reference to a tuple, else the value."""
    item = target.types[index]
    return Ref(item) if isinstance(item, types.BaseTuple) else item


def _read(builder: Any, target: Any, pointer: Any, index: int) -> Any:
    place = [ir.Constant(ir.IntType(32), 0), ir.Constant(ir.IntType(32), index)]
    item = builder.gep(pointer, place, inbounds=True)
    return item if isinstance(_item(target, index), Ref) else builder.load(item)


@infer_getattr
class _RefAttribute(AttributeTemplate):
    key = Ref

    def generic_resolve(self, typ: Ref, attr: str) -> Any:  # type: ignore[override]
        if attr not in getattr(typ.target, "fields", ()):
            return None
        return _item(typ.target, typ.target.fields.index(attr))


@lower_getattr_generic(Ref)
def _get_attribute(context: Any, builder: Any, typ: Ref, value: Any, attr: str) -> Any:
    return _read(builder, typ.target, value, typ.target.fields.index(attr))


@infer
class _RefItem(AbstractTemplate):
    key = "static_getitem"

    def generic(self, args: Any, kws: Any) -> Any:
        typ, index = args
        if isinstance(typ, Ref) and isinstance(index, int):
            return signature(_item(typ.target, index), *args)
        return None


@lower_builtin("static_getitem", Ref, types.IntegerLiteral)
def _get_item(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _read(builder, sig.args[0].target, args[0], args[1])
