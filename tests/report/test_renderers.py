"""Terminal, notebook and page: each shows every kind of node, and every text as it is."""

from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
from report_pages import HOSTILE, Page
from rich.console import Console
from scenes import block, scene, steady

import hydrosim as hs
from hydrosim.files.display_units import Units
from hydrosim.files.document import Document, print_document
from hydrosim.files.document_nodes import (
    Between,
    Chart,
    ChartLine,
    Code,
    Drawing,
    Heading,
    List,
    Outcome,
    Sentence,
    Table,
    Value,
    Verdict,
    warnings,
)
from hydrosim.report.page import html

TIME = np.array([0.0, 1.0])
DRAWING = Drawing("Plan", "<svg><title>plan</title></svg>", "a plan")
FIGURES = [
    Code("Case", "title: x", shown=True),
    Chart("Heave", "heave", "m", {"barge": ChartLine(TIME)}),
    Chart("Limits", "height", "m", {"beam": ChartLine(TIME, TIME)}, x_label="period"),
]
DOCUMENT = Document(
    "A title",
    [
        Sentence("Before any heading."),
        Heading("Outcome", "outcome"),
        Verdict(Outcome.GOOD, "Tension stays below {}.", [Value(2e6, "N")]),
        Verdict(Outcome.BAD, "It touched."),
        *warnings(["Waves are steep."]),
        Sentence("Between {}.", [Between(1.0, 2.5, "m")]),
        Table(["line", "tension"], [["fore", Value(1.5e6, "N")]], "Lines"),
        List(["one", Sentence("two at {}", [Value(3.0, "s")])], "Remarks"),
        Sentence("A detail.", detail=True),
        Heading("More", "more", detail=True),
        Sentence("Below a heading of details."),
    ],
    subtitle="what it is of",
    time=TIME,
)
SHOWN = ("A title", "what it is of", "Before any heading.", "Outcome", "It touched.", "Remarks")
SHOWN += ("Tension stays below 2000 kN.", "Waves are steep.", "Between 1 to 2.5 m.", "two at 3 s")
SHOWN += ("Lines", "tension [kN]", "1,500", "fore")
DETAILS = ("A detail.", "More", "Below a heading of details.")


def printed(document: Document, width: int = 80, details: bool = False) -> str:
    out = StringIO()
    print_document(document, Console(file=out, width=width, no_color=True), details)
    return out.getvalue()


def test_the_terminal_shows_every_node() -> None:
    short, full = printed(DOCUMENT), printed(DOCUMENT, details=True)
    assert all(text in short for text in SHOWN)
    assert not any(text in short for text in DETAILS)
    assert all(text in full for text in (*SHOWN, *DETAILS))
    assert "ok       Tension" in short
    assert "failed   It touched." in short
    assert "warning  Waves" in short


def test_print_shows_details_too() -> None:
    text = str(DOCUMENT)
    assert all(part in text for part in (*SHOWN, *DETAILS))
    assert text.startswith("A title\nwhat it is of\nBefore any heading.\n\nOutcome\n")


def test_a_notebook_shows_every_node_but_details() -> None:
    text = DOCUMENT._repr_html_()
    page = Page(text)
    said = " ".join(page.texts.values())
    assert all(part in said for part in SHOWN)
    assert not any(part in said for part in DETAILS)
    assert "good: Tension" in said
    assert "plan" in replace(DOCUMENT, nodes=[DRAWING])._repr_html_()


def test_a_page_shows_every_node() -> None:
    page = Page(html(replace(DOCUMENT, nodes=[*DOCUMENT.nodes, *FIGURES]), "mark"))
    said = " ".join(page.texts.values())
    assert all(part in said for part in (*SHOWN, *DETAILS, "title: x", "Heave", "Limits"))
    assert page.count("circle") == 2


def test_figures_do_not_disturb_a_terminal_or_a_notebook() -> None:
    both = replace(DOCUMENT, nodes=[*FIGURES, DRAWING, *DOCUMENT.nodes])
    assert printed(both) == printed(DOCUMENT)
    assert all(part in both._repr_html_() for part in ("A title", "Remarks"))


