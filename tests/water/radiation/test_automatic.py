"""What is taken for the memory: states where their fit holds the tolerance, else the integral; and
what that does to motions."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from closed_forms import kernel, transfer
from markers import few
from scenes import motion
from test_runs import HEAVE, decay, heaving

import hydrosim as hs
from hydrosim.analysis.seakeeping import LinearRequest, linear_analysis
from hydrosim.database import HydroDatabase
from hydrosim.scene import (
    AutomaticRadiation,
    ConvolutionRadiation,
    LinearScenes,
    Radiation,
    Scene,
    Start,
    StateSpaceRadiation,
)
from hydrosim.water.radiation.retardation import LONGER, tabulate_retardation, transfer_function

SURGE, LENGTH, STEP = 0, 40.0, 0.05
AUTOMATIC = AutomaticRadiation(3e-4, LENGTH, STEP)


def bad_in_surge() -> HydroDatabase:
    """Heave as in the closed form, and surge with damping that is negative, -0.3 of the largest, in
    a part of the band: no passive model is near."""
    db = heaving()
    A, B, w = db.added_mass.copy(), db.radiation_damping.copy(), db.frequency
    A[:, SURGE, SURGE], B[:, SURGE, SURGE] = A[:, HEAVE, HEAVE], B[:, HEAVE, HEAVE]
    B[:, SURGE, SURGE] -= 0.3 * B.max() * np.exp(-(((w - 2.5) / 0.3) ** 2))
    return replace(db, added_mass=A, radiation_damping=B)


def scene(radiation: Radiation, dofs: tuple[str, ...] = ("surge", "heave")) -> Scene:
    """Free decay in heave of the buoy with damping that is bad in surge."""
    whole = decay(radiation, 0.1)
    body = replace(whole.bodies[0], hydrodynamics=bad_in_surge(), dofs=dofs)
    return replace(whole, bodies=(body,), duration=8.0)


def test_the_table_does_to_smooth_motions_what_the_kernel_does(figure) -> None:
    """Against a table of 0.05 s: to order 3 where K has a kink at t = 0, as here."""
    w = 0.05 * np.arange(1, 401)
    at = np.array([0.0, 0.3, 0.8, 1.5])

    def found(step: float) -> np.ndarray:
        time = step * np.arange(round(40.0 / step) + 1)
        return transfer_function(time, tabulate_retardation(w, transfer(w).real, time), at)

    exact = found(0.05)
    assert exact == pytest.approx(transfer(at), abs=1e-2)  # the spacing of the frequencies
    errors = [float(np.abs(found(step) - exact).max()) for step in (0.4, 0.2, 0.1)]
    figure("error at 0.1 s", errors[-1])
    assert errors[0] / errors[1] > 8.0
    assert errors[1] / errors[2] > 8.0
    time = 0.1 * np.arange(601)
    plain = transfer_function(time, kernel(time), at)
    assert np.abs(plain - transfer(at)).max() > 10.0 * errors[-1]


@pytest.mark.slow
def test_states_where_they_hold_and_the_integral_elsewhere_with_the_reason() -> None:
    run = hs.simulate(scene(AUTOMATIC))
    said = run.attrs["radiation_buoy"]
    assert said.startswith("automatic: ")
    assert "states for heave of buoy" in said
    assert "for surge of buoy: no passive state-space model within 0.0003 was found" in said
    assert list(run.memory_dof.values) == ["surge of buoy"]
    model = hs.compile_scene(scene(AUTOMATIC)).model
    assert set(model.states.dof) == {HEAVE}
    assert set(model.convolution.column) == {SURGE}


def test_what_has_no_fit_is_linear_all_the_same_and_the_error_is_told() -> None:
    """Heave is as in a scene of states; surge is that of the nearest passive model."""
    rough, fitted = (
        linear_analysis(scene(of, dofs), LinearRequest())
        for of, dofs in (
            (AUTOMATIC, ("surge", "heave")),
            (StateSpaceRadiation(3e-4, LENGTH, STEP), ("heave",)),
        )
    )
    assert "the radiation of surge of buoy uses the nearest" in rough.attrs["remarks"]
    assert not fitted.attrs["remarks"]
    found, exact = (of.natural_period.sel(mode="buoy heave").item() for of in (rough, fitted))
    assert found == pytest.approx(exact, rel=1e-9)


def test_both_together_are_the_integral_of_both() -> None:
    other = hs.simulate(scene(ConvolutionRadiation(LENGTH, STEP)))
    assert motion(hs.simulate(scene(AUTOMATIC))) == pytest.approx(motion(other), abs=1e-4)


def test_what_is_locked_blocks_no_fit() -> None:
    states = StateSpaceRadiation(3e-4, LENGTH, STEP)
    free = hs.compile_scene(scene(states))
    assert [of.dofs.tolist() for wet in free.wet for of in wet.convolved] == [[SURGE]]
    (told,) = [text for text in free.notes.warnings if "found state_space" in text]
    assert "radiation of surge of buoy" in told
    assert "the memory is computed by convolution" in told
    compiled = hs.compile_scene(scene(states, ("heave",)))
    assert not [text for text in compiled.notes.warnings if "state_space" in text]
    automatic = hs.compile_scene(scene(AUTOMATIC))
    assert not [text for text in automatic.notes.warnings if "state_space" in text]
    assert [list(fit.dofs) for wet in compiled.wet for fit in wet.fits] == [[HEAVE]]


@pytest.mark.slow
def test_a_run_that_goes_on_has_the_model_of_the_run_before() -> None:
    """Whatever the tolerance is now: at one of 1, surge would have states by itself."""

    def convolved(compiled: Any) -> list[list[int]]:
        return [of.dofs.tolist() for wet in compiled.wet for of in wet.convolved]

    first = hs.simulate(scene(AUTOMATIC))
    again = hs.compile_scene(replace(scene(AUTOMATIC), initial=Start(first)))
    assert convolved(again) == [[SURGE]]
    assert "as in the run that this one starts from" in hs.simulate(again).attrs["radiation_buoy"]
    loose = scene(replace(AUTOMATIC, tolerance=1.0))
    assert convolved(hs.compile_scene(loose)) == []
    assert convolved(hs.compile_scene(replace(loose, initial=Start(first)))) == [[SURGE]]


@pytest.mark.slow
def test_the_estimate_of_the_change_of_motion_bounds_what_is_found(figure) -> None:
    """Decay in heave by rough fits against the integral: no harmonic part of it changes by more
    than is said, relative to the motion."""
    reference = motion(hs.simulate(decay(ConvolutionRadiation(LENGTH, STEP), 0.1)))[:, HEAVE]
    for tolerance in (1e-1, 1e-2):
        one = decay(StateSpaceRadiation(tolerance, LENGTH, STEP), 0.1, linear=LinearScenes.STEP)
        compiled = hs.compile_scene(one)
        (errors,) = compiled.memory_errors
        assert errors.fit is not None
        said, found = errors.fit[0].size, motion(hs.simulate(compiled))[:, HEAVE]
        off = np.abs(found - reference).max() / np.ptp(reference)
        figure(f"found over said at {tolerance:g}", off / said)
        assert off <= said
        assert off >= said / 50.0


@pytest.mark.parametrize("duration", few([4.0, 1.0, 40.0], 1))
def test_the_estimate_of_what_a_cut_changes_bounds_what_is_found(duration: float, figure) -> None:
    """Decay in heave with memories that are cut early, against those `LONGER` times as long. What a
    run does not remember cannot change it: the shorter it is, the less."""
    for length in (1.0, 2.0):
        one, other = (
            replace(decay(ConvolutionRadiation(cut, STEP), 0.1), duration=duration)
            for cut in (length, LONGER * length)
        )
        compiled = hs.compile_scene(one)
        (errors,) = compiled.memory_errors
        found, longer = (motion(hs.simulate(x))[:, HEAVE] for x in (compiled, other))
        off, said = np.abs(found - longer).max() / np.ptp(longer), errors.cut[0].size
        figure(f"found over said at {length:g} s in {duration:g} s", off / said)
        assert said / 50.0 <= off <= said
