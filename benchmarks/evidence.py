"""What was held against what, and how far is hydrosim from it?

Runs the tests that note lines of evidence with the fixture `validated`. With --keep the lines are
written into the package, into docs/reference/evidence.md, and ten of them into README.md.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks.report import ROOT, Answer, Row, machine, page_table
from hydrosim.report.evidence import FILE, EvidenceLine, Feature, Kind, known_lines

NAME = "evidence"
"""Name of the plugin, which the fixture asks for, and of what it notes in reports."""
PAGE = ROOT / "docs" / "reference" / "evidence.md"
README = ROOT / "README.md"
BEGIN, END = "<!-- lines: python -m benchmarks --keep evidence -->", "<!-- end of lines -->"
FIRST_PAGE: tuple[tuple[str, str], ...] = (
    ("sphere, decay in heave from 1 m, rms over 1 m", "InWave+H"),
    ("sphere, heave in ten regular waves", "HydroChrono"),
    ("VolturnUS, RAOs from the coefficients of WAMIT's listing, median", "WAMIT's RAOs"),
    ("sphere in hydro_db, loads in surge and heave, of the largest", "WAMIT"),
    ("two barges in regular waves, 12 x 12", "frequency domain, same radiation"),
    ("one-dimensional model of Plasterk 2017, 20 random sets, of its range", "DOP853 by events"),
    ("oscillator with dry friction, amplitude at 11 frequencies", "Den Hartog 1931"),
    ("block held by friction for an hour, creep [m]", "0"),
    ("oscillator that strikes a landing 100 times [m]", "matrix exponentials between impacts"),
    ("trim and heel of a ballasted barge", "hydrostatics by hand"),
)
"""Claims in README.md, and what they are held against."""
TITLES: Mapping[Kind, str] = {
    Kind.EXPERIMENT: "Against experiments",
    Kind.PROGRAM: "Against other programs",
    Kind.CLOSED_FORM: "Against closed forms",
    Kind.INDEPENDENT: "Against independent codes",
    Kind.SELF: "Against hydrosim itself",
}
REMARKS: Mapping[Kind, str] = {
    Kind.EXPERIMENT: "An error here is that of the theory and of the measurement. The pages of the"
    " cases say what is fitted.",
    Kind.INDEPENDENT: "Written apart from hydrosim's kernels, for the tests: other equations,"
    " other integrators, direct sums. The two databases of H-851 are of one program with other"
    " panels.",
    Kind.SELF: "The same scene, solved in another way. It shows that two ways agree, not that"
    " either is right.",
}


class Collector:
    """Lines that tests note, the largest error of each; and tests that did not run."""

    def __init__(self) -> None:
        self.lines: dict[tuple[str, str], EvidenceLine] = {}
        self.left_out: set[str] = set()

    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        """Tests that note no line are left out."""
        items[:] = [item for item in items if "validated" in item.fixturenames]

    def pytest_collectreport(self, report: Any) -> None:
        """Of every file: one that is skipped as a whole has tests that do not run here."""
        if report.skipped:
            self.left_out.add(report.nodeid)

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Of every test that ran."""
        if report.skipped:
            self.left_out.add(report.nodeid.split("[")[0])
        for name, value in report.user_properties if report.when == "call" else ():
            if name == NAME:
                self._note(EvidenceLine.read(value))

    def _note(self, line: EvidenceLine) -> None:
        known = self.lines.get((line.claim, line.against), line)
        if replace(known, figure=line.figure, others=line.others) != line:
            raise ValueError(f"{line.claim}: noted as {known} and as {line}")
        self.lines[line.claim, line.against] = max(known, line, key=lambda each: each.figure)


