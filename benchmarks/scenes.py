"""The base case and the sphere in the variants that the benchmarks need, and scenes that are
compiled once and run several times, with as many radiation states as wanted."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from benchmarks.report import ROOT
from hydrosim import compile_scene, load_case, load_database
from hydrosim.compile.compiled import Compiled
from hydrosim.elements import Fender, IndexedConstants, NormalCurve, StickSlip, assign_indices
from hydrosim.integrate.dynamics import Model
from hydrosim.integrate.names import state_layout
from hydrosim.scene import (
    Kinematics,
    LinearScenes,
    Method,
    Radiation,
    Scene,
    StateSpaceRadiation,
    Unstable,
)
from hydrosim.water.radiation import StateSpace, state_space_model

SHORT = 700.0  # s: the first contact, at 534 s, and a few dozen events after it
RECORDED = 0.4  # s
FINEST = RECORDED / 128  # s: the step of the reference


@lru_cache
def base_case() -> Scene:
    """The base case, its database read once for all."""
    return with_database_read(ROOT / "cases" / "reverse_float_over" / "base.yaml")


def with_database_read(case: Path) -> Scene:
    """The scene of a case of one body, its database in memory."""
    scene = load_case(case).scene()
    (body,) = scene.bodies
    assert isinstance(body.hydrodynamics, Path)
    read = replace(body, hydrodynamics=load_database(body.hydrodynamics))
    return replace(scene, bodies=(read,))


def short_case(step: float, method: Method = Method.RK4, events: bool = True) -> Scene:
    """The base case until `SHORT`, recorded every `RECORDED`, with this solver, stable or not."""
    settings: dict[str, Any] = {
        "step": step,
        "method": method,
        "events": events,
        "unstable": Unstable.WARN,
    }
    solver = replace(base_case().solver, **settings)
    return replace(base_case(), duration=SHORT, solver=solver).with_output(step=RECORDED)


def free_barge() -> Scene:
    """The moored barge in its sea, without lift and fenders, stepped."""
    scene = base_case()
    solver = replace(scene.solver, linear=LinearScenes.STEP)
    return replace(scene, forces={"mooring": scene.forces["mooring"]}, solver=solver)


def with_fenders(count: int) -> Scene:
    """The base case with ``count`` fenders, a square number, over the area of its four; together
    they are as stiff, and hold as much."""
    scene, side = base_case(), np.linspace(-20.0, 20.0, round(count**0.5))
    fender, share = scene.forces["interface"], 4.0 / count
    assert isinstance(fender, Fender)
    assert isinstance(fender.normal, NormalCurve)
    assert isinstance(fender.friction, StickSlip)
    x, y = np.meshgrid(side, side)
    law = fender.friction
    spread = replace(
        fender,
        points=np.column_stack([x.ravel(), y.ravel(), np.full(count, fender.points[0, 2])]),
        normal=replace(fender.normal, force=share * fender.normal.force),
        friction=replace(
            law,
            stiffness=share * law.stiffness,
            damping=share * law.damping,
            slip_damping=share * law.slip_damping,
        ),
    )
    return replace(scene, forces={**scene.forces, "interface": spread})


def barges(count: int) -> Scene:
    """``count`` moored barges 500 m apart, which do not feel each other."""
    scene = free_barge()
    (barge,), mooring = scene.bodies, scene.forces["mooring"]
    names = [f"barge {k + 1}" for k in range(count)]
    return replace(
        scene,
        bodies=tuple(
            replace(barge, name=name, location=(0.0, 500.0 * k)) for k, name in enumerate(names)
        ),
        forces={f"mooring of {name}": replace(mooring, body=name) for name in names},
    )


def motions(run: xr.Dataset) -> np.ndarray:
    """Displacements and angles (nt, 6) of the one body."""
    return run.position.isel(body=0).values


def touches(run: xr.Dataset) -> np.ndarray:
    """True (nt,) from the first record with contact on."""
    return np.logical_or.accumulate((run.fender_mode > 0).any("fender").values)


STATES = StateSpaceRadiation(tolerance=2e-4)
"""42 states; more exact fits have poles too fast for steps of 0.1 s."""


@lru_cache
def irregular() -> Scene:
    """`cases/sphere/irregular.yaml`, its database read once for all."""
    return with_database_read(ROOT / "cases" / "sphere" / "irregular.yaml")


def sphere(
    duration: float,
    radiation: Radiation = STATES,
    kinematics: Kinematics = Kinematics.EXACT,
    output_step: float = 0.5,
    **solver: Any,
) -> Scene:
    """The sphere for ``duration`` [s], stepped even where the scene is linear; ``solver`` are other
    settings of it."""
    scene = irregular()
    usual = {"linear": LinearScenes.STEP, "unstable": Unstable.WARN}
    return replace(
        scene,
        duration=duration,
        bodies=(replace(scene.bodies[0], radiation=radiation),),
        solver=replace(scene.solver, kinematics=kinematics, **{**usual, **solver}),
    ).with_output(step=output_step)


class Several(NamedTuple):
    """A scene as `compile_scene` makes it; ``fits`` are the radiation's of all bodies."""

    compiled: Compiled
    fits: tuple[StateSpace, ...]

    @property
    def scene(self) -> Scene:
        """What is simulated."""
        return self.compiled.scene

    @property
    def model(self) -> Model:
        """Its constants."""
        return self.compiled.model


