"""Two box barges side by side, solved together: energy and reciprocity over both, and responses in
regular waves against the frequency domain of the pair."""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose

import hydrosim as hs
from hydrosim.compile.hydrodynamic_groups import HydrodynamicGroup
from hydrosim.database import HydroDatabase, load, require_array
from hydrosim.files.document_nodes import List
from hydrosim.report.evidence import Feature, Kind
from hydrosim.report.sentences.check import check_document
from hydrosim.scene import RegularWave, Scene, Start, WaveTrain
from hydrosim.water.radiation import Retardation, retardation
from hydrosim.water.radiation.retardation import (
    diagonal_scale,
    infinite_added_mass,
    retardation_function,
    transfer_function,
)

Validated = Callable[..., None]
Figure = Callable[[str, float], None]
BARGES = Path(__file__).parents[2] / "hydro_db" / "two_barges.nc"
RESONANT = (1.3, 1.46)  # in the gap
FREQUENCIES = (0.7, 1.0, *RESONANT, 2.0)  # of the database
HEADINGS = (30.0, 90.0)  # deg, of the database
MASS, RADII = 1025.0 * 1200.0, {"port": (3.5, 10.4, 10.4), "starboard": (4.0, 11.0, 11.0)}
STIFFNESS = np.array([1.5e5, 1.5e5, 0.0, 0.0, 0.0, 1.5e7])
DAMPING = np.array([2.7e5, 2.7e5, 0.0, 0.0, 0.0, 2.5e7])
ROLL = 5e6  # N m s/rad, besides radiation: without, roll rings on
LINES = (
    "stiffness: {surge: 1.5e5, sway: 1.5e5, yaw: 1.5e7},"
    " damping: {surge: 2.7e5, sway: 2.7e5, yaw: 2.5e7}"
)
RADIATION = "{model: state_space, length: 160 s, tolerance: 0.01}"
CASE = f"""
title: two barges
duration: 500 s
environment: {{water_depth: infinite}}
bodies:
  starboard:
    hydrodynamics: {BARGES}
    database_body: 2
    mass: {MASS}
    centre_of_gravity: [0, -7 m, 0]
    radii_of_gyration: {list(RADII["starboard"])}
    radiation: {RADIATION}
  port:
    hydrodynamics: {BARGES}
    database_body: 1
    mass: {MASS}
    centre_of_gravity: [0, 7 m, 0]
    radii_of_gyration: {list(RADII["port"])}
    radiation: {RADIATION}
forces:
  starboard_lines: {{type: linear_mooring, body: starboard, {LINES}}}
  port_lines: {{type: linear_mooring, body: port, {LINES}}}
  starboard_bilges: {{type: linear_damping, body: starboard, damping: {{roll: {ROLL}}}}}
  port_bilges: {{type: linear_damping, body: port, damping: {{roll: {ROLL}}}}}
solver: {{method: rk4, step: 0.05 s, kinematics: linear}}
"""


@lru_cache
def barges() -> HydroDatabase:
    """The database; what it is warned of is in hydro_db/README.md."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return load(BARGES)


@pytest.fixture(scope="module")
def moored(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    """Both barges from a case file, starboard first, with the database read once."""
    path = tmp_path_factory.mktemp("case") / "case.yaml"
    path.write_text(CASE)
    scene = hs.load_case(path).scene()
    assert [body.database_body for body in scene.bodies] == [2, 1]
    bodies = tuple(replace(body, hydrodynamics=barges()) for body in scene.bodies)
    return replace(scene, bodies=bodies)


@pytest.fixture(scope="module")
def wet(moored: Scene) -> HydrodynamicGroup:
    return hs.compile_scene(moored).wet[0]


def far_field(db: HydroDatabase) -> np.ndarray:
    """B (nw, 12, 12) by Haskind's relation: w^3 / (4 pi rho g^3) Re int X_i X_j* db."""
    X, w = db.excitation, db.frequency
    turn = 2 * np.pi / db.heading.size
    products = np.einsum("whi,whj->wij", X, X.conj()).real * turn
    return (w**3 / (4 * np.pi * db.water_density * db.gravity**3))[:, None, None] * products


def test_energy_and_reciprocity_over_both(validated: Validated) -> None:
    """The recipe makes A and B symmetric and B that of the loads; the added mass is the solver's,
    and its limit at infinite frequency is solved by itself."""
    db = barges()
    B = db.radiation_damping
    size = diagonal_scale(B)
    scale = size[:, None] * size
    error = float((np.abs(far_field(db) - B) / scale).max())
    haskind = "Haskind's relation, from the loads"
    claim = "two barges, damping of all 12 x 12"
    validated(Kind.CLOSED_FORM, claim, haskind, error, 1e-6, Feature.COUPLED)
    assert np.linalg.eigvalsh(B / scale).min() > -1e-12
    time = np.arange(0.0, 160.0, 0.1)
    kernel = retardation_function(db.frequency, B, time)
    infinite, _ = infinite_added_mass(db.frequency, db.added_mass, time, kernel)
    added = require_array(db, "added_mass_infinite")
    size = diagonal_scale(db.added_mass)
    gap = float((np.abs(infinite - added) / (size[:, None] * size)).max())
    ogilvie = "Ogilvie's relation, from A(ω) and B(ω)"
    claim = "two barges, added mass at infinite frequency"
    validated(Kind.CLOSED_FORM, claim, ogilvie, gap, 0.1, Feature.COUPLED)


