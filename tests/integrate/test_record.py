"""Records of a run: all states, of few records; all but radiation states, of every one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import hydrosim as hs
from hydrosim.compile.clock import compile_clock
from hydrosim.compile.compile import compile_scene
from hydrosim.integrate.loop import advance
from hydrosim.integrate.record import (
    MEMORY_SPACING,
    new_record,
    states_at,
    unpack_channels,
    with_states,
)
from hydrosim.integrate.state import GRID_POINT, RECORDS, Run, new_run

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
