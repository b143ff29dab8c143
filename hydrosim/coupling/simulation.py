"""`Simulation`: a run that its caller advances step by step."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from math import inf, isfinite
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from hydrosim.elements import externals_of
from hydrosim.elements.external import BodyState, body_states, read_only
from hydrosim.errors import InputError
from hydrosim.files.outputs import Output, as_output
from hydrosim.integrate.dynamics import new_work, rhs
from hydrosim.integrate.loop import grid_time
from hydrosim.integrate.names import force_names
from hydrosim.integrate.state import GRID_POINT, rounding_at
from hydrosim.jit.waiting import Torn
from hydrosim.multibody.kinematics import place_bodies
from hydrosim.multibody.tree import record_angles
from hydrosim.results.run_data import as_xarray
from hydrosim.run.checkpoint import Checkpoint, CheckpointWriter
from hydrosim.run.course import RunInProgress
from hydrosim.run.error_estimate import estimate_error
from hydrosim.scene import ForceElement, LinearScenes, Scene
from hydrosim.simulation import can_measure_error, compiled_to_run, prepare_scene, with_forces

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.case import Case


class Simulation:
    """A run of a case, a file or a scene, which its caller advances.

    It begins at the start of the case; ``forces`` are added to those of the case, as in `simulate`.
    Steps are those of `simulate`: after `step` to times on the grid of steps, `result` equals its
    dataset to the bit. A linear scene is stepped too; `simulate` does so with ``solver.linear:
    step``.

    With the file of a ``checkpoint`` that `save` has written, it goes on from there, to the bit.

    One thread at a time may use it, and no function of its own forces: anything else is refused
    with InputError. It cannot be copied.
    """

    def __init__(
        self,
        case: Case | Scene | str | Path,
        forces: Mapping[str, ForceElement] | None = None,
        checkpoint: str | Path | None = None,
    ) -> None:
        scene = with_forces(prepare_scene(case), forces or {})
        compiled = compiled_to_run(scene)
        if compiled.derived.exact:
            stepped = replace(scene.solver, linear=LinearScenes.STEP)
            compiled = compiled_to_run(replace(scene, solver=stepped))
        earlier = _continued_from(Path(checkpoint)) if checkpoint is not None else None
        self._course = RunInProgress(compiled, earlier)
        self._work = new_work(self._course.run.model)
        self._torn = False
        self._using = Lock()
        self._check()

    @property
    def time(self) -> float:
        """Time [s] that the run has reached."""
        return self._course.time

    @property
    def end(self) -> float:
        """Time [s] of the end of the run."""
        return float(self._course.run.clock.end)

    @property
    def ended(self) -> bool:
        """Whether the run has reached its end."""
        return self._course.has_ended

    def step(self, until: float | None = None) -> float:
        """Advance to the time ``until`` [s]; returns the time reached.

        Without ``until``, this is one step: to the next point of the grid of ``solver.step``, or
        one step of an adaptive method. A time between two points of the grid is met exactly. The
        step is cut there and its rest follows, so later numbers differ from those of an uncut run
        by the error of the method. The grid of an adaptive method is that of the output times.

        Raises InputError for a time that has passed or is beyond the end, and SimulationError as
        `simulate` does.
        """
        with self._exclusive_use("step"):
            self._step(until)
            return self.time

    def _step(self, until: float | None) -> None:
        """`step` for the only user."""
        self._check()
        course = self._course
        if course.has_ended:
            raise InputError(f"step: the run is at its end, {self.end:g} s; nothing is left to do.")
        try:
            if until is None and course.compiled.method.adapts:
                course.take_step()
            else:
                until = self._next_grid_time() if until is None else self._target(until)
                for _ in course.chunks(until):
                    pass
        except Torn:
            self._torn = True
            raise
        if course.has_failed:
            course.data(last=False)  # raises

    def run(self) -> xr.Dataset:
        """Advance to the end; returns the dataset."""
        if not self.ended:
            self.step(self.end)
        return self.result()

    def result(self) -> xr.Dataset:
        """The dataset of the run until now, as `simulate` returns it. Before the end, its status is
        "interrupted", and it ends with the last output time. At the end, a companion run
        measures the error."""
        with self._exclusive_use("result"):
            self._check()
            course = self._course
            measured = self.ended and can_measure_error(course)
            estimate = estimate_error(course.compiled, course.run) if measured else None
            return as_xarray(course.data(estimate, last=False))

    def save(self, path: str | Path) -> Path:
        """Write a checkpoint, from which `Simulation` goes on; returns its path. An earlier
        checkpoint there is replaced. Raises InputError if another file is there, or if a function
        may remember and gives no state, and WritingError if it cannot be written."""
        with self._exclusive_use("save"):
            return self._save(path)

    def _save(self, path: str | Path) -> Path:
        """`save` for the only user."""
        self._check()
        course = self._course
        scene = course.compiled.scene
        once = [name for name, e in externals_of(scene.forces).items() if not e.restarts]
        if once:
            raise InputError(
                f"forces.{', '.join(once)}: the function is called once per step and may remember,"
                " so a checkpoint is not enough to go on. Give it methods get_state and set_state,"
                " or say UserForce(..., repeatable=True) if it depends on its arguments alone."
            )
        output = as_output(path, "checkpoint")
        CheckpointWriter(Checkpoint(output), course.compiled, course.run).write()
        return output.path

    @property
    def state(self) -> Mapping[str, BodyState]:
        """The motion of every body, by name."""
        with self._exclusive_use("state"):
            run = self._course.run
            bodies = run.model.bodies
            n = bodies.active.size
            motion = self._work.motion
            place_bodies(run.state.y[:n], run.state.y[n : 2 * n], bodies, motion)
            coordinates = motion.coordinates.copy()
            record_angles(bodies, motion, coordinates)
            names = [body.name for body in self._course.compiled.scene.bodies]
            references = [read_only(origin) for origin in bodies.each["origin"]]
            turned = motion.rotation.reshape(-1)
            return body_states(
                names, references, coordinates, motion.velocity, turned, bool(bodies.exact)
            )

    @property
    def forces(self) -> dict[str, dict[str, np.ndarray]]:
        """Wrench (6,) [N, N m] of every force on every body, by the names of both: in the earth
        frame, about the centre of gravity. The names are those of ``force_...`` in the dataset."""
        with self._exclusive_use("forces"):
            course = self._course
            run = course.run
            work = self._work
            rates = np.zeros(run.model.size)
            state = run.state
            rhs(self.time, state.y, state.modes, state.history, run.model, work, rates)
            wrench = work.wrench.reshape(run.model.rows, -1, 6)
            bodies = [body.name for body in course.compiled.scene.bodies]
            return {
                name: dict(zip(bodies, wrench[row].copy(), strict=True))
                for row, name in enumerate(force_names(course.compiled.scene))
            }

    def __reduce_ex__(self, _: object) -> NoReturn:
        raise InputError(
            "Simulation: it cannot be copied or pickled, because its kernels know the place of its"
            " numbers in memory. Write a checkpoint with save, and begin others from it:"
            " Simulation(case, checkpoint=path)."
        )

    @contextmanager
    def _exclusive_use(self, action: str) -> Iterator[None]:
        """A context for an ``action`` of one user. Raises InputError if there is another."""
        if not self._using.acquire(blocking=False):
            raise InputError(
                f"{action}: the simulation is in use, by another thread or by the function of a"
                " force that it calls; expected one user at a time. Threads share a lock of their"
                " own around it; a function is given time and motions as arguments."
            )
        try:
            yield
        finally:
            self._using.release()

    def _check(self) -> None:
        """Raises SimulationError if the run cannot continue."""
        if self._torn:
            raise InputError(
                "step: an interrupt came within a step, which is not finished; expected a whole"
                " step. Begin anew, or go on from a checkpoint."
            )
        if self._course.has_failed:
            self._course.data(last=False)

    def _next_grid_time(self) -> float:
        """The next point of the grid."""
        run = self._course.run
        return float(grid_time(int(run.counters[GRID_POINT]) + 1, run.clock))

    def _target(self, until: float) -> float:
        """The time ``until``, exactly on the grid or at a breakpoint if it is there but for
        rounding."""
        until = float(until)
        clock = self._course.run.clock
        close = float(rounding_at(np.array(until), clock))
        if not (isfinite(until) and self.time < until <= self.end + close):
            raise InputError(
                f"step: found until = {until:g} s; expected a time after {self.time:g} s, which is"
                f" reached, and at most {self.end:g} s, the end of the run."
            )
        first = round((until - clock.start) / clock.step) - clock.first
        for n in (first - 1, first, first + 1):
            if n <= clock.points and abs(grid_time(n, clock) - until) <= close:
                return float(grid_time(n, clock))
        near = clock.breakpoints[np.abs(clock.breakpoints - until) <= close]
        return float(near[0]) if near.size else until


def _continued_from(path: Path) -> Checkpoint:
    """Settings to go on from a checkpoint, and to write none by oneself."""
    if not path.is_file():
        raise InputError(f"checkpoint: there is no file {path}; expected one that `save` wrote.")
    return Checkpoint(Output(path, "checkpoint", path), every=inf, resume=True)
