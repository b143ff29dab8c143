"""`Work`: what it takes to make one run of many, here or in another process."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from hydrosim.waves.components import sea

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled
    from hydrosim.scene import Scene
    from hydrosim.waves.components import Components


class Work(NamedTuple):
    """A scene, the sea drawn of its waves, and all else compiled."""

    scene: Scene
    sea: tuple[Components, ...]
    calm: Compiled


def pack(work: Work) -> Scene:
    """What another process must be sent of a work, beside its compiled model."""
    return replace(work.scene, bodies=(), initial=None)


def unpack(scene: Scene, calm: Compiled) -> Work:
    """A work that was packed. Its sea is drawn again from its seeds."""
    scene = replace(scene, bodies=calm.scene.bodies, initial=calm.scene.initial)
    return Work(scene, sea(scene.environment), calm)
