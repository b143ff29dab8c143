"""Criteria of a case: the register, verdicts, margins; what a run cannot be held against."""

from __future__ import annotations

from pathlib import Path

import pytest

import hydrosim as hs
from hydrosim.errors import InputError
from hydrosim.presentation.document import Document, Outcome, Table, Value, Verdict
from hydrosim.statistics.criteria import criteria_of
from hydrosim.wording.criteria import criteria_nodes
from hydrosim.wording.run import run_document

CASE = """\
title: A block on a spring
duration: 10 s
bodies:
  block: {{mass: 2 kg, dofs: [surge], initial: {{position: [300 mm, 0, 0, 0, 0, 0]}}}}
forces:
  spring: {{type: linear_mooring, body: block, stiffness: {{surge: 5 N/m}}}}
criteria:
  far: {{channel: position.block.surge, statistic: largest, limit: {far}, source: "Drawing 7"}}
  near: {{channel: position.block.surge, statistic: smallest, limit: -400 mm}}
"""


def documents(folder: Path, far: str = "0.4 m", more: str = "") -> tuple[Document, list[object]]:
    path = folder / "case.yaml"
    path.write_text(CASE.format(far=far) + more)
    run = hs.simulate(hs.load_case(path))
    return run_document(run), list(criteria_nodes(run))


def test_values_margins_and_utilisations(tmp_path: Path) -> None:
    """A spring without damping swings from 0.3 m to -0.3 m: margins 0.1 m, three quarters used."""
    path = tmp_path / "case.yaml"
    path.write_text(CASE.format(far="0.4 m"))
    run = hs.simulate(hs.load_case(path))
    far, near = criteria_of(run)
    assert (far.unit, far.source, far.limit) == ("m", "Drawing 7", 0.4)
    assert far.value == pytest.approx(0.3, abs=1e-3)
    assert far.margin == pytest.approx(0.1, abs=1e-3)
    assert far.utilisation == pytest.approx(0.75, abs=3e-3)
    assert near.margin == pytest.approx(0.1, abs=1e-3)
    assert near.utilisation != near.utilisation
    assert far.is_met
    assert near.is_met


def test_a_limit_that_is_exceeded_is_the_first_thing_said(tmp_path: Path) -> None:
    document, _ = documents(tmp_path, far="0.25 m")
    first, second = document.nodes[:2]
    assert isinstance(first, Verdict)
    assert first.outcome is Outcome.BAD
    assert list(first.parts) == ["1", "2"]
    assert isinstance(second, Verdict)
    assert "far" in second.parts
    values = [part for part in second.parts if isinstance(part, Value)]
    assert values[1] == Value(0.25, "m")
    assert "NOT MET" in str(document)


def test_values_are_read_in_the_units_of_the_case(tmp_path: Path) -> None:
    """Lengths are in millimetres, as the case has them most often."""
    document, nodes = documents(tmp_path, far="400 mm")
    table = next(node for node in nodes if isinstance(node, Table))
    assert table.rows[0][1].unit == "m"
    assert "value [mm]" in str(document)


def test_a_channel_that_is_not_there_is_not_met(tmp_path: Path) -> None:
    more = "  lost: {channel: position.barge.surge, statistic: end, limit: 1 m}\n"
    _, nodes = documents(tmp_path, more=more)
    said = [node for node in nodes if isinstance(node, Verdict)]
    assert said[0].outcome is Outcome.BAD
    assert "position.barge.surge" in str(said[1].parts)


def test_a_limit_without_a_number_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(CASE.format(far="wide"))
    with pytest.raises(InputError, match=r"criteria\.far\.limit"):
        hs.load_case(path)
