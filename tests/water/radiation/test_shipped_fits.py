"""Fits that come with the package, and those that tests bring: used, and what is made anew."""

from pathlib import Path
from zipfile import ZipFile

import kept_fits
import numpy as np
import pytest
from scenes import scene_of

import hydrosim as hs
from hydrosim.files.cache import SHIPPED_FITS
from hydrosim.integrate.dynamics import Model
from hydrosim.water.radiation import StateSpace, fits
from hydrosim.water.radiation.kept import read_shipped
from hydrosim.water.radiation.ship import pack

SAME = 1e-6  # of the largest entry: fits of one database agree to this rounding


@pytest.fixture
def fits_made(monkeypatch: pytest.MonkeyPatch) -> list[np.ndarray]:
    """The degrees of freedom of each fit that is made, where the cache has none; it keeps none, or
    other tests would have fits that are rounded otherwise than those of the package."""
    monkeypatch.setattr("hydrosim.water.radiation.kept.stored", lambda name: None)
    monkeypatch.setattr("hydrosim.water.radiation.kept.store", lambda name, content: None)
    made = []
    fit_group = fits.fit_group

    def noting(memory: object, dofs: np.ndarray, *others: object) -> StateSpace:
        made.append(dofs)
        return fit_group(memory, dofs, *others)  # type: ignore[arg-type]

    monkeypatch.setattr(fits, "fit_group", noting)
    return made


def radiation_of_base() -> Model:
    return hs.compile_scene(scene_of("free_floating")).model


def test_no_fit_of_a_shipped_case_is_made(fits_made: list[np.ndarray]) -> None:
    """After a change of the radiation's sources:
    `python -m hydrosim.water.radiation.ship cases/*/*.yaml`."""
    radiation_of_base()
    assert not fits_made


@pytest.mark.slow
def test_fits_made_anew_are_those_that_were_shipped(
    fits_made: list[np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another processor rounds in another way, so a model at the edge of its tolerance may take two
    more states. Both are then as near to each other as their reports say."""
    brought = fits_of_base()
    monkeypatch.setattr("hydrosim.water.radiation.kept.read_shipped", lambda name: None)
    anew = fits_of_base()
    assert fits_made
    for one, other in zip(brought, anew, strict=True):
        assert np.array_equal(one.dofs, other.dofs)
        assert abs(one.order - other.order) <= 2
        apart = difference_in_frequency(one, other)
        if one.order == other.order:
            assert apart <= SAME
        else:
            assert apart <= one.report.frequency_error + other.report.frequency_error


def fits_of_base() -> tuple[StateSpace, ...]:
    (group,) = hs.compile_scene(scene_of("free_floating")).wet
    return group.fits


def difference_in_frequency(one: StateSpace, other: StateSpace) -> float:
    """The largest difference of K^(i w), over the largest diagonal entries as in `FitReport`."""
    s = 1j * np.linspace(0.0, 2.0, 201)
    K = [fit.modes.transfer_function(s) for fit in (one, other)]
    scale = np.sqrt(np.abs(K[0][:, range(one.dofs.size), range(one.dofs.size)]).max(axis=0))
    return float((np.abs(K[1] - K[0]) / np.outer(scale, scale)).max())


def test_a_damaged_archive_is_not_believed(tmp_path: Path) -> None:
    archive = tmp_path / "fits.zip"
    (tmp_path / "fits").mkdir()
    (tmp_path / "fits" / "one.npz").write_bytes(bytes(32) + b"content" * 9)
    assert pack(tmp_path, archive) == ["fits/one.npz"]
    assert read_shipped("fits/one.npz", archive) == b"content" * 9
    assert read_shipped("fits/two.npz", archive) is None
    content = bytearray(archive.read_bytes())
    content[45] ^= 0x10
    archive.write_bytes(content)
    assert read_shipped("fits/one.npz", archive) is None
    assert read_shipped("fits/one.npz", tmp_path / "none.zip") is None


def test_tests_bring_only_what_the_package_lacks() -> None:
    with ZipFile(SHIPPED_FITS) as ours, ZipFile(kept_fits.ARCHIVE) as others:
        assert not {*ours.namelist()} & {*others.namelist()}
