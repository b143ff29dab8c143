"""Where a scene is at rest, under its mean loads and without friction."""

from __future__ import annotations

from dataclasses import replace

from hydrosim.compiling.calm import wave_bodies
from hydrosim.compiling.compile import compile_in_calm
from hydrosim.compiling.compiled import Compiled
from hydrosim.forces import without_friction
from hydrosim.linear.equilibrium import Rest, equilibrium
from hydrosim.scene import Body, Scene, SecondOrder, WaveForces
from hydrosim.waves import following_model, sea, wave_loads_model


def at_rest(scene: Scene | Compiled, time: float = 0.0, mean_drift: bool = False) -> Rest:
    """The place at rest near that of the scene's start, with applied forces as at ``time`` [s].

    ``mean_drift``: with the mean second-order loads of the sea, of bodies that have any. Raises
    InputError if there is none, with the loads that are left.
    """
    compiled = scene if isinstance(scene, Compiled) else compile_in_calm(_until(scene, time))
    scene, seas = compiled.scene, compiled.sea or sea(compiled.scene.environment)
    drifting = wave_bodies(replace(scene, bodies=tuple(map(_drifting, scene.bodies))), compiled.wet)
    steady = [replace(waves, ramp=0.0) for waves in (seas if mean_drift else ())]
    model = compiled.model._replace(
        elements=without_friction(compiled.model.elements),
        waves=wave_loads_model(steady, drifting, time, scene.solver.step / 2, 0.0),
        following=following_model((), ()),
    )
    weight = model.bodies.each["mass"].sum() * scene.environment.gravity
    return equilibrium(model, compiled.state, time, weight)


def _until(scene: Scene, time: float) -> Scene:
    """The scene from its own start, long enough for ``time``."""
    return replace(scene, duration=max(scene.duration, time), initial=None)


def _drifting(body: Body) -> Body:
    """The body with mean second-order loads alone, if it has any."""
    any_order = body.wave_forces.second_order != SecondOrder.NONE
    load = SecondOrder.MEAN_DRIFT if any_order else SecondOrder.NONE
    return replace(body, wave_forces=WaveForces(first_order=False, second_order=load))
