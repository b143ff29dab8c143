"""Text files as editors, mail and other systems leave them: the same data, or one message."""

import re
import shutil
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import test_aqwa
import test_marin
import test_nemoh
import test_veres
from orcaflex_files import contents, write

from hydrosim.database import HydroDatabase
from hydrosim.database.load import read
from hydrosim.database.readers import wamit
from hydrosim.errors import InputError
from hydrosim.scene.hydrodynamics import NOTHING_GIVEN, FrequencyColumn, Given

Change = Callable[[bytes], bytes]


def with_spaces_as_tabs(content: bytes) -> bytes:
    return re.sub(rb"(?m)(?<=\S) {2,}(?=\S)", b"\t", content)


def with_fortran_exponents(content: bytes) -> bytes:
    return re.sub(rb"(\d)[eE]([+-]\d\d)", rb"\1D\2", content)


VARIANTS: dict[str, Change] = {
    "CRLF": lambda content: content.replace(b"\n", b"\r\n"),
    "CR": lambda content: content.replace(b"\n", b"\r"),
    "byte order mark": lambda content: b"\xef\xbb\xbf" + content,
    "blank lines at the end": lambda content: content + b"\n \n\n",
    "end of file of DOS": lambda content: content + b"\x1a",
    "blanks at line ends": lambda content: content.replace(b"\n", b"  \n"),
    "tabs": with_spaces_as_tabs,
    "exponents with D": with_fortran_exponents,
    "no line end at the end": lambda content: content.rstrip(b"\n"),
}
REFUSED = {("MARIN", "tabs")}
"""Columns of fixed width, which tabs break."""


def with_few_frequencies(db: HydroDatabase) -> HydroDatabase:
    """A fourth of the frequencies: formats are tried here, not loads."""
    names = ("frequency", "added_mass", "radiation_damping", "excitation", "froude_krylov")
    drifts = ("mean_drift", "mean_drift_held", "drift_imbalance")
    series = [name for name in (*names, *drifts) if getattr(db, name) is not None]
    fewer = {name: getattr(db, name)[::4] for name in series}
    assert db.qtf_frequency is not None
    assert db.qtf_difference is not None
    qtf = db.qtf_difference[:, ::3, ::3]
    return replace(db, **fewer, qtf_frequency=db.qtf_frequency[::3], qtf_difference=qtf)


def wamit_set(db: HydroDatabase, folder: Path) -> Path:
    wamit.write(with_few_frequencies(db), folder / "hull")
    return folder / "hull.1"


def text_files(**texts: Callable[[HydroDatabase], str]) -> Callable[[HydroDatabase, Path], Path]:
    """Writes the text of each suffix; the file to read is the first."""

    def make(db: HydroDatabase, folder: Path) -> Path:
        paths = [folder / f"hull.{suffix}" for suffix in texts]
        for path, text in zip(paths, texts.values(), strict=True):
            path.write_text(text(db))
        return paths[0]

    return make


FORMATS = {
    "WAMIT": wamit_set,
    "AQWA": text_files(AH1=test_aqwa.written),
    "MARIN": text_files(hyd=test_marin.written),
    "VERES": text_files(re7=test_veres.coefficients, re8=test_veres.loads, re2=test_veres.drift),
    "Nemoh": lambda db, folder: test_nemoh.written(test_nemoh.thinned(db), folder / "project"),
    "OrcaFlex": lambda db, folder: write(folder / "hull.yml", contents(db)),
}


@pytest.fixture(scope="session")
def written(barge: HydroDatabase, tmp_path_factory: Any) -> dict[str, tuple[Path, Path]]:
    """Folder and file to read of each format."""
    found = {}
    for name, make in FORMATS.items():
        folder = tmp_path_factory.mktemp(name)
        found[name] = (folder, make(barge, folder))
    return found


def changed(source: tuple[Path, Path], target: Path, change: Change) -> Path:
    """A copy with all files changed; the file to read."""
    folder, file = source
    shutil.copytree(folder, target)
    for path in target.rglob("*"):
        if path.is_file():
            path.write_bytes(change(path.read_bytes()))
    return target / file.relative_to(folder)


def assert_same(db: HydroDatabase, other: HydroDatabase) -> None:
    for name in (item.name for item in fields(HydroDatabase)):
        value = getattr(other, name)
        if isinstance(value, np.ndarray):
            np.testing.assert_array_equal(getattr(db, name), value)
        elif name not in ("source", "attributes"):
            assert getattr(db, name) == value


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("program", FORMATS)
def test_a_text_file_is_read_alike_or_refused_in_one_message(
    written: dict[str, tuple[Path, Path]], tmp_path: Path, program: str, variant: str
) -> None:
    path = changed(written[program], tmp_path / "changed", VARIANTS[variant])
    given = test_marin.GIVEN if program == "MARIN" else NOTHING_GIVEN
    if (program, variant) in REFUSED:
        with pytest.raises(InputError, match=r"line \d+"):
            read(path, given)
    else:
        assert_same(read(path, given), read(written[program][1], given))


