"""Mutants of the shipped cases, a few of those that `python -m benchmarks.mutants` tries."""

from pathlib import Path

import pytest

from hydrosim.case import load_case
from hydrosim.errors import InputError
from tests.generators import mutant_papers
from tests.generators.mutant_trials import prepare, tried
from tests.generators.mutants import CHANGES, RENAMES, Mutant, mutants, shipped, text_of, whole

SEED = 2_000
ENDS = ("complete", "failed", "refused")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the cases."""
    folder = tmp_path_factory.mktemp("mutants")
    prepare(folder)
    return folder


@pytest.fixture(scope="module")
def papers_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What papers read; each test writes its own paper."""
    folder = tmp_path_factory.mktemp("papers")
    mutant_papers.prepare(folder)
    return folder


@pytest.mark.parametrize("name", shipped())
def test_what_is_mutated_is_the_case_itself(name: str, folder: Path) -> None:
    path = (folder / "cases" / name).with_name("mutant.yaml")
    path.write_text(text_of(Mutant(name, ("title",), "nothing")).replace("null", "x"))
    assert load_case(path).data.bodies
    assert {"solver", "output", "bodies", "duration"} <= whole(name).keys()


def test_mutants_are_of_all_kinds() -> None:
    """The same for a seed, and different from each other."""
    chosen = mutants(3000, SEED)
    assert chosen == mutants(3000, SEED)
    assert len({*chosen}) == 3000
    assert {mutant.how for mutant in chosen} == {*CHANGES, *RENAMES}
    assert {mutant.case for mutant in chosen} == {*shipped()}


@pytest.mark.parametrize("count", [5, pytest.param(40, marks=pytest.mark.slow)])
def test_a_mutant_is_refused_or_checked(folder: Path, count: int) -> None:
    for mutant in mutants(count, SEED):
        outcome = tried(("check", mutant, str(folder)))
        assert outcome.status in ENDS, (mutant, outcome.message)
        assert outcome.message or outcome.status == "complete"


@pytest.mark.slow
@pytest.mark.parametrize("paper", mutant_papers.papers())
def test_a_paper_is_right_before_it_is_changed(paper: str, papers_folder: Path) -> None:
    kind = mutant_papers.papers()[paper]
    path = papers_folder / f"{paper}{kind.suffix}"
    for name in ("hindcast", "scatter"):
        (papers_folder / f"{name}.csv").write_text(mutant_papers.papers()[name].text)
    mutant_papers.write_right(path, kind)
    if paper in mutant_papers.REFUSED:
        with pytest.raises(InputError, match=r"MAP\+\+"):
            kind.read(path)
    else:
        kind.read(path)


@pytest.mark.parametrize("count", [3, pytest.param(30, marks=pytest.mark.slow)])
@pytest.mark.parametrize("paper", mutant_papers.papers())
def test_a_mutant_of_another_file_is_refused(paper: str, count: int, papers_folder: Path) -> None:
    for number in range(count):
        what, outcome = mutant_papers.trial(paper, SEED + number, papers_folder)
        assert outcome.status in ENDS, (what, outcome.message)
