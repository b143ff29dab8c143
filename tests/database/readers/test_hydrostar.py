from __future__ import annotations

from pathlib import Path

import damaged
import numpy as np
import pytest

from hydrosim.database.load import read
from hydrosim.database.readers import hydrostar, wamit
from hydrosim.errors import InputError

OMEGA = np.linspace(0.3, 1.1, 9)
DIFFERENCES = np.arange(9) * 0.1
DEGREES = np.array([0.0, 40.0, 180.0])
POINTS = np.array([[-30.0, 4.0], [11.0, -9.0], [25.0, 2.0]])  # where gauges stand
WEIGHTS = np.array([1.0, 2.5, -0.7])
SIX = np.arange(1.0, 7.0)  # what the loads of the six DOFs are multiples of
WAVES_AT = np.array([12.0, -3.0])  # where tables count phases from
MOMENTS_AT = np.array([2.0, -1.0, 0.5])
T = np.linspace(0.0, 200.0, 4001)


def elevation(waves: dict[int, complex], degrees: float, origin: np.ndarray) -> np.ndarray:
    """At the gauges, of waves cos(w t + phase) at ``origin``, in deep water."""
    towards = np.radians(degrees)
    along = (POINTS - origin) @ [np.cos(towards), np.sin(towards)]
    return sum(
        (a * np.exp(1j * (OMEGA[n] * T[:, None] - OMEGA[n] ** 2 / 9.81 * along))).real
        for n, a in waves.items()
    )


def value(i: int, j: int, degrees: float, difference: bool) -> complex:
    """What Snoopy makes a time series of, from the load of the gauges in time: half of its cosine
    and sine at w_j - w_i, half of its cosine and minus its sine at w_i + w_j."""
    if i == j:
        load = elevation({i: 1.0}, degrees, WAVES_AT) ** 2 @ WEIGHTS
        w = 0.0 if difference else 2 * OMEGA[i]
    else:
        both = elevation({i: 1.0, j: 1.0}, degrees, WAVES_AT) ** 2
        alone = [elevation({n: 1.0}, degrees, WAVES_AT) ** 2 for n in (i, j)]
        load = (both - sum(alone)) @ WEIGHTS / 2  # what they make together
        w = OMEGA[j] - OMEGA[i] if difference else OMEGA[i] + OMEGA[j]
    known = {abs(OMEGA[j] - OMEGA[i]), OMEGA[i] + OMEGA[j]} - {0.0}
    terms = np.stack([np.ones_like(T), *[g(x * T) for x in known for g in (np.cos, np.sin)]], 1)
    found = dict(zip([(0.0, 0), *[(x, g) for x in known for g in (0, 1)]],
                     np.linalg.lstsq(terms, load, rcond=None)[0], strict=True))  # fmt: skip
    sine = found.get((w, 1), 0.0)
    return complex(found[(w, 0)], sine if difference else -sine)


def table(dof: int, difference: bool = True, differences: np.ndarray = DIFFERENCES) -> str:
    """As HydroStar writes it; where w_2 is above the last frequency it has numbers, too."""
    lines = [
        "# Project : ",
        "# User    : ",
        f"# File : qtf_{dof}.qtf",
        "# Constants used in computations :",
        "#     Reference length     :     1.0000 ",
        "#     Water density (rho)  :  1025.0000",
        "#     Gravity acceleration :     9.8100",
        "#     Waterdepth           :  Inf. ",
        f"#     Ref.pt incident wave : ({WAVES_AT[0]:11.4f}{WAVES_AT[1]:8.4f})",
        "#            Forward speed :   0.0000  m/s   ",
        "#",
        "#" + 72 * "-",
        '#QTFTYPE "2NDLOAD"',
        "#CPLXTYPE 0",
        f"#QTFMODE {'Diff' if difference else 'Sum'}",
        f'#DIRECTION  "{dof:12d}',
        "#COORD  " + "".join(f"{x:9.3f}" for x in MOMENTS_AT),
        f"#NBHEADING{DEGREES.size:4d}",
        "#HEADING" + "".join(f"{x:12.2f}" for x in DEGREES),
        "#DIFF" + "".join(f"{x:24.5f}" for x in differences),
        "#---w(r/s)-----------------------------------------------------",
    ]
    for degrees in DEGREES:
        lines.append(f"#Heading ={degrees:8.2f}")
        for i, w in enumerate(OMEGA):
            row = f"{w:13.4E}"
            for n in range(differences.size):
                two = VALUES[difference, degrees, i, i + n] if i + n < OMEGA.size else 9.0
                row += f"{SIX[dof - 1] * two.real:15.6E}{SIX[dof - 1] * two.imag:15.6E}"
            lines.append(row)
        lines += ["", ""]
    return "\n".join(lines)


VALUES = {
    (difference, degrees, i, j): value(i, j, degrees, difference)
    for difference in (True, False)
    for degrees in DEGREES
    for i in range(OMEGA.size)
    for j in range(i, OMEGA.size)
}