def by_frequency(content: bytes, gravity: float, wavenumber: bool) -> bytes:
    """Rows whose first column is the frequency (IPEROUT 2) or w^2 L / g (IPEROUT 3)."""
    rows = []
    for line in content.decode().splitlines():
        words = line.split()
        try:
            period = float(words[0])
        except ValueError:
            rows.append(line)
            continue
        w = 2.0 * np.pi / period if period > 0.0 else 0.0
        value = w * w / gravity if wavenumber else w
        code = value if period > 0.0 else (-1.0 if period == 0.0 else 0.0)
        rows.append(" ".join([f"{code:.16e}", *words[1:]]))
    return "\n".join(rows).encode()


@pytest.mark.parametrize("wavenumber", [False, True])
@pytest.mark.parametrize("said", [False, True])
def test_frequency_columns_of_wamit(
    barge: HydroDatabase, tmp_path: Path, wavenumber: bool, said: bool
) -> None:
    """Also where nobody says which it is: loads of long waves tell."""
    path = wamit_set(barge, tmp_path)
    for file in tmp_path.glob("hull.1?[ds]"):
        file.unlink()
    column = FrequencyColumn.DEEP_WAVENUMBER if wavenumber else FrequencyColumn.FREQUENCY
    given = Given(water_density=1025.0, gravity=9.81, length=1.0)
    expected = read(path, given)
    for file in tmp_path.glob("hull.*"):
        if file.suffix not in (".hst", ".mmx"):
            file.write_bytes(by_frequency(file.read_bytes(), 9.81, wavenumber))
    db = read(path, replace(given, frequency_column=column if said else None))
    np.testing.assert_allclose(db.frequency, expected.frequency, rtol=1e-12)
    np.testing.assert_array_equal(db.added_mass, expected.added_mass)
    np.testing.assert_allclose(db.excitation, expected.excitation, rtol=1e-12)


def header_removed(content: bytes) -> bytes:
    return content.split(b"\n", 1)[1]


def test_tables_without_a_heading_in_a_folder_of_hams(barge: HydroDatabase, tmp_path: Path) -> None:
    """HAMS writes .1, .3 and .hst without a heading; names may differ in case, as under Windows."""
    given = Given(gravity=9.81, length=1.0)
    expected = read(wamit_set(barge, tmp_path), given)
    folder = tmp_path / "Output" / "Wamit_format"
    folder.mkdir(parents=True)
    for suffix, name in ((".1", "Buoy.1"), (".3", "BUOY.3"), (".hst", "buoy.HST")):
        content = (tmp_path / f"hull{suffix}").read_bytes()
        (folder / name).write_bytes(header_removed(content))
    db = read(folder / "Buoy.1", given)
    np.testing.assert_array_equal(db.added_mass, expected.added_mass)
    np.testing.assert_array_equal(db.excitation, expected.excitation)
    np.testing.assert_array_equal(db.hydrostatic_stiffness, expected.hydrostatic_stiffness)


def test_comments_and_commas_in_tables(barge: HydroDatabase, tmp_path: Path) -> None:
    """A comma counts between numbers, and not in a number: 2,5 is no 2 and 5."""
    path = wamit_set(barge, tmp_path)
    expected = read(path)
    lines = header_removed(path.read_bytes()).decode().splitlines()
    lines[0] = ", ".join(lines[0].split()) + "  ! the first"
    path.write_text("\n".join(["# PER  I  J  A  B", lines[0], "! more", *lines[1:]]))
    assert_same(read(path), expected)
    words = lines[1].split()
    path.write_text("\n".join([lines[1].replace(words[3], "2,5"), *lines[2:]]))
    with pytest.raises(InputError, match=r"line 1: found '2,5', expected a number"):
        read(path)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("ControlFile.in", r"HAMS; give its Output/Wamit_format/NAME\.1"),
        ("platform_HydroDyn.dat", r"HydroDyn; give the \.1 file that its PotFile names"),
        ("hull.ss", r"give the \.1 file"),
        ("hull.4", r"motions of WAMIT; give the \.1 file"),
        ("hull.owr", r"OrcaWave; .* text data file \(\.yml\)"),
        ("hull.LIS", r"give the \.AH1 file"),
    ],
)
def test_files_beside_databases_are_told_from_them(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text("---- a control file ----\n 1 2 3\n")
    with pytest.raises(InputError, match=text):
        read(tmp_path / name)
