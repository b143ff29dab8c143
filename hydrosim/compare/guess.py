"""Guesses of the channel that a column of a recording holds, from names and units.

A column with the name of a channel is that channel. Other columns match a channel under three
conditions. All words of the name belong to the channel ("barge heave velocity", "Z [m]",
"run1.ROLL_deg", "fender 2"). The words that distinguish the channel (its degree of freedom, its
number) are among them. The unit fits. If two channels or two columns remain, nothing is guessed.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence

from hydrosim.compare.mapping import ChannelPlace
from hydrosim.documents.text import name_and_unit, readable_unit
from hydrosim.documents.units import factor
from hydrosim.dofs import DOFS
from hydrosim.recordings.recording import RecordedColumn, Recording, is_time
from hydrosim.results.channels import Channel

OUR_WORDS = {  # words of other programs, and our word for each
    "x": "surge",
    "y": "sway",
    "z": "heave",
    "rx": "roll",
    "ry": "pitch",
    "rz": "yaw",
    **dict.fromkeys(("motion", "motions", "displacement", "disp", "pos"), "position"),
    **dict.fromkeys(("eta", "zeta", "surface"), "elevation"),
    **dict.fromkeys(("vel", "speed"), "velocity"),
    "waves": "wave",
    "contact": "fender",
}
# If several variables match, the first of these is chosen: "heave" is a position.
USUAL_VARIABLES = (
    "position",
    "wave_elevation",
    "fender_normal_force",
    "spring_tension",
    "velocity",
)


def guess(recording: Recording, channels: Sequence[Channel]) -> dict[str, ChannelPlace]:
    """Column of each recognised channel; other channels are left out."""
    names, time = {channel.name for channel in channels}, recording.time_column()
    numbered = [
        (number, column)
        for number, column in enumerate(recording.columns, 1)
        if column is not time and not is_time(column.name)
    ]
    same = [(c.name, number) for number, c in numbered if c.name in names]
    free = [channel for channel in channels if channel.name not in dict(same)]
    others = [(number, c) for number, c in numbered if c.name not in names] if free else []
    found = [(name, ChannelPlace(column=number)) for name, number in same]
    for number, column in others:
        for name, unit in _readings(column):
            if channel := _matching_channel(name, unit, free):
                found.append((channel, ChannelPlace(column=number, unit=unit)))
                break
    claims = Counter(name for name, _ in found)
    return {name: place for name, place in found if claims[name] == 1}


def _readings(column: RecordedColumn) -> Iterator[tuple[str, str | None]]:
    """Possible names and units of a column, the plainest first: as it is, with a unit at its end
    ("ROLL_deg"), and each without the names of its groups ("run1.ROLL_deg")."""
    groups = name_and_unit(column.name)[0].split(".")
    for k in range(len(groups)):
        name = ".".join(groups[k:])
        yield name, column.unit
        stem, _, end = name.rpartition("_")
        if stem and column.unit is None and end and (unit := readable_unit(end)):
            yield stem, unit


def _matching_channel(name: str, unit: str | None, channels: Sequence[Channel]) -> str | None:
    """The single channel that matches a column of this name; None if none or several do."""
    words = _words(name)
    fits = [c.name for c in channels if _matches_channel(words, c.name) and _converts(unit, c.unit)]
    by_variable = [
        [name for name in fits if name.split(".")[0] == usual] for usual in USUAL_VARIABLES
    ]
    meant = next((named for named in by_variable if named), fits)
    return meant[0] if len(meant) == 1 else None


def _matches_channel(words: frozenset[str], channel: str) -> bool:
    own = _words(channel)
    tells = {word for word in own if word in DOFS or word.isdigit()}
    spoken = any(not word.isdigit() for word in words)
    return spoken and tells <= words <= own


def _words(name: str) -> frozenset[str]:
    """Words in a name, in our terms; letters and digits are separated."""
    return frozenset(OUR_WORDS.get(word, word) for word in re.findall(r"[a-z]+|\d+", name.lower()))


def _converts(unit: str | None, ours: str) -> bool:
    try:
        return unit is None or factor(unit, ours) > 0.0
    except ValueError:
        return False
