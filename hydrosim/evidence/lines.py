"""Lines of evidence that come with the program. ``python -m benchmarks --keep evidence`` writes
them from what tests measure."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from hydrosim.evidence.features import Feature

FILE = Path(__file__).with_name("lines.json")


class Kind(StrEnum):
    """What a line holds hydrosim against, in the order of what it is worth."""

    EXPERIMENT = "experiment"
    PROGRAM = "other program"
    CLOSED_FORM = "closed form"
    INDEPENDENT = "independent code"
    SELF = "hydrosim otherwise"


@dataclass(frozen=True)
class Line:
    """A ``claim`` held ``against`` a reference of a ``kind``.

    ``figure`` is the largest error that the ``test`` measured at the ``commit``, ``limit`` the
    bound that it asserts. Both are relative unless the claim names a unit. ``others`` is what
    another program has there. The line is about scenes that use all its ``features``.
    """

    claim: str
    against: str
    kind: Kind
    figure: float
    limit: float
    features: tuple[Feature, ...]
    test: str
    commit: str
    others: str = ""

    @classmethod
    def read(cls, data: Mapping[str, Any]) -> Line:
        """A line as it is stored."""
        features = tuple(Feature[name] for name in data["features"])
        return cls(**{**data, "kind": Kind(data["kind"]), "features": features})

    def as_dict(self) -> dict[str, Any]:
        """The line as it is stored, of plain texts and numbers: names of features, figures of three
        digits."""
        return {
            **asdict(self),
            "kind": self.kind.value,
            "figure": float(f"{self.figure:.3g}"),
            "limit": float(self.limit),
            "features": [feature.name for feature in self.features],
        }


def known_lines() -> tuple[Line, ...]:
    """All lines, by kind."""
    return tuple(Line.read(data) for data in json.loads(FILE.read_text("utf-8")))


def lines_about(used: Collection[Feature]) -> list[Line]:
    """Lines whose features are all ``used``."""
    return [line for line in known_lines() if set(line.features) <= set(used)]
