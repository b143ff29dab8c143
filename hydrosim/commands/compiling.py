"""What is said before the first run of a version, which takes longer."""

from __future__ import annotations

from rich.console import Console

from hydrosim.kernels import compiled_before, kernel_cache


def announce_compile(err: Console) -> None:
    """Say it if a compile is ahead."""
    if not compiled_before():
        what = "compiling the kernels, once for this version (about a minute), into"
        err.print(f"{what} {kernel_cache()}", highlight=False, soft_wrap=True)
