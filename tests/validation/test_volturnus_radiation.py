"""Radiation of the VolturnUS-S: our state space and the one supplied with it, against WAMIT."""

from collections.abc import Callable

import numpy as np
import pytest
from markers import few
from validation_data import unpacked

from hydrosim.database.load import read
from hydrosim.errors import InputError
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene.hydrodynamics import Given
from hydrosim.water.radiation import fits, retardation

DATA = unpacked("volturnus")
DOFS = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def supplied() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A, B, C of SS_Fitting's file: four lines of text, then the rows of the matrices."""
    lines = (DATA / "volturnus.ss").read_text().splitlines()
    n = int(lines[2].split()[0])
    rows = [np.array(line.split(), dtype=float) for line in lines[4:]]
    return np.array(rows[:n]), np.array(rows[n : 2 * n]), np.array(rows[2 * n : 2 * n + 6])


@pytest.fixture(scope="module")
def database():
    return read(DATA / "volturnus.1", Given(length=1.0, water_density=1025.0, gravity=9.80665))


@pytest.mark.parametrize("tolerance", few([6e-2, 1e-2], 1))
def test_ours_is_closer_to_the_coefficients_than_the_supplied_one(
    database,
    tolerance: float,
    tmp_path,
    monkeypatch,
    figure: Callable[[str, float], None],
    validated: Callable[..., None],
) -> None:
    """K^ = B + i w (A - A_inf) of WAMIT's .1, the root mean square error over its frequencies and
    over all 36 entries, each relative to the geometric mean of the diagonal entries' largest. Ours
    is passive and reciprocal, too. With the larger tolerance it is as small as the supplied one."""
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(tmp_path))
    w, B = database.frequency, database.radiation_damping
    memory = retardation(w, database.added_mass, B)
    models = fits.fit_state_space("volturnus", memory, w, np.arange(6), tolerance)
    ours = np.zeros((w.size, 6, 6), dtype=complex)
    for model in models:
        ours[:, model.dofs[:, None], model.dofs] = model.modes.transfer_function(1j * w)
    state, reach, seen = supplied()
    resolved = np.linalg.solve(1j * w[:, None, None] * np.eye(len(state)) - state, reach[None])
    theirs = -seen @ resolved  # the force is +C x there

    size = np.sqrt(np.abs(np.diagonal(B, axis1=1, axis2=2)).max(axis=0))
    infinite = {"ours": memory.added_mass_infinite, "theirs": database.added_mass_infinite}
    errors = {}
    for name, found in (("ours", ours), ("theirs", theirs)):
        added = database.added_mass - infinite[name]
        exact = B + 1j * w[:, None, None] * added
        scaled = np.abs(found - exact) / np.outer(size, size)
        errors[name] = np.sqrt((scaled**2).mean(axis=0))
        figure(f"{name}: rms error over all entries", np.sqrt((errors[name] ** 2).mean()))
        for i, dof in enumerate(DOFS):
            figure(f"{name}: rms error in {dof}", errors[name][i, i])
    figure("ours: states", sum(model.order for model in models))
    figure("theirs: states", len(state))
    eigenvalues = np.linalg.eigvalsh((theirs.real + theirs.real.transpose(0, 2, 1)) / 2)
    figure("theirs: passivity", eigenvalues.min() / eigenvalues.max())
    assert np.linalg.eigvals(state).real.max() < 0.0  # it is the right file, the right way round
    assert all(model.report.passivity_margin >= -1e-7 for model in models)
    ours, theirs = (np.sqrt((errors[name] ** 2).mean()) for name in ("ours", "theirs"))
    claim = "VolturnUS, radiation as states, rms over 36 entries"
    validated(
        Kind.PROGRAM,
        claim,
        "WAMIT's A(ω), B(ω)",
        ours,
        float(f"{theirs:.3g}"),
        Feature.RADIATION,
        others=f"SS_Fitting {100.0 * theirs:.2f} %",
    )
    assert np.linalg.norm(errors["ours"]) <= np.linalg.norm(errors["theirs"])
    assert (np.diag(errors["ours"]) <= 1.05 * np.diag(errors["theirs"])).all()
    assert tolerance < 5e-2 or sum(model.order for model in models) <= len(state)


@pytest.mark.slow
def test_the_default_tolerance_is_refused_for_data_with_negative_damping(
    database, tmp_path, monkeypatch
) -> None:
    """Damping of surge and pitch has an eigenvalue of -1 % of its largest, and that of heave: no
    passive model is nearer than half of it, and ten times the default tolerance is the limit."""
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(tmp_path))
    w = database.frequency
    memory = retardation(w, database.added_mass, database.radiation_damping)
    assert memory.report.smallest_eigenvalue < -5e-3
    models = fits.fit_state_space("volturnus", memory, w, np.arange(6))
    with pytest.raises(InputError, match=r"volturnus.1.* passive .*tolerance: 0\.0(0[5-9]|[1-9])"):
        fits.check_fits(models, database.source)
