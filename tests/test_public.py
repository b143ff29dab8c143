"""What `import hydrosim as hs` shows of itself."""

import importlib
from collections.abc import Callable
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from command_line import printed

import hydrosim as hs
from hydrosim.errors import InputError

CASE = Path(__file__).parents[1] / "cases" / "reverse_float_over" / "base.yaml"
SLOW = {"numba", "llvmlite", "scipy", "xarray", "pandas", "netCDF4", "h5py", "matplotlib"}
RUN = """
from contextlib import suppress
from hydrosim.__main__ import main

with suppress(SystemExit):
    main()
"""
UNUSED = {"scipy.stats", "scipy.signal", "scipy.interpolate", "matplotlib"}
"""Of a run without criteria and pictures."""
OF_DATASETS = {"xarray", "pandas", "pint", "pyarrow"}
OF_FILES = {"netCDF4", "h5py", *OF_DATASETS}


def test_names_are_listed_and_there() -> None:
    assert set(hs.__all__) < set(dir(hs))
    assert all(getattr(hs, name) is not None for name in dir(hs))
    assert hs.__version__.split(".")[0].isdigit()


def test_names_of_the_last_version_work() -> None:
    assert getattr(hs, "Figure") is hs.ScalarResult  # noqa: B009
    assert getattr(hs, "WhyResult") is hs.MotionCauseResult  # noqa: B009


@pytest.mark.parametrize(
    ("guess", "words"),
    [
        (lambda: hs.load("run.nc"), "hs.open_run('run.nc') reads a run"),
        (lambda: hs.run("case.yaml"), "hs.simulate(case) runs a case"),
        (lambda: hs.report("run.nc"), "a run has it: run.hydrosim"),
        (lambda: hs.study({"case": "case.yaml"}), "hs.simulate_many(cases)"),  # type: ignore[arg-type]
        (lambda: hs.load_case(CASE).forces, "case.data.forces, and hs.load_case(path, {key: value"),
        (lambda: xr.Dataset().hydrosim.why("surge"), "has no 'why'; it has case, channel, "),
    ],
)
def test_names_of_other_programs_are_told(guess: Callable[[], object], words: str) -> None:
    importlib.import_module("hydrosim.run")
    importlib.import_module("hydrosim.report")
    with pytest.raises((AttributeError, TypeError, InputError)) as refused:
        guess()
    assert words in str(refused.value)


def test_a_case_is_loaded_without_compilers_and_libraries_of_files() -> None:
    """They take longer to load than all else together, and who reads a case needs none of them."""
    hs.load_case(CASE)  # keeps the factors of its units, which pint tells
    assert loaded_after("from hydrosim import load_case; load_case({case!r})") == set()


def test_help_loads_no_numpy() -> None:
    assert loaded_by_command("--help", {"numpy", *SLOW}) == set()


def test_a_check_loads_no_libraries_of_files() -> None:
    """It reads no file but its case if the scene is dry."""
    block = CASE.parents[1] / "friction_block" / "exact.yaml"
    hs.load_case(block)  # keeps the factors of its units, which pint tells
    assert loaded_by_command(f"check {block}", UNUSED | OF_FILES) == set()


@pytest.mark.parametrize("pictures", [False, True])
def test_a_run_loads_no_statistics_and_no_xarray(tmp_path: Path, pictures: bool) -> None:
    """scipy loads its parts when they are used: criteria and comparisons need them, a run does
    not. Its results are written and told, and drawn, without a dataset of xarray."""
    hs.load_case(CASE)
    output = tmp_path / "run.nc"
    command = f"run {CASE} -o {output} --set duration=1" + pictures * " --plot"
    loaded = loaded_by_command(command, UNUSED | OF_DATASETS)
    assert output.is_file()
    assert loaded == ({"matplotlib"} if pictures else set())


def loaded_by_command(arguments: str, wanted: set[str]) -> set[str]:
    """Those of the ``wanted`` packages that a command of the command line has loaded."""
    return loaded_after(f"import sys; sys.argv = {['hydrosim', *arguments.split()]}\n{RUN}", wanted)


def loaded_after(program: str, wanted: set[str] = SLOW) -> set[str]:
    """Those of the ``wanted`` packages that a new process has loaded after a program."""
    told = f"import sys; print(*set(sys.modules) & {wanted})"
    text = f"{program.format(case=str(CASE))}\n{told}"
    return set(printed(text).split("\n")[-2].split())


@pytest.mark.parametrize("take", [hs.check, hs.simulate, hs.analyse])
def test_what_is_no_case_is_said(take: Callable[..., Any]) -> None:
    with pytest.raises(InputError, match=r"found 3 \(int\); expected a case or the path"):
        take(3)


def test_a_scene_in_python_is_analysed_as_its_case(tmp_path: Path) -> None:
    case = hs.load_case(CASE.parents[1] / "sphere" / "decay.yaml")
    assert hs.analyse(case.scene()).dataset.identical(hs.analyse(case).dataset)
    with pytest.raises(InputError, match="output: found a scene"):
        hs.analyse(case.scene(), output=tmp_path / "modes.nc")


def test_functions_show_their_signatures() -> None:
    """Also those that are folders of the package."""
    assert callable(import_module("hydrosim.study"))
    assert "workers" in signature(hs.study).parameters
    assert str(hs.compare.__doc__).startswith("Compare a run")


def test_examples_are_written_from_python(tmp_path: Path) -> None:
    cases = hs.new(tmp_path, example="friction_block")
    assert tmp_path / "cases" / "friction_block" / "exact.yaml" in cases
    with pytest.raises(hs.InputError, match="expected one of chain"):
        hs.new(example="list")
    with pytest.raises(hs.InputError, match="beam, draught: found none; expected a file name"):
        hs.new(tmp_path / "own.yaml", length=100)
