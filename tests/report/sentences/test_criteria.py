"""Criteria of a case: the register, verdicts, margins; what a run cannot be held against."""

from dataclasses import replace
from pathlib import Path

import pytest
import text_tables
from scenes import scene_of

import hydrosim as hs
from hydrosim import simulation
from hydrosim.errors import InputError
from hydrosim.files.document import Document
from hydrosim.files.document_nodes import Outcome, Table, Value, Verdict
from hydrosim.report.sentences.run import criteria_nodes, run_document
from hydrosim.results.channels import channel_names, channel_series
from hydrosim.simulation import blank_run
from hydrosim.statistics.figures import criteria_of
from hydrosim.study.many_runs import run_study
from hydrosim.study.sweep import load_study

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


def test_a_channel_that_a_kept_result_lacks_is_not_met(tmp_path: Path) -> None:
    """Runs are refused before they begin; a file of another version may lack it all the same."""
    path = tmp_path / "case.yaml"
    path.write_text(CASE.format(far="0.4 m"))
    run = hs.simulate(hs.load_case(path))
    asked = run.attrs["criteria_asked"].replace("position.block.surge", "position.barge.surge")
    nodes = list(criteria_nodes(run.assign_attrs(criteria_asked=asked)))
    said = [node for node in nodes if isinstance(node, Verdict)]
    assert said[0].outcome is Outcome.BAD
    assert "position.barge.surge" in str(said[1].parts)


WRONG = """
  {channel: position.block.surg, statistic: end, limit: 1 m} | \
    channel: found position.block.surg | did you mean "position.block.surge"?
  {channel: position.block.surge, statistic: end, limit: 1 kN} | \
    limit: found "1 kN" | expected a limit in m, which position.block.surge has
  {channel: clearance.pin, statistic: end, limit: 1 m} | \
    channel: found clearance.pin | they need output: {clearances: ...}
  {channel: position.block.surge, statistic: end, phase: stuck, limit: 1 m} | \
    phase: found phase stuck; expected a run with contacts
  {result: recontact_force, group: legs, limit: 1 MN} | result: found a run without contacts
"""


@pytest.mark.parametrize("row", text_tables.rows(WRONG), ids=lambda row: row[0])
def test_what_a_run_will_not_have_is_refused_before_it_begins(
    tmp_path: Path, row: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """By simulate and check, with file, line and what was meant; no step is taken."""
    path = tmp_path / "case.yaml"
    lost, said, *words = row
    path.write_text(CASE.format(far="0.4 m") + f"  lost: {lost}\n")
    monkeypatch.setattr(simulation, "run_compiled", None)
    for do in (hs.simulate, hs.check):
        with pytest.raises(InputError) as caught:
            do(hs.load_case(path))
        for word in (f"case.yaml:10: criteria.lost.{said}", *words):
            assert word in str(caught.value)


def test_the_names_before_a_run_are_those_of_its_result() -> None:
    """Channels, variables and units of a moored barge with fenders, a line and waves."""
    scene = replace(scene_of("base"), duration=1.0).with_output(accelerations=True)
    compiled = hs.compile_scene(scene, in_plane=True)
    before = blank_run(compiled)
    run = hs.simulate(scene)
    assert channel_names(before) == channel_names(run)
    assert [channel_series(before, name)[1] for name in channel_names(run)] == [
        channel_series(run, name)[1] for name in channel_names(run)
    ]


def test_a_study_of_a_case_with_a_wrong_criterion_names_the_case(tmp_path: Path) -> None:
    (tmp_path / "case.yaml").write_text(
        CASE.format(far="0.4 m") + "  lost: {channel: speed.blok, statistic: end, limit: 1 m/s}\n"
    )
    path = tmp_path / "study.yaml"
    path.write_text("case: case.yaml\nparameters: {forces.spring.stiffness.surge: [5, 10]}\n")
    with pytest.raises(InputError, match=r"case\.yaml:10: criteria\.lost\.channel: .*speed\.block"):
        run_study(load_study(path), tmp_path / "runs.nc")


def test_a_limit_without_a_number_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(CASE.format(far="wide"))
    with pytest.raises(InputError, match=r"criteria\.far\.limit"):
        hs.load_case(path)
