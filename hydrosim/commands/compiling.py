"""Message that kernels are being compiled, which makes a first run longer."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console


@contextmanager
def announce_compiling(err: Console) -> Iterator[None]:
    """Print a message when the first kernel is compiled within this context."""
    from hydrosim.cache import cache_folder
    from hydrosim.jit.kernels import kernel_folder  # loads numba
    from hydrosim.jit.waiting import at_first_compile

    def say() -> None:
        folder = cache_folder(kernel_folder())
        what = "compiling kernels, once for this version (up to half a minute)"
        err.print(f"{what}; they are stored in {folder}", highlight=False, soft_wrap=True)

    with at_first_compile(say):
        yield
