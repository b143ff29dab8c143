"""HTML of a document with its curves: one file without links, in which no text of a case can run.

The template escapes texts. Data are JSON without characters that could end their element. A content
security policy allows only the program's own scripts and styles, by their digests.
"""

from __future__ import annotations

import json
import re
from base64 import b64encode
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from hashlib import sha256
from importlib.resources import files
from itertools import count
from math import ceil, floor, log10
from typing import Any, NamedTuple

import numpy as np

from hydrosim.errors import InputError
from hydrosim.files.display_units import Units
from hydrosim.files.document import Document
from hydrosim.files.document_layout import digits_of, name_with_unit, render_table, text_of
from hydrosim.files.document_nodes import Chart, ChartLine, Replay
from hydrosim.files.outputs import Output
from hydrosim.results.channels import interval_envelope

# Positions of the points, bars and ticks of curves in a picture.

CHART_WIDTH, CHART_HEIGHT, LEFT_EDGE, RIGHT_EDGE, TOP_EDGE, BOTTOM_EDGE = 720, 320, 70, 700, 24, 270
RANGE_MARGIN_FRACTION = 0.05  # of a range, on both sides
TICK_STEPS = (1.0, 2.0, 5.0, 10.0)  # between ticks, times a power of ten


class PlottedPoint(NamedTuple):
    """A point with its bar, and a remark."""

    x: float
    y: float
    low: float
    high: float
    text: str
    is_open: bool = False


class PlottedCurves(NamedTuple):
    """A picture of curves."""

    x_label: str
    y_label: str
    lines: list[list[PlottedPoint]]
    x_ticks: list[tuple[float, str]]
    y_ticks: list[tuple[float, str]]
    width: int = CHART_WIDTH
    height: int = CHART_HEIGHT
    left: int = LEFT_EDGE
    right: int = RIGHT_EDGE
    top: int = TOP_EDGE
    bottom: int = BOTTOM_EDGE


def plot_curves(of: Chart, units: Units) -> PlottedCurves:
    """Picture of a chart that is not over time, in display units, without points that are not
    finite."""
    points = {name: list(_curve_points(of, line, units)) for name, line in of.lines.items()}
    every = [point for line_points in points.values() for point in line_points]
    x = _axis_range([point.x for point in every])
    y = _axis_range([value for point in every for value in (point.y, point.low, point.high)])
    across, up = _axis_scale(x, LEFT_EDGE, RIGHT_EDGE), _axis_scale(y, BOTTOM_EDGE, TOP_EDGE)
    lines = [
        [
            PlottedPoint(
                across(p.x), up(p.y), up(p.low), up(p.high), f"{name}: {p.text}", p.is_open
            )
            for p in line_points
        ]
        for name, line_points in points.items()
    ]
    x_ticks = [(across(t), digits_of(t)) for t in ticks(*x)]
    y_ticks = [(up(t), digits_of(t)) for t in ticks(*y)]
    x_label, y_label = (
        name_with_unit(label, units.display_unit(unit).unit)
        for label, unit in ((of.x_label, of.x_unit), (of.quantity, of.unit))
    )
    return PlottedCurves(x_label, y_label, lines, x_ticks, y_ticks)


def ticks(low: float, high: float, count: int = 6) -> list[float]:
    """Round numbers from ``low`` to ``high``, about so many."""
    power = 10.0 ** floor(log10((high - low) / count))
    step = next(s * power for s in TICK_STEPS if s * power >= (high - low) / count)
    return [k * step for k in range(ceil(low / step), floor(high / step) + 1)]


