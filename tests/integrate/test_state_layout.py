"""The layout of y: blocks lie where the model has them, and names are not taken apart."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hydrosim as hs
from hydrosim.compile.clock import compile_clock
from hydrosim.compile.compile import compile_scene
from hydrosim.integrate.loop import advance
from hydrosim.integrate.methods import guard_defect, linear_value, next_trial
from hydrosim.integrate.names import StateKind, state_layout
from hydrosim.integrate.record import (
    MEMORY_SPACING,
    new_record,
    states_at,
    unpack_channels,
    with_states,
)
from hydrosim.integrate.state import GRID_POINT, RECORDS, Run, new_run
from hydrosim.jit.kernels import any_negative

CASES = Path(__file__).parents[2] / "cases"
IRREGULAR = CASES / "sphere" / "irregular.yaml"


def test_radiation_states_are_named_after_their_group_once() -> None:
    """Groups of two degrees of freedom and of one, which a model may fill up."""
    scene = hs.load_case(IRREGULAR).scene()
    compiled = hs.compile_scene(scene)
    model = compiled.model
    layout = state_layout(scene, model, compiled.derived.met)
    names = layout.names()
    assert len(names) == len(set(names)) == model.size
    entries = layout.entries_of(StateKind.RADIATION)
    first = [entry for entry in entries if entry.component == "radiation 1"]
    groups = ("surge, pitch", "sway, roll", "heave")
    assert sorted(entry.owner for entry in first) == sorted(f"{g} of sphere" for g in groups)
    (pair,) = (entry for entry in first if entry.owner == "surge, pitch of sphere")
    assert [q.name for q in pair.coordinates] == ["surge of sphere", "pitch of sphere"]


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("sphere/irregular", {}),
        ("reverse_float_over/base", {"output.impulses": True}),
        ("reverse_float_over/tanks", {}),
        ("topside_removal/tanks", {}),
        ("mating/mating", {}),
    ],
)
def test_blocks_lie_where_the_model_has_them(name: str, changes: dict[str, object]) -> None:
    compiled = hs.compile_scene(hs.load_case(CASES / f"{name}.yaml", changes).scene())
    scene, model = compiled.scene, compiled.model
    layout = state_layout(scene, model, compiled.derived.met)
    at = {block.kind: block.offset for block in layout.blocks}
    p = model.elements
    assert at[StateKind.RATE] == model.bodies.active.size
    assert at[StateKind.RADIATION] == model.radiation
    assert at["contact node"] == model.own == p.fenders.state
    assert at["tank"] == model.tanks.state
    assert at["trigger"] == p.triggers.state
    assert at[StateKind.SLOW_PLACE] == model.slow
    assert at[StateKind.SLOW_DRAUGHT] == model.draught
    assert at[StateKind.ENERGY] == model.energy
    assert at.get(StateKind.IMPULSE, model.size) == model.impulse
    assert len(layout.names()) == model.size
    for index in (0, model.size - 1, model.energy):
        kind, entry = layout.entry_at(index)
        assert (str(kind), entry.name) == (layout.kinds()[index], layout.names()[index])


def renamed(scene: hs.Scene, name: str) -> hs.Scene:
    """The scene with another name of its only body."""
    (body,) = scene.bodies
    forces = {key: replace(force, body=name) for key, force in scene.forces.items()}  # type: ignore[type-var]
    return replace(scene, bodies=(replace(body, name=name),), forces=forces)


@pytest.mark.parametrize(
    "name", ["leg of jacket", "a and b", "heave, roll of one and surge of two"]
)
def test_a_restart_knows_bodies_whatever_their_name_is(name: str) -> None:
    changes = {"duration": 20.0, "solver.linear": "step", "output.states": True}
    scene = renamed(hs.load_case(IRREGULAR, changes).scene(), name)
    run = hs.simulate(scene)
    again = hs.simulate(replace(scene, initial=hs.Start(run, 10.0), duration=10.0))
    assert np.array_equal(again.position.values[-1], run.position.values[-1])


# Records of a run: all states, of few records; all but radiation states, of every one.

CASE = Path(__file__).parents[2] / "cases" / "reverse_float_over" / "base.yaml"
RECORDS_OF_RUN = 41  # 20 s, every 0.5 s


def run_with(spacing: int) -> Run:
    """A run of the base case that has radiation states in every ``spacing``-th record."""
    compiled = compile_scene(hs.load_case(CASE, ["duration=20 s"]).scene(), in_plane=True)
    clock = compile_clock(compiled)
    record = new_record(compiled.model, clock, spacing=spacing)
    run = new_run(clock, compiled.model, compiled.method, compiled.first_state(), record)
    while run.counters[GRID_POINT] < run.clock.points:
        advance(100_000, run)
    assert run.counters[RECORDS] == RECORDS_OF_RUN
    return run


def test_all_states_are_in_every_sixteenth_record_and_in_the_newest() -> None:
    rare = run_with(MEMORY_SPACING)
    every = run_with(1)
    which = with_states(rare.record, RECORDS_OF_RUN)
    assert which.tolist() == [0, 16, 32, 40]
    assert with_states(rare.record, 40).tolist() == [0, 16, 32]
    here = states_at(rare.model, rare.record, which)
    assert here.tobytes() == states_at(every.model, every.record, which).tobytes()
    assert here[-1].tobytes() == rare.state.y.tobytes()


def test_radiation_states_are_read_from_no_other_record() -> None:
    """Other states keep their places in y."""
    run = run_with(MEMORY_SPACING)
    model = run.model
    y = unpack_channels(model, run.record, RECORDS_OF_RUN)["y"]
    states = model.states.decay.size
    assert states > 0
    last = run.state.y
    assert np.array_equal(y[: model.radiation][-1], last[: model.radiation])
    assert np.array_equal(y[model.radiation + states :][-1], last[model.radiation + states :])
    for wrong in (slice(None), slice(model.radiation, None), slice(0, model.radiation + 1)):
        with pytest.raises(IndexError, match="not every record"):
            y[wrong]


def test_a_run_that_records_all_states_has_them_at_every_time() -> None:
    """At the end both are the same, to the bit."""
    with_all = hs.simulate(hs.load_case(CASE, ["duration=20 s", "output.states=true"]))
    at_end = hs.simulate(hs.load_case(CASE, ["duration=20 s"]))
    assert np.array_equal(with_all.state_time, with_all.time)
    assert at_end.state_time.values.tolist() == [20.0]
    last = with_all.state_value.sel(state_time=20.0)
    assert last.values.tobytes() == at_end.state_value.values.tobytes()


# Margins: which have ended, in which units they are compared, how a zero is closed in.

BEFORE = np.array([4.0, 1.0, -0.5, 2.0])
AFTER = np.array([-1.0, 3.0, -2.0, -8.0])


def test_a_mode_has_ended_where_a_margin_is_negative() -> None:
    assert any_negative(AFTER)
    assert not any_negative(np.array([0.0, 1.0]))
    assert not any_negative(np.zeros(0))


def test_margins_are_compared_in_units_of_their_larger_end() -> None:
    now = np.array([2.0, -5.0, 0.6, 1.0])
    assert [linear_value(i, now, BEFORE, AFTER) for i in range(4)] == [0.5, -5 / 3, 0.3, 0.125]


def test_phi_is_the_smallest_of_the_margins_that_end_negative() -> None:
    """The second margin is negative in between, but positive at the end: it is not watched."""
    assert guard_defect(np.array([2.0, -5.0, 0.6, 1.0]), BEFORE, AFTER) == 0.125
    assert guard_defect(AFTER, BEFORE, AFTER) == -1.0
    assert guard_defect(np.array([2.0, 3.0]), np.ones(2), np.ones(2)) == 1.0


@given(scale=st.floats(1e-6, 1e6), value=st.floats(-1.0, 1.0))
def test_phi_does_not_depend_on_the_units_of_a_margin(scale: float, value: float) -> None:
    ends = np.array([1.0, 0.5]), np.array([-0.5, -1.0])
    now = np.array([value, 0.3])
    units = np.array([scale, 1.0])
    scaled = guard_defect(now * units, *(e * units for e in ends))
    assert scaled == pytest.approx(guard_defect(now, *ends))


@given(
    lo=st.floats(-10.0, 10.0),
    width=st.floats(1e-3, 10.0),
    f_lo=st.floats(0.0, 1e6),
    f_hi=st.floats(-1e6, -1e-6),
)
def test_the_next_guess_is_inside_the_bracket(lo, width, f_lo, f_hi):
    x = next_trial(lo, f_lo, lo + width, f_hi)
    assert lo + 0.009 * width <= x <= lo + 0.991 * width


def test_the_next_guess_is_where_the_chord_crosses() -> None:
    assert next_trial(1.0, 3.0, 5.0, -1.0) == pytest.approx(4.0)


@pytest.mark.parametrize("power", [1, 3, 9])
def test_the_bracket_closes_on_the_zero(power: int) -> None:
    """Even where the function is as flat as (x - 0.3)^9; every guess takes at least 1 % off."""
    lo, hi = 0.0, 1.0
    for _ in range(2500):
        x = next_trial(lo, (0.3 - lo) ** power, hi, (0.3 - hi) ** power)
        lo, hi = (x, hi) if x <= 0.3 else (lo, x)
        if hi - lo < 1e-10:
            break
    assert lo <= 0.3 <= hi < lo + 1e-10