def compiled(scene: Scene, in_plane: bool = False) -> Several:
    """The scene as it is, or in its plane if it is symmetric, as `simulate` has it."""
    found = compile_scene(scene, in_plane)
    fits = [fit.on_dofs(wet.dofs[fit.dofs]) for wet in found.wet for fit in wet.fits]
    return Several(found, tuple(fits))


def with_states(given: Several, total: int) -> Several:
    """The same motions by ``total`` radiation states, or one less: each is there several times,
    with a part of the force. For scenes without fenders."""
    share = total / sum(fit.order for fit in given.fits)
    *others, last = given.fits
    fits = [_split(fit, round((share * fit.order - fit.real) / 2)) for fit in others]
    rest = total - sum(fit.order for fit in fits)
    fits.append(_split(last, (rest - last.real) // 2))
    model, first, at = given.model, given.compiled.state, given.model.radiation
    more = sum(fit.order for fit in fits) - model.states.decay.size
    known = IndexedConstants(model.elements, model.tanks)
    parts = assign_indices(known, given.scene, model.own + more, model.energy + more)
    model = model._replace(
        states=state_space_model(fits),
        elements=parts.elements,
        tanks=parts.tanks,
        own=model.own + more,
        slow=model.slow + more,
        draught=model.draught + more,
        energy=model.energy + more,
        impulse=model.impulse + more,
        size=model.size + more,
    )
    state = first._replace(y=np.insert(first.y, at, np.zeros(more)))
    known = given.compiled.derived
    derived = replace(known, model=model, layout=state_layout(given.scene, model, known.met))
    return Several(replace(given.compiled, derived=derived, state=state), tuple(fits))


def _split(fit: StateSpace, pairs: int) -> StateSpace:
    """The fit with this number of pairs of poles, at least its own."""
    real, own = fit.real, fit.decay.size - fit.real
    edges = np.linspace(0.0, max(pairs, own), own + 1).round()
    copies = np.diff(edges).astype(int)
    pick = np.repeat(np.arange(own), copies)
    part = np.concatenate([np.ones(real), *[1.0 / np.sqrt(copies[pick])] * 2])
    rows = np.concatenate([np.arange(real), real + pick, real + own + pick])
    poles = np.concatenate([np.arange(real), real + pick])
    return replace(
        fit,
        decay=fit.decay[poles],
        frequency=fit.frequency[poles],
        B=fit.B[rows] * part[:, None],
        C=fit.C[:, rows] * part,
    )
