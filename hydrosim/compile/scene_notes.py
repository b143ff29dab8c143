"""Messages on a scene in its sea: where waves and current act, streams, warnings, skipped loads."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim import scene as scenes
from hydrosim.compile.closed_joints import bodies_move_freely, describe_dropped
from hydrosim.compile.hydrodynamic_groups import HydrodynamicGroup, each_database
from hydrosim.compile.questions.waters import OUTSIDE_REFUSED, outside_range_text
from hydrosim.dofs import DOFS
from hydrosim.elements import heights_of_wind, signals_of
from hydrosim.elements.stream_load import STREAM_LOAD_KIND
from hydrosim.files.display_units import Units, units_of
from hydrosim.files.document_layout import text_of
from hydrosim.files.document_nodes import Value
from hydrosim.integrate.names import dofs_of
from hydrosim.multibody.kinematics import moving_dofs
from hydrosim.scene.loads import CurrentLoad, StreamLoad, WindLoad
from hydrosim.scene.scene import arrangement
from hydrosim.scene.signal import Recorded
from hydrosim.water.components import (
    SeaState,
    WaveComponents,
    components,
    energy_outside_band,
    sea_state,
)
from hydrosim.water.current import current_table, draught_of, is_sheared
from hydrosim.water.database_limits import lost_between_headings, shares_outside
from hydrosim.water.quadratic_loads import uses_second_order_at_rest
from hydrosim.water.second_order import has_separate_headings
from hydrosim.water.transfer import angle_between
from hydrosim.water.wind import (
    REFERENCE_HEIGHT,
    MeanWind,
    gust_band,
    gust_factor,
    mean_wind,
    variance,
)

if TYPE_CHECKING:
    from hydrosim.compile.compiled import DerivedData, Notes
    from hydrosim.database.database import HydroDatabase
    from hydrosim.integrate.dynamics import Model
    from hydrosim.integrate.state import State

HEADING_LOSS_WARNING = (
    0.05  # relative loss of loads between headings of a database that is worth a warning
)
AT_NODE = 1e-6  # rad: waves this close to a heading of the database count as at it
MAX_ENERGY_BETWEEN_HEADINGS = 0.01  # relative energy between headings that needs no message


class Meeting(NamedTuple):
    """At which place and heading of a ``body`` the waves meet it. ``lost`` are the parts of its
    first-order forces and moments that interpolation between the headings of the ``database``
    loses, if known. ``second_at_rest`` is true if second-order loads stay those at rest."""

    body: scenes.Body
    database: HydroDatabase
    position: scenes.Place
    headings: scenes.Place
    lost: tuple[float, float] | None
    second_at_rest: bool


def meetings(
    scene: scenes.Scene, derived: DerivedData, seas: Sequence[WaveComponents]
) -> Iterator[Meeting]:
    """Meeting of each body that waves load."""
    alone = derived.databases
    for body in scene.bodies if seas else ():
        if body.name in alone and body.wave_forces.has_loads:
            db = alone[body.name]
            chosen = derived.met[body.name]
            between = chosen.headings != scenes.Place.MEAN or _is_between_headings(body, seas, db)
            between = between and body.wave_forces.first_order
            lost = lost_between_headings(db, seas) if between else None
            fixed = uses_second_order_at_rest(chosen, db)
            yield Meeting(body, db, chosen.position, chosen.headings, lost, fixed)


def said_of_waves(meeting: Meeting) -> Iterator[str]:
    """Text on the position where waves act on the body, and on the method; empty at rest."""
    body = meeting.body
    if {meeting.position, meeting.headings} != {scenes.Place.MEAN}:
        position = meeting.position.describe("position")
        heading = meeting.headings.describe("heading")
        text = f"waves act on {body.name} at its {position} and its {heading}"
        if meeting.second_at_rest and meeting.headings != scenes.Place.MEAN:
            text += (
                "; second-order loads are those at rest, because its QTFs do not cover all headings"
            )
        yield text
    if meeting.lost is not None:
        yield f"{body.name}: {_loss_text(meeting.lost, meeting.database)}"


def coarse_headings(meeting: Meeting) -> Iterator[str]:
    """Warning about a database whose headings are too coarse for its hull in this sea."""
    lost = meeting.lost
    db = meeting.database
    if lost is not None and max(lost) > HEADING_LOSS_WARNING:
        yield (
            f"bodies.{meeting.body.name}: {_loss_text(lost, db)}; expected less than"
            f" {HEADING_LOSS_WARNING:.0%}. Compute the database for headings"
            f" {_frequency_spacing(db) / 2.0:.3g} deg apart, or choose waves that meet"
            " the body at a heading"
            " of the database."
        )


def said_of_current(scene: scenes.Scene, model: Model) -> Iterator[str]:
    """Note on the effect of the current on the added-mass loads of the bodies."""
    for b in model.headings.turning if scene.environment.current.top_speed else ():
        A = model.added_mass[6 * b : 6 * b + 2, 6 * b : 6 * b + 2]
        yield _munk_note(scene, scene.bodies[b], A, float(np.hypot(*model.headings.current[b])))


def _loss_text(lost: tuple[float, float], db: HydroDatabase) -> str:
    return (
        f"the headings of {db.source} are {_frequency_spacing(db):.3g} deg apart;"
        " interpolation between"
        f" them loses about {lost[0]:.1%} of the first-order forces and {lost[1]:.1%} of the"
        " moments in this sea"
    )


def _frequency_spacing(db: HydroDatabase) -> float:
    return 360.0 / db.heading.size


def _is_between_headings(
    body: scenes.Body, seas: Sequence[WaveComponents], db: HydroDatabase
) -> bool:
    """Whether waves meet the body at rest between the headings of its database."""
    energy = np.concatenate([waves.amplitude**2 for waves in seas])
    to = np.concatenate([waves.heading for waves in seas]) - body.heading
    off = np.full(to.size, np.inf)
    for heading in db.heading:  # one at a time, because seas of long runs have many waves
        np.minimum(off, angle_between(to, heading), out=off)
    return bool(energy[off > AT_NODE].sum() > MAX_ENERGY_BETWEEN_HEADINGS * energy.sum())


def _munk_note(scene: scenes.Scene, body: scenes.Body, A: np.ndarray, speed: float) -> str:
    """Note on the Munk moment, which measured coefficients often contain as well, for the ``speed``
    of the current on the body."""
    largest = 0.5 * abs(A[1, 1] - A[0, 0]) * speed**2
    text = (
        f"the current turns {body.name} by its added mass (Munk moment), by at most"
        f" {largest:.3g} N m"
    )
    if any(
        isinstance(e, CurrentLoad) and e.body == body.name and np.any(e.yaw)
        for e in scene.forces.values()
    ):
        text += (
            ". Yaw coefficients of a current_load that were measured or computed in a steady"
            f" flow include this moment: subtract {0.5 * (A[0, 0] - A[1, 1]):.3g} sin(2 a) N m"
            " s^2/m^2 at a heading of a"
        )
    return text


# Messages on wind and current: figures that the keys of a scene do not show.

GUSTS = {3.0: "3 s", 60.0: "1 min"}
"""Averaging times [s] of gusts that are told."""


def said_of_streams(scene: scenes.Scene, model: Model) -> Iterator[str]:
    """Notes on gusts and profiles: what is left out, and which speed each load and hull has."""
    water = scene.environment
    wind = mean_wind(water)
    if water.gusts is not None and wind.hour_mean > 0.0:
        yield from _said_of_gusts(water.gusts, wind)
    loads = [(name, e) for name, e in scene.forces.items() if isinstance(e, StreamLoad)]
    p = STREAM_LOAD_KIND.constants_in(model)
    heights = heights_of_wind(model.elements)
    for (name, load), row in zip(loads, p.each, strict=True):
        speed = _speed(row["stream"])
        if isinstance(load, WindLoad) and wind.has_profile:
            height = heights[row["gusts"]]
            yield f"{name} feels the wind at {height:.3g} m: a mean of {speed:.3g} m/s"
        elif not isinstance(load, WindLoad) and is_sheared(current_table(water)):
            yield f"{name} feels a mean current of {speed:.3g} m/s"
    if is_sheared(current_table(water)):
        for b in model.headings.turned:
            body = scene.bodies[b]
            speed = _speed(model.headings.current[b])
            yield (
                f"{body.name} feels a current of {speed:.3g} m/s, the mean over its draught of"
                f" {draught_of(body):.3g} m"
            )


def _speed(velocity: np.ndarray) -> float:
    return float(np.hypot(*velocity))


def _said_of_gusts(gusts: scenes.Gusts, wind: MeanWind) -> Iterator[str]:
    lowest, highest = gust_band(gusts)
    below, within, above = variance(gusts.spectrum, REFERENCE_HEIGHT, wind, lowest, highest)
    total = below + within + above
    factors_text = " and ".join(
        f"{gust_factor(wind.hour_mean, REFERENCE_HEIGHT, time):.3g} over {text}"
        for time, text in GUSTS.items()
    )
    yield (
        f"gusts ({gusts.spectrum}) about {wind.hour_mean:.4g} m/s, the mean of one hour at 10 m:"
        f" standard deviation {within**0.5:.3g} m/s"
    )
    yield (
        f"gusts from {lowest:.3g} to {highest:.3g} Hz; the spectrum has {below / total:.1%} of its"
        f" variance below and {above / total:.1%} above, which is left out"
    )
    yield (
        f"largest means of the NPD wind in an hour, over its mean: {factors_text}. Gusts act along"
        " the wind and on all bodies at the same instant"
    )


# Messages on waves: skipped loads and warnings.

Seas = Sequence[WaveComponents]
# fraction of a sea's energy, or of its loads, outside a database's frequencies
OUTSIDE_WARNED = 1e-3
MIN_SPREADING_RAD = 1e-6
"""Spreading below which crests are long: what rounding leaves of it."""
SPECTRUM_NAMES = {
    scenes.Jonswap: "JONSWAP",
    scenes.Tma: "TMA",
    scenes.Torsethaugen: "Torsethaugen",
    scenes.OchiHubble: "Ochi-Hubble",
    scenes.WhiteNoise: "white noise",
    scenes.SpectrumTable: "table",
    scenes.DirectionalTable: "table over directions",
    scenes.RegularWave: "regular wave",
    scenes.GivenComponents: "components",
    scenes.RecordedElevation: "recorded elevation",
}


def notes_of_sea(
    scene: scenes.Scene,
    wet: Sequence[HydrodynamicGroup],
    derived: DerivedData,
    state: State,
    seas: Seas,
    notes: Notes,
) -> Notes:
    """The ``notes`` of a scene in calm water, with messages on the scene in its ``seas``, which
    begins in a ``state``."""
    alone = derived.databases
    warnings = [text for group in wet for text in group.cut_lengths]
    warnings.extend(_fit_warnings(wet))
    warnings.extend(_fallback_warnings(wet))
    warnings.extend(text for group in wet for text in group.doubts(seas))
    for body in scene.bodies:
        if body.name in alone and body.dofs:
            warnings.extend(range_warnings(seas, body, alone[body.name]))
            warnings.extend(_heading_warnings(seas, body, alone[body.name]))
    dropped = list(describe_dropped(scene, derived.model, state))
    shared = bodies_move_freely(
        derived.model
    )  # otherwise a locked or mirrored direction may hold them
    warnings.extend(dropped if shared else ())
    met = list(meetings(scene, derived, seas))
    warnings.extend(text for meeting in met for text in coarse_headings(meeting))
    notes_of_waves = [text for meeting in met for text in said_of_waves(meeting)]
    return replace(
        notes,
        skipped=(
            *_skipped_loads(scene, derived.model, alone, seas, notes.zero),
            *(() if shared else dropped),
        ),
        records=(*_record_notes(scene), *_jump_notes(scene)),
        seas=tuple(_describe_trains(scene, alone)),
        meetings=(*notes_of_waves, *said_of_current(scene, derived.model)),
        streams=tuple(said_of_streams(scene, derived.model)),
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
        if not isinstance(wet.radiation, scenes.StateSpaceRadiation):
            continue
        for dofs, reason in wet.convolved:
            yield (
                f"radiation of {dofs_of(dofs, wet.names)}: found state_space, and no fit that"
                f" serves ({reason}); the memory is computed by convolution. Use radiation:"
                " convolution or automatic if this is meant, or check the database with `hydrosim"
                " db check`."
            )


def range_warnings(seas: Seas, body: scenes.Body, db: HydroDatabase) -> Iterator[str]:
    """Warnings about waves outside a database's frequencies whose first-order loads would matter.
    `questions.waters` asks about larger parts."""
    if seas and body.wave_forces.first_order:
        range_losses = shares_outside(db, seas)
        if OUTSIDE_WARNED < range_losses.share <= OUTSIDE_REFUSED:
            yield (
                f"environment.waves: {outside_range_text(range_losses, body, db)}: these waves have"
                " no first-order loads."
            )


def _heading_warnings(seas: Seas, body: scenes.Body, db: HydroDatabase) -> Iterator[str]:
    """Warnings about QTFs without pairs of different headings."""
    second = (
        body.wave_forces.second_order == scenes.SecondOrder.QTF or body.wave_forces.sum_frequency
    )
    for waves in seas if second else ():
        if has_separate_headings(db, waves):
            yield (
                f"{db.source} has QTFs for pairs of waves of one heading only: pairs of waves of"
                f" different headings give {body.name} no second-order load."
            )


def _describe_trains(scene: scenes.Scene, wet: Mapping[str, HydroDatabase]) -> Iterator[str]:
    """Height, period and directions of each wave train, the largest share of its energy for which
    a database has no loads, and whether it loads a body at all."""
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
        afloat = [body for body in scene.bodies if body.dofs and body.name in wet]
        if not any(body.wave_forces.has_loads for body in afloat):
            text += "; it loads no body"
        yield text


def _figures_of_train(train: scenes.WaveTrain, state: SeaState, units: Units) -> Iterator[str]:
    """Name, height, period, heading and spreading of a wave train, in this order."""

    def label_value(label: str, value: float, unit: str, digits: int = 3) -> str:
        return f"{label} {text_of(Value(value, unit, digits), units)}"

    spectrum = train.spectrum
    yield SPECTRUM_NAMES[type(spectrum)]
    if isinstance(spectrum, scenes.RegularWave):
        yield label_value("amplitude", spectrum.amplitude, "m")
        yield label_value("period", spectrum.period, "s")
    else:
        yield label_value("Hs", state.significant_height, "m")
    if isinstance(spectrum, scenes.WhiteNoise):
        yield f"{spectrum.lowest_frequency:.3g} to {spectrum.highest_frequency:.3g} rad/s"
    elif not isinstance(spectrum, scenes.RegularWave) and isfinite(state.peak_period):
        yield label_value("Tp", state.peak_period, "s")
    if isfinite(state.heading):
        yield label_value("goes to", state.heading, "rad")
    else:
        yield "without a mean direction"
    if state.spreading > MIN_SPREADING_RAD:
        yield label_value("spreading", state.spreading, "rad", 2)
    else:
        yield "long-crested"


def _record_notes(scene: scenes.Scene) -> Iterator[str]:
    """Notes on left-out parts of recorded elevations, and on the accuracy of splines through
    recorded forces."""
    for train in scene.environment.waves:
        if isinstance(record := train.spectrum, scenes.RecordedElevation):
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


def _jump_notes(scene: scenes.Scene) -> Iterator[str]:
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
    scene: scenes.Scene,
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
            range_losses = shares_outside(wet[body.name], seas)
            if range_losses.below + range_losses.above > OUTSIDE_WARNED:
                yield (
                    f"{outside_range_text(range_losses, body, wet[body.name])}: these waves have no"
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
