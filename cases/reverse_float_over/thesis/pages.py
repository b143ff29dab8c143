"""Tables of the READMEs of the cases, from the files in ``measured``.

A table stands between ``<!-- thesis: NAME -->`` and ``<!-- end -->``. ``python -m
cases.reverse_float_over.thesis --keep`` writes it anew.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from benchmarks.report import page_table
from cases.reverse_float_over.thesis.runner import MEASURED
from cases.reverse_float_over.thesis.runs import CASES
from cases.reverse_float_over.thesis.tables import read_rows

PAGES = tuple(
    CASES / name / "README.md" for name in ("reverse_float_over", "numerical_oscillation")
)
MARK = re.compile(r"<!-- thesis: ([\w ]+) -->\n.*?<!-- end -->", re.S)

Line = Mapping[str, str]
Means = Mapping[str, Mapping[str, Line]]
"""Rows of a table by variant and figure."""


def write_tables(pages: Iterable[Path] = PAGES, folder: Path = MEASURED) -> None:
    """Replace the tables of the pages."""
    for page in pages:
        page.write_text(with_tables(page.read_text(), folder))


def with_tables(text: str, folder: Path = MEASURED) -> str:
    """The text of a page with its tables made anew."""

    def renewed(found: re.Match[str]) -> str:
        name = found[1]
        return f"<!-- thesis: {name} -->\n{TABLES[name](folder)}\n<!-- end -->"

    return MARK.sub(renewed, text)


def _base(folder: Path) -> str:
    """Figures of the base case beside those of the thesis."""
    base = _means(folder, "sensitivities")["base case"]
    head = ("base case", "mean, 90 % interval", "least to most", "thesis")
    rows = [
        (label, _interval(base[name], digits), _range(base[name], digits), thesis)
        for label, name, digits, thesis in BASE_FIGURES
    ]
    return page_table(head, rows)


def _fenders(folder: Path) -> str:
    """Fenders and friction of the base case."""
    return _columns(_means(folder, "six_degrees"), "fenders, friction", FENDER_COLUMNS)


def _sensitivities(folder: Path) -> str:
    """The five sensitivities."""
    return _columns(_means(folder, "sensitivities"), "varied", SENSITIVITY_COLUMNS)


def _wave_force(folder: Path) -> str:
    """Velocity while stuck."""
    return _columns(_means(folder, "wave_force"), "K2 = 5.6e7 N/m", WAVE_COLUMNS)


def _pressed(folder: Path) -> str:
    """Section 3.3."""
    means = _means(folder, "pressed")
    return _columns(means, "lift at 7000 s / 132,105 kN", PRESSED_COLUMNS)


def _score_of_base(folder: Path) -> str:
    """Shares of seeds for rows 6 to 14 of the score card, in six degrees of freedom."""
    lines = read_rows(folder / "score.csv")
    rows = [
        (line["row"], line["quote"], *_agreement(line))
        for line in lines
        if line["model"] == "six degrees of freedom"
    ]
    return page_table(("row", "the thesis", *AGREEMENT), rows)


def _score_of_set_up(folder: Path) -> str:
    """Shares of seeds for rows 1, 2 and 5 of the score card."""
    lines = read_rows(folder / "score.csv")
    rows = [
        (line["row"], line["quote"], *_agreement(line))
        for line in lines
        if int(line["row"]) in (1, 2, 5)
    ]
    return page_table(("row", "the thesis", *AGREEMENT), rows)


def _score_of_pressed(folder: Path) -> str:
    """Shares of seeds for rows 3 and 4 of the score card, a row for each variant."""
    found: dict[str, list[str]] = {}
    for line in read_rows(folder / "score.csv"):
        if int(line["row"]) in (3, 4):
            variant = line["model"].removeprefix("section 3.3, ")
            found.setdefault(variant, []).append(", ".join(_agreement(line)))
    rows = [(variant, *shares) for variant, shares in found.items()]
    return page_table(("seeds that agree, share", *PRESSED_STATEMENTS), rows)


PRESSED_STATEMENTS = (
    "3: crawl against the waves",
    "3: by 0.35 to 1.05 m",
    "4: no mean wave force",
    "4: negative mean fender force",
)
AGREEMENT = ("seeds that agree", "share, 90 % interval")
BASE_FIGURES = (
    ("first contact [s]", "first_contact", 0, "about 600"),
    ("surge, moored mean [m]", "moored_mean", 2, "positive"),
    ("surge at 600 s [m]", "surge_600", 2, ""),
    ("at 1000 s", "surge_1000", 2, ""),
    ("at 1500 s", "surge_1500", 2, ""),
    ("at 2000 s", "surge_2000", 2, "-1.20"),
    ("share of stick, 1500 to 2000 s", "stick_1500_2000", 2, "stick"),
    ("fenders moving in +x, 600 to 1000 s [kN]", "fenders_moving_ahead", 0, "more"),
    ("fenders moving in -x", "fenders_moving_back", 0, "less"),
    ("mean fender force, 1500 to 2000 s [kN]", "fenders_1500_2000", 0, "-531 (K1 x - drift)"),
    ("mean drift, 600 to 2000 s [kN]", "drift_contact", 0, ""),
    ("mean first-order wave force, 600 to 2000 s [kN]", "waves_contact", 1, ""),
    ("largest velocity while stuck [m/s]", "velocity_stuck", 3, ""),
)
FENDER_COLUMNS = (
    ("first contact [s]", "first_contact", 0),
    ("at 600 s [m]", "surge_600", 2),
    ("at 1000 s", "surge_1000", 2),
    ("at 1500 s", "surge_1500", 2),
    ("at 2000 s", "surge_2000", 2),
    ("stick after 1500 s", "stick_1500_2000", 2),
    ("fender force after 1500 s [kN]", "fenders_1500_2000", 0),
    ("velocity while stuck [m/s]", "velocity_stuck", 3),
)
SENSITIVITY_COLUMNS = (
    ("surge at 1000 s [m]", "surge_1000", 2),
    ("at 2000 s", "surge_2000", 2),
    ("at the end", "surge_end", 2),
    ("last slip [s]", "last_slip", 0),
    ("velocity while stuck [m/s]", "velocity_stuck", 3),
    ("heave velocity, rms [m/s]", "heave_velocity", 3),
)
WAVE_COLUMNS = (
    ("deviation of the wave force in surge [kN]", "wave_force_deviation", 0),
    ("largest velocity while stuck [m/s]", "velocity_stuck", 3),
    ("surge at 2000 s [m]", "surge_2000", 2),
)
PRESSED_COLUMNS = (
    ("surge at 7000 s [m]", "surge_7000", 2),
    ("mean wave force [kN]", "waves", 1),
    ("mean fender force by impulse [kN]", "fenders", 0),
    ("by samples [kN]", "fenders_sampled", 0),
)
TABLES: Mapping[str, Callable[[Path], str]] = {
    "base": _base,
    "fenders": _fenders,
    "sensitivities": _sensitivities,
    "wave force": _wave_force,
    "pressed": _pressed,
    "score 6 to 14": _score_of_base,
    "score 1 2 5": _score_of_set_up,
    "score 3 and 4": _score_of_pressed,
}


def _columns(means: Means, title: str, columns: Sequence[tuple[str, str, int]]) -> str:
    """A row for each variant, and means with intervals of some figures."""
    head = [title, "n", *(label for label, _, _ in columns)]
    rows = []
    for variant, figures in means.items():
        n = figures[columns[0][1]]["n"]
        cells = [_interval(figures[name], digits) for _, name, digits in columns]
        rows.append([variant, n, *cells])
    return page_table(head, rows)


def _means(folder: Path, table: str) -> Means:
    found: dict[str, dict[str, Line]] = {}
    for line in read_rows(folder / f"{table}.csv"):
        found.setdefault(line["variant"], {})[line["figure"]] = line
    return found


def _interval(line: Line, digits: int) -> str:
    mean, lower, upper = (float(line[name]) for name in ("mean", "lower", "upper"))
    return f"{mean:.{digits}f} ({lower:.{digits}f} to {upper:.{digits}f})"


def _range(line: Line, digits: int) -> str:
    return f"{float(line['least']):.{digits}f} to {float(line['most']):.{digits}f}"


def _agreement(line: Line) -> tuple[str, str]:
    """How many seeds agree, and their share. A single run without a sea has no share."""
    agree, n = line["agree"], line["n"]
    if n == "1":
        return ("yes" if agree == "1" else "no"), ""
    share, lower, upper = (100.0 * float(line[name]) for name in ("share", "lower", "upper"))
    return f"{agree} of {n}", f"{share:.0f} % ({lower:.0f} to {upper:.0f})"
