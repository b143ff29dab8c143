"""A run that is stopped on its way and goes on comes to the same result, to the bit."""

import zipfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from markers import few
from scenes import SEA, in_contact, in_waves, scene_of, steady, with_body

import hydrosim as hs
from hydrosim.compare.dataset import differences
from hydrosim.elements import LinearMooring
from hydrosim.files.outputs import Output
from hydrosim.jit.waiting import Torn
from hydrosim.run import checkpoint, course
from hydrosim.run.checkpoint import Checkpoint
from hydrosim.scene import ConvolutionRadiation, Method, Place, Scene, Solver, WaveForces, WaveTrain


@pytest.fixture(autouse=True)
def short_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many calls of the kernels, however fast the machine is."""
    monkeypatch.setattr(course, "CHUNK_CPU_TIME_S", 0.0)


def kept(
    folder: Path, resume: bool = True, every: float = 0.0, say: list | None = None
) -> Checkpoint:
    output = Output(folder / "x.nc.checkpoint", "checkpoint", folder / "x.yaml")
    return Checkpoint(output, every, resume, [].append if say is None else say.append)


def stopping(share: float, duration: float) -> Callable[[float, int], None]:
    """Progress that is interrupted once so much of the run is done."""

    def progress(time: float, _: int) -> None:
        if time >= share * duration:
            raise KeyboardInterrupt

    return progress


def in_pieces(scene: Scene, folder: Path, shares: tuple[float, ...]) -> xr.Dataset:
    """The run, interrupted at these shares of its duration."""
    for share in shares:
        run = hs.simulate(scene, stopping(share, scene.duration), kept(folder))
        assert run.attrs["status"] == "interrupted"
        assert run.time[-1] < scene.duration
    return hs.simulate(scene, None, kept(folder))


def scenes() -> Iterator[tuple[str, Scene]]:
    contact = in_contact(40.0)
    for method in Method:
        yield method, replace(contact, solver=Solver(method=method, step=0.05))
    yield "convolution", with_body(contact, radiation=ConvolutionRadiation(length=20.0))
    drift = LinearMooring("barge", np.zeros((6, 6)), np.zeros((6, 6)))
    free = in_waves(scene_of("free_floating"), WaveTrain(SEA, heading=0.5))
    slow = WaveForces(position=Place.SLOW, headings=Place.SLOW)
    forces = {**free.forces, "nothing": drift, "push": steady("barge", surge=1e6, yaw=1e7)}
    yield "slow paths", replace(with_body(free, wave_forces=slow), forces=forces, duration=40.0)


SCENES = dict(scenes())


@pytest.mark.parametrize("name", few(sorted(SCENES, reverse=True), 2))
def test_in_pieces_to_the_bit(name: str, tmp_path: Path) -> None:
    scene = SCENES[name]
    whole = hs.simulate(scene)
    assert "stepped" in str(whole.solver_linear) or whole.solver_steps > 0
    assert differences(whole, in_pieces(scene, tmp_path, (0.1, 0.5, 0.8))) == []


def test_what_an_interrupt_of_the_compiler_tears_is_not_kept(tmp_path: Path) -> None:
    """A kernel that waited for another has left the run in the middle of a step."""
    scene = SCENES["convolution"]

    def torn(time: float, _: int) -> None:
        if time >= 0.5 * scene.duration:
            raise Torn

    keeping = kept(tmp_path, every=1e6)
    run = hs.simulate(scene, torn, keeping)
    assert run.attrs["status"] == "interrupted"
    assert not keeping.output.path.exists()


def test_a_checkpoint_in_time_is_enough(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is killed writes nothing more: it goes on from the last one."""
    scene, said = in_contact(30.0), []

    def killed(time: float, _: int) -> None:
        if time > 20.0:
            raise MemoryError

    with pytest.raises(MemoryError):
        hs.simulate(scene, killed, kept(tmp_path))
    run = hs.simulate(scene, None, kept(tmp_path, say=said))
    assert "the run continues from" in said[0]
    assert "% complete" in said[0]
    assert differences(hs.simulate(scene), run) == []


