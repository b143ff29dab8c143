"""Runs that start from the state of another: they go on as if it had not stopped."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scenes
import xarray as xr
from markers import few
from numpy.testing import assert_array_equal

import hydrosim as hs
from hydrosim.compile.restart import open_start
from hydrosim.report.evidence import Feature, Kind
from hydrosim.results.dataset import write_run
from hydrosim.results.ledger import worst_energy_gap
from hydrosim.scene import ConvolutionRadiation, Method

BREAK, END = 60.0, 100.0  # s
HULL = "barge"


def continued(whole: hs.Scene, **changes: Any) -> xr.Dataset:
    """The scene with ``changes`` from the break on, after a run up to there."""
    before = hs.simulate(replace(whole, duration=BREAK))
    changes = {"duration": END - BREAK, **changes}
    return hs.simulate(replace(whole, initial=hs.Start(before), **changes))


def rest_of(run: xr.Dataset, time: float = BREAK) -> xr.Dataset:
    return run.sel(time=slice(time - 1e-9, None))


def assert_same_bytes(found: xr.Dataset, expected: xr.Dataset) -> None:
    """All that is recorded, but for the residual, which is that of each run."""
    assert found.data_vars.keys() == expected.data_vars.keys()
    recorded = {name for name, values in found.items() if "time" in values.dims}
    for name in ("time", *(recorded - {"energy_residual"})):
        assert_array_equal(found[name].values, expected[name].values, err_msg=str(name))
    assert_array_equal(found.state_value[-1], expected.state_value[-1])


@pytest.fixture(scope="module")
def whole() -> xr.Dataset:
    return hs.simulate(scenes.in_contact(END))


@pytest.mark.parametrize("method", [Method.RK2, Method.HEUN, Method.RK4])
def test_a_restart_goes_on_to_the_bit(method: Method, validated) -> None:
    """Steps, stages, waves and events are the same ones; energies and slip distances go on."""
    scene = replace(scenes.in_contact(END), solver=hs.Solver(method=method, step=0.1))
    whole, after = hs.simulate(scene), continued(scene)
    assert after.time[0] == BREAK
    assert after.solver_events >= 20
    assert {0, 1, 2} == set(np.unique(after.fender_mode))
    assert_same_bytes(after, rest_of(whole))
    apart = float(np.abs(after.position.values - rest_of(whole).position.values).max())
    claim = "run through contacts that goes on from another [m]"
    validated(Kind.SELF, claim, "run in one piece", apart, 0.0, Feature.RESTART)


def test_a_restart_of_a_restart_through_files(whole: xr.Dataset, tmp_path: Path) -> None:
    start = None
    for end, length in ((30.0, 30.0), (60.0, 30.0), (100.0, 40.0)):
        run = hs.simulate(replace(scenes.in_contact(length), initial=start))
        write_run(run, tmp_path / f"{end:g}.nc")
        start = hs.Start(tmp_path / f"{end:g}.nc")
    assert_same_bytes(run, rest_of(whole))
    assert run.attrs["initial_run"] == str(tmp_path / "60.nc")
    assert run.attrs["initial_time"] == 60.0


def test_a_start_from_any_output_time(whole: xr.Dataset) -> None:
    """And what is kept for it does not change the run."""
    scene = scenes.in_contact(END).with_output(states=True)
    every = hs.simulate(scene)
    assert_same_bytes(every, whole)
    for time in (0.0, 12.5, 99.5):
        start = replace(scene, duration=END - time, initial=hs.Start(every, time))
        assert_same_bytes(hs.simulate(start), rest_of(every, time))


def test_tables_and_ramps_keep_their_phase() -> None:
    """The base case on its way up: a ramp of 200 s and the corner of a table at 500 s."""
    whole = replace(scenes.scene_of("base"), duration=520.0).with_output(states=True)
    every = hs.simulate(whole)
    for time in (100.0, 499.5):
        start = replace(whole, duration=520.0 - time, initial=hs.Start(every, time))
        assert_same_bytes(hs.simulate(start), rest_of(every, time))


def test_the_ledger_of_a_restart_is_its_own(whole: xr.Dataset) -> None:
    """Sums go on, but the residual begins at 0 and is of what was exchanged in this run."""
    after, expected = continued(scenes.in_contact(END)), rest_of(whole)
    residual = expected.energy_residual - expected.energy_residual[0]
    size = float(after.energy_wave_absolute[-1] - after.energy_wave_absolute[0])
    np.testing.assert_allclose(after.energy_residual, residual, atol=1e-9 * size)
    relative = worst_energy_gap(expected.assign(energy_residual=residual)).relative
    assert after.energy_residual_relative == pytest.approx(relative, rel=1e-6)
    assert after.fender_slip_distance[0].min() > 0.0


@pytest.mark.parametrize("method", few([Method.RK4, Method.RK2], 1))
def test_a_convolution_remembers_to_the_bit(method: Method) -> None:
    """The same nodes, sums and slopes at events; within the length of its memory and beyond."""
    memory = ConvolutionRadiation(length=40.0)
    scene = scenes.with_body(scenes.in_contact(END), radiation=memory)
    scene = replace(scene, solver=hs.Solver(method=method, step=0.1))
    whole = hs.simulate(scene.with_output(states=True))
    assert whole.solver_events >= 20
    for time in (20.0, 30.0, BREAK):
        start = replace(scene, duration=time, initial=None)
        before = hs.simulate(start)
        after = replace(scene, duration=END - time, initial=hs.Start(before))
        assert_same_bytes(hs.simulate(after), rest_of(whole, time))
    lost = before.assign(memory_past=0.0 * before.memory_past)
    start = replace(scene, duration=END - BREAK, initial=hs.Start(lost, BREAK))
    assert np.abs(hs.simulate(start).position - rest_of(whole).position).max() > 1e-4


def test_a_convolution_goes_on_from_within_a_run(figure) -> None:
    """Its past is made anew from the run's grid of polynomials: 2e-10 m of 0.1 m were seen."""
    scene = scenes.with_body(scenes.in_contact(30.0), radiation=ConvolutionRadiation(length=40.0))
    whole = hs.simulate(scene.with_output(states=True))
    after = hs.simulate(replace(scene, duration=10.0, initial=hs.Start(whole, 20.0)))
    difference = np.abs(after.position - rest_of(whole, 20.0).position)
    figure("difference [m]", float(difference.max()))
    assert difference.max() < 1e-8


