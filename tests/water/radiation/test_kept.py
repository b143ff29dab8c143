"""Arrays kept on disk: the same to the bit, and never believed where they are damaged."""

import io
from pathlib import Path

import numpy as np
import pytest

from hydrosim.files.cache import DIGEST
from hydrosim.water.radiation.kept import read_or_make

NUMBERS = {"one": np.array([0.1, -0.0, np.inf]), "two": np.arange(6).reshape(2, 3)}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(tmp_path))
    return tmp_path / "numbers"


def numbers(*settings: object, made: bool = False) -> dict[str, np.ndarray]:
    """The numbers, and whether they had to be ``made``."""
    calls = []

    def make() -> dict[str, np.ndarray]:
        calls.append(1)
        return NUMBERS

    found = read_or_make("numbers", settings, make, dict, dict)
    assert bool(calls) == made
    return found


def test_what_is_kept_is_what_was_made(folder: Path) -> None:
    numbers(1, made=True)
    found = numbers(1)
    assert found.keys() == NUMBERS.keys()
    for name, value in NUMBERS.items():
        assert found[name].dtype == value.dtype
        assert found[name].shape == value.shape
        assert found[name].tobytes() == value.tobytes()
    numbers(2, made=True)
    assert len(list(folder.iterdir())) == 2


def zipped(**arrays: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def another_number(content: bytes) -> bytes:
    """A whole file with its old digest."""
    size = DIGEST().digest_size
    arrays = dict(np.load(io.BytesIO(content[size:])))
    arrays["one"] = np.array([0.2, 0.0, np.inf])
    return content[:size] + zipped(**arrays)


@pytest.mark.parametrize(
    "damaged",
    [
        lambda content: b"",
        lambda content: b"no zip",
        lambda content: content[: len(content) // 2],
        lambda content: zipped(**NUMBERS),
        another_number,
    ],
)
def test_damaged_file_is_made_again(folder: Path, damaged) -> None:
    numbers(1, made=True)
    [file] = folder.iterdir()
    file.write_bytes(damaged(file.read_bytes()))
    numbers(1, made=True)
    numbers(1)


def test_every_changed_byte_is_noticed(folder: Path) -> None:
    numbers(1, made=True)
    [file] = folder.iterdir()
    content = file.read_bytes()
    for place in range(0, len(content), 7):
        changed = bytearray(content)
        changed[place] ^= 0x10
        file.write_bytes(changed)
        numbers(1, made=True)


def test_folder_that_cannot_be_written_is_no_error(folder: Path) -> None:
    folder.write_text("in the way")
    with pytest.warns(UserWarning, match="is not used: it cannot be made"):
        numbers(1, made=True)
    numbers(1, made=False)  # from a folder of this process
