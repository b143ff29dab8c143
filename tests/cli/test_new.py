"""`hydrosim new`: cases from main particulars can be checked at once; wrong ones are refused."""

from math import tanh
from pathlib import Path

import pytest
from command_line import Command, command, refusal, succeeds
from scipy.optimize import brentq

import hydrosim as hs
from hydrosim.case.load import Particulars
from hydrosim.database.build.drift import MIN_TESTED_KH
from hydrosim.database.build.recipe import load_recipe

BOX = Path(__file__).parents[2] / "hydro_db" / "box.nc"
SIDES = ("--length", "180 m", "--beam", 55, "--draught", "800 cm")


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    return command(monkeypatch, capsys)


def test_a_slender_hull_passes_check(run: Command, tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    sides = ("--length", 330, "--beam", 60, "--draught", 20, "--block-coefficient", 0.83)
    assert run("new", path, *sides, "--kg", 18).code == 0
    assert "warning" not in run("check", path).out


def test_a_new_case_passes_check(run: Command, tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    succeeds(run, "new", path, *SIDES)
    said = succeeds(run, "check", path)
    assert "warning" not in said
    assert "ok The step of 0.1 s is stable" in said
    for dof, period in Particulars(180.0, 55.0, 8.0, 1.0, 8.0).periods().items():
        assert f"barge {dof} {period:.1f}" in said


def test_its_recipe_can_be_read(run: Command, tmp_path: Path) -> None:
    """It covers the sea, and its hull displaces what the case weighs."""
    run("new", tmp_path / "own.yaml", *SIDES, "--displacement", "75000 tonne", "--kg", "11 m")
    recipe = load_recipe(tmp_path / "own_hull.yaml").data
    hull = recipe.hull
    assert 1025.0 * hull.length * hull.beam * hull.draught == pytest.approx(75e6, rel=1e-5)
    assert recipe.centre_of_gravity == (0.0, 0.0, 3.0)
    assert recipe.frequencies[-1] > 3 * 2 * 3.1415 / 8
    assert hs.load_case(tmp_path / "own.yaml").scene().bodies[0].mass == pytest.approx(75e6)


def test_a_case_with_its_database(run: Command, tmp_path: Path) -> None:
    sides = ("--length", 100, "--beam", 20, "--draught", 5, "--database", BOX)
    assert run("new", tmp_path / "own.yaml", *sides).code == 0
    assert not (tmp_path / "own_hull.yaml").exists()
    body = hs.load_case(tmp_path / "own.yaml").scene().bodies[0]
    assert body.mass == pytest.approx(10.25e6, rel=1e-6)


@pytest.mark.parametrize("taken", ["own.yaml", "own_hull.yaml"])
def test_nothing_is_replaced(run: Command, tmp_path: Path, taken: str) -> None:
    (tmp_path / taken).write_text("mine")
    said = refusal(run, tmp_path, "new", tmp_path / "own.yaml", *SIDES)
    assert f"{taken} exists and is not replaced" in said


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--length", "180 kg", "--beam", 55, "--draught", 8), "--length: found"),
        (("--length", 180, "--beam", -55, "--draught", 8), "it must be above 0"),
        (("--length", 55, "--beam", 180, "--draught", 8), "a length above the beam"),
        ((*SIDES, "--kg", 100), "expected less than 35.51 m"),
        ((*SIDES, "--block-coefficient", 1.2), "found a block coefficient of 1.2"),
        ((*SIDES, "--displacement", "8e6 tonne"), "found a block coefficient of 98.5"),
        ((*SIDES, "--displacement", "8e4 tonne", "--block-coefficient", 1), "found both"),
        ((*SIDES, "--water-depth", "5 m"), "expected more than the draught of 8 m"),
        ((*SIDES, "--database", BOX, "--water-depth", "50 m"), "is for infinite"),
        ((*SIDES, "--database", BOX), "expected the same hull"),
    ],
)
def test_wrong_particulars(
    run: Command, tmp_path: Path, options: tuple[object, ...], said: str
) -> None:
    assert said in refusal(run, tmp_path, "new", tmp_path / "own.yaml", *options)


def test_only_yaml_is_a_case(run: Command, tmp_path: Path) -> None:
    said = refusal(run, tmp_path, "new", tmp_path / "own.nc", *SIDES)
    assert "expected a name that ends in .yaml" in said


@pytest.mark.parametrize("depth", [10, 20, 40, 100, 1000])
def test_a_recipe_begins_at_a_frequency_that_can_be_computed(
    run: Command, tmp_path: Path, depth: float
) -> None:
    """The dispersion relation at the start gives a kh that the solver is tested for."""
    assert run("new", tmp_path / "own.yaml", *SIDES, "--water-depth", depth).code == 0
    recipe = load_recipe(tmp_path / "own_hull.yaml").data
    first = recipe.frequencies[0]
    k = brentq(lambda k: 9.81 * k * tanh(k * depth) - first**2, 1e-9, 1.0)
    assert k * depth > MIN_TESTED_KH
    assert first - recipe.frequencies[1] == pytest.approx(-0.03)
    assert first == pytest.approx(0.03)


def test_panels_do_not_depend_on_the_depth(run: Command, tmp_path: Path) -> None:
    """Finite depth costs 1.5 times as much as deep water, so that it needs no wider panels."""
    sizes = []
    for depth in ("infinite", "100 m"):
        path = tmp_path / f"{depth.split()[0]}.yaml"
        run("new", path, "--length", 110, "--beam", 30, "--draught", 4.2, "--water-depth", depth)
        sizes.append(load_recipe(path.with_name(f"{path.stem}_hull.yaml")).data.hull.panels)
    assert sizes[0] == sizes[1]
