"""Measured figures on pages have a source: each section with figures names what makes them.

A *section* is what stands below one heading. A *figure* is a number with a power of ten or in per
cent, "N times", or a cell of a table that is a number with or without a unit. 90 % is none: it is
the level of all intervals. The section must name

* a command: a benchmark, a script, or `hydrosim` with a file of this repository;
* or a question answered once, whose section there names the commit;
* or a test, as a path below tests/ that exists;
* or the commit at which it was measured;
* or the page of evidence.

Code gives no figures, but it names commands. Sections named `INPUTS` have inputs of a case, each
with its origin: nobody measured those here.
"""

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from stated_lines import ROUNDING, unlike

from benchmarks import ELSEWHERE, evidence
from hydrosim.report.evidence import EvidenceLine, known_lines

ROOT = Path(__file__).parents[2]
PAGES = (
    ROOT / "README.md",
    *sorted((ROOT / "docs").glob("*.md")),
    *sorted((ROOT / "cases").glob("*/*.md")),
    ROOT / "benchmarks" / "answered.md",
)
BOX = re.compile(r"^```.*?^```", re.S | re.M)
CODE = re.compile(r"`[^`]*`|\b90 %")
NUMBER = r"[-−+]?\d[\d.,]*(?:e[-+]?\d+)?"
FIGURE = re.compile(
    rf"\d(?:\.\d+)?e[-+]?\d+|\d %|\d times\b|\| *{NUMBER}(?: [a-zA-Zµ°]+(?:/\w+)?)? *(?=\|)"
)
BENCHMARKS = (
    re.compile(r"python -m benchmarks(?: --keep)? (\w+)"),
    re.compile(r"benchmarks/(\w+)(?:\.py|/\w+\.py)"),
    re.compile(r"benchmarks/README\.md#(\w+)"),
)
ANSWERED = re.compile(r"\banswered\.md#(\w+)")
PROGRAM = re.compile(r"python -m ((?:cases|benchmarks)\.[\w.]+)")
INPUTS = "## Where the numbers come from"
TEST = re.compile(r"tests/[\w/]+\.py")
FILE = re.compile(r"\b(?:hydrosim|python) [^\n`]*?([\w./-]+\.(?:yaml|py))")
COMMIT = re.compile(r"[Cc]ommits? \W?[0-9a-f]{7}\b")


def sections(text: str) -> list[str]:
    """Headings with what stands below them, up to the next heading."""
    whole = BOX.sub(lambda box: box[0].replace("#", " "), text)
    return re.split(r"^(?=#{1,6} )", whole, flags=re.M)


def figures(section: str) -> list[str]:
    """Measured figures of a section, outside of code."""
    if section.startswith(INPUTS):
        return []
    return FIGURE.findall(CODE.sub("", BOX.sub("", section)))


def source(section: str, page: Path) -> str:
    """What a section names as the source of its figures; "" if it names none."""
    return next(sources(section, page), "")


def sources(section: str, page: Path) -> Iterator[str]:
    """All sources that a section names and that exist."""
    for pattern in BENCHMARKS:
        names = pattern.findall(section)
        yield from (name for name in names if is_benchmark(name))
    yield from (name for name in ANSWERED.findall(section) if names_commit(name))
    yield from (name for name in PROGRAM.findall(section) if is_program(name))
    yield from (path for path in TEST.findall(section) if (ROOT / path).exists())
    named = FILE.findall(section)
    yield from (x for x in named if (ROOT / x).exists() or (page.parent / x).exists())
    yield from COMMIT.findall(section)
    if page == evidence.PAGE or "evidence.md" in section:
        yield "evidence.md"


def is_benchmark(name: str) -> bool:
    """Whether there is a question of this name, or a module of benchmarks."""
    if name in ELSEWHERE:
        return is_program(ELSEWHERE[name])
    return (ROOT / "benchmarks" / f"{name}.py").exists()


def names_commit(name: str) -> bool:
    """Whether a question of this name was answered, and a commit is named there."""
    text = (ROOT / "benchmarks" / "answered.md").read_text("utf-8")
    return any(COMMIT.search(x) for x in sections(text) if x.startswith(f"## {name}\n"))


