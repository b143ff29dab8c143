"""The course of a run: from its start, chunk by chunk, to its dataset."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import replace
from math import inf, nan
from time import thread_time
from typing import TYPE_CHECKING

from hydrosim.compile.clock import compile_clock
from hydrosim.compile.compiled import Compiled, solution
from hydrosim.elements import function_errors
from hydrosim.errors import SimulationError
from hydrosim.integrate import state
from hydrosim.integrate.loop import advance_until, count_evaluations
from hydrosim.integrate.record import MEMORY_SPACING, new_record, unpack_channels
from hydrosim.jit.refs import StructReference, clear_references
from hydrosim.jit.waiting import Torn, running_time
from hydrosim.results.ledger import ErrorEstimate, add_error_estimate, append_warnings
from hydrosim.results.output import to_dataset
from hydrosim.results.run_data import as_xarray
from hydrosim.run.checkpoint import Checkpoint, CheckpointWriter
from hydrosim.run.failure import failure, find_blow_up
from hydrosim.run.functions import delay_warnings, function_attributes, repeatability_warnings
from hydrosim.run.post_run_checks import validity_warnings
from hydrosim.run.provenance import provenance
from hydrosim.run.step_limits import unresolved_vibration_warnings

if TYPE_CHECKING:
    import xarray as xr


CHUNK_CPU_TIME_S = 0.1  # s of processor time between reports of progress


class RunInProgress:
    """A run of a ``compiled`` scene, which has begun: its first record is made. With ``kept``, it
    continues from a checkpoint and saves others. With ``propagate``, that advances the run, without
    steps (`hydrosim.linear.propagate`)."""

    def __init__(
        self,
        compiled: Compiled,
        checkpoint: Checkpoint | None = None,
        propagate: Callable[[state.Run], Iterator[float]] | None = None,
    ) -> None:
        scene = compiled.scene
        model = compiled.model
        clock = compile_clock(compiled)
        spacing = 1 if scene.output.states else MEMORY_SPACING
        record = new_record(model, clock, scene.output.accelerations, spacing)
        self.compiled = compiled
        self.run = state.new_run(clock, model, compiled.method, compiled.first_state(), record)
        self._held = StructReference(self.run)
        self._evaluations = 1
        self._seen = 0
        self._status = "complete"
        self._torn = False
        stepped = propagate is None  # otherwise computed at once: no checkpoint
        self._keeper = (
            CheckpointWriter(checkpoint, compiled, self.run) if checkpoint and stepped else None
        )
        if self._keeper:
            self._keeper.resume_run()
        self._propagated = propagate(self.run) if propagate else None
        self.time = (
            next(self._propagated) if self._propagated else advance_until(0, inf, self._held)
        )
        self._start = running_time()
        if self._keeper:
            self._keeper.begin()

    @property
    def steps(self) -> int:
        """Number of steps so far."""
        return int(self.run.counters[state.ACCEPTED])

    @property
    def has_failed(self) -> bool:
        """Whether the run cannot continue."""
        return bool(self.run.counters[state.STATUS] != state.IN_PROGRESS)

    @property
    def has_ended(self) -> bool:
        """Whether the run is at its end, or cannot continue."""
        return self.has_failed or int(self.run.counters[state.GRID_POINT]) >= self.run.clock.points

    def chunks(self, until: float = inf) -> Iterator[float]:
        """Advance to the end, or to the time ``until``, in chunks; yields the time reached. The
        last chunk ends at the record at which the run blows up, if it does; later records are
        discarded. Between chunks, the caller may stop; checkpoints are saved when they are due."""
        for time in self._propagated or self._advance_in_chunks(until):
            self.time = time
            self._raise_interrupts()
            self._stop_at_blow_up()
            yield self.time
            if self._keeper:
                self._keeper.save_if_due()
            if self.has_failed:
                return

    def take_step(self) -> None:
        """Advance by one step of an adaptive method."""
        before = self.time
        while self.time == before and not self.has_ended:
            self.time = self._advance(1, inf)
        self._raise_interrupts()
        self._stop_at_blow_up()

    def interrupt(self, reason: KeyboardInterrupt) -> None:
        """End the run early."""
        self._status = "interrupted"
        self._torn = isinstance(reason, Torn)
        if self._keeper and not self._torn:
            self._keeper.save()

    def _advance_in_chunks(self, until: float) -> Iterator[float]:
        """Advance in chunks of about 0.1 s of processor time, so that an interrupt is handled.

        The processor time of this thread counts. Otherwise, a chunk that waits for other processes
        would shorten the next ones, each of which is followed by a test of its records.
        """
        counters = self.run.counters
        while not self.has_ended and self.run.scratch.pace[state.REACHED_TIME] < until:
            begin = thread_time()
            before = int(count_evaluations(counters))
            reached = self._advance(self._evaluations, until)
            spent = int(count_evaluations(counters)) - before
            pace = spent / max(thread_time() - begin, 1e-6)
            self._evaluations = int(min(max(CHUNK_CPU_TIME_S * pace, 1), 100 * self._evaluations))
            yield reached

    def _advance(self, evaluations: int, until: float) -> float:
        """Advance for so many evaluations, or to the time ``until``; returns the time reached. That
        is the time of the run too if an interrupt has waited for it."""
        try:
            return float(advance_until(evaluations, until, self._held))
        except Torn:
            raise
        except KeyboardInterrupt:
            self.time = float(self.run.scratch.pace[state.REACHED_TIME])
            raise

    def _raise_interrupts(self) -> None:
        """Raises an interrupt that came while a function of the user was called: the step is not
        finished. An exception of a signal that came where its call began is lost, and so is the
        call."""
        errors = [error for _, error in function_errors(self.compiled.scene.forces)]
        lost = not errors and self.run.counters[state.STATUS] == state.NO_SAMPLE
        interrupts = [error for error in errors if isinstance(error, KeyboardInterrupt)]
        if lost or interrupts:
            self.run.counters[state.STATUS] = state.IN_PROGRESS
            raise Torn from next(iter(interrupts), None)

    def _stop_at_blow_up(self) -> None:
        """Stop at the record at which the run blows up, if it does."""
        run = self.run
        counters = run.counters
        count = int(counters[state.RECORDS])
        blow_up = find_blow_up(self.compiled.scene, run.model, run.record, self._seen, count)
        self._seen = count
        if blow_up is not None:
            counters[state.RECORDS] = blow_up + 1
            counters[state.STATUS] = state.BLOWN_UP
            self.time = float(
                unpack_channels(run.model, run.record, blow_up + 1, blow_up)["time"][0]
            )

    @property
    def complete(self) -> bool:
        """Whether the run has ended as it should."""
        return self._status == "complete" and not self.has_failed

    def data(self, estimate: ErrorEstimate | None = None, last: bool = True) -> xr.Dataset:
        """The `RunData` of the run until now, with the ``estimate`` of its error. After the
        ``last`` the course is of no use: it lets go of the waves over time. Raises SimulationError
        with the dataset if the run cannot continue."""
        compiled = self.compiled
        run = self.run
        message = failure(compiled, run, self.time) if self.has_failed else None
        status = self._status if last or self.has_ended else "interrupted"
        attributes = self._attributes("failed" if message else status, message, estimate)
        record = run.record
        count = int(run.counters[state.RECORDS])
        history = run.state.history if last else deepcopy(run.state.history)
        compiled = _without_table(compiled)
        if last:
            del run, self.compiled, self.run, self._held, self._keeper, self._propagated
            clear_references()  # with them the table of waves, if no caller holds it
        layout = compiled.derived.layout
        sea = compiled.sea
        scene = compiled.scene
        dataset = to_dataset(scene, compiled.model, layout, sea, record, count, history, attributes)
        append_warnings(dataset, validity_warnings(compiled, dataset))
        if estimate is not None:
            add_error_estimate(dataset, estimate)
        if message:
            errors = (error for _, error in function_errors(scene.forces))
            raise SimulationError(message, dataset, as_xarray) from next(errors, None)
        return dataset

    def _attributes(
        self, status: str, message: str | None, estimate: ErrorEstimate | None
    ) -> dict[str, object]:
        """Attributes of the dataset. Doubts about the step are left out if the ``estimate`` of the
        error shows that they do not matter."""
        compiled = self.compiled
        counters = self.run.counters
        count = int(counters[state.RECORDS])
        warnings = [*compiled.notes.warnings]
        if estimate is None or estimate.warnings:
            warnings += compiled.step_warnings
            warnings += unresolved_vibration_warnings(compiled, self.run.record, count)
        warnings += [] if self.has_failed else repeatability_warnings(compiled, self.run)
        warnings += delay_warnings(compiled, self.run)
        keeper = self._keeper
        return {
            **provenance(compiled),
            # functions are further than the last complete step of a torn run
            **function_attributes(compiled.scene, nan if self._torn else self.time),
            "solver_linear": solution(compiled.scene, compiled.derived),
            "solver_steps": int(counters[state.ACCEPTED]),
            "solver_rejected": int(counters[state.REJECTED]),
            "solver_events": int(counters[state.EVENTS]),
            "solver_evaluations": int(counters[state.EVALUATIONS]),
            "wall_time": keeper.wall_time if keeper else running_time() - self._start,
            "status": status,
            "status_message": message,
            "warnings": "\n".join(warnings) or None,
        }


def _without_table(compiled: Compiled) -> Compiled:
    """Compiled scene without its waves over time. Only steps need them, and of a long run they are
    a third of its record."""
    waves = compiled.model.waves
    model = compiled.model._replace(waves=waves._replace(values=waves.values[:0].copy()))
    return replace(compiled, derived=replace(compiled.derived, model=model))
