"""What `import hydrosim as hs` shows of itself."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import hydrosim as hs

CASE = Path(__file__).parents[1] / "cases" / "reverse_float_over" / "base.yaml"
SLOW = {"numba", "llvmlite", "scipy", "xarray", "pandas", "netCDF4", "h5py", "matplotlib"}


def test_names_are_listed_and_there() -> None:
    assert set(hs.__all__) < set(dir(hs))
    assert all(getattr(hs, name) is not None for name in dir(hs))
    assert hs.__version__.split(".")[0].isdigit()


def test_a_case_is_loaded_without_compilers_and_libraries_of_files() -> None:
    """They take longer to load than all else together, and who reads a case needs none of them."""
    hs.load_case(CASE)  # keeps the factors of its units, which pint tells
    assert loaded_after("from hydrosim import load_case; load_case({case!r})") == set()


def loaded_after(program: str) -> set[str]:
    """Those of the ``SLOW`` packages that a new process has loaded after a program."""
    told = f"import sys; print(*{{name.split('.')[0] for name in sys.modules}} & {SLOW})"
    text = f"{program.format(case=str(CASE))}; {told}"
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    return set(done.stdout.split())
