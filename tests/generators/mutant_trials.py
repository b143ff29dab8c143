"""What becomes of a mutant of the shipped cases? A message or a run: no traceback, and nothing that
is not finite."""

import io
import shutil
import warnings
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path
from traceback import format_exc
from typing import NamedTuple

import numpy as np
import xarray as xr

from hydrosim.__main__ import app
from hydrosim.errors import HydrosimError
from hydrosim.results.phases import FIGURES, STAGE_TIME
from tests.generators.mutants import CASES, SHORT, Mutant, text_of

WORDY = 3000  # characters of a message: more is not read
TOUCHES = ("fender_closings", "fender_closing_speed", "fender_largest_force")
MAY_LACK = {"slow_draught", *TOUCHES, STAGE_TIME, *FIGURES}
"""Variables that are not a number for bodies, contacts and stages that have none of it."""
Asked = tuple[str, Mutant, str]
"""check or run, of a mutant, in a copy of the cases."""


class Outcome(NamedTuple):
    """How it ended: "complete", "failed", "refused" or "crash"; and what was said."""

    status: str
    message: str = ""


def prepare(folder: Path) -> None:
    """A copy of the cases in a ``folder``, with what they need."""
    big = shutil.ignore_patterns("*.nc", "*.png", "thesis")
    shutil.copytree(CASES, folder / "cases", ignore=big)
    (folder / "hydro_db").symlink_to(CASES.parent / "hydro_db")


def tried(asked: Asked) -> Outcome:
    """Check or run a mutant."""
    command, mutant, folder = asked
    path = Path(folder, "cases", mutant.case).with_name("mutant.yaml")
    result = path.with_suffix(".nc")
    path.write_text(text_of(mutant, SHORT if command == "run" else None))
    result.unlink(missing_ok=True)
    more = ["-o", str(result), "--set", "solver.unstable=warn"] if command == "run" else []
    try:
        with warnings.catch_warnings(), _quiet():
            warnings.simplefilter("ignore")
            app([command, str(path), *more], standalone_mode=False)
    except HydrosimError as error:
        return said("failed" if error.exit_code == 3 else "refused", str(error))
    except Exception:
        return Outcome("crash", format_exc(limit=-6))
    return _judged(result) if command == "run" else Outcome("complete")


@cache
def _room() -> io.StringIO:
    return io.StringIO()


class _quiet:
    """Prints to nowhere, as to a terminal of a user."""

    def __enter__(self) -> None:
        self._both = redirect_stdout(_room()), redirect_stderr(_room())
        for each in self._both:
            each.__enter__()

    def __exit__(self, *error: object) -> None:
        for each in self._both:
            each.__exit__(*error)  # type: ignore[arg-type]


def said(status: str, message: str) -> Outcome:
    """A message is for people."""
    if len(message) > WORDY or any(ord(c) < 32 and c not in "\n\t" for c in message):
        return Outcome("crash", f"a message of {len(message)} characters: {message[:500]!r}")
    return Outcome(status, message)


def _wild(name: str, values: np.ndarray) -> bool:
    """Whether there is what is not finite; not a number may be what does not apply."""
    return bool(np.isinf(values).any() if name in MAY_LACK else not np.isfinite(values).all())


def _judged(result: Path) -> Outcome:
    run = xr.load_dataset(result, engine="netcdf4")
    wild = [str(n) for n, x in run.items() if x.dtype.kind == "f" and _wild(str(n), x.values)]
    if wild:
        return Outcome("crash", f"not finite, and {run.attrs['status']}: {', '.join(wild)}")
    return Outcome(str(run.attrs["status"]))
