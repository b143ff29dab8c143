"""What commands share that run a case: the runs it needs first, and progress."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

from hydrosim.commands.compiling import announced
from hydrosim.commands.terminal import progress_console, say

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.case import Case
    from hydrosim.outputs import Output

err = progress_console()


@contextmanager
def resumable(by: str) -> Iterator[None]:
    """Says after an interrupt ``by`` what the command goes on."""
    try:
        yield
    except KeyboardInterrupt:
        say(f"interrupted: what is complete is kept; {by} goes on from there")
        raise typer.Exit(130) from None


def complete(case: Case, run: Callable[[Case, Output], xr.Dataset]) -> None:
    """Make the runs that the case needs, and say so."""
    from hydrosim.studies.run.stages import complete as made

    made(case, run, lambda text: say(f"first stage: {text}"))


def simulate_with_progress(
    case: Case, result: Output, resume: bool = False, every: float = 60.0
) -> xr.Dataset:
    """The run of a case, with a bar of how far it is, kept on the disk ``every`` so often [s]."""
    from rich.progress import (
        BarColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    from hydrosim.compiling.restart import begin, opened
    from hydrosim.studies.run.checkpoint import Checkpoint, checkpoint_of
    from hydrosim.studies.run.simulation import simulate

    kept = Checkpoint(checkpoint_of(result), every, resume, say)
    scene = opened(case.scene())
    start = begin(scene)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.0f}/{task.total:.0f} s"),
        TextColumn("{task.fields[speed]}"),
        *(TimeElapsedColumn(), TimeRemainingColumn()),
    )
    with (
        announced(err),
        Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as bar,
    ):
        task = bar.add_task("simulating", total=scene.duration, speed="")

        def report(time: float, steps: int) -> None:
            elapsed = bar.tasks[task].elapsed or 0.0
            speed = f"{steps / elapsed:,.0f} steps/s" if elapsed > 0.0 else ""
            bar.update(task, completed=time - start, speed=speed)

        return simulate(scene, report, kept)