def test_an_adaptive_method_goes_on_within_its_tolerance(figure) -> None:
    """The controller forgets its pace: other steps, each with an error of 1e-6 at most."""
    scene = replace(scenes.in_contact(END), solver=hs.Solver(method=Method.DOPRI5, step=0.1))
    difference = np.abs(continued(scene).position - rest_of(hs.simulate(scene)).position)
    figure("difference", float(difference.max()))
    assert 0.0 < difference.max() <= 1e-6


def test_what_may_be_another(whole: xr.Dataset) -> None:
    """The motion goes on, and sums of elements of the same names; new ones have done nothing."""
    scene = scenes.in_contact(END)
    fender = scene.forces["interface"]
    assert isinstance(fender, hs.Fender)
    forces = {
        "spring": scenes.mooring(HULL, surge=1e6),
        "lift": scene.forces["lift"],
        "interface": replace(fender, friction=hs.FrictionSlope(0.15, 1e7)),
    }
    solver = hs.Solver(method=Method.HEUN, step=0.07)
    after = continued(scene, forces=forces, solver=solver, output={"step": 0.35}, duration=35.0)
    there = whole.sel(time=BREAK)
    np.testing.assert_allclose(after.time, BREAK + 0.35 * np.arange(101), rtol=1e-12)
    for name in ("position", "velocity", "fender_slip_distance", "energy_work_lift"):
        assert_array_equal(after[name][0], there[name])
    assert after.energy_dissipated_interface[0] == there.energy_dissipated_interface
    assert after.energy_dissipated_spring[0] == 0.0
    assert "energy_dissipated_mooring" not in after
    assert after.energy_residual_relative < 1e-3


STEEL = hs.StickSlip(0.3, 0.2, 2e6, 4e4, 1e4)
WEIGHT = 1e5  # N


