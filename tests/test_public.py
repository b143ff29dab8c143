"""What `import hydrosim as hs` shows of itself."""

from importlib import import_module
from inspect import signature
from pathlib import Path

import pytest
from command_line import printed

import hydrosim as hs

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
