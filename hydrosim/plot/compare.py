"""Picture of a comparison: run and recording over each other, and what is between them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from hydrosim.compare.compare import Comparison, Result
from hydrosim.plot.panels import HEIGHT, Panel, lines, picture

CHANNELS = 8  # in a picture


def draw_comparison(found: Comparison, title: str, path: Path) -> None:
    """Write the picture of the channels to ``path``: of more than `CHANNELS`, those that are
    furthest apart."""
    furthest = sorted(found.results, key=lambda name: -found.results[name].error)[:CHANNELS]
    shown = [result for name, result in found.results.items() if name in furthest]
    panels = [panel for result in shown for panel in _panels(found.overlap.time, result)]
    more = len(found.results) - len(shown)
    note = f"; {more} channels that are closer are not drawn" if more else ""
    picture(panels, title + note).savefig(path)


def _panels(time: np.ndarray, result: Result) -> Iterator[Panel]:
    pair = result.pair
    scale, unit = (np.degrees(1.0), "deg") if pair.unit == "rad" else (1.0, pair.unit)
    ours, recorded = scale * pair.ours, scale * pair.recorded
    name = pair.channel.replace(".", " ").replace("_", " ")
    yield lines(time, name, unit, {f"{name}: recorded": recorded, "ours": ours})
    yield lines(time, "difference", unit, {"ours - recorded": ours - recorded})._replace(
        height=HEIGHT / 2
    )
