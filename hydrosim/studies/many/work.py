"""`RunTask`: what it takes to make one run of many, here or in another process."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from hydrosim.waves.components import sea

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled
    from hydrosim.scene import Scene
    from hydrosim.waves.components import WaveComponents


class RunTask(NamedTuple):
    """A scene, the sea drawn of its waves, and all else compiled; whether its run ``estimates`` its
    error."""

    scene: Scene
    sea: tuple[WaveComponents, ...]
    calm: Compiled
    estimates: bool = False


class PackedTask(NamedTuple):
    """What another process must be sent of a work, beside its compiled model."""

    scene: Scene
    estimates: bool


def pack(work: RunTask) -> PackedTask:
    """The work without its sea and its compiled model."""
    return PackedTask(replace(work.scene, bodies=(), initial=None), work.estimates)


def unpack(packed: PackedTask, calm: Compiled) -> RunTask:
    """A work that was packed. Its sea is drawn again from its seeds."""
    scene = replace(packed.scene, bodies=calm.scene.bodies, initial=calm.scene.initial)
    return RunTask(scene, sea(scene.environment), calm, packed.estimates)
