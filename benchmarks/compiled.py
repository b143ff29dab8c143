"""Scenes that are compiled once and run several times, with as many radiation states as wanted."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hydrosim import compile_scene
from hydrosim.compiling.compiled import Compiled
from hydrosim.forces import IndexedConstants, assign_indices
from hydrosim.radiation import StateSpace, state_space_model
from hydrosim.scene import Scene
from hydrosim.stepping.dynamics import Model
from hydrosim.stepping.state_layout import state_layout


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
    known = given.compiled.facts
    facts = replace(known, model=model, layout=state_layout(given.scene, model, known.met))
    return Several(replace(given.compiled, facts=facts, state=state), tuple(fits))


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