def test_what_there_is_to_say(tmp_path: Path) -> None:
    scene, said = in_contact(5.0), []
    hs.simulate(scene, None, kept(tmp_path, say=said))
    assert said.pop(0).endswith("the run starts at the beginning")
    hs.simulate(scene, None, kept(tmp_path, resume=False, say=said))
    assert "--resume continues it" in said.pop(0)
    assert said == []


def sunk(scene: Scene) -> Scene:
    """In a database with another last digit."""
    database = scene.bodies[0].hydrodynamics
    mass = database.added_mass.copy()
    mass[3, 0, 0] *= 1.0 + 1e-15
    return with_body(scene, hydrodynamics=replace(database, added_mass=mass))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda scene: replace(scene, duration=31.0), "--resume: the case changed after"),
        (lambda scene: with_body(scene, position=(0.0,) * 6), "--resume: the case changed after"),
        (lambda scene: in_waves(scene, WaveTrain(SEA, seed=9)), "--resume: the case changed after"),
        (sunk, "--resume: the database of barge changed after"),
    ],
)
@pytest.mark.usefixtures("fits_made_here")
@pytest.mark.slow
def test_another_run_is_refused(
    change: Callable[[Scene], Scene], words: str, tmp_path: Path
) -> None:
    scene = in_contact(30.0)
    hs.simulate(scene, stopping(0.5, 30.0), kept(tmp_path))
    with pytest.raises(hs.InputError, match=words):
        hs.simulate(change(scene), None, kept(tmp_path))


def test_another_program_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = in_contact(30.0)
    hs.simulate(scene, stopping(0.5, 30.0), kept(tmp_path))
    monkeypatch.setattr(checkpoint, "program_version", lambda: "9.9")
    with pytest.raises(hs.InputError, match="--resume: the program changed after"):
        hs.simulate(scene, None, kept(tmp_path))


@pytest.mark.parametrize("share", [0.0, 0.3, 0.99])
def test_a_damaged_checkpoint_is_refused(share: float, tmp_path: Path) -> None:
    scene = in_contact(30.0)
    hs.simulate(scene, stopping(0.5, 30.0), kept(tmp_path))
    path = tmp_path / "x.nc.checkpoint"
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(hs.InputError, match=r"--resume: .* is damaged"):
        hs.simulate(scene, None, kept(tmp_path))
    encrypted = content.rfind(b"PK\x01\x02") + 8  # of the last entry, what a zip file says of it
    path.write_bytes(content)
    with zipfile.ZipFile(path) as archive:
        largest = max(archive.infolist(), key=lambda entry: entry.file_size)
    inside = largest.header_offset + largest.file_size // 2  # headers hold bytes that nobody needs
    for place in (inside, encrypted):
        changed = bytearray(content)
        changed[place] ^= 1
        path.write_bytes(bytes(changed))
        with pytest.raises(hs.InputError, match=r"--resume: .* is damaged"):
            hs.simulate(scene, None, kept(tmp_path))


def test_a_checkpoint_that_lacks_something_is_refused(tmp_path: Path) -> None:
    scene, path = in_contact(30.0), tmp_path / "x.nc.checkpoint"
    hs.simulate(scene, stopping(0.5, 30.0), kept(tmp_path))
    arrays = dict(np.load(path))
    shorter = {**arrays, "a3": arrays["a3"][:1]}
    for content in (shorter, {name: each for name, each in arrays.items() if name != "a2"}):
        with path.open("wb") as file:
            np.savez(file, **content)
        with pytest.raises(hs.InputError, match=r"is damaged \(a. has changed\)"):
            hs.simulate(scene, None, kept(tmp_path))


def test_a_checkpoint_that_cannot_be_written_ends_nothing(tmp_path: Path) -> None:
    said: list[str] = []
    (tmp_path / "x.nc.checkpoint").mkdir()
    run = hs.simulate(in_contact(5.0), None, kept(tmp_path, resume=False, say=said))
    assert run.attrs["status"] == "complete"
    assert any("The run continues without a new checkpoint" in text for text in said)
