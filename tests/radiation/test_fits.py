"""The cache of fits: it changes nothing but the time, and survives damage."""

from __future__ import annotations

import numpy as np
import pytest
from closed_forms import kernel

from hydrosim.radiation import KernelReport, Retardation, fits

TIME = np.linspace(0.0, 40.0, 801)
BAND = np.array([0.5, 3.0])


@pytest.fixture
def memory(tmp_path, monkeypatch) -> Retardation:
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(tmp_path))
    K = np.zeros((TIME.size, 6, 6))
    K[:, 2, 2] = kernel(TIME)[:, 0, 0]
    K[:, 3, 3] = 2.0 * K[:, 2, 2]
    report = KernelReport(0.0, 0.0, 0.0, 0.0, np.zeros((6, 6)))
    return Retardation(TIME, K, np.zeros((6, 6)), report)


def same(one, other) -> bool:
    return len(one) == len(other) == 2 and all(
        a.report == b.report
        and all(np.array_equal(getattr(a, name), getattr(b, name)) for name in fits.ARRAYS)
        for a, b in zip(one, other, strict=True)
    )


def refuse(*_):
    raise AssertionError("fitted again")


def test_cached_equals_fresh(memory, tmp_path, monkeypatch):
    fresh = fits.fit("a", memory, BAND)
    assert [list(model.dofs) for model in fresh] == [[2], [3]]
    assert [file.suffix for file in (tmp_path / "fits").iterdir()] == [".npz"]
    monkeypatch.setattr(fits, "fit_group", refuse)
    assert same(fits.fit("a", memory, BAND), fresh)


@pytest.mark.parametrize("change", ["checksum", "band", "tolerance", "sources"])
def test_another_fit_is_another_file(memory, monkeypatch, change):
    fits.fit("a", memory, BAND)
    monkeypatch.setattr(fits, "fit_group", refuse)
    if change == "sources":
        monkeypatch.setattr(fits, "_version", lambda: "edited")
    with pytest.raises(AssertionError, match="fitted again"):
        fits.fit(
            "b" if change == "checksum" else "a",
            memory,
            BAND + 1.0 if change == "band" else BAND,
            1e-2 if change == "tolerance" else 1e-3,
        )


@pytest.mark.parametrize("damage", [b"", b"not a zip file", None])
def test_damaged_file_is_made_again(memory, tmp_path, monkeypatch, damage):
    fresh = fits.fit("a", memory, BAND)
    [file] = (tmp_path / "fits").iterdir()
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2] if damage is None else damage)
    assert same(fits.fit("a", memory, BAND), fresh)
    monkeypatch.setattr(fits, "fit_group", refuse)
    assert same(fits.fit("a", memory, BAND), fresh)


def test_folder_that_cannot_be_written_is_no_error(memory, tmp_path):
    (tmp_path / "fits").write_text("in the way")
    assert len(fits.fit("a", memory, BAND)) == 2
