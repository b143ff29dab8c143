"""`simulate_many`: the same as single runs, whatever the number of threads; failures, interrupts.

Nothing here has a tolerance: a run among others is the same run to the bit.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scenes import CASES, SEA, in_contact, in_waves, scene_of, steady, with_body

import hydrosim as hs
from hydrosim.compare.dataset import differences
from hydrosim.results.runs_file import LARGE, read_unfinished
from hydrosim.scene import Scene, Solver, Start, Unstable, WaveTrain
from hydrosim.statistics.figures import ScalarResult
from hydrosim.statistics.statistics import statistics
from hydrosim.study import scene_cache
from hydrosim.study.scene_cache import are_scenes_equal

SHORT = 60.0  # s: with contact from the start


def seeds(*numbers: int) -> list[Scene]:
    """The barge that knocks against the topside, in seas of these seeds."""
    return [in_waves(in_contact(SHORT), WaveTrain(SEA, seed=seed)) for seed in numbers]


def turning_over() -> Scene:
    """The same barge under a moment that turns it over."""
    scene = in_contact(SHORT)
    return replace(scene, forces={**scene.forces, "push": steady("barge", pitch=3e12)})


def same(found: xr.Dataset, expected: xr.Dataset) -> bool:
    """Whether all variables of the one are in the other, bit for bit."""
    return all(
        np.array_equal(found[name].values, expected[name].values, equal_nan=True)
        for name in expected.data_vars
    )


@pytest.fixture(scope="module")
def singles() -> list[xr.Dataset]:
    """Three runs, each on its own."""
    return [hs.simulate(scene) for scene in seeds(1, 2, 3)]


def test_each_run_is_a_single_run_to_the_bit(singles: list[xr.Dataset]) -> None:
    """Motions, other variables, statistics; the waves are all that is made anew for each."""
    chosen = ["position", "wave_elevation", "fender_normal_force", "force_interface"]
    runs = hs.simulate_many(seeds(1, 2, 3), variables=chosen, workers=2, start=20.0)
    assert list(runs.seed) == [1, 2, 3]
    assert list(runs.status) == ["complete"] * 3
    for k, single in enumerate(singles):
        run = runs.isel(run=k)
        assert same(run, single[chosen])
        expected = statistics(single, 20.0)
        assert same(run, expected.drop_vars("phase_crawl"))
        assert np.array_equal(run.phase_crawl.sel(axis=["x", "y"]), expected.phase_crawl)
        assert np.array_equal(run.end_position, single.position[-1])
        touching = single.time[(single.fender_mode > 0).any("fender").values]
        assert run.first_contact.item() == float(touching[0])
        for name in ("solver_steps", "solver_events", "energy_residual_relative"):
            assert float(run[name]) == single.attrs[name]
        assert str(run.warnings.values) == single.attrs.get("warnings", "")


def test_runs_may_differ_in_more_than_their_waves(singles: list[xr.Dataset]) -> None:
    """What is taken over from the run before is taken over from a like one only."""
    (barge,) = in_contact(SHORT).bodies
    heavy = [with_body(scene, mass=1.001 * barge.mass) for scene in seeds(1, 2)]
    mixed = [seeds(1)[0], *heavy, seeds(3)[0]]
    runs = hs.simulate_many(mixed, labels={"mass": [s.bodies[0].mass for s in mixed]})
    assert runs.mass.dims == ("run",)
    expected = [singles[0], *(hs.simulate(scene) for scene in heavy), singles[2]]
    for k, single in enumerate(expected):
        assert same(runs.isel(run=k), single[["position"]])
    assert not np.array_equal(expected[1].position, singles[0].position)


def test_databases_and_all_but_the_waves_are_compiled_once(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[str] = []

    def counted(name: str) -> None:
        function = getattr(scene_cache, name)

        def call(*arguments: object) -> object:
            calls.append(name)
            return function(*arguments)

        monkeypatch.setattr(scene_cache, name, call)

    counted("open_database")
    counted("compile_calm")
    cases = [
        hs.load_case(CASES / "base.yaml", {"duration": 5.0, "environment.waves.seed": seed})
        for seed in (1, 2, 3)
    ]
    runs = hs.simulate_many(cases)
    assert sorted(calls) == ["compile_calm", "open_database"]
    assert same(runs.isel(run=1), hs.simulate(cases[1])[["position"]])
    assert "seed: 2" in str(runs.case[1].values)  # the texts differ, so each run has its own
    assert "case" not in runs.attrs


@pytest.mark.slow
def test_the_file_is_the_same_to_the_byte_for_any_number_of_workers(tmp_path: Path) -> None:
    """The first run takes five times as long as the others, which end before it."""
    slow, *others = seeds(1, 2, 3, 4, 5)
    scenes = [replace(slow, solver=Solver(step=0.02)), turning_over(), *others]
    made = []
    for workers in (1, 2, 3):
        path = tmp_path / f"{workers}" / "runs.nc"
        path.parent.mkdir()
        hs.simulate_many(scenes, path, workers=workers).close()
        made.append(path.read_bytes())
    assert made[0] == made[1] == made[2]


def test_a_run_that_fails_is_marked_and_the_others_go_on(singles: list[xr.Dataset]) -> None:
    """One that cannot go on, and one whose sea would repeat itself; first of all, and within."""
    repeating = in_waves(in_contact(SHORT), WaveTrain(replace(SEA, peak_period=1.0)))
    runs = hs.simulate_many([turning_over(), *seeds(1), repeating, *seeds(2)], workers=2)
    assert list(runs.status) == ["failed", "complete", "failed", "complete"]
    assert "is beyond 85 deg, or the heel of its hull" in str(runs.status_message[0].values)
    assert "outside the frequencies" in str(runs.status_message[2].values)
    assert np.isnan(runs.position[[0, 2]]).all()
    assert np.isnan(runs.motion[[0, 2]]).all()
    assert same(runs.isel(run=1), singles[0][["position"]])
    assert same(runs.isel(run=3), singles[1][["position"]])


def test_a_set_of_failures_has_a_file_all_the_same(tmp_path: Path) -> None:
    runs = hs.simulate_many([turning_over()] * 2, tmp_path / "runs.nc")
    assert list(runs.status) == ["failed", "failed"]
    assert "position" not in runs


def test_runs_are_in_the_folder_as_soon_as_they_are_done(tmp_path: Path) -> None:
    """It is read after each run as if this process had been killed, and has all runs until then, as
    the file has them in the end."""
    path, done, parts = tmp_path / "runs.nc", [], []

    def look(count: int, total: int) -> None:
        part = read_unfinished(tmp_path / "runs.nc.partial")
        status = part.status.values.tolist()
        assert total == 3
        assert status[:count] == ["complete"] * count
        assert {*status[count:]} <= {"complete", "not run"}  # one may be there before its turn
        assert part.attrs["gathered"] == f"{status.count('complete')} of 3 runs are complete"
        parts.append(part)
        done.append(count)

    with hs.simulate_many(seeds(1, 2, 3), path, workers=2, progress=look) as runs:
        assert runs.position.dims == ("run", "time", "body", "dof")
        assert runs.encoding["source"] == str(path)
        runs.load()
    assert done == [1, 2, 3]
    assert not Path(f"{path}.partial").exists()
    assert all(runs[name][0].size < LARGE for name in runs)  # else it is not in the parts
    assert differences(runs, parts[-1], ["gathered"]) == []
    assert differences(runs.isel(run=0), parts[0].isel(run=0), ["gathered"]) == []


def test_an_interrupt_keeps_what_is_done(tmp_path: Path, singles: list[xr.Dataset]) -> None:
    long = seeds(*range(1, 41))
    runs = hs.simulate_many(long, tmp_path / "runs.nc", workers=2, progress=interrupt_after(2))
    status = runs.status.values.tolist()
    assert status[:2] == ["complete", "complete"]
    assert {*status[2:]} <= {"complete", "interrupted", "not run"}
    assert status[-1] == "not run"
    assert same(runs.isel(run=1), singles[1][["position"]])
    complete = runs.status == "complete"
    assert np.isfinite(runs.position[complete]).all()
    assert np.isnan(runs.position[~complete]).all()


def interrupt_after(count: int) -> Callable[[int, int], None]:
    """Progress that is interrupted from the keyboard after so many runs."""

    def progress(done: int, _: int) -> None:
        if done == count:
            raise KeyboardInterrupt

    return progress


@pytest.mark.slow
def test_runs_from_the_state_of_another(tmp_path: Path) -> None:
    """Opened once; their times go on from there."""
    before = tmp_path / "before.nc"
    hs.simulate(in_contact(20.0)).to_netcdf(before)
    starts = [replace(scene, initial=Start(before)) for scene in seeds(1, 2)]
    runs = hs.simulate_many(starts)
    assert float(runs.time[0]) == 20.0
    for k, scene in enumerate(starts):
        assert same(runs.isel(run=k), hs.simulate(scene)[["position"]])
    mixed = hs.simulate_many([*starts[:1], *seeds(1)])
    assert mixed.status.values.tolist() == ["complete", "failed"]
    assert "its time is not that of the runs before it" in str(mixed.status_message[1].values)


def test_seeds_of_several_wave_trains() -> None:
    swell = replace(SEA, peak_period=12.0)
    trains = [(WaveTrain(SEA, seed=k), WaveTrain(swell, seed=k + 10)) for k in (1, 2)]
    runs = hs.simulate_many([in_waves(in_contact(5.0), *pair) for pair in trains])
    assert (runs.seed.values.tolist(), runs.seed_2.values.tolist()) == ([1, 2], [11, 12])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"duration": 30.0}, "duration 60.0 in run 0 and 30.0 in run 1.*the same"),
        ({"output": {"step": 1.0}}, "output_step 0.5 in run 0 and 1.0 in run 1"),
    ],
)
def test_runs_that_do_not_fit_together_are_refused(change: dict[str, float], said: str) -> None:
    one, other = seeds(1, 2)
    with pytest.raises(hs.InputError, match=said):
        hs.simulate_many([one, replace(other, **change)])  # type: ignore[arg-type]


def test_what_cannot_be_kept_is_refused(tmp_path: Path) -> None:
    with pytest.raises(hs.InputError, match="found no case"):
        hs.simulate_many([])
    with pytest.raises(hs.InputError, match=r"labels.mass: found 1 values; .* the 2 runs"):
        hs.simulate_many(seeds(1, 2), labels={"mass": [1.0]})
    with pytest.raises(hs.InputError, match=r"start 60 s; expected a time well before the end"):
        hs.simulate_many(seeds(1), start=60.0)
    with pytest.raises(hs.InputError, match=r"found surge; expected some of: position, velocity"):
        hs.simulate_many(seeds(1, 2), tmp_path / "runs.nc", variables=["surge"])
    with pytest.raises(hs.InputError, match=r'energy_residual; did you mean "position"\?'):
        hs.simulate_many(seeds(1), variables=["position.barge.surge"])
    with pytest.raises(hs.InputError, match=r"give hs\.load_case\(path, {key: value}\)"):
        hs.simulate(seeds(1)[0], {"duration": 100.0})  # type: ignore[arg-type]
    assert not (tmp_path / "runs.nc").exists()


@pytest.mark.parametrize("name", ["motion", "fender", "fender_force"])
def test_a_figure_with_a_name_of_the_runs_is_refused_before_the_first(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hydrosim.study.run_layout.merge_layouts", None)
    with pytest.raises(hs.InputError, match=f"name {name}, .* such as {name}_of_run"):
        hs.simulate_many(seeds(1), figures=[ScalarResult(name, "position.barge.surge", "end")])


def test_scenes_are_alike_entry_by_entry() -> None:
    """Two readings of one file are alike; any number, array or name that differs tells."""
    one, other = (hs.load_case(CASES / "base.yaml").scene() for _ in range(2))
    assert one is not other
    assert are_scenes_equal(one, other)
    assert are_scenes_equal(one.bodies, other.bodies)
    (barge,) = one.bodies
    inertia = barge.inertia.copy()
    inertia[0, 0] += 1.0
    for change in ({"inertia": inertia}, {"name": "ship"}, {"dofs": ("surge",)}, {"mass": 1.0}):
        assert not are_scenes_equal(one, with_body(other, **change))
    assert not are_scenes_equal(one, replace(other, forces={}))
    assert not are_scenes_equal(one, scene_of("free_floating"))
    assert not are_scenes_equal(object(), object())


def test_what_every_run_is_refused_for_is_told_once_and_at_once(tmp_path: Path) -> None:
    """No seed and no value is run. The message has how many runs there are."""
    done: list[int] = []
    steps = [replace(s, solver=replace(s.solver, step=0.5)) for s in seeds(1, 2, 3)]
    refusing = [replace(s, solver=replace(s.solver, unstable=Unstable.ERROR)) for s in steps]
    with pytest.raises(hs.InputError, match="All 3 runs are refused before") as caught:
        hs.simulate_many(refusing, tmp_path / "runs.nc", progress=lambda n, _: done.append(n))
    assert str(caught.value).count("largest stable step") == 1
    assert not done
    assert not list(tmp_path.iterdir())


def test_some_runs_measure_their_errors_by_their_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first of so many runs does, and the dataset says so."""
    monkeypatch.setattr("hydrosim.study.many_runs.ESTIMATE_INTERVAL", 2)
    runs = hs.simulate_many(seeds(1, 2, 3), workers=2)
    assert [*np.isfinite(runs.error_relative.values)] == [True, False, True]
    single = hs.simulate(seeds(1)[0])
    assert float(runs.error_relative[0]) == single.attrs["error_relative"] > 0.0
    assert "in run 0" in runs.attrs["error_estimates"]
    later = hs.simulate_many(seeds(4, 5), workers=2, first=3)
    assert [*np.isfinite(later.error_relative.values)] == [False, True]


def test_one_run_of_fifty_measures_its_error() -> None:
    """That is 2 % of a sweep where a companion takes what its run does."""
    for first, measured in ((0, [True, False]), (20, [False, False]), (49, [False, True])):
        runs = hs.simulate_many(seeds(1, 2), workers=2, first=first)
        assert [*np.isfinite(runs.error_relative.values)] == measured
        assert "every 50th" in runs.attrs["error_estimates"]
