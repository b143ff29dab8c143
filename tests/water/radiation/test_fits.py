"""The cache of fits: it changes nothing but the time, and survives damage."""

from dataclasses import replace

import numpy as np
import pytest
from closed_forms import added_mass, kernel, transfer
from markers import few

from hydrosim.errors import InputError
from hydrosim.water.radiation import TOLERANCE, KernelReport, Retardation, fits, kept, retardation

TIME = np.linspace(0.0, 40.0, 801)
BAND = np.array([0.5, 3.0])
FREE = np.arange(6)


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
    fresh = fits.fit_state_space("a", memory, BAND, FREE)
    assert [list(model.dofs) for model in fresh] == [[2], [3]]
    assert [file.suffix for file in (tmp_path / "fits").iterdir()] == [".npz", ".npz"]
    monkeypatch.setattr(fits, "fit_group", refuse)
    assert same(fits.fit_state_space("a", memory, BAND, FREE), fresh)


@pytest.mark.parametrize("change", ["checksum", "band", "tolerance", "sources", "table"])
def test_another_fit_is_another_file(memory, monkeypatch, change):
    fits.fit_state_space("a", memory, BAND, FREE)
    monkeypatch.setattr(fits, "fit_group", refuse)
    if change == "sources":
        monkeypatch.setattr(kept, "_version", lambda: "edited")
    with pytest.raises(AssertionError, match="fitted again"):
        fits.fit_state_space(
            "b" if change == "checksum" else "a",
            replace(memory, time=2.0 * TIME) if change == "table" else memory,
            BAND + 1.0 if change == "band" else BAND,
            FREE,
            1e-2 if change == "tolerance" else TOLERANCE,
        )


def test_only_what_can_move_is_fitted_and_kept_for_others(memory, monkeypatch):
    """Roll that is locked is not fitted; what is coupled with it alone is not either."""
    memory.kernel[:, 3, 4] = memory.kernel[:, 4, 3] = 0.5 * memory.kernel[:, 3, 3]
    memory.kernel[:, 4, 4] = memory.kernel[:, 3, 3]
    groups = [list(model.dofs) for model in fits.fit_state_space("a", memory, BAND, FREE)]
    assert groups == [[2], [3, 4]]
    assert [list(group) for group in fits.groups_free_to_reduce(memory, np.array([2, 4]))] == [
        [2],
        [4],
    ]
    monkeypatch.setattr(fits, "fit_group", refuse)
    assert [
        list(model.dofs) for model in fits.fit_state_space("a", memory, BAND, np.array([2]))
    ] == [[2]]
    with pytest.raises(AssertionError, match="fitted again"):
        fits.fit_state_space("a", memory, BAND, np.array([2, 4]))


@pytest.mark.parametrize("damage", [b"", b"not a zip file", None])
def test_damaged_file_is_made_again(memory, tmp_path, monkeypatch, damage):
    fresh = fits.fit_state_space("a", memory, BAND, FREE)
    file = next((tmp_path / "fits").iterdir())
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2] if damage is None else damage)
    assert same(fits.fit_state_space("a", memory, BAND, FREE), fresh)
    monkeypatch.setattr(fits, "fit_group", refuse)
    assert same(fits.fit_state_space("a", memory, BAND, FREE), fresh)


def test_folder_that_cannot_be_written_is_no_error(memory, tmp_path):
    (tmp_path / "fits").write_text("in the way")
    assert len(fits.fit_state_space("a", memory, BAND, FREE)) == 2


def negative(depth: float) -> tuple[np.ndarray, Retardation]:
    """Heave and roll with a patch of negative damping, of a part of the largest."""
    w = np.linspace(0.01, 6.0, 600)
    B, A = np.zeros((2, w.size, 6, 6))
    patch = np.exp(-(((w - 3.5) / 0.3) ** 2))
    for dof in (2, 3):
        B[:, dof, dof], A[:, dof, dof] = transfer(w)[:, 0, 0].real, added_mass(w)[:, 0, 0]
        B[:, dof, dof] -= (depth * B[:, dof, dof].max() + np.interp(3.5, w, B[:, dof, dof])) * patch
    return w, retardation(w, A, B, length=60.0, step=0.05)


@pytest.mark.parametrize("depth", few([2e-3, 0.2], 1))
def test_negative_damping_is_mended_within_reason_or_refused(tmp_path, monkeypatch, depth):
    """The nearest passive model is as far away as the patch is deep. All groups are named, with the
    tolerance that all of them hold."""
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(tmp_path))
    w, memory = negative(depth)
    assert -1.2 * depth < memory.report.smallest_eigenvalue < -0.95 * depth
    models = fits.fit_state_space("a", memory, w, FREE)
    assert not any(model.report.holds for model in models)
    if depth > 10 * TOLERANCE:
        with pytest.raises(InputError) as caught:
            fits.check_fits(models, "hull.nc")
        for text in ("hull.nc", "of heave: ", "; roll: ", "passive", "db check", "automatic"):
            assert text in str(caught.value)
        suggested = float(str(caught.value).split("tolerance: ")[1].split("}")[0])
        models = fits.fit_state_space("a", memory, w, FREE, suggested)
        assert all(model.report.holds for model in models)
    fits.check_fits(models, "hull.nc")
    for model in models:
        dof = model.dofs[0]
        assert model.report.passivity_before < -0.9 * depth or depth > 10 * TOLERANCE
        K = model.modes.transfer_function(1j * np.linspace(0.0, 600.0, 200001))[:, 0, 0].real
        assert K.min() >= -1e-7 * K.max(), dof
        assert 0.9 * depth < model.report.frequency_error < 2.5 * depth
