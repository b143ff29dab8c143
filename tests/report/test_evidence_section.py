"""Lines of evidence in reports: those about what a scene uses, and no others."""

from pathlib import Path

import pytest
from recorded_runs import made_run

import hydrosim as hs
from hydrosim.files.document_nodes import List, Sentence, Table
from hydrosim.report.document import run_document
from hydrosim.report.evidence import (
    OF_RUNS,
    OF_SCENES,
    UNKNOWN_CASE_NOTE,
    Feature,
    evidence_nodes,
    features_of,
    known_lines,
    lines_about,
    without_line,
)
from hydrosim.report.replay import scene_of

CASES = Path(__file__).parents[2] / "cases"
OF_COMMANDS = {Feature.LINEAR, Feature.LIMITS, Feature.RECIPES, Feature.HULLS}
"""Features of the program that no scene has."""


def features_of_case(name: str) -> set[Feature]:
    return features_of(hs.load_case(CASES / f"{name}.yaml").scene())


def test_every_feature_is_of_scenes_runs_or_commands() -> None:
    assert {*OF_SCENES, *OF_RUNS, *OF_COMMANDS} == set(Feature)
    assert len(OF_SCENES) + len(OF_RUNS) + len(OF_COMMANDS) == len(Feature)


@pytest.mark.parametrize(
    ("name", "used", "unused"),
    [
        (
            "reverse_float_over/base",
            {Feature.FENDERS, Feature.STICK_SLIP, Feature.RADIATION, Feature.NEWMAN, Feature.SEA},
            {Feature.LANDINGS, Feature.TANKS, Feature.COULOMB, Feature.CURRENT, Feature.QTF},
        ),
        (
            "topside_removal/tanks",
            {Feature.LANDINGS, Feature.TANKS, Feature.HULL, Feature.DRAUGHTS, Feature.WEIGHT},
            {Feature.STIFFNESS, Feature.SLOPE, Feature.SPRINGS},
        ),
        ("mating/mating", {Feature.GUIDES, Feature.LANDINGS}, {Feature.TANKS}),
        ("friction_block/exact", {Feature.COULOMB}, {Feature.WAVES, Feature.RADIATION}),
        ("friction_block/slope_1e8", {Feature.SLOPE}, {Feature.COULOMB, Feature.STICK_SLIP}),
        ("sphere/regular", {Feature.WAVES, Feature.RADIATION}, {Feature.SEA, Feature.EXTREMES}),
    ],
)
def test_features_of_cases(name: str, used: set[Feature], unused: set[Feature]) -> None:
    found = features_of_case(name)
    assert used <= found
    assert not unused & found


@pytest.mark.parametrize(
    "name",
    [
        "reverse_float_over/base",
        "topside_removal/tanks",
        "mating/mating",
        "friction_block/exact",
        "sphere/irregular",
    ],
)
def test_each_feature_of_our_cases_has_a_line(name: str) -> None:
    used = features_of_case(name)
    assert without_line(used, lines_about(used)) == []


def test_lines_need_all_of_their_features() -> None:
    assert lines_about(set()) == []
    assert len(lines_about(set(Feature))) == len(known_lines())
    for line in lines_about(features_of_case("friction_block/exact")):
        assert set(line.features) <= features_of_case("friction_block/exact")


def test_a_report_names_the_lines_of_its_scene() -> None:
    """A dry block under rigid friction: Den Hartog's oscillator, and nothing of water."""
    run = hs.simulate(hs.load_case(CASES / "friction_block" / "exact.yaml", {"duration": 5}))
    (table,) = [node for node in evidence_nodes(run, scene_of(run)) if isinstance(node, Table)]
    used = features_of_case("friction_block/exact")
    assert [row[:2] for row in table.rows] == [[x.claim, x.against] for x in lines_about(used)]
    against = [str(row[1]) for row in table.rows]
    assert "Den Hartog 1931" in against
    assert "InWave+H" not in against
    assert "Evidence" in str(run_document(run))


def test_parts_without_a_line_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    coulomb = [line for line in known_lines() if line.features == (Feature.COULOMB,)]
    monkeypatch.setattr("hydrosim.report.evidence.known_lines", lambda: tuple(coulomb))
    run = hs.simulate(hs.load_case(CASES / "friction_block" / "exact.yaml", {"duration": 5}))
    (bare,) = [node for node in evidence_nodes(run, scene_of(run)) if isinstance(node, List)]
    assert "rigid friction" not in bare.items
    assert {"fenders", "applied forces"} <= set(bare.items)


def test_a_run_without_its_case_says_so() -> None:
    assert list(evidence_nodes(made_run(), None)) == [Sentence(UNKNOWN_CASE_NOTE)]
