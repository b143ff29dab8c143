"""What hydrosim raises at people."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr


class HydrosimError(Exception):
    """Base of all errors with a message meant for the user; ``exit_code`` is the command's."""

    exit_code = 2


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
