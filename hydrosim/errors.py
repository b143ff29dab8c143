"""What hydrosim raises at people."""

from __future__ import annotations


class HydrosimError(Exception):
    """Base of all errors with a message meant for the user; ``exit_code`` is the command's."""

    exit_code = 2


class InputError(HydrosimError):
    """Wrong input: the message names the file, the key or line, what was found, what was expected
    and what to do."""

    exit_code = 2


class SimulationError(HydrosimError):
    """A run that cannot go on: the message says when, which body or element, and what to try."""

    exit_code = 3
