"""What is kept on disk is what was stored there, or nothing; unsafe folders are not used."""

import os
import threading
from pathlib import Path

import numpy as np
import pytest
from command_line import printed

from hydrosim.files.cache import _require_usable, cache_root, limit_size, store, stored
from tests.generators.cache_damage import KINDS, damage

CONTENTS = {"units-1.json": b'{"km in m": 1000.0}', "fits/a.npz": b"numbers" * 40, "k/b.nbc": b""}
ROOT = hasattr(os, "geteuid") and os.geteuid() == 0
KERNELS = Path(__file__).parent / "jit"
PROGRAM = """
import test_linking as here, linked_kernels
print(linked_kernels.twice_summed(here.VALUES, here.SCALE))
print(sum(linked_kernels.twice_summed.stats.cache_misses.values()))
"""


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache with something in it."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(folder))
    for name, content in CONTENTS.items():
        store(name, content)
    return folder


def test_what_is_stored_is_there(cache: Path) -> None:
    assert {name: stored(name) for name in CONTENTS} == CONTENTS
    assert stored("fits/other.npz") is None
    store("fits/a.npz", b"new")
    assert stored("fits/a.npz") == b"new"
    assert [path for path in cache.rglob("*") if path.suffix == ".partial"] == []


def test_entries_beyond_a_size_go_those_unused_longest_first(cache: Path) -> None:
    """Reading an entry is a use; entries with other names and folders in use stay."""
    for age, name in enumerate(("k-2/d", "k-2/c", "k-1/b", "k-1/a")):
        store(name, b"0" * 1000)
        os.utime(cache / name, (1e9 + age, 1e9 + age))
    size = (cache / "k-2/d").stat().st_size
    assert stored("k-2/d")
    limit_size("k-*/*", 4 * size)
    assert len(list(cache.glob("k-*/*"))) == 4
    limit_size("k-*/*", 3 * size - 1)
    assert {path.name for path in cache.glob("k-*/*")} == {"d", "a"}
    limit_size("k-*/*", size)
    assert {path.name for path in cache.glob("k-*")} == {"k-2"}
    assert {name: stored(name) for name in CONTENTS} == CONTENTS


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_what_is_damaged_is_not_believed(cache: Path, kind: object) -> None:
    """Of 40 damages of each kind; what follows is whole again."""
    draw = np.random.default_rng(7)
    for _ in range(40):
        name = list(CONTENTS)[int(draw.integers(len(CONTENTS)))]
        damage(cache, name, kind, draw)  # type: ignore[arg-type]
        assert stored(name) is None
        store(name, CONTENTS[name])
        assert {name: stored(name) for name in CONTENTS} == CONTENTS


def test_something_else_at_the_place_of_a_file(cache: Path) -> None:
    """A directory, or a pipe, which would be waited for."""
    (cache / "fits" / "a.npz").unlink()
    (cache / "fits" / "a.npz").mkdir()
    os.mkfifo(cache / "fits" / "pipe")
    for name in ("fits/a.npz", "fits/pipe"):
        assert stored(name) is None
        store(name, b"1")
    assert stored("fits/pipe") == b"1"


def test_several_at_once(cache: Path) -> None:
    """Whoever reads finds all of what one of them wrote, or nothing."""
    contents = [bytes([k]) * 200_000 for k in range(4)]
    found: list[bytes | None] = []

    def write(content: bytes) -> None:
        for _ in range(50):
            store("fits/shared", content)
            found.append(stored("fits/shared"))

    threads = [threading.Thread(target=write, args=(content,)) for content in contents]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert set(found) <= {*contents}
    assert len(list((cache / "fits").iterdir())) == 2


@pytest.mark.parametrize(
    ("mode", "reason"), [(0o777, "others may write"), (0o775, "others may write"), (0o755, "")]
)
def test_a_folder_that_others_may_write_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mode: int, reason: str
) -> None:
    folder = tmp_path / f"{mode:o}"
    folder.mkdir()
    folder.chmod(mode)
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(folder))
    if not reason:
        assert cache_root() == folder
        return
    with pytest.warns(UserWarning, match=reason):
        private = cache_root()
    assert private != folder
    assert private.stat().st_mode & 0o777 == 0o700
    store("units-1.json", b"1")
    assert stored("units-1.json") == b"1"
    assert list(folder.iterdir()) == []


