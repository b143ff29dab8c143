"""HTML of a document: one file without links to other files, in which nothing from a case can run.

The template escapes texts. Data are JSON without characters that could end their element. A content
security policy allows only the program's own scripts and styles, by their digests.
"""

from __future__ import annotations

import json
import re
from base64 import b64encode
from functools import partial
from hashlib import sha256
from importlib.resources import files
from itertools import count
from typing import Any

from hydrosim.errors import InputError
from hydrosim.outputs import Output
from hydrosim.presentation.document import Document
from hydrosim.presentation.figures import Chart, Replay
from hydrosim.presentation.layout import render_table, text_of
from hydrosim.report.curves import plot_curves
from hydrosim.report.envelopes import base64_of, chart_data, stretch

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
        found = f"{len(page) / 1e6:.1f} MB; expected at most {MAX_PAGE_BYTES / 1e6:g} MB"
        raise InputError(
            f"{output.path}: the page would have {found}. hydrosim plot draws pictures instead."
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
    own = files("hydrosim.report") / "templates"
    scripts = ["page.js", *(["replay.js"] if _nodes_of_kind(document, Replay) else [])]
    codes = [(own / name).read_text("utf-8") for name in scripts]
    style = (own / "page.css").read_text("utf-8")
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
        policy=_policy(codes, style),
        scripts=codes,
        style=style,
        data=json_for_html(_data(document)),
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


def _data(document: Document) -> dict[str, Any]:
    """Data for the scripts of the page."""
    charts, time = list(_nodes_of_kind(document, Chart)), document.time
    size = stretch(time.size, sum(len(chart.series) for chart in charts if not chart.modes))
    replays = [replay.data for replay in _nodes_of_kind(document, Replay)]
    return {
        "time": base64_of(time[::size]),
        "end": float(time[-1]) if time.size else 0.0,
        "stretch": size,
        "charts": [chart_data(chart, size, document.units) for chart in charts],
        "replay": replays[0] if replays else None,
    }


def _nodes_of_kind(document: Document, kind: type[Any]) -> list[Any]:
    return [node for node in document.nodes if isinstance(node, kind)]


def _policy(scripts: list[str], style: str) -> str:
    """Policy: nothing from elsewhere, and only scripts and styles with these digests."""
    allowed = " ".join(_digest(code) for code in scripts)
    return (
        f"default-src 'none'; script-src {allowed}; style-src {_digest(style)};"
        " base-uri 'none'; form-action 'none'"
    )


def _digest(code: str) -> str:
    return f"'sha256-{b64encode(sha256(code.encode()).digest()).decode()}'"
