"""What a page of a report holds, taken from it again; texts that would like to be run."""

import base64
import json
from html.parser import HTMLParser
from typing import Any

import numpy as np
import xarray as xr
from recorded_runs import made_run

HOSTILE = (
    "</script><script>window.hacked = 1</script>"
    "<img src=x onerror='window.hacked = 2'>\" onload=\"window.hacked = 3\" '; window.hacked = 4;//"
    "\u2028\u2029 =cmd|' /C calc'!A0 {{ 7 * 7 }} ]]> <!-- &lt; \\u003c/script> javascript:alert(1)"
)


class Page(HTMLParser):
    """Elements of a page: their names and attributes, and all its text."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, str] = {}
        self._inside = ""
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        self._inside = tag

    def handle_endtag(self, tag: str) -> None:
        self._inside = ""

    def handle_data(self, data: str) -> None:
        self.texts[self._inside] = self.texts.get(self._inside, "") + data

    def count(self, tag: str) -> int:
        """How many elements of a kind there are."""
        return sum(name == tag for name, _ in self.elements)


def data_of(html: str) -> Any:
    """What the scripts of a page draw."""
    begin = html.index('id="data">') + len('id="data">')
    return json.loads(html[begin : html.index("</script>", begin)])


def chart(data: Any, title: str) -> dict[str, np.ndarray]:
    """The lines of a chart (n,), or its envelopes (2, n), by name, in SI."""
    found = next(each for each in data["charts"] if each["title"] == title)
    lines = {}
    for name, text in zip(found["names"], found["values"], strict=True):
        values = np.frombuffer(base64.b64decode(text), "<f4")
        n = len(base64.b64decode(data["time"])) // 4
        lines[name] = values if values.size == n else values.reshape(2, n)
    return lines


def hostile_run() -> xr.Dataset:
    """A run whose every text is `HOSTILE`."""
    run = made_run(duration=60.0)
    names = {dim: [f"{k} {HOSTILE}" for k in range(run.sizes[dim])] for dim in ("body", "fender")}
    run = run.assign_coords({dim: (dim, values) for dim, values in names.items()})
    run = run.rename({"force_mooring": f"force_{HOSTILE}".replace("/", "|")})
    text = json.dumps(HOSTILE)
    case = (
        f"title: {text}\nbodies: {{{text}: {{mass: {text}}}}}\n"
        f"forces: {{{text}: {{type: {text}, body: {text}}}}}\n"
        f"environment: {{water_depth: {text}, waves: [{{spectrum: {text}}}]}}\n"
    )
    texts = ("title", "program", "versions", "warnings", "skipped", "solver_method", "case_file")
    more = {"case": case, "case_resolved": case, "status": "failed", "status_message": HOSTILE}
    more[f"radiation_{names['body'][0]}".replace("/", "|")] = HOSTILE
    return run.assign_attrs({**dict.fromkeys(texts, HOSTILE), **more})
