"""What `import hydrosim as hs` shows of itself."""

from __future__ import annotations

from pathlib import Path

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


def test_a_run_loads_no_statistics_and_no_pictures(tmp_path: Path) -> None:
    """scipy loads its parts when they are used: criteria and comparisons need them, a run does
    not."""
    output = tmp_path / "run.nc"
    arguments = f"['hydrosim', 'run', {{case!r}}, '-o', {str(output)!r}, '--set', 'duration=1']"
    program = f"import sys; sys.argv = {arguments}\n{RUN}"
    loaded = loaded_after(program, UNUSED)
    assert output.is_file()
    assert loaded == set()


def loaded_after(program: str, wanted: set[str] = SLOW) -> set[str]:
    """Those of the ``wanted`` packages that a new process has loaded after a program."""
    told = f"import sys; print(*set(sys.modules) & {wanted})"
    text = f"{program.format(case=str(CASE))}\n{told}"
    return set(printed(text).split("\n")[-2].split())
