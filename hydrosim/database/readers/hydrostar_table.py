"""HydroStar's text tables: heads of lines with #, and one quadratic transfer function."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hydrosim.database.database import Complex, Real
from hydrosim.database.readers.assembly import Abscissa, frequencies
from hydrosim.database.readers.text import Text
from hydrosim.scene.hydrodynamics import Given

DIFFERENCE_TOLERANCE_RAD_S = 1e-6  # rad/s

_FACTS = "Reference length", "Water density", "Gravity acceleration"
_SMALLEST = 0.5  # density in tonnes and gravity in 10 m/s^2; the inverse is the largest value

_NUMBER_PATTERN = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][-+]?\d+)?")


@dataclass(frozen=True)
class QtfTable:
    """One load: ``value`` (nh, nw, nd) in rows with the lower frequency and the ``difference``."""

    text: Text
    given: Given
    is_difference: bool
    dof: int
    point: Real  # (3,): of the moments
    wave_point: Real  # (2,)
    heading: Real
    frequency: Real
    difference: Real
    value: Complex
    is_crossed: bool  # of a file that also has waves of two headings

    @property
    def is_mean(self) -> bool:
        """Whether it is a mean drift: only the difference zero."""
        return self.is_difference and self.difference.size == 1


def table_of(text: Text) -> QtfTable:
    """Table of a file. Raises `InputError` for data that are missing or not supported."""
    head = head_of(text)
    check_head(text, head, ("HEADING", "DIFF", "QTFMODE", "DIRECTION", "COORD"))
    if "CPLXTYPE" in head and numbers_of(text, head, "CPLXTYPE")[0] != 0:
        raise text.wrong(head["CPLXTYPE"], "another type", "0, real and imaginary parts")
    heading = numbers_of(text, head, "HEADING")
    difference = numbers_of(text, head, "DIFF")
    if (np.diff(difference, prepend=-DIFFERENCE_TOLERANCE_RAD_S) <= 0).any() or difference[
        0
    ] > DIFFERENCE_TOLERANCE_RAD_S:
        raise text.wrong(head["DIFF"], "other differences", "ascending ones from zero")
    mode = text.lines[head["QTFMODE"]].split()[1:]
    direction = numbers_of(text, head, "DIRECTION")[-1]
    if mode not in (["Diff"], ["Sum"]) or direction not in (1, 2, 3, 4, 5, 6):
        raise text.wrong(
            head["QTFMODE"],
            f"mode {' '.join(mode)} and direction {direction:g}",
            "Diff or Sum, and 1 to 6",
        )
    crossed = "HEADING1" in head
    frequency, value = _rows(text, heading.size, difference.size, crossed)
    return QtfTable(
        text,
        water_of(text),
        mode == ["Diff"],
        int(direction) - 1,
        numbers_of(text, head, "COORD", 3),
        np.array(numbers_after(text, "Ref.pt incident wave", 2)),
        np.radians(heading),
        frequencies(text.path, frequency, Abscissa.RADIANS_PER_SECOND),
        difference,
        value,
        crossed,
    )


def head_of(text: Text) -> dict[str, int]:
    """The first line of each name in the head."""
    return {
        line.lstrip("#").split()[0].upper(): index
        for index, line in reversed(list(enumerate(text.lines)))
        if line.startswith("#") and line.strip("# ")
    }


def check_head(text: Text, head: dict[str, int], names: Sequence[str]) -> None:
    """Raises `InputError` if a line of these names is missing, or if the body has a forward
    speed."""
    for name in names:
        if name not in head:
            raise text.wrong(0, f"no line #{name}", "HydroStar's table of a load with one")
    if any(numbers_after(text, "Forward speed", 1)):
        raise text.wrong(0, "a forward speed", "none", "Compute it without.")


def water_of(text: Text) -> Given:
    """Water properties in the head."""
    line = next((line for line in text.lines if line.startswith("#") and "Waterdepth" in line), "")
    deep = "inf" in line.lower()
    length, density, gravity = (numbers_after(text, words, 1)[0] for words in _FACTS)
    depth = np.inf if deep else numbers_after(text, "Waterdepth", 1)[0]
    water = density / 1e3, gravity / 10
    if (
        not _SMALLEST < min(water) <= max(water) < 1 / _SMALLEST
        or not 1e-3 <= length <= 1e4
        or depth <= 0
    ):
        raise text.wrong(
            0,
            f"a length of {length:g}, density of {density:g}, gravity of {gravity:g} and depth of"
            f" {depth:g} in the head",
            "those of water in SI units",
        )
    return Given(length=length, water_density=density, gravity=gravity, water_depth=depth)


def numbers_after(text: Text, words: str, count: int) -> list[float]:
    """Numbers after these words and a colon in the head."""
    for index, line in enumerate(text.lines):
        if line.startswith("#") and words in line:
            return text.numbers(index, _NUMBER_PATTERN.findall(line.partition(":")[2]), count)
    raise text.wrong(0, f"no line with {words}", "the head of a HydroStar table")


def numbers_of(text: Text, head: dict[str, int], name: str, count: int | None = None) -> Real:
    """Numbers of the line with this name, at least one."""
    words = _NUMBER_PATTERN.findall(text.lines[head[name]].partition(name)[2])
    if not words:
        raise text.wrong(head[name], "no numbers", f"those of {name}")
    return np.array(text.numbers(head[name], words, count))


def rows_of(text: Text, columns: int) -> Real:
    """Lines without #, each of so many numbers."""
    rows = [
        text.numbers(index, line.split(), columns)
        for index, line in enumerate(text.lines)
        if line.strip() and not line.startswith("#")
    ]
    return np.reshape(np.array(rows, dtype=float), (-1, columns))


def _rows(text: Text, headings: int, differences: int, crossed: bool) -> tuple[Real, Complex]:
    """Frequencies (nw,) and values (nh, nw, nd). If the waves are ``crossed``, pairs of different
    headings are skipped."""
    rows = rows_of(text, 1 + 2 * differences)
    last = len(text.lines) - 1
    blocks = headings**2 if crossed else headings
    if not len(rows) or len(rows) % blocks:
        raise text.wrong(last, f"{len(rows)} rows", f"as many for each of {blocks} headings")
    table = rows.reshape(blocks, -1, rows.shape[1])
    frequency = table[0, :, 0]
    if (table[..., 0] != frequency).any() or (np.diff(frequency) <= 0).any():
        raise text.wrong(last, "other frequencies", "the same, ascending, for all headings")
    own = table[:: headings + 1] if crossed else table
    return frequency, own[..., 1::2] + 1j * own[..., 2::2]