def test_all_renderers_read_the_units_of_the_document() -> None:
    tonnes = replace(DOCUMENT, units=Units({"N": "MN"}))
    for text in (str(tonnes), tonnes._repr_html_(), html(tonnes, "mark")):
        assert "tension [MN]" in text
        assert "1.5" in text
        assert "below 2 MN." in text


@pytest.mark.parametrize("empty", [Document("Alone", []), Document("", [])])
def test_a_document_without_nodes(empty: Document) -> None:
    assert empty.sections == []
    assert str(empty) == f"{empty.title}\n"
    assert empty.title in empty._repr_html_()
    assert empty.title in html(empty, "mark")


BRACES = "{} {0} {x!r} %s [red]not markup[/] [/b] :smile: \\["
CONTROL = "\x1b[2J\x07\r\u202e\x00"


def hostile(text: str) -> Document:
    """Every text that may be a user's is this one."""
    nodes = [
        Heading(text, "place"),
        Sentence("{}", [text]),
        Sentence(text),
        Verdict(Outcome.WARNING, "{}", [text]),
        *warnings([text]),
        List([text, Sentence("{}", [text])], text),
        Table([text, "x"], [[text, Value(1.0)], [Sentence("{}", [text]), text]], text),
    ]
    return Document(text, nodes, subtitle=text)


def test_braces_and_markup_are_shown_as_they_are() -> None:
    lines = printed(hostile(BRACES), 200)
    assert lines.count(BRACES) == 15
    assert Page(hostile(BRACES)._repr_html_()).texts["td"].count(BRACES) == 3
    assert Page(html(hostile(BRACES), "mark")).texts["p"].count(BRACES) >= 4


def test_nothing_steers_a_terminal() -> None:
    text = printed(hostile(f"a{CONTROL}b"), 200)
    assert not {*"\x1b\x07\r\u202e\x00"} & {*text}
    assert "a\\u001b[2J\\u0007\\u000d\\u202e\\u0000b" in text
    assert "\x1b" not in str(hostile(CONTROL))


def test_nothing_runs_in_html() -> None:
    notebook = Page(hostile(HOSTILE)._repr_html_())
    assert {tag for tag, _ in notebook.elements} <= {
        *("h3", "h4", "p", "ul", "li", "table", "caption", "thead", "tbody", "tr", "th", "td")
    }
    assert not any(of for _, of in notebook.elements)
    plain, page = (Page(html(hostile(text), "mark")) for text in ("plain", HOSTILE))
    for tag in ("script", "style", "img", "iframe", "link", "svg"):
        assert page.count(tag) == plain.count(tag)
    assert not any(key.startswith("on") for _, of in page.elements for key in of)


def test_heads_wrap_between_words_and_numbers_do_not() -> None:
    head = ["motion", "significant double amplitude", *(f"largest {k}" for k in range(6))]
    rows = [["barge surge of a long name", *(Value(123456.75, "N", 8) for _ in head[1:])]]
    text = printed(Document("", [Table(head, rows)]), 90)
    assert text.count("123.45675") == 7
    assert "significant" in text
    assert "amplitude" in text


def test_a_table_has_one_blank_line_on_each_side() -> None:
    table = Table(["a", "b"], [["x", "y"]])
    both = printed(Document("", [table, table, Heading("End"), Sentence("after")]))
    assert [line.strip() for line in both.splitlines()].count("") == 4  # the title is the first
    lines = printed(Document("Title", [table])).splitlines()
    assert [line.strip() for line in lines[:3]] == ["Title", "", "a  b"]
    assert [line.split() for line in lines[-2:]] == [["x", "y"], []]


def test_check_gives_a_document_in_python() -> None:
    """Of a scene and of a case: verdicts, periods; what is forced alone has none."""
    of = scene(block(2.0, ("surge",)), {"push": steady(surge=1.0)}, 1.0, 0.1)
    document = hs.check(of)
    assert isinstance(document, Document)
    assert "Natural periods at the start of the run" in str(document)
    assert "Details" in str(document)
    assert "Natural periods" in document._repr_html_()
    later = hs.check(of, times=[0.5])
    assert [each.heading.text for each in later.sections] == ["", "At 0.5 s", "Details"]
