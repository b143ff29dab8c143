"""The prescribed motions of a scene in words."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrosim.compiling.joints.drives import drives_of, is_turn, motion_at
from hydrosim.forces.drive import Drive
from hydrosim.forces.signal import Harmonic, Recorded
from hydrosim.presentation.nodes import Part, Sentence, Value
from hydrosim.scene import Scene

PLACES = 7  # in each piece of a signal, for its largest speed
SWING = 64  # places in a period


def describe_drives(scene: Scene, begin: float = 0.0) -> Iterator[Sentence]:
    """A sentence for each drive: what it moves, how far, and how fast."""
    for name, drive in drives_of(scene).items():
        unit = "rad" if is_turn(scene, drive) else "m"
        times = _times(drive, begin, begin + scene.duration)
        position, speed, acceleration = np.array([motion_at(drive, float(t)) for t in times]).T
        parts: list[Part] = [
            *(name, drive.driven, _form(drive)),
            *(Value(float(position.min()), unit), Value(float(position.max()), unit)),
            *(Value(float(position[0]), unit), Value(float(speed[0]), f"{unit}/s")),
            Value(float(np.abs(speed).max()), f"{unit}/s"),
            Value(float(np.abs(acceleration).max()), f"{unit}/s^2"),
        ]
        text = (
            "{} moves {} by {}: from {} to {}; it starts at {} with {}; at most {} and {}."
        )
        yield Sentence(text, parts)


def _form(drive: Drive) -> str:
    signal = drive.position
    if isinstance(signal, Harmonic):
        return f"a sine of {signal.period:g} s"
    what = "a record" if isinstance(signal, Recorded) else "a table"
    return f"{what} of {np.size(signal.value)} values"


def _times(drive: Drive, begin: float, end: float) -> np.ndarray:
    """Times of a run at which a drive is looked at."""
    signal = drive.position
    if isinstance(signal, Harmonic):
        count = int(np.ceil(min((end - begin) / signal.period, 1.0) * SWING))
        return np.linspace(begin, min(end, begin + signal.period), count + 1)
    knots = np.clip(np.asarray(signal.time, float), begin, end)
    inside = [np.linspace(a, b, PLACES, endpoint=False) for a, b in zip(knots[:-1], knots[1:])]
    return np.unique(np.concatenate([*inside, [end]]))