def _curve_points(of: Chart, line: ChartLine, units: Units) -> Iterator[PlottedPoint]:
    """The points of a line that are finite, and those at its bounds, in display units."""
    x_unit, x_scale = units.display_unit(of.x_unit)
    y_unit, y_scale = units.display_unit(of.unit)
    none = np.full(line.y.size, np.nan)
    columns = (line.y, line.low, line.high, line.bounds)
    scaled = (y_scale * column if column.size else none for column in columns)
    remarks = line.remarks or [""] * line.y.size
    for x, y, low, high, bound, remark in zip(x_scale * line.x, *scaled, remarks, strict=True):
        place = f"at {digits_of(x)} {x_unit}".strip()
        if np.isfinite([x, y]).all():
            has_range = np.isfinite([low, high]).any()
            low, high = (end if np.isfinite(end) else y for end in (low, high))
            between = f" ({digits_of(low)} to {digits_of(high)})" if has_range else ""
            words = (f"{digits_of(y)}{between}", y_unit, place, remark)
            yield PlottedPoint(x, y, low, high, " ".join(filter(None, words)))
        elif np.isfinite([x, bound]).all():
            yield PlottedPoint(x, bound, bound, bound, f"{remark} {place}", True)


def _axis_range(values: Sequence[float]) -> tuple[float, float]:
    if not values:
        return 0.0, 1.0
    low, high = min(values), max(values)
    pad = RANGE_MARGIN_FRACTION * (high - low) or RANGE_MARGIN_FRACTION * abs(high) or 1.0
    return low - pad, high + pad


def _axis_scale(of: tuple[float, float], begin: float, end: float) -> Callable[[float], float]:
    return lambda value: round(begin + (value - of[0]) / (of[1] - of[0]) * (end - begin), 2)


# Series for a page: complete, or the smallest and largest value of each interval.

MAX_SERIES_BYTES = 4_000_000  # bytes of all series of a page together, as 32-bit numbers
MAX_STRETCHES = 5000  # stretches
CLOSED_MODES = (1, 2)  # stick and slip: their fractions of an interval; the rest is open
MODE_INTERVALS = 800  # of modes