def test_barges_are_mirror_images() -> None:
    """What one does to the other in waves to b, the other does in waves to -b."""
    db, sign = barges(), np.tile([1, -1, 1, -1, 1, -1], 2)
    swap = np.r_[6:12, 0:6]
    image = db.excitation[:, -np.arange(db.heading.size)][..., swap] * sign
    assert image == pytest.approx(db.excitation, abs=1e-6 * np.abs(db.excitation).max())
    for matrix in (db.added_mass, db.radiation_damping):
        image = matrix[:, swap][:, :, swap] * np.outer(sign, sign)
        assert image == pytest.approx(matrix, abs=1e-6 * np.abs(matrix).max())


def test_the_fit_of_both_is_passive_and_the_kernel_has_decayed(
    wet: HydrodynamicGroup, figure: Figure
) -> None:
    assert wet.names == ["port", "starboard"]
    figure("K(T)/max K at 160 s", wet.memory.report.end_ratio)
    figure("states", sum(fit.order for fit in wet.fits))
    figure("error of the fits in frequency", max(fit.report.frequency_error for fit in wet.fits))
    assert wet.memory.report.end_ratio < 5e-3
    K = radiation_of(wet, np.linspace(0.02, 8.0, 400)).real
    scaled = K / np.sqrt(np.multiply.outer(*[np.diagonal(wet.memory.kernel[0])] * 2))
    margin = np.linalg.eigvalsh(scaled).min() / np.linalg.eigvalsh(scaled).max()
    figure("smallest over largest eigenvalue of Re K^", float(margin))
    assert margin > -1e-9
    assert max(fit.report.frequency_error for fit in wet.fits) < 0.02


def radiation_of(wet: HydrodynamicGroup, frequency: np.ndarray) -> np.ndarray:
    """K^(i w) (nw, 12, 12) of the fits, in the database's order."""
    K = np.zeros((frequency.size, 12, 12), dtype=complex)
    for fit in wet.fits:
        K[:, fit.dofs[:, None], fit.dofs] = fit.modes.transfer_function(1j * frequency)
    return K


@lru_cache
def refined() -> Retardation:
    """The memory of the database from a table eight times as fine."""
    db = barges()
    matrices = db.frequency, db.added_mass, db.radiation_damping
    return retardation(*matrices, length=160.0, step=0.0125)


def harmonic(
    wet: HydrodynamicGroup,
    omega: float,
    heading: float,
    radiation: Literal["database", "memory", "fits"],
) -> np.ndarray:
    """Complex amplitudes (12,) per wave amplitude in the database's order, from a solution of the
    12 x 12 system: with A(w) and B(w) of the database, its memory integral, or the run's fits."""
    db = barges()
    i = int(np.argmin(np.abs(db.frequency - omega)))
    j = int(np.argmin(np.abs(db.heading - heading)))
    radii = np.concatenate([[1, 1, 1, *RADII[name]] for name in ("port", "starboard")])
    mass = np.diag(MASS * radii**2)
    C = require_array(db, "hydrostatic_stiffness") + np.diag(np.tile(STIFFNESS, 2))
    drag = np.tile(DAMPING + ROLL * (np.arange(6) == 3), 2)
    if radiation == "database":
        waves = -(omega**2) * db.added_mass[i] + 1j * omega * db.radiation_damping[i]
    else:
        at = np.array([omega])
        memory = refined() if radiation == "memory" else wet.memory
        K = (
            radiation_of(wet, at)
            if radiation == "fits"
            else transfer_function(memory.time, memory.kernel, at)
        )
        waves = -(omega**2) * memory.added_mass_infinite + 1j * omega * K[0]
    Z = C - omega**2 * mass + 1j * omega * np.diag(drag) + waves
    return np.linalg.solve(Z, db.excitation[i, j])


def amplitudes(run: xr.Dataset, omega: float, start: float) -> np.ndarray:
    """Complex amplitudes (12,) of the motions in the database's order, by least squares."""
    late = run.sel(time=slice(start, None), body=["port", "starboard"])
    t = late.time.values
    basis = np.stack([np.cos(omega * t), -np.sin(omega * t), np.ones_like(t)], axis=1)
    found = np.linalg.lstsq(basis, late.position.values.reshape(t.size, 12), rcond=None)[0]
    return found[0] + 1j * found[1]