@pytest.fixture
def path(made_up, tmp_path) -> Path:
    """Six tables of differences and six of sums beside a WAMIT set."""
    db = made_up(
        qtf_frequency=None, qtf_heading=None, qtf_difference=None, qtf_sum=None,
        reference_point=np.zeros((1, 3)),
    )  # fmt: skip
    wamit.write(db, tmp_path / "hull")
    for dof in range(1, 7):
        (tmp_path / f"qtf_{dof}.qtf").write_text(table(dof))
        (tmp_path / f"sum_{dof}.rao").write_text(table(dof, difference=False))
    return tmp_path / "qtf_1.qtf"


def test_two_waves_feel_what_the_tables_say(path):
    """The gauges' load in time, of waves whose phases are those at the frame's origin; and moments
    about the reference point."""
    db = read(path)
    i, j, h = 1, 4, 1
    waves = {i: 1.3 * np.exp(0.4j), j: 0.8 * np.exp(-1.1j)}
    expected = elevation(waves, DEGREES[h], np.zeros(2)) ** 2 @ WEIGHTS
    np.testing.assert_allclose(db.qtf_frequency, OMEGA)
    load = np.zeros((T.size, 6), dtype=complex)
    for m, a in waves.items():
        for n, b in waves.items():
            slow, fast = OMEGA[m] - OMEGA[n], OMEGA[m] + OMEGA[n]
            load += np.outer(np.exp(1j * slow * T), a * np.conj(b) * db.qtf_difference[h, m, n])
            load += np.outer(np.exp(1j * fast * T), a * b * db.qtf_sum[h, m, n])
    moments = SIX[3:] + np.cross(MOMENTS_AT, SIX[:3])
    np.testing.assert_allclose(
        load.real, np.outer(expected, [*SIX[:3], *moments]), atol=1e-4 * abs(expected).max() * 6
    )
    assert "HydroStar's QTF in the frame of the WAMIT set" in db.attributes["assumed"]
    assert (db.water_density, db.gravity) == (1025.0, 9.81)


def test_difference_functions_are_hermitian_about_the_mean_load(path):
    transfer = read(path).qtf_difference
    np.testing.assert_allclose(transfer, transfer.conj().swapaxes(1, 2), atol=1e-12)
    mean = np.einsum("hiid->hid", transfer)[..., :3]
    np.testing.assert_allclose(mean, np.broadcast_to(WEIGHTS.sum() / 2 * SIX[:3], mean.shape))


def test_waves_further_apart_than_the_tables_go(path):
    for dof in range(1, 7):
        path.with_name(f"qtf_{dof}.qtf").write_text(table(dof, differences=DIFFERENCES[:4]))
        path.with_name(f"sum_{dof}.rao").unlink()
    full = {(h, n): VALUES[True, d, 0, n] for h, d in enumerate(DEGREES) for n in (3, 4)}
    with pytest.warns(UserWarning, match=r"up to 0\.3 rad/s apart; .* taken to be zero"):
        db = read(path)
    assert db.qtf_sum is None
    for h in range(DEGREES.size):
        assert abs(db.qtf_difference[h, 0, 3, 0]) == pytest.approx(abs(full[h, 3]), rel=1e-5)
        assert db.qtf_difference[h, 0, 4, 0] == 0.0


def test_messages(path):
    text = path.read_text()
    path.write_text(text.replace("#Heading =    0.00", "##Heading1 = 0.0"))
    with pytest.raises(InputError, match=r"line 22: found pairs of headings"):
        read(path)
    path.write_text(text.replace("   0.0000  m/s", "   2.5700  m/s"))
    with pytest.raises(InputError, match="found a forward speed"):
        read(path)
    path.write_text(text.replace('"           1', '"           2'))
    with pytest.raises(InputError, match=r"two of qtf_1\.qtf, .* have the same load"):
        read(path)
    path.write_text(text)
    path.with_name("qtf_2.qtf").unlink()
    with pytest.raises(InputError, match="5 loads are there, expected six to move the moments"):
        read(path)
    path.with_name("hull.1").unlink()
    with pytest.raises(InputError, match=r"alone, and 0 files \.1 are beside it"):
        read(path)


@pytest.mark.filterwarnings("ignore:.*rad/s apart")
def test_damaged_files_are_refused(path):
    for dof in range(2, 7):
        path.with_name(f"qtf_{dof}.qtf").unlink()
        path.with_name(f"sum_{dof}.rao").unlink()
    path.with_name("sum_1.rao").unlink()
    text = path.read_text()
    coord = next(line for line in text.split("\n") if line.startswith("#COORD"))
    content = text.replace(coord, "#COORD      0.000    0.000    0.000").encode()
    assert 50 < damaged.refused(hydrostar.read, path, content, "qtf_1.qtf")
