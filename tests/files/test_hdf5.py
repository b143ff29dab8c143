"""Whether HDF5 files are whole, and that this is not remembered of another state of a file."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from hydrosim.files import text as hdf5


@pytest.fixture
def whole(tmp_path: Path) -> Path:
    path = tmp_path / "whole.h5"
    with h5py.File(path, "w") as file:
        file["numbers"] = np.arange(1000.0)
    return path


@pytest.fixture
def looked(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The files that were looked into."""
    files: list[Path] = []
    look = hdf5._fault_of_file
    monkeypatch.setattr(hdf5, "_fault_of_file", lambda path: files.append(path) or look(path))
    return files


def test_damage_right_after_a_look_is_seen(whole: Path) -> None:
    """Of the same size, and within the resolution of the file system's times."""
    content = whole.read_bytes()
    for _ in range(20):
        whole.write_bytes(content)
        assert hdf5.fault(whole) is None
        whole.write_bytes(bytes(len(content)))
        assert hdf5.fault(whole) is not None


def test_settled_file_is_looked_into_once(
    whole: Path, looked: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hdf5, "SETTLED", 0)
    assert hdf5.fault(whole) is None
    assert hdf5.fault(whole) is None
    assert len(looked) == 1
    whole.write_bytes(whole.read_bytes()[:-100])
    assert hdf5.fault(whole) is not None
    assert len(looked) == 2


def test_missing_file_is_a_fault(tmp_path: Path) -> None:
    assert "No such file" in str(hdf5.fault(tmp_path / "missing.h5"))


def test_what_points_to_another_file_is_a_fault(whole: Path, tmp_path: Path) -> None:
    other = str(whole)
    layout = h5py.VirtualLayout(shape=(1000,), dtype="f8")
    layout[:] = h5py.VirtualSource(other, "numbers", shape=(1000,))
    with h5py.File(tmp_path / "link.h5", "w") as file:
        file["group/inside"] = h5py.SoftLink("/none")
        file["group/outside"] = h5py.ExternalLink(other, "/numbers")
    with h5py.File(tmp_path / "virtual.h5", "w") as file:
        file.create_virtual_dataset("numbers", layout)
    with h5py.File(tmp_path / "raw.h5", "w") as file:
        file.create_dataset("raw", shape=(10,), dtype="f8", external=[("/etc/passwd", 0, 80)])
    assert hdf5.fault(whole) is None
    for name in ("link", "virtual", "raw"):
        assert "points to another file" in str(hdf5.fault(tmp_path / f"{name}.h5"))
