"""Two sets of runs: what differs is named, what does not is not, as often as is promised."""

import numpy as np
import pytest
import xarray as xr
from reading import tables, texts

from hydrosim.compare.dataset import studies_dataset
from hydrosim.compare.studies import StudyComparison, compare_studies
from hydrosim.errors import InputError
from hydrosim.report.sentences.comparison import studies_tables

RUNS, CHANNELS = 12, 20


def said(found: StudyComparison) -> list[str]:
    """What is said of a comparison: which runs, sentences, verdicts."""
    document = studies_tables(studies_dataset(found, {}))
    return [document.subtitle, *texts(document.nodes)]


def runs(values: np.ndarray, seeds: np.ndarray | None = None) -> xr.Dataset:
    """Runs (n, channels) with the seeds."""
    found = xr.Dataset(
        {"motion": (("run", "dof"), values, {"units": "m"}), "crawl": ("run", values[:, 0])},
        {"dof": [f"d{k}" for k in range(values.shape[1])]},
    )
    return found if seeds is None else found.assign_coords(seed=("run", seeds))


def test_pairs_in_the_same_waves_find_what_independent_runs_do_not() -> None:
    """A shift of a tenth of the scatter over seeds, in another order of the runs."""
    random = np.random.default_rng(1)
    seeds, waves = np.arange(RUNS), random.normal(0.0, 1.0, (RUNS, CHANNELS))
    other = waves + random.normal(0.0, 0.01, waves.shape)
    other[:, 3] -= 0.1
    order = random.permutation(RUNS)
    found = compare_studies(runs(waves, seeds), runs(other[order], seeds[order]))
    assert found.paired
    assert [each.channel for each in found.channels if each.differs] == ["motion.d3"]
    (each,) = (one for one in found.channels if one.differs)
    assert each.low < 0.1 < each.high
    apart = compare_studies(runs(waves), runs(other))
    assert not apart.paired
    assert not any(each.differs for each in apart.channels)
    nodes = studies_tables(studies_dataset(found, {})).nodes
    differing = tables(nodes, "channel")[0]
    assert [row[0] for row in differing.rows] == ["motion.d3"]
    assert "1 of 21 channels differ by more than chance" in " ".join(texts(nodes))


@pytest.mark.slow
def test_by_chance_something_is_named_as_often_as_is_said() -> None:
    """5 % of 400 comparisons of the same law; 3 standard deviations are 3.3 %."""
    random = np.random.default_rng(5)
    named = 0
    for _ in range(400):
        one, other = random.normal(0.0, 1.0, (2, RUNS, 5))
        named += any(each.differs for each in compare_studies(runs(one), runs(other)).channels)
    assert named / 400 < 0.083


def test_equal_runs_and_constant_differences() -> None:
    values = np.random.default_rng(1).normal(size=(RUNS, 2))
    same = compare_studies(runs(values, np.arange(RUNS)), runs(values, np.arange(RUNS)))
    assert not any(each.differs for each in same.channels)
    text = " ".join(said(same))
    assert "3 are equal in all runs, and differences of the other 0 may be chance" in text
    constant = runs(np.ones((RUNS, 2)))
    moved = compare_studies(constant, runs(np.zeros((RUNS, 2))))
    assert all(each.differs and each.difference == 1.0 for each in moved.channels)


def test_too_few_runs() -> None:
    with pytest.raises(InputError, match="found no recorded number that at least 3 runs"):
        compare_studies(runs(np.ones((2, 2))), runs(np.ones((2, 2))))


def test_other_parameters_are_no_other_seeds() -> None:
    """Runs at two heights are not pooled with runs at one."""
    values, seeds = np.random.default_rng(1).normal(size=(RUNS, 2)), np.arange(RUNS)
    heights = runs(values, seeds // 2).assign_coords(height=("run", np.tile([1.0, 2.0], RUNS // 2)))
    with pytest.raises(InputError, match="several values of height"):
        compare_studies(
            heights, runs(values, seeds).assign_coords(height=("run", np.full(RUNS, 3.0)))
        )


def test_codes_are_no_channels() -> None:
    """What extremes are by differs in all runs: it is told, and not counted among the tests."""
    values, seeds = np.random.default_rng(2).normal(size=(RUNS, 2)), np.arange(RUNS)
    meanings = {"flag_values": np.arange(11, dtype=np.int8), "flag_meanings": "gaussian ..."}
    one, other = (
        runs(values, seeds).assign(
            motion_basis=(("run", "dof"), np.full((RUNS, 2), code)),
            state=("run", np.full(RUNS, code), meanings),
        )
        for code in (0.0, 10.0)
    )
    found = compare_studies(one, other)
    assert [each.channel for each in found.channels] == ["motion.d0", "motion.d1", "crawl"]
    assert "warning: Codes differ too. They are not tested: motion_basis, state." in said(found)
    assert studies_dataset(found, {}).attrs["codes_apart"] == "motion_basis state"
    assert compare_studies(one, one).codes == ()
    assert compare_studies(one.drop_vars("seed"), other.drop_vars("seed")).codes == found.codes


@pytest.mark.parametrize("paired", [True, False])
def test_other_durations_are_told_first(paired: bool) -> None:
    seeds = np.arange(RUNS) if paired else None
    values = np.random.default_rng(3).normal(size=(RUNS, 2))

    def lasting(*durations: float) -> xr.Dataset:
        cases = [f"title: S\nduration: {x}\nbodies: {{}}\n" for x in durations * RUNS][:RUNS]
        return runs(values, seeds).assign(case_resolved=("run", cases))

    text = said(compare_studies(lasting(300.0), lasting(400.0, 500.0)))
    assert "but of different durations: ours 300 s and theirs 400 to 500 s" in text[0]
    assert "same waves" not in text[0]
    assert any("durations differ" in line for line in text if line.startswith("warning: "))
    for same in (
        compare_studies(*[lasting(300.0)] * 2),
        compare_studies(*[runs(values, seeds)] * 2),
    ):
        assert same.durations == ()
        assert "durations" not in " ".join(said(same))