def errors(found: np.ndarray, expected: np.ndarray, alike: int) -> np.ndarray:
    """Difference of each DOF over the largest of those ``alike``, where the waves move it: of both
    barges in the same DOF (1), or in all translations or rotations (3)."""
    size = np.abs(expected).reshape(2, 6 // alike, alike).max(axis=(0, 2))
    moved = np.tile(np.repeat(size > 1e-4 * size.max(), alike), 2)
    return (np.abs(found - expected) / np.tile(np.repeat(size, alike), 2))[moved]


@pytest.mark.parametrize("heading", HEADINGS)
@pytest.mark.parametrize("omega", FREQUENCIES)
def test_response_is_that_of_the_frequency_domain(
    moored: Scene, wet: HydrodynamicGroup, validated: Validated, omega: float, heading: float
) -> None:
    """Of the time domain's own radiation within 0.2 % of each DOF. The database's own memory is off
    by what is beyond the end of its frequencies (Ogilvie's relation leaves 6 % of the added mass),
    and the run by what the fit (1e-2 of the largest K^) adds, in resonance of the gap more."""
    wave = WaveTrain(RegularWave(1.0, 2 * np.pi / omega), np.radians(heading), ramp=100.0)
    run = hs.simulate(replace(moored, environment=replace(moored.environment, waves=(wave,))))
    found = amplitudes(run, omega, 350.0)
    fits, memory, database = (
        harmonic(wet, omega, np.radians(heading), radiation)
        for radiation in ("fits", "memory", "database")
    )
    same = errors(found, fits, 1).max()
    true, beyond = (errors(motions, database, 3).max() for motions in (found, memory))
    claim = "two barges in regular waves, 12 x 12"
    features = (Feature.COUPLED, Feature.WAVES, Feature.RADIATION)
    domain = "frequency domain, same radiation"
    validated(Kind.INDEPENDENT, claim, domain, float(same), 0.002, *features)
    where, limit = ("in", 0.1) if omega in RESONANT else ("beside", 0.065)
    claim = f"{claim}, {where} resonances of the gap"
    domain = "frequency domain of the database"
    validated(Kind.INDEPENDENT, claim, domain, float(true), limit, *features)
    assert beyond < (0.1 if omega in RESONANT else 0.055)
    assert true < (0.1 if omega in RESONANT else beyond + 0.01)


def test_a_run_of_both_goes_on_where_another_ended(moored: Scene) -> None:
    wave = WaveTrain(RegularWave(1.0, 6.0), 0.5, ramp=5.0)
    scene = replace(moored, environment=replace(moored.environment, waves=(wave,)), duration=20.0)
    whole = hs.simulate(scene)
    first = hs.simulate(replace(scene, duration=8.0))
    rest = hs.simulate(replace(scene, duration=12.0, initial=Start(first)))
    # both are propagated; the polynomials of the loads beside the restart are not the same
    assert_allclose(rest.position[-1], whole.position[-1], rtol=1e-9, atol=1e-9)
    names = [str(name) for name in whole.state.values]
    assert any("of starboard and" in name for name in names if name.startswith("radiation"))
    assert len(set(names)) == len(names)


def test_check_knows_both(moored: Scene) -> None:
    titles = [node.title for node in check_document(moored).nodes if isinstance(node, List)]
    assert "port, starboard" in titles


def test_a_held_neighbour_reflects_the_waves(moored: Scene) -> None:
    """Only the free barge's equation is left, with loads and radiation of the pair."""
    omega, heading = 1.0, np.radians(90.0)
    wave = WaveTrain(RegularWave(1.0, 2 * np.pi / omega), heading, ramp=100.0)
    bodies = tuple(
        replace(body, dofs=()) if body.name == "port" else body for body in moored.bodies
    )
    forces: Mapping = {name: e for name, e in moored.forces.items() if e.body != "port"}
    environment = replace(moored.environment, waves=(wave,))
    compiled = hs.compile_scene(
        replace(moored, bodies=bodies, forces=forces, environment=environment)
    )
    wet = compiled.wet[0]  # only what can move is fitted: not as in the fits of both
    found, db = amplitudes(hs.simulate(compiled), omega, 350.0), barges()
    i, j = int(np.argmin(np.abs(db.frequency - omega))), 9
    K = radiation_of(wet, np.array([omega]))[0]
    Z = require_array(db, "hydrostatic_stiffness") + 1j * omega * K
    Z = Z - omega**2 * wet.memory.added_mass_infinite
    own = slice(6, 12)
    mass = np.diag(MASS * np.array([1, 1, 1, *RADII["starboard"]]) ** 2)
    drag = np.diag(DAMPING + ROLL * (np.arange(6) == 3))
    alone = Z[own, own] + np.diag(STIFFNESS) - omega**2 * mass + 1j * omega * drag
    expected = np.linalg.solve(alone, db.excitation[i, j, own])
    size = np.abs(expected).max()
    assert not found[:6].any()
    assert np.abs(found[6:] - expected).max() < 0.002 * size