def answer() -> Answer:
    """The lines; a test that fails is said."""
    commit = machine()["commit"]  # before anybody edits what is tested
    collector = Collector()
    plugins = [_Named(collector)]
    code = pytest.main(["-q", "-p", "no:cacheprovider", str(ROOT / "tests")], plugins=plugins)
    lines = _with_commit(collector, commit)
    tables = {TITLES[kind]: [_row(x) for x in lines if x.kind == kind] for kind in _kinds(lines)}
    kept = {} if code else pages(lines)
    return Answer(tables, ["some tests failed."] if code else [], kept=kept)


class _Named:
    """The collector as a plugin with a name: pytest registers the plugins that this one has."""

    def __init__(self, collector: Collector) -> None:
        self._collector = collector

    def pytest_configure(self, config: pytest.Config) -> None:
        """Registers the collector."""
        config.pluginmanager.register(self._collector, NAME)


def pages(lines: Sequence[EvidenceLine]) -> dict[Path, str]:
    """Files that hold the lines: data of the package, the page, the README."""
    data = json.dumps([line.as_dict() for line in lines], indent=1, ensure_ascii=False) + "\n"
    return {
        FILE: data,
        PAGE: with_block(PAGE.read_text("utf-8"), page_block(lines)),
        README: with_block(README.read_text("utf-8"), readme_block(lines)),
    }


def page_block(lines: Sequence[EvidenceLine]) -> str:
    """Tables of all lines, by kind."""
    return "\n\n".join(_section(lines, kind) for kind in _kinds(lines))


def readme_block(lines: Sequence[EvidenceLine]) -> str:
    """The lines of the first page, in short."""
    known = {(line.claim, line.against): line for line in lines}
    first = [known[name] for name in FIRST_PAGE if name in known]
    rows = [(x.claim, x.against, _shown(x.figure), x.others) for x in first]
    return page_table(("claim", "against", "error", "others"), rows)


def with_block(text: str, block: str, begin: str = BEGIN, end: str = END) -> str:
    """The page with another block between its marks."""
    found = re.compile(f"({re.escape(begin)}).*({re.escape(end)})", re.S)
    return found.sub(lambda marks: f"{marks[1]}\n\n{block}\n\n{marks[2]}", text)


def uncovered(lines: Iterable[EvidenceLine]) -> list[Feature]:
    """Features that no line is about."""
    covered = {feature for line in lines for feature in line.features}
    return [feature for feature in Feature if feature not in covered]


def _with_commit(collector: Collector, commit: str) -> list[EvidenceLine]:
    """Lines in the order of the page. Lines of tests that did not run here stay as they are."""
    left_out = collector.left_out
    kept = [x for x in known_lines() if {x.test, x.test.partition("::")[0]} & left_out]
    new = [replace(line, commit=commit) for line in collector.lines.values()]
    kinds = list(Kind)
    return sorted([*kept, *new], key=lambda line: (kinds.index(line.kind), line.test, line.claim))


def _kinds(lines: Sequence[EvidenceLine]) -> list[Kind]:
    used = {line.kind for line in lines}
    return [kind for kind in Kind if kind in used]


def _section(lines: Sequence[EvidenceLine], kind: Kind) -> str:
    """The heading of a kind, a remark, and the table of its lines."""
    head = ("claim", "against", "error", "limit", "others", "commit", "test")
    table = page_table(head, [_cells(line) for line in lines if line.kind == kind])
    remark = f"{REMARKS[kind]}\n\n" if kind in REMARKS else ""
    return f"## {TITLES[kind]}\n\n{remark}{table}"


def _cells(line: EvidenceLine) -> list[str]:
    file, _, name = line.test.partition("::")
    shown = [line.claim, line.against, _shown(line.figure), f"{line.limit:g}", line.others]
    return [*shown, line.commit, f"`{file}` `{name}`"]


def _row(line: EvidenceLine) -> Row:
    limit = f"{line.limit:g}"
    return {"claim": line.claim, "against": line.against, "error": line.figure, "limit": limit}


def _shown(figure: float) -> str:
    return f"{figure:.2g}"
