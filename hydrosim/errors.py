"""Exceptions with messages for the user."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from shutil import disk_usage
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr


LONG_WORD = re.compile(r"([^\s;:,]{300})[^\s;:,]{700,}")


class HydrosimError(Exception):
    """Base of all errors with a message for the user; ``exit_code`` is the exit code of the
    command. Names and paths of a thousand characters are cut."""

    exit_code = 2

    def __init__(self, message: str) -> None:
        super().__init__(LONG_WORD.sub(r"\1...", message))


class InputError(HydrosimError):
    """Wrong input. The message names the file, the key or line, the value found, the value
    expected, and the remedy."""

    exit_code = 2


class SimulationError(HydrosimError):
    """A run that cannot continue. The message names the time, the body or element, and the remedy;
    ``dataset`` holds the results until then, which ``to_xarray`` makes of ``run_data``."""

    exit_code = 3

    def __init__(
        self, message: str, run_data: xr.Dataset, to_xarray: Callable[[xr.Dataset], xr.Dataset]
    ) -> None:
        super().__init__(message)
        self.run_data = run_data
        self._to_xarray = to_xarray

    @property
    def dataset(self) -> xr.Dataset:
        """The results until then."""
        return self._to_xarray(self.run_data)


class WritingError(HydrosimError):
    """A file that cannot be written, for example on a full disk. An earlier file of that name is
    unchanged."""

    exit_code = 3


def unwritable(path: Path, error: Exception) -> WritingError:
    """Error for a file that cannot be written, with the reason and the free space of its disk."""
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    if isinstance(error, PermissionError) and os.access(path.parent, os.W_OK):
        text = "it cannot be made"  # netCDF reports missing permission also on a full disk
    with suppress(OSError):
        text += f"; {disk_usage(path.parent).free / 1e6:,.1f} MB are free there"
    return WritingError(
        f"{path}: cannot be written ({text}). Free some space, or write to another place. An"
        " earlier file of that name is unchanged."
    )
