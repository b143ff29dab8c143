"""Wheels with machine code: they compile no kernel, and results are those of kernels made here."""

import os
import subprocess
import sys
from pathlib import Path
from runpy import run_path
from shutil import copytree
from typing import Any

import numpy as np
import pytest
import xarray as xr

from hydrosim.jit.ship import ship
from hydrosim.jit.shipped import FEATURES, MANIFEST, read_manifest, refusal_reason

ROOT = Path(__file__).parents[2]
BASE, SPHERE, BLOCK = "reverse_float_over/base", "sphere/irregular", "friction_block/exact"
DECAY = "reverse_float_over/decay"
BEFORE_CONTACT = 500.0  # s, of the base case
ROUNDING = 1e-12  # of the range of a channel
PROGRAM = """
import sys
import hydrosim as hs
from numba.core import event
with event.install_recorder("numba:compile") as recorder:
    run = hs.simulate(hs.load_case(sys.argv[1]))
run[["position", "velocity"]].to_netcdf(sys.argv[2])
print(hs.__file__, len(recorder.buffer))
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which a wheel with the kernels of four cases is installed."""
    pytest.importorskip("hatchling", reason="hatchling is not installed (pip install .[dev])")
    home = tmp_path_factory.mktemp("wheel")
    cases = [str(ROOT / "cases" / f"{name}.yaml") for name in (BASE, SPHERE, BLOCK, DECAY)]
    command("hydrosim.jit.ship", str(home / "kernels"), *cases, PYTHONPATH=str(ROOT))
    build = ["build", "--target", "wheel", "--directory", str(home)]
    command("hatchling", *build, HYDROSIM_SHIPPED=str(home / "kernels"))
    (wheel,) = home.glob("*.whl")
    options = ["--quiet", "--no-deps", "--no-index", "--target", str(home / "installed")]
    command("pip", "install", *options, str(wheel))
    return home / "installed"


@pytest.mark.slow
@pytest.mark.extras
@pytest.mark.parametrize("case", [BASE, SPHERE, BLOCK, DECAY])
def test_no_kernel_of_a_wheel_is_compiled(installed, case, tmp_path, figure):
    """Without contact, motions are those of kernels compiled for this processor."""
    shipped, compiles, _ = motions(installed, case, tmp_path)
    assert compiles == 0
    native, _, _ = motions(ROOT, case, tmp_path, cache=None)
    if case != BLOCK:
        end = BEFORE_CONTACT if case == BASE else None
        error = largest_change(shipped.sel(time=slice(end)), native.sel(time=slice(end)))
        figure(f"shipped against native, {case}", error)
        assert error <= ROUNDING


@pytest.mark.slow
@pytest.mark.extras
def test_a_damaged_kernel_of_a_wheel_is_compiled_with_a_warning(installed, tmp_path):
    damaged = copytree(installed, tmp_path / "damaged")
    (file,) = damaged.glob("hydrosim/jit/shipped/hydrosim.integrate.dynamics.rhs-*.nbc")
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)
    sound, compiles, told = motions(damaged, BLOCK, tmp_path)
    assert compiles > 0
    assert f"{file} is damaged" in told
    assert largest_change(sound, motions(installed, BLOCK, tmp_path)[0]) <= ROUNDING


@pytest.mark.slow
@pytest.mark.extras
def test_the_version_tells_of_shipped_kernels(installed: Path) -> None:
    told = command("hydrosim", "--version", cwd=installed).stdout
    assert "kernels for x86-64-v3 came with the package, used" in told
    assert "fits of radiation came with the package" in told


def test_shipped_kernels_are_for_these_sources_and_a_processor_of_their_kind() -> None:
    manifest = {"kernels": "kernels-1", "made with": "numba 0.61.0", "files": {}}
    assert refusal_reason(manifest, "kernels-1", f"{FEATURES},+avx512f") == ""
    assert "numba 0.61.0" in refusal_reason(manifest, "kernels-2", FEATURES)
    assert "lacks +fma" in refusal_reason(manifest, "kernels-1", FEATURES.replace("+fma", "-fma"))
    assert refusal_reason({}, "kernels-1", FEATURES)


@pytest.mark.parametrize("content", ["", "{", "[]", "[1]", '{"files": {}}', "\xff"])
def test_a_damaged_manifest_ships_nothing_and_is_told(content, tmp_path, monkeypatch):
    monkeypatch.setattr("hydrosim.jit.shipped.HOME", tmp_path)
    assert read_manifest() == {}
    (tmp_path / MANIFEST).write_text(content, encoding="latin-1")
    with pytest.warns(UserWarning, match=r"manifest\.json is damaged"):
        assert read_manifest() == {}


def test_a_folder_in_use_and_a_case_that_is_not_there_ship_nothing(tmp_path, capfd):
    with pytest.raises(SystemExit, match="is not an empty folder"):
        ship(tmp_path.parent, [])
    with pytest.raises(SystemExit) as end:
        ship(tmp_path / "kernels", [str(tmp_path / "none.yaml")])
    assert end.value.code == 2
    assert "none.yaml" in capfd.readouterr().err
    assert not (tmp_path / "kernels").exists()


def test_a_wheel_is_not_built_with_a_folder_that_has_no_kernels(tmp_path, monkeypatch):
    pytest.importorskip("hatchling", reason="hatchling is not installed (pip install .[dev])")
    monkeypatch.setenv("HYDROSIM_SHIPPED", str(tmp_path))
    hook = run_path(str(ROOT / "hatch_build.py"))["Included"]
    built: dict[str, Any] = {"force_include": {}}
    with pytest.raises(SystemExit, match=r"found no manifest\.json"):
        hook.initialize(None, "standard", built)
    (tmp_path / MANIFEST).touch()
    hook.initialize(None, "standard", built)
    assert built["force_include"][str(tmp_path)] == "hydrosim/jit/shipped"
    cases = [target for source, target in built["force_include"].items() if source != str(tmp_path)]
    assert "hydrosim/examples/cases/reverse_float_over/base.yaml" in cases
    assert not [target for target in cases if "thesis" in target or target.endswith(".py")]


def motions(
    package: Path, case: str, folder: Path, cache: str | None = "new"
) -> tuple[xr.Dataset, int, str]:
    """Motions of a case in this folder's package, kernels compiled, warnings; with a ``cache``."""
    place = {"PYTHONPATH": str(package)}
    if cache is not None:
        place["HYDROSIM_CACHE_DIR"] = str(folder / cache)
    file = folder / "motions.nc"
    path = str(ROOT / "cases" / f"{case}.yaml")
    done = command("-c", PROGRAM, path, str(file), cwd=folder, **place)
    home, compiles = done.stdout.split()
    assert Path(home).is_relative_to(package)
    return xr.load_dataset(file, engine="netcdf4"), int(compiles), done.stderr


def largest_change(one: xr.Dataset, other: xr.Dataset) -> float:
    """Of positions and velocities, in terms of the range of each."""
    changes = []
    for name in one.data_vars:
        a, b = (each[name].values.reshape(each.time.size, -1) for each in (one, other))
        size = np.ptp(b, axis=0)
        moving = size > 0.0
        changes.append((np.abs(a - b).max(axis=0)[moving] / size[moving]).max(initial=0.0))
    return float(max(changes))


def command(
    *arguments: str, cwd: Path = ROOT, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run a module of Python, or a program after ``-c``."""
    module = [] if arguments[0] == "-c" else ["-m"]
    words, env = [sys.executable, *module, *arguments], {**os.environ, **environment}
    done = subprocess.run(words, env=env, cwd=cwd, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done