def records_per_interval(count: int, charts: Sequence[Chart]) -> int:
    """Number of records per interval, for the lines of ``charts`` of ``count`` records."""
    lines = sum(len(chart.lines) for chart in charts if not chart.modes)
    if 4 * count * lines <= MAX_SERIES_BYTES and count <= MAX_STRETCHES:
        return 1
    stretches = min(MAX_STRETCHES, max(MAX_SERIES_BYTES // (8 * max(lines, 1)), 50))
    return -(-count // stretches)


def chart_data(chart: Chart, size: int, units: Units) -> dict[str, Any]:
    """Data of a chart for the page, with intervals of ``size`` records."""
    rows = [
        shares(line.y) if chart.modes else interval_envelope(line.y, size)
        for line in chart.lines.values()
    ]
    unit, scale = units.display_unit(chart.unit)
    return {
        "title": chart.title,
        "unit": unit,
        "scale": scale,
        "modes": chart.modes,
        "names": chart.names,
        "styles": chart.styles,
        "values": [base64_of_floats(row) for row in rows],
    }


def shares(modes: np.ndarray) -> np.ndarray:
    """Fractions (2, n) of the time in `CLOSED_MODES`, in `MODE_INTERVALS` equal intervals."""
    starts = np.unique(np.linspace(0, modes.size, MODE_INTERVALS + 1)[:-1].astype(int))
    length = np.diff(np.append(starts, modes.size))
    return np.array(
        [np.add.reduceat((modes == k).astype(float), starts) / length for k in CLOSED_MODES]
    )


def base64_of_floats(values: np.ndarray | Sequence[float]) -> str:
    """32-bit numbers, little-endian; values outside their range become NaN."""
    with np.errstate(over="ignore", invalid="ignore"):
        small = np.asarray(values, dtype="<f4")
    return b64encode(np.where(np.isfinite(small), small, np.float32(np.nan)).tobytes()).decode()


MAX_PAGE_BYTES = 10_000_000  # bytes of a page
PATH_PATTERN = re.compile(
    r"""
    (?m:(?:^|(?<=:[ ]))(?:[A-Za-z]:)?/[^:\n'"]*/(?=[^/:\n'"]+(?::[ ]|$)))  # a value, a line's start
    | (?<=['"])(?:[A-Za-z]:)?/[^'"\n]*/(?=[^'"/\n]+['"])  # between quotes
    | (?<![\w.:/<+])(?:[A-Za-z]:)?/(?:[^\s/'":;,()]+/)+(?=[^\s/])  # in a sentence
    | (?<!\w)[A-Za-z]:\\+(?:[^\\\n:'"]+\\+)*(?=[^\s\\])  # of Windows
    """,
    re.VERBOSE,
)
"""Folders of absolute paths in a text. Folders with spaces are known where a path stands alone
or between quotes."""
HTML_ESCAPES = {ord(c): f"\\u{ord(c):04x}" for c in "<>&'"}  # none of them occurs outside a text


def written_page(document: Document, output: Output) -> int:
    """Write a page; return its size in bytes. Raises InputError if it would be too large to
    send."""
    page = html(document, output.mark).encode("utf-8", "backslashreplace")
    if len(page) > MAX_PAGE_BYTES:
        size_text = f"{len(page) / 1e6:.1f} MB; expected at most {MAX_PAGE_BYTES / 1e6:g} MB"
        raise InputError(
            f"{output.path}: the page would have {size_text}. hydrosim show --plot draws pictures"
            " instead."
        )
    with output.write_complete() as path:
        path.write_bytes(page)
    return len(page)


def html(document: Document, mark: str) -> str:
    """HTML of the page; ``mark`` says what it is and names its source file."""
    try:
        from jinja2 import Environment, PackageLoader, StrictUndefined
    except ImportError:
        raise InputError(
            "a page needs jinja2. Install it: pip install 'hydrosim[report]'."
        ) from None
    templates = files("hydrosim.report") / "templates"
    scripts = ["page.js", *(["replay.js"] if _nodes_of_kind(document, Replay) else [])]
    codes = [(templates / name).read_text("utf-8") for name in scripts]
    style = (templates / "page.css").read_text("utf-8")
    environment = Environment(
        loader=PackageLoader("hydrosim.report"),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=lambda value: without_folders(value) if type(value) is str else value,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    numbers = count()
    return environment.get_template("page.html").render(
        document=document,
        mark=mark,
        policy=_content_policy(codes, style),
        scripts=codes,
        style=style,
        data=json_for_html(_data_of_charts(document)),
        next_chart=lambda: next(numbers),
        plot_curves=partial(plot_curves, units=document.units),
        render_table=partial(render_table, units=document.units),
        text_of=partial(text_of, units=document.units),
        display_unit=document.units.display_unit,
    )


def without_folders(text: str) -> str:
    """Text with the file name of each absolute path: folders of a machine mean nothing to a
    reader, and tell whose machine it was."""
    return PATH_PATTERN.sub("", text)


def json_for_html(data: Any) -> str:
    """JSON that can stand in an HTML element."""
    return json.dumps(data, allow_nan=False).translate(HTML_ESCAPES)


def _data_of_charts(document: Document) -> dict[str, Any]:
    """Data for the scripts of the page."""
    charts = [chart for chart in _nodes_of_kind(document, Chart) if chart.is_over_time]
    time = document.time
    size = records_per_interval(time.size, charts)
    replays = [replay.data for replay in _nodes_of_kind(document, Replay)]
    return {
        "time": base64_of_floats(time[::size]),
        "end": float(time[-1]) if time.size else 0.0,
        "stretch": size,
        "phases": [(phase.name, float(phase.start), float(phase.end)) for phase in document.phases],
        "charts": [chart_data(chart, size, document.units) for chart in charts],
        "replay": replays[0] if replays else None,
    }


def _nodes_of_kind(document: Document, kind: type[Any]) -> list[Any]:
    return [node for node in document.nodes if isinstance(node, kind)]


def _content_policy(scripts: list[str], style: str) -> str:
    """Policy: nothing from elsewhere, and only scripts and styles with these digests."""
    allowed = " ".join(_script_digest(code) for code in scripts)
    return (
        f"default-src 'none'; script-src {allowed}; style-src {_script_digest(style)};"
        " base-uri 'none'; form-action 'none'"
    )


def _script_digest(code: str) -> str:
    return f"'sha256-{b64encode(sha256(code.encode()).digest()).decode()}'"
