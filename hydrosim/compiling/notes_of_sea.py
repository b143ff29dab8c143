"""Messages on a scene in its sea: skipped parts and warnings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compiling.hydrodynamic_groups import HydrodynamicGroup, each_database
from hydrosim.compiling.joints.closed import describe_dropped, moves_freely
from hydrosim.compiling.notes_of_headings import (
    coarse_headings,
    meetings,
    said_of_current,
    said_of_waves,
)
from hydrosim.compiling.questions.ranges import OUTSIDE_REFUSED, said_of_outside
from hydrosim.compiling.streams.notes_of_streams import said_of_streams
from hydrosim.dofs import DOFS
from hydrosim.forces import signals_of
from hydrosim.forces.signal import Recorded
from hydrosim.presentation.layout import text_of
from hydrosim.presentation.nodes import Value
from hydrosim.presentation.units import Units, units_of
from hydrosim.rigid.free import moving_dofs
from hydrosim.scene import (
    Body,
    DirectionalTable,
    GivenComponents,
    Jonswap,
    OchiHubble,
    RecordedElevation,
    RegularWave,
    Scene,
    SecondOrder,
    SpectrumTable,
    StateSpaceRadiation,
    Tma,
    Torsethaugen,
    WaveTrain,
    WhiteNoise,
)
from hydrosim.scene.trees import arrangement
from hydrosim.stepping.names import dofs_of
from hydrosim.waves import components, shares_outside
from hydrosim.waves.components import WaveComponents
from hydrosim.waves.quadratic import separate_headings
from hydrosim.waves.sea_state import SeaState, energy_outside_band, sea_state

if TYPE_CHECKING:
    from hydrosim.compiling.derived import Facts
    from hydrosim.compiling.notes import Notes
    from hydrosim.database.database import HydroDatabase
    from hydrosim.stepping.dynamics import Model
    from hydrosim.stepping.state import State

Seas = Sequence[WaveComponents]
# fraction of a sea's energy, or of its loads, outside a database's frequencies
OUTSIDE_WARNED = 1e-3
MIN_SPREADING_RAD = 1e-6
"""Spreading below which crests are long: what rounding leaves of it."""
SPECTRUM_NAMES = {
    Jonswap: "JONSWAP",
    Tma: "TMA",
    Torsethaugen: "Torsethaugen",
    OchiHubble: "Ochi-Hubble",
    WhiteNoise: "white noise",
    SpectrumTable: "table",
    DirectionalTable: "table over directions",
    RegularWave: "regular wave",
    GivenComponents: "components",
    RecordedElevation: "recorded elevation",
}


def notes_of_sea(
    scene: Scene,
    wet: Sequence[HydrodynamicGroup],
    facts: Facts,
    state: State,
    seas: Seas,
    notes: Notes,
) -> Notes:
    """The ``notes`` of a scene in calm water, with messages on the scene in its ``seas``, which
    begins in a ``state``."""
    alone = facts.databases
    warnings = [text for group in wet for text in group.cut_lengths]
    warnings.extend(_fit_warnings(wet))
    warnings.extend(_fallback_warnings(wet))
    warnings.extend(text for group in wet for text in group.doubts(seas))
    for body in scene.bodies:
        if body.name in alone and body.dofs:
            warnings.extend(range_warnings(seas, body, alone[body.name]))
            warnings.extend(_heading_warnings(seas, body, alone[body.name]))
    dropped = list(describe_dropped(scene, facts.model, state))
    shared = moves_freely(facts.model)  # otherwise a locked or mirrored direction may hold them
    warnings.extend(dropped if shared else ())
    met = list(meetings(scene, facts, seas))
    warnings.extend(text for each in met for text in coarse_headings(each))
    said = [text for each in met for text in said_of_waves(each)]
    return replace(
        notes,
        skipped=(
            *_skipped_loads(scene, facts.model, alone, seas, notes.zero),
            *(() if shared else dropped),
        ),
        records=(*_records(scene), *_jumps(scene)),
        seas=tuple(_describe_trains(scene, alone)),
        meetings=(*said, *said_of_current(scene, facts.model)),
        streams=tuple(said_of_streams(scene, facts.model)),
        warnings=(*warnings, *notes.warnings),
    )


def _fit_warnings(groups: Sequence[HydrodynamicGroup]) -> Iterator[str]:
    """Warnings about fits that had to exceed their tolerance to be passive."""
    for wet in each_database(groups):
        for fit in wet.fits:
            if fit.report.error > fit.report.tolerance:
                at = f" at {wet.draught:g} m" if wet.draught else ""
                yield (
                    f"radiation of {dofs_of(fit.dofs, wet.names)}{at}: no passive fit is within"
                    f" the tolerance {fit.report.tolerance:g}; the nearest fit has an error of"
                    f" {fit.report.frequency_error:.1e}. Check the database with `hydrosim db"
                    " check`."
                )


def _fallback_warnings(groups: Sequence[HydrodynamicGroup]) -> Iterator[str]:
    """Warnings about memory that was to be in states, and is convolved because no fit is good."""
    for wet in each_database(groups):
        if not isinstance(wet.radiation, StateSpaceRadiation):
            continue
        for dofs, reason in wet.convolved:
            yield (
                f"radiation of {dofs_of(dofs, wet.names)}: found state_space, and no fit that"
                f" serves ({reason}); the memory is computed by convolution. Use radiation:"
                " convolution or automatic if this is meant, or check the database with `hydrosim"
                " db check`."
            )


def range_warnings(seas: Seas, body: Body, db: HydroDatabase) -> Iterator[str]:
    """Warnings about waves outside a database's frequencies whose first-order loads would matter.
    `questions.ranges` asks about larger parts."""
    if seas and body.wave_forces.first_order:
        found = shares_outside(db, seas)
        if OUTSIDE_WARNED < found.share <= OUTSIDE_REFUSED:
            yield (
                f"environment.waves: {said_of_outside(found, body, db)}: these waves have no"
                " first-order loads."
            )


def _heading_warnings(seas: Seas, body: Body, db: HydroDatabase) -> Iterator[str]:
    """Warnings about QTFs without pairs of different headings."""
    second = body.wave_forces.second_order == SecondOrder.QTF or body.wave_forces.sum_frequency
    for waves in seas if second else ():
        if separate_headings(db, waves):
            yield (
                f"{db.source} has QTFs for pairs of waves of one heading only: pairs of waves of"
                f" different headings give {body.name} no second-order load."
            )


def _describe_trains(scene: Scene, wet: Mapping[str, HydroDatabase]) -> Iterator[str]:
    """Height, period and directions of each wave train, and the largest share of its energy for
    which a database has no loads."""
    water = scene.environment
    loaded = [body.name for body in scene.bodies if body.dofs and body.wave_forces.first_order]
    bands = {name: wet[name].frequency[[0, -1]] for name in loaded if name in wet}
    for train in water.waves:
        figures = _figures_of_train(train, sea_state(train, water), units_of(scene.source))
        outside_share = {
            name: energy_outside_band(train, water, *band) for name, band in bands.items()
        }
        text = ", ".join(figures)
        if outside_share:
            name = max(outside_share, key=lambda body: outside_share[body])
            share = outside_share[name]
            text += f"; {share:.2%} of its energy outside the frequencies of {name}"
        yield text


def _figures_of_train(train: WaveTrain, state: SeaState, units: Units) -> Iterator[str]:
    """Name, height, period, heading and spreading of a wave train, in this order."""

    def label_value(label: str, value: float, unit: str, digits: int = 3) -> str:
        return f"{label} {text_of(Value(value, unit, digits), units)}"

    spectrum = train.spectrum
    yield SPECTRUM_NAMES[type(spectrum)]
    if isinstance(spectrum, RegularWave):
        yield label_value("amplitude", spectrum.amplitude, "m")
        yield label_value("period", spectrum.period, "s")
    else:
        yield label_value("Hs", state.significant_height, "m")
    if isinstance(spectrum, WhiteNoise):
        yield f"{spectrum.lowest_frequency:.3g} to {spectrum.highest_frequency:.3g} rad/s"
    elif not isinstance(spectrum, RegularWave) and isfinite(state.peak_period):
        yield label_value("Tp", state.peak_period, "s")
    if isfinite(state.heading):
        yield label_value("goes to", state.heading, "rad")
    else:
        yield "without a mean direction"
    if state.spreading > MIN_SPREADING_RAD:
        yield label_value("spreading", state.spreading, "rad", 2)
    else:
        yield "long-crested"


def _records(scene: Scene) -> Iterator[str]:
    """Notes on left-out parts of recorded elevations, and on the accuracy of splines through
    recorded forces."""
    for train in scene.environment.waves:
        if isinstance(record := train.spectrum, RecordedElevation):
            energy = np.sum(components(train, scene.environment).amplitude ** 2) / 2.0
            left = max(1.0 - energy / (float(record.elevation.var()) or 1.0), 0.0)
            yield (
                f"environment.waves: {record.time.size} recorded elevations, without their mean,"
                f" {record.elevation.mean():.3g} m, and without {left:.1%} of their energy, above"
                f" {record.highest_frequency:g} rad/s"
            )
    for key, signal in signals_of(scene.forces):
        if isinstance(signal, Recorded):
            miss = signal.largest_miss() / max(float(np.ptp(signal.value)), 1e-300)
            yield (
                f"{key}: cubic spline through {signal.time.size} values. A spline through every"
                f" other value misses the rest by up to {miss:.1e} of the range; the error of the"
                " full spline is about a sixteenth of that, if the signal is smooth"
            )


def _jumps(scene: Scene) -> Iterator[str]:
    """Notes on forces that jump at corners of tables."""
    for name, element in scene.forces.items():
        for key, jump in element.jumps():
            if jump > 0.0:
                yield (
                    f"forces.{name}.{key}: its rate jumps at corners of the table, and with damping"
                    f" the tension jumps there by up to {jump:.3g} N. If that is not meant, give a"
                    " recorded series, which is smooth, or no damping"
                )


def _skipped_loads(
    scene: Scene,
    model: Model,
    wet: Mapping[str, HydroDatabase],
    seas: Seas,
    zero: Sequence[str],
) -> Iterator[str]:
    carried = arrangement(scene).children
    for body in scene.bodies:
        left_out = [dof for dof in DOFS if dof not in body.dofs]
        symmetric = [dof for dof in left_out if f"{dof} of {body.name}" in zero]
        locked = [dof for dof in left_out if dof not in symmetric]
        if symmetric:
            yield f"{body.name}: {', '.join(symmetric)} zero by symmetry, not in the state"
        if locked and body.name not in carried:
            text = f"{body.name}: {', '.join(locked)} locked, not in the state"
            # waves load free directions only, and memory is fitted for DOFs that move
            missing = "; forces in these directions exclude waves and the radiation memory"
            yield text + (missing if body.name in wet else "")
        if locked and body.name in carried and body.name in wet:
            missing = f"excludes the radiation memory in {', '.join(locked)}"
            yield f"{body.name}: the load of its joint {missing}"
        if body.name not in wet:
            if body.hydrostatics is None:
                yield f"{body.name}: dry, no hydrostatics, radiation or wave loads"
            else:
                text = "buoyancy of its hull in still water, no waves, drag or added mass"
                yield f"{body.name}: {text}"
        elif seas and body.wave_forces.first_order:
            found = shares_outside(wet[body.name], seas)
            if found.below + found.above > OUTSIDE_WARNED:
                yield (
                    f"{said_of_outside(found, body, wet[body.name])}: these waves have no"
                    " first-order loads"
                )
    owner = np.append(np.arange(len(scene.bodies)), model.family.owner)
    loaded = 6 * owner[model.waves.first_dof // 6] + model.waves.first_dof % 6
    unloaded = [
        f"{scene.bodies[i // 6].name} {DOFS[i % 6]}"
        for i in moving_dofs(model.bodies)
        if scene.bodies[i // 6].name in wet
        and i not in loaded
        and i // 6 not in model.following.body
    ]
    if seas and unloaded:
        yield "no first-order wave loads on: " + ", ".join(unloaded)
    if not seas:
        yield "no waves: no wave loads"
    if model.waves.second_dof.size + model.following.second.pairing.size == 0:
        yield "no second-order loads"
