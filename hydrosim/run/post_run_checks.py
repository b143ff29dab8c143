"""Checks of a run against its assumptions. Bodies may be far from the position where waves act on
them, coupled bodies may move apart, angles may be large, and fenders may be compressed by metres.

`validity_warnings` reads the motions of a run; it changes nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.compile.hydrodynamic_groups import HydrodynamicGroup
from hydrosim.compile.hydrostatics import cut_shape
from hydrosim.compile.questions.elements import SOFTEST
from hydrosim.dofs import loads_about_z
from hydrosim.elements.contact.law import OPEN
from hydrosim.elements.joint.locks import CLOSED, WAITING
from hydrosim.results.memory import frames_of
from hydrosim.scene import Body, FreeSurface, Joint, Kinematics, Place, Question, Scene
from hydrosim.scene.catenary import Catenary, StretchCurve
from hydrosim.scene.contacts import Contact, Landing, PrescribedNormal
from hydrosim.scene.joint import MotionKind
from hydrosim.tanks.shapes import heel_and_trim, volume_at
from hydrosim.water.body import is_long
from hydrosim.water.components import WaveComponents
from hydrosim.water.quadratic_loads import uses_second_order_at_rest
from hydrosim.water.transfer import excitation_at, mean_drift_at

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.compile.compiled import Compiled
    from hydrosim.database.database import HydroDatabase

MIN_REPORTED_LOAD_CHANGE = 0.1  # of the loads: change by slow yaw below which nothing is reported
# rad: phase of waves of rms wave number over a slow drift, below which nothing is reported
MIN_REPORTED_PHASE_RAD = 0.5
MIN_REPORTED_DISTANCE_CHANGE, MIN_REPORTED_TURN_RAD = 0.1, np.radians(3.0)
"""Relative change of distance, and angle between headings of coupled bodies, below which nothing is
reported."""
# of the interval between draughts: distance beyond the last one, below which nothing is reported
MIN_REPORTED_DRAUGHT_EXCESS = 0.2
MAX_SMALL_ANGLE_RAD = np.radians(10.0)  # errors of sin and cos are 0.5 and 1.5 % there
SEA_SAMPLES = 200  # waves of equal energy that represent a sea
RECORDS_PER_BLOCK = 1024  # at once, because all records of a long run would need much memory
SLOW_WAVE_PERIODS = 3.0  # of the waves: longer periods are slow


class SampledSea(NamedTuple):
    """Waves that represent a sea: frequency, heading and wave number, (`SEA_SAMPLES`,) each."""

    omega: np.ndarray
    heading: np.ndarray
    wavenumber: np.ndarray


def validity_warnings(compiled: Compiled, run: xr.Dataset) -> Iterator[str]:
    """Warnings after a ``run`` of the compiled scene, as texts with figures."""
    scene = compiled.scene
    seas = compiled.sea
    exact = scene.solver.kinematics == Kinematics.EXACT
    if run.sizes["time"] < 2 or not np.isfinite(run.position.values).all():
        return
    if Question.SOFTNESS not in scene.accept:
        yield from _compression_warnings(scene, run)
    yield from _stretch_warnings(scene, run)
    yield from _missed_seat_warnings(compiled, run)
    yield from _missed_window_warnings(compiled, run)
    if not exact:
        yield from _large_angle_warnings(run)
    yield from _free_surface_warnings(scene, run)
    if exact and seas:
        yield from _wave_position_warnings(compiled, run, _sample_sea(seas))
    for group in compiled.wet if exact else ():
        yield from _coupling_warnings(group, run)
        yield from _draught_warnings(group, run)


def _compression_warnings(scene: Scene, run: xr.Dataset) -> Iterator[str]:
    """Warn of fenders with an implausibly large compression."""
    for name, fender in scene.forces.items():
        if not isinstance(fender, Contact) or isinstance(fender.normal, PrescribedNormal):
            continue
        contacts = _select_points(run, fender.unit_names(name))
        deep = np.where(contacts.fender_mode == OPEN, 0.0, contacts.fender_compression)
        at, point = np.unravel_index(int(np.argmax(deep)), deep.shape)
        if deep[at, point] > SOFTEST:
            yield (
                f"forces.{name}: point {point + 1} was compressed by {deep[at, point]:.3g} m at"
                f" {run.time.values[at]:.4g} s; usual is up to {SOFTEST:g} m. Check"
                f" forces.{name}.normal and its unit. If this is intended, accept:"
                f" [{Question.SOFTNESS}]."
            )


def _stretch_warnings(scene: Scene, run: xr.Dataset) -> Iterator[str]:
    """Warn of lines whose tension was beyond the end of a curve."""
    for name, line in scene.forces.items():
        segments = line.segments if isinstance(line, Catenary) else ()
        laws = (segment.stiffness for segment in segments)
        ends = [law.tension[-1] for law in laws if isinstance(law, StretchCurve)]
        if not ends:
            continue
        end = min(ends)
        channels = ("line_tension", "line_anchor_tension")
        largest = max(float(run[channel].sel(line=name).max()) for channel in channels)
        if largest > end:
            yield (
                f"forces.{name}: its tension was up to {largest:.4g} N, and the curve of its"
                f" stiffness ends at {end:.4g} N. The last slope went on."
            )


def _select_points(run: xr.Dataset, names: Iterable[str]) -> xr.Dataset:
    """Modes and compressions of some contact points, without a copy of all other data."""
    return run[["fender_mode", "fender_compression"]].sel(fender=list(names))


def _missed_seat_warnings(compiled: Compiled, run: xr.Dataset) -> Iterator[str]:
    """Warn of landings that came down beside their seats, which then carry nothing."""
    landings = {
        name: element
        for name, element in compiled.scene.forces.items()
        if isinstance(element, Landing) and element.active is None
    }
    for name, landing in landings.items():
        contacts = _select_points(run, landing.unit_names(name))
        below = (contacts.fender_mode.values == OPEN) & (contacts.fender_compression.values == 0.0)
        for point in np.flatnonzero(below.any(axis=0)):
            late = np.flatnonzero(below[:, point])
            off = _distance_from_seat(compiled, run.isel(time=late), landing, int(point))
            beside = np.flatnonzero(off > landing.reach())
            if not beside.size:  # points that only begin to touch
                continue
            at = late[beside[0]]
            yield (
                f"forces.{name}: at {run.time.values[at]:.4g} s point {point + 1} was below its"
                f" seat and {off[beside[0]]:.3g} m beside it, where nothing carries it; a seat"
                f" has a radius of {landing.reach():.3g} m (on.extent)."
            )
            break


def _missed_window_warnings(compiled: Compiled, run: xr.Dataset) -> Iterator[str]:
    """Tell how near to its window each joint came that waited for it until the end."""
    for name, joint in compiled.scene.joints.items():
        window = joint.window
        if window is None or any(motion.kind == MotionKind.SLIDE for motion in joint.motions):
            continue
        modes = run.lock_mode.sel(lock=name).values
        waiting = np.flatnonzero(modes == WAITING)
        if modes[-1] != WAITING or np.any(modes == CLOSED) or waiting.size < 2:
            continue
        apart = _distance_of_points(compiled, run, joint)
        gap = np.linalg.norm(apart, axis=1)
        speed = np.linalg.norm(np.gradient(apart, run.time.values, axis=0), axis=1)
        allowed = window.limits
        beyond = np.maximum(gap / allowed[0], speed / allowed[1])[waiting]
        at = waiting[int(beyond.argmin())]
        yield (
            f"joints.{name}: it came nearest to its window at {run.time.values[at]:.4g} s, with a"
            f" gap of {gap[at]:.3g} m and a speed of {speed[at]:.3g} m/s; the window has"
            f" {allowed[0]:g} m and {allowed[1]:g} m/s. Its smallest gap while it waited was"
            f" {gap[waiting].min():.3g} m, its smallest speed {speed[waiting].min():.3g} m/s."
        )


def _distance_of_points(compiled: Compiled, run: xr.Dataset, joint: Joint) -> np.ndarray:
    """Vectors (nt, 3) [m] between the points of a joint on both bodies, which meet at rest."""
    index = {body.name: i for i, body in enumerate(compiled.scene.bodies)}
    coordinates = run.position.values.reshape(run.time.size, -1)
    places, rotations = frames_of(compiled.model, np.vstack([0.0 * coordinates[:1], coordinates]))
    b = index[joint.body]
    point = places[:, b] + rotations[:, b] @ np.array(joint.point, float)
    if joint.to is None:
        return np.asarray(point[1:] - point[0])
    a = index[joint.to]
    on_other = rotations[0, a].T @ (point[0] - places[0, a])
    return np.asarray((point - places[:, a] - rotations[:, a] @ on_other)[1:])


def _distance_from_seat(
    compiled: Compiled, run: xr.Dataset, landing: Landing, point: int
) -> np.ndarray:
    """Distance of a point of a landing from the axis of its seat [m], at each time (nt,)."""
    index = {body.name: i for i, body in enumerate(compiled.scene.bodies)}
    places, rotations = frames_of(compiled.model, run.position.values.reshape(run.time.size, -1))
    b = index[landing.body]
    place = places[:, b] + rotations[:, b] @ landing.points[point]
    seat = landing.on.points[point]
    axis = np.array(landing.on.axis)
    if landing.on.body is not None:
        a = index[landing.on.body]
        seat = places[:, a] + rotations[:, a] @ seat
        axis = rotations[:, a] @ axis
    across = np.cross(place - seat, axis)
    return np.asarray(np.linalg.norm(across, axis=-1) / np.linalg.norm(axis, axis=-1))


def _wave_position_warnings(compiled: Compiled, run: xr.Dataset, sea: SampledSea) -> Iterator[str]:
    """Warn of bodies that were not where waves act on them."""
    scene = compiled.scene
    alone = compiled.derived.databases
    for body in scene.bodies:
        if body.name in alone and body.wave_forces.has_loads:
            chosen = compiled.derived.met[body.name]
            slow = _slow_motion(run, body.name, sea)
            if body.wave_forces.first_order and chosen.position == Place.MEAN:
                yield from _drift_warnings(body, run, slow, sea)
            if chosen.headings == Place.MEAN:
                yield from _first_order_yaw_warnings(body, run, slow, sea, alone[body.name])
            if uses_second_order_at_rest(chosen, alone[body.name]):
                yield from _second_order_yaw_warnings(body, run, slow, sea, alone[body.name])


def _large_angle_warnings(run: xr.Dataset) -> Iterator[str]:
    angles = np.abs(run.position.values[:, :, 3:])
    if angles.max() > MAX_SMALL_ANGLE_RAD:
        _, b, j = np.unravel_index(angles.argmax(), angles.shape)
        yield (
            f"solver.kinematics: linear assumes small angles, but {run.dof.values[3 + j]} of"
            f" {run.body.values[b]} reached {np.degrees(angles.max()):.3g} deg; expected less"
            f" than {np.degrees(MAX_SMALL_ANGLE_RAD):.2g} deg. Choose exact."
        )


def _free_surface_warnings(scene: Scene, run: xr.Dataset) -> Iterator[str]:
    """Warn of tanks without a cut shape whose free surface met bottom or top."""
    names = run.variables["tank"].values.tolist() if "tank_mass" in run else []
    angles = np.abs(run.position.values[:, :, 3:5])
    for b, body in enumerate(scene.bodies):
        for tank in body.tanks:
            if tank.free_surface == FreeSurface.FROZEN or cut_shape(tank, scene):
                continue
            name = f"{tank.name} of {body.name}"
            if name in names:
                volumes = run.tank_mass.sel(tank=name).values / tank.density
            else:
                volumes = np.full(run.sizes["time"], volume_at(tank.shape, tank.level))
            reach = heel_and_trim(tank.shape, volumes)
            beyond = (angles[:, b] - reach) * (volumes > 0.0)[:, None]
            at, k = np.unravel_index(beyond.argmax(), beyond.shape)
            if beyond[at, k] > 0.0:
                yield (
                    f"bodies.{body.name}.tanks.{tank.name}: its free surface is modelled for"
                    f" upright walls, but met bottom or top: at {run.time.values[at]:.4g} s"
                    f" {('heel', 'trim')[k]} was {np.degrees(angles[at, b, k]):.3g} deg; expected"
                    f" less than {np.degrees(reach[at, k]):.3g} deg at its level then. Give it as"
                    " a box or a mesh, with solver.kinematics: exact."
                )


def _slow_motion(run: xr.Dataset, name: str, sea: SampledSea) -> np.ndarray:
    """Slow surge, sway and yaw (nt, 3): running means over several wave periods."""
    index = run.variables["body"].values.tolist().index(name)
    q = run.variables["position"].values[:, index, [0, 1, 5]]
    step = float(np.median(np.diff(run.variables["time"].values)))
    width = min(
        max(round(SLOW_WAVE_PERIODS * 2.0 * np.pi / float(sea.omega.mean()) / step), 1), len(q)
    )
    sums = np.cumsum(np.vstack([np.zeros((1, 3)), q]), axis=0)
    means = (sums[width:] - sums[:-width]) / width
    before = (len(q) - len(means)) // 2
    return np.pad(means, ((before, len(q) - len(means) - before), (0, 0)), mode="edge")


def _drift_warnings(
    body: Body, run: xr.Dataset, slow: np.ndarray, sea: SampledSea
) -> Iterator[str]:
    """Warn of a body that was far from its position at rest while waves act on it there."""
    blocks = (slow[k : k + RECORDS_PER_BLOCK] for k in range(0, len(slow), RECORDS_PER_BLOCK))
    phase = np.concatenate([_rms_wave_phases(block, sea) for block in blocks])
    at = int(phase.argmax())
    if phase[at] > MIN_REPORTED_PHASE_RAD:
        yield (
            f"bodies.{body.name}: waves act on it at its position at rest, but at"
            f" {run.time.values[at]:.4g} s it was {np.hypot(*slow[at, :2]):.3g} m away,"
            f" {phase[at]:.2g} rad of the waves' phase; expected less than"
            f" {MIN_REPORTED_PHASE_RAD:g} rad. Set wave_forces.position: slow."
        )


def _rms_wave_phases(slow: np.ndarray, sea: SampledSea) -> np.ndarray:
    """Root mean square phase [rad], (nt,), of the waves between rest and the positions ``slow``
    (nt, 3)."""
    along = slow[:, :1] * np.cos(sea.heading) + slow[:, 1:2] * np.sin(sea.heading)
    return np.asarray(np.sqrt(np.mean(np.square(sea.wavenumber * along), axis=1)))


def _first_order_yaw_warnings(
    body: Body, run: xr.Dataset, slow: np.ndarray, sea: SampledSea, db: HydroDatabase
) -> Iterator[str]:
    """Warn of a body that turned away from the heading at which waves act on it."""
    at, yaw = _largest_yaw(slow)
    if yaw == 0.0 or not body.wave_forces.first_order:
        return
    to = sea.heading - body.heading
    here, turned = (excitation_at(db, to - x, sea.omega) for x in (0.0, yaw))
    turned = loads_about_z(turned, yaw)
    if is_long(db):  # moments are used in the axes of the hull
        here = np.hstack([here[:, :3], loads_about_z(here[:, 3:], yaw)])
    change = _load_change(here, turned, 0.0)
    if change > MIN_REPORTED_LOAD_CHANGE:
        yield (
            f"bodies.{body.name}: waves act on it at its heading at rest, but"
            f" {_yaw_text(run, at, yaw)} {change:.0%}; expected less than"
            f" {MIN_REPORTED_LOAD_CHANGE:.0%}. Set wave_forces.headings: slow."
        )


def _second_order_yaw_warnings(
    body: Body, run: xr.Dataset, slow: np.ndarray, sea: SampledSea, db: HydroDatabase
) -> Iterator[str]:
    """Warn of the same for second-order loads, from the change of mean drift."""
    at, yaw = _largest_yaw(slow)
    if yaw == 0.0 or db.mean_drift is None:
        return
    to = sea.heading - body.heading
    here, turned = (mean_drift_at(db, to - x, sea.omega).mean(axis=0)[None] for x in (0.0, yaw))
    arm = float(np.sqrt(body.inertia[2, 2] / body.mass))
    change = _load_change(here, loads_about_z(turned, yaw), arm)
    if change > MIN_REPORTED_LOAD_CHANGE:
        yield (
            f"bodies.{body.name}: second-order loads are computed for its heading at rest, but"
            f" {_yaw_text(run, at, yaw)} {change:.0%}; expected less than"
            f" {MIN_REPORTED_LOAD_CHANGE:.0%}. Set wave_forces.headings: slow, with loads (and"
            f" QTFs) for all headings; or set bodies.{body.name}.heading to its mean heading."
        )


def _largest_yaw(slow: np.ndarray) -> tuple[int, float]:
    """Index of the largest slow yaw, and that yaw [rad]."""
    at = int(np.abs(slow[:, 2]).argmax())
    return at, float(slow[at, 2])


def _yaw_text(run: xr.Dataset, at: int, yaw: float) -> str:
    return (
        f"at {run.time.values[at]:.4g} s its slow yaw was {np.degrees(yaw):.3g} deg, which"
        " changes the loads by"
    )


def _load_change(here: np.ndarray, turned: np.ndarray, arm: float) -> float:
    """Root mean square change of forces or moments (n, 6), whichever is larger, relative to
    ``here``. Moments are at least the force times ``arm`` [m], because symmetry may make them
    zero."""
    change, size = (
        np.sqrt(np.mean(np.abs(x.reshape(-1, 2, 3)) ** 2, axis=(0, 2)))
        for x in (turned - here, here)
    )
    size[1] = max(size[1], arm * size[0])
    return float(np.divide(change, size, out=np.zeros(2), where=size > 0.0).max())


def _sample_sea(seas: Sequence[WaveComponents]) -> SampledSea:
    """Waves of equal energy out of all seas."""
    omega, heading, k, amplitude = (
        np.concatenate([getattr(waves, name) for waves in seas])
        for name in ("omega", "heading", "wavenumber", "amplitude")
    )
    energy = np.cumsum(amplitude**2)
    wanted = energy[-1] * (np.arange(SEA_SAMPLES) + 0.5) / SEA_SAMPLES
    chosen = np.searchsorted(energy, wanted)
    return SampledSea(omega[chosen], heading[chosen], k[chosen])


def _draught_warnings(group: HydrodynamicGroup, run: xr.Dataset) -> Iterator[str]:
    """Warn of a body whose slow draught left the range of its family of databases."""
    if not group.members:
        return
    draughts = [member.draught for member in group.members]
    (name,) = group.names
    slow = run.slow_draught.sel(body=name).values
    beyond = np.maximum(draughts[0] - slow, slow - draughts[-1])
    at = int(beyond.argmax())
    if beyond[at] > MIN_REPORTED_DRAUGHT_EXCESS * float(np.diff(draughts).min()):
        yield (
            f"bodies.{name}.hydrodynamics: at {run.time.values[at]:.4g} s its slow draught was"
            f" {slow[at]:.4g} m, but its databases cover {draughts[0]:g} to {draughts[-1]:g} m."
            " The coefficients of the nearest were used. Add a database for that draught."
        )


def _coupling_warnings(group: HydrodynamicGroup, run: xr.Dataset) -> Iterator[str]:
    """Warn of bodies of one database that moved from the positions for which it was computed."""
    names = run.variables["body"].values.tolist()
    indices = [names.index(name) for name in group.names]
    q = run.variables["position"].values[:, indices]
    places = run.variables["reference_position"].values[indices]
    for first, second in combinations(range(len(group.bodies)), 2):
        away = np.hypot(*(q[:, first, :2] - q[:, second, :2]).T)
        turned = np.abs(q[:, first, 5] - q[:, second, 5])
        distance = float(np.linalg.norm(places[first] - places[second]))
        if (
            away.max() > MIN_REPORTED_DISTANCE_CHANGE * distance
            or turned.max() > MIN_REPORTED_TURN_RAD
        ):
            yield (
                f"bodies.{group.names[first]}, {group.names[second]}: the database has the waves"
                f" between them for their places at rest, {distance:.4g} m apart and parallel. In"
                f" the run their relative place changed by up to {away.max():.3g} m and"
                f" {np.degrees(turned.max()):.3g} deg; expected less than"
                f" {MIN_REPORTED_DISTANCE_CHANGE * distance:.3g} m and"
                f" {np.degrees(MIN_REPORTED_TURN_RAD):.2g} deg. Compute a database for"
                " their mean places in the run."
            )
