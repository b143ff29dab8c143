"""Runs of one file that do not share their names: each is the single run, in the form of all."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scenes import block, on_floor, steady
from scenes import scene as dry

import hydrosim as hs
from hydrosim.compare.dataset import differences
from hydrosim.elements import Frictionless, StickSlip
from hydrosim.results.runs_file import read_unfinished
from hydrosim.scene import Scene, Weight
from hydrosim.statistics.explain import explain_run, explanations_of_runs
from hydrosim.statistics.figures import ScalarResult
from hydrosim.study import run_layout
from hydrosim.study.run_layout import one_scene_of_each_kind


def sliding(kinetic: float = 0.1, points: int = 1, impulses: bool = True) -> Scene:
    """A block that stands on the floor and is pushed."""
    places = [[0.0, float(k), 0.0] for k in range(points)]
    law = StickSlip(static=0.2, kinetic=kinetic, stiffness=1e6, damping=1e4)
    floor = on_floor(1e6, law, places)
    body = block(1e3, ("surge", "heave"))
    forces = {"floor": floor, "weight": steady(heave=-1e4), "push": steady(surge=3e3)}
    return dry(body, forces, 2.0, 0.1, step=0.01).with_output(impulses=impulses)


def without(scene: Scene, *names: str) -> Scene:
    """A scene without some of its elements."""
    return replace(scene, forces={k: f for k, f in scene.forces.items() if k not in names})


def topside(mass: float) -> Scene:
    """A dry body that carries its weight, on a floor."""
    body = block(mass, ("heave",), weight=Weight.CARRIED)
    return dry(body, {"floor": on_floor(1e6, Frictionless())}, 2.0, 0.1, step=0.01)


def equal(found: xr.DataArray, expected: xr.DataArray) -> bool:
    return np.array_equal(found.values, expected.transpose(*found.dims).values, equal_nan=True)


def test_kinetic_friction_with_impulses_is_kept_apart() -> None:
    """The question that this program was made for: one study, explained for each value."""
    scenes = [sliding(0.1), sliding(0.15), sliding(0.05)]
    runs = hs.simulate_many(scenes, labels={"kinetic": [0.1, 0.15, 0.05]})
    assert list(runs.status) == ["complete"] * 3
    assert runs.fender_kinetic.dims == ("run", "fender")
    assert runs.fender_kinetic.values.ravel().tolist() == [0.1, 0.15, 0.05]
    assert "fender_kinetic" in runs.coords
    assert "fender_kinetic: a value for each run" in runs.attrs["runs_differ"]
    found = explanations_of_runs(runs)
    for k, scene in enumerate(scenes):
        single = explain_run(hs.simulate(scene))
        for name in single.data_vars:
            assert equal(found[name][k], single[name]), name


def test_what_a_run_lacks_is_padded(tmp_path: Path) -> None:
    """Two points, one, none: values of the single runs, and a coordinate that says which are
    there."""
    one, two, none = sliding(points=1), sliding(points=2), without(sliding(), "floor")
    scenes = [two, one, none]
    names = ["position", "fender_normal_force", "fender_mode"]
    with hs.simulate_many(scenes, tmp_path / "runs.nc", variables=names) as runs:
        runs.load()
    assert list(runs.status) == ["complete"] * 3
    assert runs.fender.values.tolist() == ["floor 1", "floor 2"]
    has = runs.fender_in_run.values.astype(bool)
    assert has.sum(axis=1).tolist() == [2, 1, 0]
    assert "fender_in_run" in runs.coords
    for k, scene in enumerate(scenes):
        single = hs.simulate(scene)
        assert equal(runs.position[k], single.position)
        if has[k].any():
            own = runs.isel(run=k).sel(fender=single.fender.values)
            assert equal(own.fender_normal_force, single.fender_normal_force)
            assert equal(own.fender_mode, single.fender_mode.astype(float))
    absent = runs.fender_normal_force.where(runs.fender_in_run == 0, drop=True)
    assert absent.size
    assert absent.isnull().all()
    assert "in 1 of 3 runs" in runs.attrs["runs_differ"]


def test_bodies_may_differ() -> None:
    """Another name, and one more of them."""
    one = dry(block(2.0, ("surge",), "a"), {"push": steady("a", surge=1.0)}, 1.0, 0.1)
    two = dry(
        [block(2.0, ("surge",), "a"), block(4.0, ("surge",), "b")],
        {"push": steady("a", surge=1.0), "pull": steady("b", surge=2.0)},
        1.0,
        0.1,
    )
    runs = hs.simulate_many([one, two])
    assert runs.body.values.tolist() == ["a", "b"]
    assert runs.body_in_run.values.tolist() == [[1, 0], [1, 1]]
    assert np.isnan(runs.position.sel(run=0, body="b")).all()
    assert equal(runs.position[1], hs.simulate(two).position)
    ends = runs.end_position.sel(dof="surge").values
    assert ends[1].tolist() == pytest.approx([0.25, 0.25])


def test_a_weight_that_varies_is_kept_apart() -> None:
    runs = hs.simulate_many([topside(1e3), topside(2e3)])
    assert list(runs.status) == ["complete"] * 2
    assert runs.contact_weight.values.ravel().tolist() == pytest.approx([9810.0, 19620.0])


def test_a_figure_or_a_variable_that_some_runs_lack_is_left_out_of_these() -> None:
    have, lack = sliding(impulses=False), without(sliding(impulses=False), "push")
    pushed = ScalarResult("pushed", "force_push.block.surge", "largest")
    runs = hs.simulate_many([lack, have], variables=["force_push"], figures=[pushed])
    assert list(runs.status) == ["complete"] * 2
    assert np.isnan(float(runs.pushed[0]))
    assert float(runs.pushed[1]) == 3e3
    assert np.isnan(runs.force_push[0]).all()
    assert "pushed: in 1 of 2 runs" in runs.attrs["runs_differ"]


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"variables": ["force_pull"]}, "variables: found force_pull"),
        (
            {"figures": [ScalarResult("a", "force_pull.block.surge", "end")]},
            "force_pull.block.surge",
        ),
        ({"channels": ["tide.*"]}, "output.channels: found tide"),
    ],
)
def test_what_no_run_has_is_refused_before_the_first(
    asked: dict[str, object], words: str, tmp_path: Path
) -> None:
    done: list[int] = []
    with pytest.raises(hs.InputError, match=re.escape(words)):
        hs.simulate_many(
            [sliding(), sliding(points=2)],
            tmp_path / "runs.nc",
            progress=lambda n, _: done.append(n),
            **asked,  # type: ignore[arg-type]
        )
    assert not done
    assert not list(tmp_path.iterdir())


def test_runs_that_differ_in_what_is_not_kept_have_no_form_of_their_own() -> None:
    runs = hs.simulate_many([sliding(0.1, impulses=False), sliding(0.15, impulses=False)])
    assert list(runs.status) == ["complete"] * 2
    assert "runs_differ" not in runs.attrs
    assert float(runs.end_position[1, 0, 0]) < float(runs.end_position[0, 0, 0])


@pytest.mark.slow
def test_a_padded_set_that_is_interrupted_goes_on_to_the_same(tmp_path: Path) -> None:
    """Its folder can be read meanwhile, with the coordinates of runs."""
    scenes = [sliding(points=2), *[sliding(0.15)] * 6, without(sliding(), "floor")]
    whole = hs.simulate_many(scenes, tmp_path / "whole.nc").load()
    path = tmp_path / "runs.nc"

    def stop(done: int, _: int) -> None:
        if done == 1:
            part = read_unfinished(tmp_path / "runs.nc.partial")
            assert "fender_in_run" in part.coords
            assert part.fender_in_run.values[0].tolist() == whole.fender_in_run.values[0].tolist()
            raise KeyboardInterrupt

    hs.simulate_many(scenes, path, workers=1, progress=stop).close()
    assert Path(f"{path}.partial").is_dir()
    again = hs.simulate_many(scenes, path, resume=True).load()
    assert differences(again, whole) == []


def test_a_kind_of_scene_is_tried_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """As many trials as there are kinds of names, not values; and none of seeds."""
    scenes = [sliding(0.01 * k, points) for points in (1, 2) for k in range(5, 10)]
    assert len(one_scene_of_each_kind(scenes)) == 2
    tried: list[Scene] = []
    simulate = run_layout.simulate
    monkeypatch.setattr(run_layout, "simulate", lambda s: (tried.append(s), simulate(s))[1])
    hs.simulate_many(scenes)
    assert len(tried) == 2
