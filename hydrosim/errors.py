"""What hydrosim raises at people."""

from __future__ import annotations

import os
import re
from contextlib import suppress
from pathlib import Path
from shutil import disk_usage
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr


LONG_WORD = re.compile(r"([^\s;:,]{300})[^\s;:,]{700,}")


class HydrosimError(Exception):
    """Base of all errors with a message meant for the user; ``exit_code`` is the command's. Names
    and paths of a thousand characters are cut."""

    exit_code = 2

    def __init__(self, message: str) -> None:
        super().__init__(LONG_WORD.sub(r"\1...", message))


class InputError(HydrosimError):
    """Wrong input: the message names the file, the key or line, what was found, what was expected
    and what to do."""

    exit_code = 2


class SimulationError(HydrosimError):
    """A run that cannot go on: the message says when, which body or element, and what to try;
    ``dataset`` is what was computed until then."""

    exit_code = 3

    def __init__(self, message: str, dataset: xr.Dataset) -> None:
        super().__init__(message)
        self.dataset = dataset


class WritingError(HydrosimError):
    """A file that cannot be written, as on a full disk: what stood there before still stands."""

    exit_code = 3


def unwritable(path: Path, error: Exception) -> WritingError:
    """Says why a file cannot be written, and how much room there is where it is to be."""
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    if isinstance(error, PermissionError) and os.access(path.parent, os.W_OK):
        text = "it cannot be made"  # netCDF says that permission lacks, also on a full disk
    with suppress(OSError):
        text += f"; {disk_usage(path.parent).free / 1e6:,.1f} MB are free there"
    return WritingError(
        f"{path}: cannot be written ({text}). Make room, or write to another place. What was there"
        " before still stands."
    )
