"""The cache of fits: it changes nothing but the time, and survives damage."""

from __future__ import annotations

import numpy as np
import pytest
from closed_forms import added_mass, kernel, transfer

from hydrosim.errors import InputError
from hydrosim.radiation import KernelReport, Retardation, fits, kept, retardation

TIME = np.linspace(0.0, 40.0, 801)
BAND = np.array([0.5, 3.0])


@pytest.fixture
def memory(tmp_path, monkeypatch) -> Retardation:
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(tmp_path))
    K = np.zeros((TIME.size, 6, 6))
    K[:, 2, 2] = kernel(TIME)[:, 0, 0]
    K[:, 3, 3] = 2.0 * K[:, 2, 2]
    report = KernelReport(0.0, 0.0, 0.0, 0.0, np.zeros((6, 6)))
    return Retardation(TIME, lambda: K, np.zeros((6, 6)), report)


def same(one, other) -> bool:
    return len(one) == len(other) == 2 and all(
        a.report == b.report
        and all(np.array_equal(getattr(a, name), getattr(b, name)) for name in fits.ARRAYS)
        for a, b in zip(one, other, strict=True)
    )


def refuse(*_):
    raise AssertionError("fitted again")


def test_cached_equals_fresh(memory, tmp_path, monkeypatch):
    fresh = fits.fit("a", "hull.nc", memory, BAND)
    assert [list(model.dofs) for model in fresh] == [[2], [3]]
    assert [file.suffix for file in (tmp_path / "fits").iterdir()] == [".npz"]
    monkeypatch.setattr(fits, "fit_group", refuse)
    assert same(fits.fit("a", "hull.nc", memory, BAND), fresh)


@pytest.mark.parametrize("change", ["checksum", "band", "tolerance", "sources"])
def test_another_fit_is_another_file(memory, monkeypatch, change):
    fits.fit("a", "hull.nc", memory, BAND)
    monkeypatch.setattr(fits, "fit_group", refuse)
    if change == "sources":
        monkeypatch.setattr(kept, "_version", lambda: "edited")
    with pytest.raises(AssertionError, match="fitted again"):
        fits.fit(
            "b" if change == "checksum" else "a",
            "hull.nc",
            memory,
            BAND + 1.0 if change == "band" else BAND,
            1e-2 if change == "tolerance" else 1e-3,
        )


@pytest.mark.parametrize("damage", [b"", b"not a zip file", None])
def test_damaged_file_is_made_again(memory, tmp_path, monkeypatch, damage):
    fresh = fits.fit("a", "hull.nc", memory, BAND)
    [file] = (tmp_path / "fits").iterdir()
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2] if damage is None else damage)
    assert same(fits.fit("a", "hull.nc", memory, BAND), fresh)
    monkeypatch.setattr(fits, "fit_group", refuse)
    assert same(fits.fit("a", "hull.nc", memory, BAND), fresh)


def test_folder_that_cannot_be_written_is_no_error(memory, tmp_path):
    (tmp_path / "fits").write_text("in the way")
    assert len(fits.fit("a", "hull.nc", memory, BAND)) == 2


@pytest.mark.parametrize("depth", [0.005, 0.2])
def test_negative_damping_is_mended_within_reason_or_refused(memory, depth):
    """Heave with a patch of negative damping, of 0.5 % or 20 % of its largest: the nearest passive
    model is as far away as the patch is deep."""
    w = np.linspace(0.01, 6.0, 600)
    B, A = np.zeros((2, w.size, 6, 6))
    B[:, 2, 2], A[:, 2, 2] = transfer(w)[:, 0, 0].real, added_mass(w)[:, 0, 0]
    patch = np.exp(-(((w - 3.5) / 0.3) ** 2))
    B[:, 2, 2] -= (depth * B.max() + np.interp(3.5, w, B[:, 2, 2])) * patch
    negative = retardation(w, A, B, length=60.0, step=0.05)
    assert negative.report.smallest_eigenvalue == pytest.approx(-depth, rel=0.05)
    if depth > 10 * 1e-3:
        with pytest.raises(InputError) as caught:
            fits.fit("a", "hull.nc", negative, w)
        for text in ("hull.nc", "in heave", "passive", "db check", "radiation: convolution"):
            assert text in str(caught.value)
        suggested = float(str(caught.value).split("tolerance: ")[1].split("}")[0])
        (model,) = fits.fit("a", "hull.nc", negative, w, suggested)
    else:
        (model,) = fits.fit("a", "hull.nc", negative, w)
        assert model.report.passivity_before < -depth
    damping = model.modes.transfer_function(1j * np.linspace(0.0, 600.0, 200001))[:, 0, 0].real
    assert damping.min() >= -1e-7 * damping.max()
    assert 0.9 * depth < model.report.frequency_error < 2.0 * depth
