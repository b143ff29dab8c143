"""Equilibrium of a scene under its mean loads, without friction."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compiling.compile import Radiation, compile_for_linear
from hydrosim.compiling.compiled import Compiled
from hydrosim.compiling.without_waves import wave_bodies
from hydrosim.errors import InputError
from hydrosim.forces import in_gusts, without_friction
from hydrosim.linear.equilibrium import RESIDUAL_RTOL, Rest, equilibrium
from hydrosim.scene import Body, Place, Scene, SecondOrder, WaveForces
from hydrosim.streams.gusts import NO_GUSTS
from hydrosim.studies.ballast.loading import state_with_contents_at
from hydrosim.waves.build import wave_loads_model
from hydrosim.waves.components import sea
from hydrosim.waves.displaced_loads import following_model
from hydrosim.waves.wave_reference import met_by_waves

if TYPE_CHECKING:
    from hydrosim.stepping.dynamics import Model


def at_rest(
    scene: Scene | Compiled, time: float = 0.0, mean_drift: bool = False, free: bool = False
) -> Rest:
    """Equilibrium near the start of the scene, with applied forces at ``time`` [s].

    ``mean_drift`` includes the mean second-order loads of the sea. Raises InputError with the
    remaining loads if there is no equilibrium. With ``free``, only directions with a stiffness must
    be in equilibrium. The others keep their position, and `Rest.drift` has the loads along them.
    """
    calm = (
        scene
        if isinstance(scene, Compiled)
        else compile_for_linear(scene, Radiation.DATABASE, time)
    )
    elements = in_gusts(without_friction(calm.model.elements), NO_GUSTS)
    model = calm.model._replace(elements=elements, following=following_model((), ()))
    weight = model.bodies.each["mass"].sum() * calm.scene.environment.gravity
    rest = equilibrium(model, state_with_contents_at(calm, time), time, weight)
    if mean_drift:
        model = _in_mean_drift(model, calm, time)
        rest = equilibrium(model, rest.state, time, weight, rest.held)
    if not free and np.abs(rest.drift).max(initial=0.0) > RESIDUAL_RTOL * weight:
        share = np.abs(rest.drift).max() / weight
        raise InputError(
            f"equilibrium at {time:g} s: none found, because loads of {share:.1e} of the weight"
            " act in directions without stiffness. Look for an unbalanced force, or hold the"
            " bodies by a mooring."
        )
    return rest


def _in_mean_drift(model: Model, calm: Compiled, time: float) -> Model:
    """Model with the mean second-order loads of the whole sea."""
    scene = calm.scene
    seas = calm.sea or sea(calm.scene.environment)
    pushed = replace(scene, bodies=tuple(map(_drifting, scene.bodies)))
    databases = calm.facts.databases
    drifting = wave_bodies(pushed, databases, met_by_waves(pushed, databases))
    steady = [replace(waves, ramp=0.0) for waves in seas]
    loads = wave_loads_model(steady, drifting, time, scene.solver.step / 2, 0.0)
    return model._replace(waves=loads)


def _drifting(body: Body) -> Body:
    """Body with mean second-order loads only, if it has any."""
    any_order = body.wave_forces.second_order != SecondOrder.NONE
    load = SecondOrder.MEAN_DRIFT if any_order else SecondOrder.NONE
    drift = WaveForces(False, load, headings=Place.MEAN, position=Place.MEAN)
    return replace(body, wave_forces=drift)
