"""Does a random scene turn as a whole, go on from a state on the way, and keep its energy?

A `Maker` draws a case from a number, and turns it about the vertical if it can. The scene is run
again turned, and from a state on the way: with a fixed step it must go on to the bit. Whether a run
is right is for `references` to say.
"""

import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from math import cos, sin
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from traceback import format_exc
from typing import NamedTuple

import numpy as np
import xarray as xr

import hydrosim as hs
from hydrosim.errors import HydrosimError, InputError
from hydrosim.scene import Kinematics, Scene, Start
from tests.generators.random_cases import Case, text_of

OPEN = 1e-4  # of the exchanged energy: what an unwarned run may have lost
WITHIN = 1e-3  # of the range of a motion: what agrees
LEAST = 1e-6  # m or rad: a smaller range is none
TURN = 0.7  # rad
TURNED = 1e-7  # of the range of a point, with a fixed step: rounding that grows

Maker = Callable[..., Case]
"""Draws the case of a number, if asked so turned by an angle [rad]."""


class Trial(NamedTuple):
    """How a run ended, what was said, and what was wrong with it; its CPU time [s], evaluations and
    events; how far the turned scene is from it, and the limit of that."""

    status: str
    said: str = ""
    wrong: tuple[str, ...] = ()
    cpu: float = 0.0
    evaluations: int = 0
    events: int = 0
    turned: float = float("nan")
    turns_within: float = WITHIN


def scene_of(case_of: Maker, number: int, turn: float = 0.0) -> Scene:
    """The scene of a case, by way of its file."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "case.yaml")
        path.write_text(text_of(case_of(number, turn) if turn else case_of(number)))
        return hs.load_case(path).scene()


def tried(case_of: Maker, number: int, turns: bool = True) -> Trial:
    """Run a case, and what must not matter; what ``case_of`` cannot turn is not turned."""
    begin = process_time()
    try:
        scene = scene_of(case_of, number)
        run = _run(scene.with_output(states=True))
    except InputError as error:
        return Trial("refused", str(error))
    except HydrosimError as error:
        return Trial("failed", str(error), cpu=process_time() - begin)
    except Exception:
        return Trial("crash", format_exc(limit=-4))
    cpu = process_time() - begin
    status = str(run.attrs["status"])
    warned = str(run.attrs.get("warnings") or "")
    work = [int(run.attrs[f"solver_{what}"]) for what in ("evaluations", "events")]
    found = Trial(status, warned, tuple(_wrong(run)), cpu, *work)
    if status != "complete":
        return found
    try:
        wrong = [*found.wrong, *_not_continued(number, scene, run)]
        turned = float("nan")
        if turns and scene.solver.kinematics is Kinematics.EXACT:  # small angles know one heading
            turned = distance(_turned_back(_run(scene_of(case_of, number, TURN))), _points(run))
    except Exception:
        return found._replace(status="crash", said=format_exc(limit=-4))
    within = WITHIN if scene.solver.method.adapts else TURNED
    return found._replace(turned=turned, turns_within=within, wrong=tuple(wrong))


def _run(scene: Scene) -> xr.Dataset:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return hs.simulate(scene)


def _is_finite(values: xr.DataArray) -> bool:
    """Whether all is finite but what does not apply, as the draught of a body without a family."""
    applies = ~np.isnan(values).all("time")
    return bool(np.isfinite(values.where(applies, 0.0)).all())


def _wrong(run: xr.Dataset) -> Iterator[str]:
    over_time = (values for values in run.data_vars.values() if "time" in values.dims)
    numbers = (x for x in over_time if x.dtype.kind == "f" and "contact_group" not in x.dims)
    if run.attrs["status"] == "complete" and not all(_is_finite(x) for x in numbers):
        yield "not finite, and complete"
    residual = float(run.attrs["energy_residual_relative"])
    if not run.attrs.get("warnings") and not residual <= OPEN:
        yield f"open ledger, {residual:.1e}, no warning"


def _not_continued(number: int, scene: Scene, run: xr.Dataset) -> Iterator[str]:
    """From a random time on to the bit, with equal steps; a convolution's memory is at the end."""
    if scene.solver.method.adapts or "memory_row" in run.dims:
        return
    first = int(np.random.default_rng(number).integers(1, run.time.size - 1))
    begin = float(run.time[first])
    rest = scene.duration - begin
    after = _run(replace(scene, initial=Start(run, begin), at_rest=False, duration=rest))
    if not np.array_equal(_points(after), _points(run)[first:]):
        apart = distance(_points(after), _points(run)[first:])
        yield f"from {begin:g} s it does not go on to the bit, {apart:.1e} apart"


def _points(run: xr.Dataset) -> np.ndarray:
    """Named points (nt, np, 3), or of a scene without any the centres of its bodies."""
    found = run.position[..., :3] if "point_position" not in run else run.point_position
    return np.asarray(found.values)


def _turned_back(run: xr.Dataset) -> np.ndarray:
    c, s = cos(TURN), sin(TURN)
    return _points(run) @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def distance(ours: np.ndarray, theirs: np.ndarray) -> float:
    """Largest difference of points (nt, np, 3) over the range of the point in ``theirs``."""
    ranges = np.ptp(theirs, axis=0).max(axis=1)
    differences = np.abs(ours - theirs).max(axis=(0, 2))
    return float((differences / np.maximum(ranges, LEAST)).max())


def offences(trial: Trial) -> Iterator[str]:
    """What is wrong with a trial."""
    yield from trial.wrong
    if trial.status in ("crash", "hang"):
        yield trial.status
    if trial.turned > trial.turns_within:
        yield f"turned, {trial.turned:.1e} apart"
