"""Results of stages and of why a body moved, against what the run's own variables say."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scenes import block, moving, on_floor, scene, steady, table

import hydrosim as hs
from hydrosim.elements import AppliedForce, Frictionless, Landing, NormalCurve, Seats, StickSlip
from hydrosim.errors import InputError
from hydrosim.results.phases import STAGES
from hydrosim.scene import Scene, Weight
from hydrosim.statistics.explain import EXPLAINED_PHASES, FRICTION_PARTS, explain_run
from hydrosim.statistics.figures import figure_of
from hydrosim.statistics.results import RESULT_KEYS, MotionCauseResult, RunResults, StageResult

MASS, WEIGHT = 1e3, 9810.0
SEAT = np.zeros((1, 3))


def lifted() -> Scene:
    """A weight on a leg, lifted off after 5 s, dropped on it again and lifted off for good."""
    top = block(MASS, ("heave",), weight=Weight.CARRIED, position=moving(heave=-0.00981))
    curve = NormalCurve(np.array([0.0, 1.0]), np.array([0.0, 1e6]))
    lift = [0.0, 1.05, 0.9, 0.9, 1.2]  # of the weight
    times = [0.0, 5.0, 5.5, 9.0, 12.0]
    push = table(times, [moving(heave=each * WEIGHT) for each in lift])
    forces = {
        "leg": Landing("block", SEAT, Seats(SEAT), curve, Frictionless(), group="legs"),
        "lift": AppliedForce("block", (0.0, 0.0, 0.0), push),
    }
    return scene(top, forces, 20.0, 0.1, step=0.01)


@pytest.fixture(scope="module")
def removal() -> xr.Dataset:
    return hs.simulate(lifted())


def test_results_of_stages_are_those_of_the_run(removal: xr.Dataset) -> None:
    """The force after the leg closed again is the largest that is recorded then, within what is
    between two records."""
    legs = removal.sel(contact_group="legs")
    open_ = float(legs.stage_time.sel(stage="open"))
    late = removal.fender_normal_force.where(removal.time > open_, 0.0)
    force = figure_of(removal, StageResult("a", "recontact_force", "legs"))
    assert force.attrs["units"] == "N"
    assert float(late.max()) <= float(force) < 1.2 * float(late.max())
    assert float(figure_of(removal, StageResult("a", "recontacts"))) == float(legs.recontacts) > 0
    for stage in ("open", "separated"):
        time = figure_of(removal, StageResult("a", "time", "legs", stage))
        assert float(time) == float(legs.stage_time.sel(stage=stage))
    lasts = figure_of(removal, StageResult("a", "duration", "legs", "open", "separated"))
    times = legs.stage_time
    assert float(lasts) == float(times.sel(stage="separated")) - float(times.sel(stage="open"))


def test_a_phase_lasts_as_long_as_it_is_recorded(removal: xr.Dataset) -> None:
    phase = removal.contact_phase.values[:, 0]
    found = figure_of(removal, StageResult("a", "duration", stage=EXPLAINED_PHASES[1]))
    assert float(found) == pytest.approx(np.mean(phase == 1) * 20.0)


def dragged() -> Scene:
    """A block that is pushed over a floor to and fro."""
    law = StickSlip(static=0.2, kinetic=0.1, stiffness=1e6, damping=1e4)
    push = table([0.0, 2.0, 4.0], [moving(surge=5e3), moving(surge=-4e3), moving(surge=5e3)])
    forces = {
        "floor": on_floor(1e6, law),
        "weight": steady(heave=-1e4),
        "push": AppliedForce("block", (0.0, 0.0, 0.0), push),
    }
    found = scene(block(MASS, ("surge", "heave")), forces, 4.0, 0.1, step=0.01)
    return found.with_output(impulses=True)


def test_why_a_body_moved_is_what_is_explained_of_it() -> None:
    """The balance: mean force of floor and push over the mass is the change of speed over time."""
    run = hs.simulate(dragged())
    found = RunResults(run)
    forces = [
        MotionCauseResult("a", "mean_force", force=name).evaluate(found)
        for name in ("floor", "push")
    ]
    speed = run.velocity.sel(body="block", dof="surge").values
    rate = MASS * (speed[-1] - speed[0]) / 4.0
    assert sum(float(force) for force in forces) == pytest.approx(rate, rel=1e-9)
    friction = float(MotionCauseResult("a", "friction").evaluate(found))
    assert friction == pytest.approx(float(forces[0]), rel=1e-9)
    parts = [
        float(MotionCauseResult("a", "friction", part=part).evaluate(found))
        for part in FRICTION_PARTS
    ]
    assert sum(parts) == pytest.approx(friction, rel=1e-12)
    shares = [
        float(MotionCauseResult("a", "time_share", mode=m).evaluate(found))
        for m in ("stick", "slip")
    ]
    assert sum(shares) == pytest.approx(1.0, abs=1e-9)
    moved = float(MotionCauseResult("a", "displacement").evaluate(found))
    assert moved == float(run.position[-1, 0, 0] - run.position[0, 0, 0])
    assert found.explanation is found.explanation


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (StageResult("a", "recontacts", "feet"), "group feet; expected one of these groups: floor"),
        (StageResult("a", "recontacts"), "no group of contacts in the run records its stages"),
        (MotionCauseResult("a", "displacement", body="tug"), "found the body tug; expected one of"),
        (MotionCauseResult("a", "mean_force", force="line"), "the force line; expected one of:"),
        (MotionCauseResult("a", "friction", stage="open to separated"), "the stage open to sep"),
    ],
)
def test_what_a_run_lacks_is_a_message(asked: StageResult | MotionCauseResult, words: str) -> None:
    run = hs.simulate(replace(dragged(), duration=1.0))
    with pytest.raises(InputError, match=words):
        figure_of(run, asked)


def test_impulses_are_needed_to_say_why() -> None:
    run = hs.simulate(replace(dragged(), duration=1.0).with_output(impulses=False))
    with pytest.raises(InputError, match="without impulse"):
        figure_of(run, MotionCauseResult("a", "displacement"))
    with pytest.raises(InputError, match="without impulse"):
        explain_run(run)


def test_every_result_has_its_keys() -> None:
    assert {"recontact_force", "time", "duration", "mean_force", "friction"} <= RESULT_KEYS.keys()
    assert StageResult("a", "time", stage=STAGES[-1]).is_late_if_missing
    assert StageResult("a", "end_clearance").at_least
