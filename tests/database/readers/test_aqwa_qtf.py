from pathlib import Path

import damaged
import numpy as np
import pytest
from test_aqwa import CENTRE, USED, _values, _wrapped, written

from hydrosim.database.load import read
from hydrosim.database.readers import aqwa
from hydrosim.errors import InputError

OMEGA = np.array([0.3, 0.5, 0.62, 0.71, 0.8, 0.9, 1.1])  # two lines
DEGREES = np.array([-90.0, 0.0, 40.0])
POINTS = np.array([[-30.0, 4.0], [11.0, -9.0], [25.0, 2.0]])  # from the centre of gravity
WEIGHTS = np.array([1.0, 2.5, -0.7])
SIX = np.arange(1.0, 7.0)  # what the loads of the six DOFs are multiples of
GRAVITY = 9.81


def phase(omega, degrees, points) -> np.ndarray:
    """k x along the waves, in deep water."""
    towards = np.radians(degrees)
    return omega**2 / GRAVITY * (points @ [np.cos(towards), np.sin(towards)])


def table(frequencies: np.ndarray = OMEGA, headings: np.ndarray = DEGREES) -> str:
    """As AQWA-LINE 2023 R1 prints the transfer functions of gauges whose load is the square of the
    elevation, summed over points: real and imaginary part, with AQWA's exp(-i w t), of the load at
    w_j - w_i and at w_i + w_j in waves w_i, w_j with crests at the centre of gravity."""
    heads = f"  1 {headings.size:2d}{frequencies.size:4d}"
    lines = [
        f"{'AQTF-2.0 :':70}",
        *_wrapped(headings, "12.5f", heads),
        *_wrapped(frequencies, "12.7f", ""),
    ]
    for h, degrees in enumerate(headings):
        waves = [np.exp(1j * phase(w, degrees, POINTS)) for w in frequencies]
        for i, first in enumerate(waves):
            for j, second in enumerate(waves):
                slow = (WEIGHTS * first.conj() * second).sum() / 2 * SIX
                fast = (WEIGHTS * first * second).sum() / 2 * SIX
                rows = np.array([slow.real, slow.imag, fast.real, fast.imag])
                head = f"{1:3d}{h + 1:3d}{i + 1:4d}{j + 1:4d}"
                lines += [f"{head:14}{row[10:]}" for row in _values(rows)[:1]]
                lines += [f"{'':14}{row[10:]}" for row in _values(rows)[1:]]
    return "\n".join(lines) + "\n"


@pytest.fixture
def path(barge, tmp_path) -> Path:
    (tmp_path / "ANALYSIS.AH1").write_text(written(barge))
    out = tmp_path / "ANALYSIS.QTF"
    out.write_text(table())
    return out


@pytest.mark.parametrize("named", ["ANALYSIS.QTF", "ANALYSIS.AH1", "ANALYSIS"])
def test_two_waves_feel_what_the_file_says(path, named):
    """The gauges' load in time, of waves whose phases are those at the frame's origin."""
    db = read(path.with_name(named))
    i, j, h = 1, 4, 2
    np.testing.assert_allclose(db.qtf_frequency, OMEGA, atol=1e-7)
    np.testing.assert_allclose(db.qtf_heading, np.radians(np.stack([DEGREES] * 2, axis=-1)))
    t, amplitudes = np.linspace(0.0, 60.0, 200), {i: 1.3 * np.exp(0.4j), j: 0.8 * np.exp(-1.1j)}
    elevation = sum(
        (a * np.exp(1j * (w * t[:, None] - phase(w, DEGREES[h], POINTS + CENTRE[:2])))).real
        for a, w in ((a, OMEGA[n]) for n, a in amplitudes.items())
    )
    load = np.zeros(t.size, dtype=complex)
    for m, a in amplitudes.items():
        for n, b in amplitudes.items():
            slow, fast = OMEGA[m] - OMEGA[n], OMEGA[m] + OMEGA[n]
            load += a * np.conj(b) * db.qtf_difference[h, m, n, 0] * np.exp(1j * slow * t)
            load += a * b * db.qtf_sum[h, m, n, 0] * np.exp(1j * fast * t)
    np.testing.assert_allclose(load.real, elevation**2 @ WEIGHTS, atol=5e-4)
    np.testing.assert_allclose(db.qtf_sum, db.qtf_sum[..., :1] * SIX, rtol=1e-3, atol=1e-3)


def test_difference_functions_are_hermitian_about_the_mean_load(path):
    db = read(path)
    T = db.qtf_difference
    np.testing.assert_allclose(T, T.conj().swapaxes(1, 2), atol=1e-12)
    mean = np.einsum("hiid->hid", T)
    np.testing.assert_allclose(
        mean, np.broadcast_to(WEIGHTS.sum() / 2 * SIX, mean.shape), rtol=1e-4
    )


def test_the_diagonal_is_the_mean_drift_where_waves_are_the_same(barge, path):
    assert read(path).mean_drift is None
    path.write_text(table(barge.frequency[USED], np.degrees(barge.heading)))
    db = read(path)
    assert db.mean_drift.shape == db.excitation.shape
    expected = np.broadcast_to(WEIGHTS.sum() / 2 * SIX, db.mean_drift.shape)
    np.testing.assert_allclose(db.mean_drift, expected, rtol=1e-4)
    assert db.attributes["mean_drift_method"] == "diagonal of the QTF"


def test_without_its_database(path):
    path.with_name("ANALYSIS.AH1").unlink()
    with pytest.raises(InputError, match=r"ANALYSIS\.QTF: .* expected ANALYSIS\.AH1 beside it"):
        read(path)


def test_other_versions_are_left_out(path):
    path.write_text(path.read_text().replace("AQTF-2.0", "AQTF-1.0"))
    with pytest.warns(UserWarning, match=r"version 'AQTF-1\.0 :', expected AQTF-2\.0"):
        db = read(path.with_name("ANALYSIS.AH1"))
    assert db.qtf_difference is None


def test_another_model(path):
    path.write_text(path.read_text().replace("  1  3   7", "  2  3   7"))
    with pytest.raises(InputError, match=r"line 2: found 2 structures.* another model"):
        read(path)


def test_damaged_files_are_refused(path, recwarn):
    assert 50 < damaged.refused(aqwa.read, path, path.read_bytes(), "ANALYSIS.QTF")
