"""Fits with fewer states: as exact as free bodies feel, passive, reciprocal, kept."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import hydrosim as hs
from hydrosim.compile.hydrodynamic_groups import floating_of
from hydrosim.water.radiation import FitReport, Floating, Retardation, StateSpace, fits
from hydrosim.water.radiation.fits import PART, Felt, reduce_stored
from hydrosim.water.radiation.passivity import Reciprocal
from hydrosim.water.radiation.rational import Emphasis
from hydrosim.water.radiation.retardation import SLOWEST, transfer_function
from hydrosim.water.radiation.state_space import TOLERANCE, Target

CASE = Path(__file__).parents[3] / "cases" / "reverse_float_over" / "base.yaml"


class Hull(NamedTuple):
    """The base case's barge: its band, memory, bodies as they float, and its fit in plane."""

    band: float
    memory: Retardation
    floating: Floating
    full: StateSpace


@pytest.fixture(scope="module")
def hull() -> Hull:
    (wet,) = hs.compile_scene(hs.load_case(CASE).scene()).wet
    db = wet.database
    in_plane, _ = fits.fit_state_space(db.checksum, wet.memory, db.frequency, wet.free_dofs)
    return Hull(float(db.frequency[-1]), wet.memory, floating_of(wet), in_plane)


@pytest.fixture(scope="module")
def model(hull: Hull) -> StateSpace:
    return reduce_stored(hull.full, hull.memory, hull.band, hull.floating)


def change_of_motion(model: StateSpace, memory: Retardation, floating: Floating) -> float:
    """The largest change of harmonic motions of the floating bodies,
    solved twice: with the memory and with the model, at frequencies other than those of the fit."""
    dofs = model.dofs
    block = dofs[:, None], dofs
    M = floating.inertia[block] + memory.added_mass_infinite[block]
    C = floating.stiffness[block]
    root = np.sqrt(np.diag(M))
    w = np.linspace(0.013, 2.4, 333)
    exact = transfer_function(memory.time, memory.kernel[:, *block], w)
    found = model.modes.transfer_function(1j * w)
    changes = []
    for x, K, fitted in zip(w, exact, found, strict=True):
        s = SLOWEST + 1j * x
        with_memory = s * M + C / s + K
        with_model = s * M + C / s + fitted
        ratio = np.linalg.solve(with_model, with_memory) - np.eye(dofs.size)
        changes.append(np.linalg.norm(root[:, None] * ratio / root, 2))
    return max(changes)


def test_fewer_states_change_motions_within_the_tolerance(hull: Hull, model: StateSpace) -> None:
    assert hull.full.report.holds
    assert model.order < 0.75 * hull.full.order
    # K^ itself is farther off: that is what free bodies do not feel
    assert model.report.frequency_error > TOLERANCE
    assert model.report.holds
    found = change_of_motion(model, hull.memory, hull.floating)
    assert found == pytest.approx(model.report.motion_error, rel=0.25)
    assert found < PART * TOLERANCE


def test_a_reduced_model_is_passive_stable_and_reciprocal(hull: Hull, model: StateSpace) -> None:
    assert np.all(model.decay < 0.0)
    w = np.append(np.linspace(0.0, 5.0, 8001), np.geomspace(5.0, 1000.0, 2000)) * hull.band
    K = model.modes.transfer_function(1j * w)
    root = np.sqrt(np.diag(hull.floating.among(model.dofs).inertia))
    K = K / np.outer(root, root)
    assert np.abs(K - np.swapaxes(K, 1, 2)).max() < 1e-9 * np.abs(K).max()
    damping = np.linalg.eigvalsh(K.real)
    assert damping.min() >= -1e-7 * damping.max()


@pytest.mark.parametrize("fault", ["error", "passivity", "states"])
def test_what_does_not_become_better_stays(
    hull: Hull, monkeypatch: pytest.MonkeyPatch, fault: str
) -> None:
    """A model that is too far off, gains energy, or has as many states is not taken."""

    def found(target: Target, tolerance: float) -> tuple[Reciprocal, FitReport]:
        states = hull.full.order if fault == "states" else 1
        simple = Reciprocal(-np.ones(states), np.empty(0), np.ones(states), np.ones((states, 3)))
        error = 1.01 * tolerance if fault == "error" else 0.0
        margin = -2e-7 if fault == "passivity" else 0.0
        return simple, FitReport(tolerance, error, 0.0, 0.0, margin)

    monkeypatch.setattr(fits, "fit_once", found)
    assert reduce_stored(hull.full, hull.memory, hull.band, hull.floating) is hull.full


def test_bodies_that_hardly_feel_their_memory_get_a_passive_model(hull: Hull) -> None:
    """A mass of 1e15 kg leaves a model that cannot be lifted everywhere: it is not taken."""
    heavy = hull.floating._replace(inertia=np.diag(np.full(len(hull.floating.inertia), 1e15)))
    model = reduce_stored(hull.full, hull.memory, hull.band, heavy)
    assert model.report.passive
    assert model.report.holds


def test_the_gramian_of_a_weight_is_its_integral() -> None:
    """Of the weight of a filter, where that is an equation."""
    filtered = Emphasis(0.7, 4.0)
    w = np.linspace(0.0, 300.0, 20001)
    A = np.array([[-0.4, 0.9, 0.0], [-0.9, -0.4, 0.0], [0.0, 0.0, -1.1]])
    B = np.array([[1.0, 0.2], [0.3, -0.5], [0.7, 0.1]])
    exact = filtered.gramian(A, B)
    found = Felt(w, filtered.at(w)).gramian(A, B)
    # what is beyond the last frequency: |B|^2 / (pi w)
    assert found == pytest.approx(exact, abs=2.0 / (np.pi * w[-1]))


def test_reduced_fits_are_kept_by_their_bodies(
    hull: Hull, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(tmp_path))
    frequency = np.array([0.1, hull.band])

    def reduce(floating: Floating, fit: StateSpace = hull.full) -> tuple[StateSpace, ...]:
        return fits.reduce_states([fit], "a", hull.memory, frequency, floating)

    def refuse(*_: object) -> StateSpace:
        raise AssertionError("reduced again")

    monkeypatch.setattr(fits, "reduce_stored", lambda full, *_: full)
    reduce(hull.floating)
    monkeypatch.setattr(fits, "reduce_stored", refuse)
    (again,) = reduce(hull.floating)
    assert again.report == hull.full.report
    assert np.array_equal(again.B, hull.full.B)
    heavier = hull.floating._replace(inertia=1.01 * hull.floating.inertia)
    stiffer = hull.floating._replace(stiffness=1.01 * hull.floating.stiffness)
    for other in (heavier, stiffer):
        with pytest.raises(AssertionError, match="reduced again"):
            reduce(other)
    # a fit that misses its tolerance is not reduced at all
    missed = replace(hull.full, report=replace(hull.full.report, tolerance=1e-9))
    assert reduce(heavier, missed) == (missed,)