def sliding(stiffness: float = 1e7, **changes: Any) -> hs.Scene:
    """A block that slides over a floor for a second."""
    start = {
        "position": scenes.moving(heave=-WEIGHT / stiffness),
        "velocity": scenes.moving(surge=1.5),
    }
    body = scenes.block(1e4, ("surge", "heave"), **start)
    forces = {"weight": scenes.steady(heave=-WEIGHT), "floor": scenes.on_floor(stiffness, STEEL)}
    return replace(scenes.scene(body, forces, 0.4, 0.1, step=0.01), **changes)


def fender_of(scene: hs.Scene) -> hs.Fender:
    fender = scene.forces["floor"]
    assert isinstance(fender, hs.Fender)
    return fender


def with_floor(scene: hs.Scene, **changes: Any) -> hs.Scene:
    return replace(scene, forces={**scene.forces, "floor": replace(fender_of(scene), **changes)})


def test_a_point_that_slips_goes_on_slipping_below_its_static_limit() -> None:
    """The same motion could also begin in stick: what a new point does, unstretched."""
    before = hs.simulate(sliding())
    pull = np.abs(before.fender_friction[-1, 0, 0])
    assert 0.2 * WEIGHT < pull < 0.3 * WEIGHT
    scene = sliding(initial=hs.Start(before))
    assert hs.simulate(scene).fender_mode[0, 0] == before.fender_mode[-1, 0] == 2
    floor = {"other_floor": fender_of(scene), "weight": scene.forces["weight"]}
    new = hs.simulate(replace(scene, forces=floor))
    assert new.fender_mode[0, 0] == 1
    assert (new.fender_slip_distance[0, 0], new.fender_dissipated[0, 0]) == (0.0, 0.0)
    assert new.fender_node[0, 0, 0] == new.position[0, 0, 0] == before.position[-1, 0, 0]


def test_contact_that_cannot_be_any_more_is_found_anew() -> None:
    """A curve with fewer pieces, a floor that is lower than it was, one that is higher."""
    steep = hs.NormalCurve(np.array([0.0, 0.002, 0.1]), np.array([0.0, 2e4, 1e6]))
    before = hs.simulate(with_floor(sliding(), normal=steep))
    assert before.fender_segment[-1, 0] == 1
    scene = sliding(initial=hs.Start(before))
    straight = hs.simulate(scene)
    assert (straight.fender_segment[-1, 0], straight.fender_mode[0, 0]) == (0, 2)
    for height, mode in ((-5.0, 0), (0.01, 2)):
        plane = replace(fender_of(scene).plane, point=(0.0, 0.0, height))
        run = hs.simulate(with_floor(scene, plane=plane))
        assert run.fender_mode[0, 0] == mode
        assert run.fender_dissipated[0, 0] == before.fender_dissipated[-1, 0]
        assert run.energy_residual_relative < 1e-3  # RK4 loses (h w)^4 / 72, 1e-4, in bouncing
    lower = with_floor(sliding(), plane=replace(plane, point=(0.0, 0.0, -5.0)))
    falling = hs.simulate(lower)
    assert falling.fender_mode[-1, 0] == 0
    caught = with_floor(sliding(initial=hs.Start(falling)), plane=plane)
    assert hs.simulate(caught).fender_mode[0, 0] == 1


def test_other_laws_have_no_node_to_take_over() -> None:
    before = hs.simulate(sliding())
    assert before.state_value.sel(state="stretch 1 of floor 1")[-1] > 0.0
    other = with_floor(sliding(initial=hs.Start(before)), friction=hs.FrictionSlope(0.2, 1e5))
    after = hs.simulate(other)
    assert_array_equal(after.fender_node[:, 0, 0], after.position[:, 0, 0])
    assert after.energy_residual_relative < 1e-6


def refusal(scene: hs.Scene) -> str:
    with pytest.raises(hs.InputError) as caught:
        hs.simulate(scene)
    assert caught.value.exit_code == 2
    return str(caught.value)


@pytest.fixture(scope="module")
def short() -> xr.Dataset:
    return hs.simulate(replace(scenes.scene_of("base"), duration=10.0).with_output(step=0.5))