def is_program(name: str) -> bool:
    """Whether there is a module of this repository, or a package that can be run."""
    path = ROOT.joinpath(*name.split("."))
    return path.with_suffix(".py").exists() or (path / "__main__.py").exists()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_sections_with_figures_name_their_source(page: Path) -> None:
    bare = {
        section.split("\n")[0]: figures(section)
        for section in sections(page.read_text("utf-8"))
        if figures(section) and not source(section, page)
    }
    assert bare == {}


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("It is 3 % off.", False),
        ("It is 3.1e-4 off.", False),
        ("It is 12 times as fast.", False),
        ("| sea | crawl |\n| --- | --- |\n| 1 | -1.065 m |", False),
        ("It is 3 % off (`tests/docs/test_figures_on_pages.py`).", True),
        ("It is 3 % off (`tests/docs/test_of_nothing.py`).", False),
        ("It is 3 % off (`python -m benchmarks evidence`).", True),
        ("It is 3 % off (`python -m benchmarks nothing`).", False),
        ("It is 3 % off ([figures](../benchmarks/answered.md#skips)).", True),
        ("It is 3 % off ([figures](../benchmarks/answered.md#nothing)).", False),
        ("It is 3 % off (`python -m benchmarks skips`).", False),
        ("It is 3 % off (`python -m cases.reverse_float_over.thesis --seeds 3`).", True),
        ("It is 3 % off (`python -m cases.reverse_float_over.nothing`).", False),
        ("It is 3 % off.\n\n```sh\nhydrosim run cases/sphere/decay.yaml\n```", True),
        ("It is 3 % off.\n\n```sh\nhydrosim run cases/sphere/nothing.yaml\n```", False),
        ("It is 3 % off (commit 885b83b).", True),
        ("It is 3 % off, see [evidence](evidence.md).", True),
    ],
)
def test_the_rule(text: str, named: bool) -> None:
    page = ROOT / "docs" / "a.md"
    (section,) = sections(text)
    assert figures(section)
    assert bool(source(section, page)) is named


def test_each_section_stands_for_itself() -> None:
    text = "# One\n\nIt is 3 % off (commit 885b83b).\n\n## Two\n\nIt is 4 % off.\n"
    page = ROOT / "docs" / "a.md"
    assert [bool(source(each, page)) for each in sections(text) if figures(each)] == [True, False]


def test_pages_of_evidence_are_those_of_its_data() -> None:
    """A figure that somebody changes on one of them is noticed."""
    for path, text in evidence.pages(known_lines()).items():
        assert path.read_text("utf-8") == text, path


@pytest.mark.parametrize("path", [evidence.PAGE, evidence.README])
@pytest.mark.parametrize("name", evidence.FIRST_PAGE)
def test_a_figure_planted_in_data_is_noticed_on_the_page(path: Path, name: tuple[str, str]) -> None:
    lines = [
        replace(line, figure=0.1 * line.figure + 1e-20)
        if (line.claim, line.against) == name
        else line
        for line in known_lines()
    ]
    assert path.read_text("utf-8") != evidence.pages(lines)[path]


@pytest.mark.parametrize("line", known_lines(), ids=lambda line: line.claim)
def test_a_figure_planted_on_all_pages_is_noticed_by_its_test(line: EvidenceLine) -> None:
    """Whoever changes data and pages alike is told by the test that measures the figure."""
    assert unlike(line) == ""
    assert "no such line" in unlike(replace(line, claim="another"))
    assert unlike(replace(line, limit=2.0 * line.limit + 1.0))
    assert unlike(replace(line, features=()))
    worse = replace(line, figure=2.0 * line.figure)
    assert bool(unlike(worse)) is (worse.figure > ROUNDING)


def test_lines_hold_their_limits_and_name_tests_that_exist() -> None:
    lines = known_lines()
    assert 40 <= len(lines)
    assert len({(line.claim, line.against) for line in lines}) == len(lines)
    for line in lines:
        file, *names = line.test.split("::")
        assert 0.0 <= line.figure <= line.limit, line
        assert f"def {names[-1]}(" in (ROOT / file).read_text("utf-8"), line
        assert line.features, line
        assert re.fullmatch(r"[0-9a-f]{7,}", line.commit), line


def test_every_feature_has_a_line() -> None:
    assert evidence.uncovered(known_lines()) == []


def test_the_first_page_has_ten_lines_of_several_kinds() -> None:
    first = [x for x in known_lines() if (x.claim, x.against) in evidence.FIRST_PAGE]
    assert len(first) == len(evidence.FIRST_PAGE) == 10
    assert len({line.kind for line in first}) >= 3
