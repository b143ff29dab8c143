"""What a test reads of a document: texts as they stand in it, values in SI."""

from collections.abc import Iterable, Sequence

from hydrosim.files.display_units import DEFAULT, Units
from hydrosim.files.document_layout import text_of
from hydrosim.files.document_nodes import Between, Cell, List, Node, Sentence, Table, Value, Verdict


def texts(nodes: Iterable[Node], units: Units = DEFAULT) -> list[str]:
    """Sentences, verdicts and what stands in lists."""
    found: list[str] = []
    for node in nodes:
        match node:
            case Sentence():
                found.append(text_of(node, units))
            case Verdict():
                found.append(f"{node.outcome.value}: {text_of(node.sentence, units)}")
            case List():
                found += [node.title, *(text_of(item, units) for item in node.items)]
    return found


def tables(nodes: Iterable[Node], *head: str) -> list[Table]:
    """Tables whose heads begin so."""
    all_ = [node for node in nodes if isinstance(node, Table)]
    return [table for table in all_ if tuple(table.head[: len(head)]) == head]


def rows(nodes: Iterable[Node], *head: str) -> list[dict[str, Cell]]:
    """The rows of the one table whose head begins so, by the names of the columns."""
    (table,) = tables(nodes, *head)
    assert len({*table.head}) == len(table.head)
    return [dict(zip(table.head, row, strict=True)) for row in table.rows]


def row(nodes: Iterable[Node], *head: str, of: Sequence[str]) -> dict[str, Cell]:
    """The one row whose first cells are these."""
    (found,) = (each for each in rows(nodes, *head) if [*each.values()][: len(of)] == [*of])
    return found


def number(cell: Cell, unit: str) -> float:
    """The number of a value in a unit."""
    assert isinstance(cell, Value)
    assert cell.unit == unit
    return cell.number


def ends(cell: Cell, unit: str) -> tuple[float, float]:
    """The ends of an interval in a unit."""
    assert isinstance(cell, Between)
    assert cell.unit == unit
    return cell.low, cell.high
