"""Functions of all commands that run a case: earlier stages and progress."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import TYPE_CHECKING

import typer

from hydrosim.commands.compiling import announce_compiling
from hydrosim.commands.progress import progress
from hydrosim.commands.terminal import print_status, progress_console

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.case import Case
    from hydrosim.outputs import Output

err = progress_console()


@contextmanager
def print_resume_hint(by: str) -> Iterator[None]:
    """After an interrupt, print that the command continues with the option ``by``."""
    try:
        yield
    except KeyboardInterrupt:
        print_status(f"interrupted: completed work is kept; {by} continues")
        raise typer.Exit(130) from None


def case_summary_line(case: Case) -> str:
    """What is about to be simulated, in one line."""
    data = case.data
    counted = [_count_text(len(data.bodies), "body", "bodies")]
    counted.append(_count_text(len(data.forces), "force element", "force elements"))
    seas = "waves" if data.water.waves else "no waves"
    lasts = f"{data.duration:g} s by {data.solver.method}"
    return f"case      {data.title}: {', '.join([*counted, seas, lasts])}"


def _count_text(number: int, one: str, several: str) -> str:
    return f"{number} {one if number == 1 else several}"


def run_earlier_stages(case: Case, run: Callable[[Case, Output], xr.Dataset]) -> None:
    """Run the other cases that the case needs, and print their names."""
    from hydrosim.studies.run.stages import complete_stages as made

    made(case, run, lambda text: print_status(f"first stage: {text}"))


def simulate_with_progress(
    case: Case, result: Output, resume: bool = False, every: float = 60.0
) -> xr.Dataset:
    """Simulate a case with a progress bar. Its state is saved to disk ``every`` so often [s]."""
    from hydrosim.compiling.restart import open_start, start_time
    from hydrosim.studies.run.checkpoint import Checkpoint, checkpoint_of
    from hydrosim.studies.run.simulation import simulate

    kept = Checkpoint(checkpoint_of(result), every, resume, print_status)
    scene = open_start(case.scene())
    start = start_time(scene)
    begun = perf_counter()
    reached = start
    with announce_compiling(err), progress("simulating", "s") as report:

        def tell(time: float, steps: int) -> None:
            nonlocal reached
            speed = f"{steps / max(perf_counter() - begun, 1e-3):,.0f} steps/s"
            done = "measuring its error" if time == reached else speed
            report(time - start, scene.duration, done)
            reached = time

        return simulate(scene, tell, kept)