def test_what_is_no_run_is_refused(tmp_path: Path, short: xr.Dataset) -> None:
    (tmp_path / "text.nc").write_text("position")
    write_run(short.drop_vars("state_value"), tmp_path / "old.nc")
    write_run(short.drop_vars("state_kind"), tmp_path / "unnamed.nc")
    places = {
        tmp_path / "nowhere.nc": "there is no such file",
        tmp_path: "is a directory",
        tmp_path / "text.nc": "cannot be read as netCDF",
        scenes.CASES.parents[1] / "hydro_db" / "h851.nc": "is netCDF without position",
        tmp_path / "old.nc": "has no states, so no run can start from it",
        tmp_path / "unnamed.nc": "does not name its states",
    }
    for place, words in places.items():
        message = refusal(replace(scenes.scene_of("base"), initial=hs.Start(place)))
        assert message.startswith("initial.run: ")
        for word in (str(place), words, "expected the result of"):
            assert word in message


def test_times_that_are_not_recorded_are_refused(short: xr.Dataset) -> None:
    scene = replace(scenes.scene_of("base"), duration=10.0)
    message = refusal(replace(scene, initial=hs.Start(short, 5.0)))
    words = ("found 5 s", "only its last whole state, at 10 s", "output: {states: true}")
    for word in ("initial.time: ", *words):
        assert word in message
    every = hs.simulate(scene.with_output(states=True))
    message = refusal(replace(scene, initial=hs.Start(every, 5.2)))
    assert "found 5.2 s" in message
    assert "nearest is at 5 s" in message
    assert open_start(replace(scene, initial=hs.Start(every, 5.0 + 1e-12))).initial.time == 5.0


def test_states_that_are_not_finite_are_refused(short: xr.Dataset) -> None:
    bad = short.assign(state_value=short.state_value.where(short.state != "heave of barge"))
    message = refusal(replace(scenes.scene_of("base"), initial=hs.Start(bad)))
    assert "at 10 s is not finite; start from an earlier time" in message


OTHERS: dict[str, tuple[dict[str, Any], list[str]]] = {
    "body": (
        {"name": "ship"},
        ["that run lacks surge of ship, ", "this scene lacks", "surge of barge, "],
    ),
    "dofs": ({"dofs": ("surge",)}, ["this scene lacks heave of barge, pitch of barge, "]),
    "no radiation": (
        {"radiation": "none"},
        ["radiation 1 of surge, heave, pitch of barge", " more"],
    ),
    "convolution": (
        {"radiation": "convolution"},
        ["that run lacks memory of surge of barge", "this scene lacks", "radiation 1 of "],
    ),
}


@pytest.mark.parametrize("what", OTHERS)
def test_another_system_is_refused(short: xr.Dataset, what: str) -> None:
    changes, words = OTHERS[what]
    scene = scenes.with_body(replace(scenes.scene_of("base"), forces={}), **changes)
    message = refusal(replace(scene, initial=hs.Start(short)))
    expected = "expected the same bodies, degrees of freedom and radiation"
    for word in ("initial.run: ", *words, expected):
        assert word in message


def test_radiation_states_of_another_fit_are_refused(short: xr.Dataset) -> None:
    """A pole's two states may be turned in their plane: the same memory by other states."""
    turned = short.assign(state_input=-short.state_input)
    assert "another fit" in refusal(replace(scenes.scene_of("base"), initial=hs.Start(turned)))


def test_memory_that_has_been_overwritten_is_refused() -> None:
    scene = scenes.with_body(scenes.in_contact(5.0), radiation="convolution")
    run = hs.simulate(scene)
    names = ("time", "state_time", "memory_time", "memory_node_time", "memory_begin")
    times = {name: run[name] + 500.0 for name in names}
    late = run.assign_coords(times)
    message = refusal(replace(scene, initial=hs.Start(late)))
    for word in ("initial.time: found 505 s", "from 500 s on", "100 s of them", "600 s or later"):
        assert word in message


def test_a_sea_must_not_repeat_itself_in_a_restart(short: xr.Dataset) -> None:
    sea = hs.WaveTrain(scenes.SEA, repeat_period=200.0)
    scene = scenes.in_waves(replace(scenes.scene_of("base"), duration=195.0), sea)
    hs.compile_scene(scene)
    message = refusal(replace(scene, initial=hs.Start(short)))
    for word in ("repeat_period: 200 s is shorter", "Raise it to 205 s, the end of the run"):
        assert word in message