@pytest.mark.skipif(not ROOT, reason="only root gives away")
def test_a_folder_of_others_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    os.chown(tmp_path, 12345, 12345)
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(tmp_path))
    with pytest.warns(UserWarning, match="belongs to another user"):
        assert cache_root() != tmp_path


@pytest.mark.parametrize("linked", [False, True], ids=["folder", "link"])
@pytest.mark.parametrize(
    ("owner", "mode", "reason"),
    [
        (None, 0o777, "others may write"),
        pytest.param(
            12345,
            0o755,
            "belongs to another user",
            marks=pytest.mark.skipif(not ROOT, reason="only root gives away"),
        ),
    ],
)
def test_a_subfolder_of_others_is_not_used(
    cache: Path, tmp_path: Path, owner: int | None, mode: int, reason: str, linked: bool
) -> None:
    """Nor what it holds, although it is what was stored there; the rest of the cache is."""
    folder = cache / "k"
    if linked:
        folder = folder.rename(tmp_path / "elsewhere")
        (cache / "k").symlink_to(folder)
    folder.chmod(mode)
    if owner is not None:
        os.chown(folder, owner, owner)
    _require_usable.cache_clear()  # as in a new process
    with pytest.warns(UserWarning, match=f"cache folder {cache}/k is not used: .*{reason}"):
        assert stored("k/b.nbc") is None
    store("k/b.nbc", b"new")
    assert stored("k/b.nbc") == b"new"
    assert [path.name for path in folder.iterdir()] == ["b.nbc"]
    assert b"new" not in (folder / "b.nbc").read_bytes()
    assert stored("fits/a.npz") == CONTENTS["fits/a.npz"]


def test_a_file_of_others_is_not_believed(cache: Path) -> None:
    """What others may have written while the folder was open to them; it is made again."""
    (cache / "fits" / "a.npz").chmod(0o666)
    assert stored("fits/a.npz") is None
    store("fits/a.npz", b"new")
    if ROOT:
        os.chown(cache / "units-1.json", 12345, 12345)
        assert stored("units-1.json") is None
    assert stored("fits/a.npz") == b"new"


@pytest.mark.parametrize(("mode", "used"), [(0o777, False), (0o1777, True)])
def test_a_folder_that_others_may_rename_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mode: int, used: bool
) -> None:
    tmp_path.chmod(mode)
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(tmp_path / "cache"))
    if used:
        assert cache_root() == tmp_path / "cache"
        return
    with pytest.warns(UserWarning, match=f"every user may rename it in {tmp_path}"):
        assert cache_root() != tmp_path / "cache"


def test_a_file_in_the_way_of_the_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(tmp_path / "file" / "cache"))
    with pytest.warns(UserWarning, match="cannot be made"):
        store("units-1.json", b"1")
    assert stored("units-1.json") == b"1"


def test_damaged_machine_code_is_compiled_again(tmp_path: Path) -> None:
    """Once, with the result of an empty cache."""
    assert computed(tmp_path) == ["31.0", "1"]
    draw = np.random.default_rng(3)
    files = [str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*.nbc")]
    for name in files:
        damage(tmp_path, name, KINDS[int(draw.integers(len(KINDS)))], draw)
    assert computed(tmp_path) == ["31.0", "1"]
    assert computed(tmp_path) == ["31.0", "0"]


def computed(cache: Path) -> list[str]:
    """What `PROGRAM` prints in a new process."""
    paths = {
        "PYTHONPATH": f"{KERNELS.parents[1]}:{KERNELS.parent}:{KERNELS}",
        "HYDROSIM_CACHE_DIR": str(cache),
    }
    return printed(PROGRAM, **paths).split()
