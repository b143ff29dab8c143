"""What a run turned out to be that its assumptions did not foresee: bodies far from where waves met
them, coupled bodies that moved apart, angles that are not small, fenders pressed by metres.

`noticed` reads the motions of a run; it changes nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.compiling.hydrostatics.liquids import cut_shape
from hydrosim.compiling.questions.elements import SOFTEST
from hydrosim.compiling.wet import WetGroup
from hydrosim.dofs import loads_about_z
from hydrosim.forces.contact.fender import Contact
from hydrosim.forces.contact.landing import Landing
from hydrosim.forces.contact.modes import OPEN
from hydrosim.forces.contact.normal import PrescribedNormal
from hydrosim.results.points import frames_of
from hydrosim.scene import Body, FreeSurface, Kinematics, Place, Question, Scene
from hydrosim.tanks.shapes import heel_and_trim, volume_at
from hydrosim.waves.components import Components
from hydrosim.waves.forms import second_order_at_rest
from hydrosim.waves.transfer import excitation_at, mean_drift_at

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.compiling.compiled import Compiled
    from hydrosim.database.database import HydroDatabase

CHANGED = 0.1  # of the loads: what a slow yaw may change unsaid
PHASE = 0.5  # rad: how far waves of rms wave number may have gone along a slow drift
APART, TURNED = 0.1, np.radians(3.0)
"""Of the distance of coupled bodies, and between their headings, that may be unsaid."""
BEYOND = 0.2  # of what is between two draughts: how far beyond the last is unsaid
SMALL = np.radians(10.0)  # sin and cos are off by 0.5 and 1.5 % there
SAMPLES = 200  # waves of equal energy that stand for a sea
BLOCK = 1024  # records at once: all of a long run, for each sample, need much memory
PERIODS = 3.0  # of the waves: what is slower is slow


class Sample(NamedTuple):
    """Waves that stand for a sea: frequency, heading and wave number, (`SAMPLES`,) each."""

    omega: np.ndarray
    heading: np.ndarray
    wavenumber: np.ndarray


def noticed(compiled: Compiled, run: xr.Dataset) -> Iterator[str]:
    """What to warn of after a ``run`` of the compiled scene, in words with figures."""
    scene = compiled.scene
    seas = compiled.sea
    exact = scene.solver.kinematics == Kinematics.EXACT
    if run.sizes["time"] < 2 or not np.isfinite(run.position.values).all():
        return
    if Question.SOFTNESS not in scene.accept:
        yield from _pressed_by_metres(scene, run)
    yield from _beside_seats(compiled, run)
    if not exact:
        yield from _large_angles(run)
    yield from _shallow(scene, run)
    if exact and seas:
        yield from _met_elsewhere(compiled, run, _sampled(seas))
    for group in compiled.wet if exact else ():
        yield from _coupled(group, run)
        yield from _beyond_draughts(group, run)


def _pressed_by_metres(scene: Scene, run: xr.Dataset) -> Iterator[str]:
    """Fenders that were thinner than they were pressed."""
    for name, fender in scene.forces.items():
        if not isinstance(fender, Contact) or isinstance(fender.normal, PrescribedNormal):
            continue
        own = _of_points(run, fender.unit_names(name))
        deep = np.where(own.fender_mode == OPEN, 0.0, own.fender_compression)
        at, point = np.unravel_index(int(np.argmax(deep)), deep.shape)
        if deep[at, point] > SOFTEST:
            yield (
                f"forces.{name}: point {point + 1} was pressed by {deep[at, point]:.3g} m at"
                f" {run.time.values[at]:.4g} s; usual is up to {SOFTEST:g} m. Look at"
                f" forces.{name}.normal and its unit. If this is intended, accept:"
                f" [{Question.SOFTNESS}]."
            )


def _of_points(run: xr.Dataset, names: Iterable[str]) -> xr.Dataset:
    """Modes and compressions of some contact points, without a copy of all else."""
    return run[["fender_mode", "fender_compression"]].sel(fender=list(names))


def _beside_seats(compiled: Compiled, run: xr.Dataset) -> Iterator[str]:
    """Landings that came down beside their seats, which did not carry them."""
    landings = {
        name: element
        for name, element in compiled.scene.forces.items()
        if isinstance(element, Landing) and element.active is None
    }
    for name, landing in landings.items():
        own = _of_points(run, landing.unit_names(name))
        below = (own.fender_mode.values == OPEN) & (own.fender_compression.values == 0.0)
        for point in np.flatnonzero(below.any(axis=0)):
            late = np.flatnonzero(below[:, point])
            off = _off_seat(compiled, run.isel(time=late), landing, int(point))
            beside = np.flatnonzero(off > landing.reach())
            if not beside.size:  # it only begins to touch
                continue
            at = late[beside[0]]
            yield (
                f"forces.{name}: at {run.time.values[at]:.4g} s point {point + 1} was below its"
                f" seat and {off[beside[0]]:.3g} m beside it, where nothing carries it; a seat"
                f" carries {landing.reach():.3g} m far (on.extent)."
            )
            break


def _off_seat(compiled: Compiled, run: xr.Dataset, landing: Landing, point: int) -> np.ndarray:
    """How far a point of a landing is from the axis of its seat [m], at each time (nt,)."""
    index = {body.name: i for i, body in enumerate(compiled.scene.bodies)}
    places, rotations = frames_of(compiled.model, run.position.values.reshape(run.time.size, -1))
    b = index[landing.body]
    place = places[:, b] + rotations[:, b] @ landing.points[point]
    seat = landing.seats[point]
    axis = np.array(landing.axis, float)
    if landing.on is not None:
        a = index[landing.on]
        seat = places[:, a] + rotations[:, a] @ seat
        axis = rotations[:, a] @ axis
    across = np.cross(place - seat, axis)
    return np.asarray(np.linalg.norm(across, axis=-1) / np.linalg.norm(axis, axis=-1))


def _met_elsewhere(compiled: Compiled, run: xr.Dataset, sea: Sample) -> Iterator[str]:
    """Bodies that were not where waves met them."""
    scene = compiled.scene
    alone = compiled.facts.databases
    for body in scene.bodies:
        if body.name in alone and body.wave_forces.any:
            chosen = compiled.facts.met[body.name]
            slow = _slow(run, body.name, sea)
            if body.wave_forces.first_order and chosen.position == Place.MEAN:
                yield from _drifted(body, run, slow, sea)
            if chosen.headings == Place.MEAN:
                yield from _turned_first(body, run, slow, sea, alone[body.name])
            if second_order_at_rest(chosen, alone[body.name]):
                yield from _turned_second(body, run, slow, sea, alone[body.name])


def _large_angles(run: xr.Dataset) -> Iterator[str]:
    angles = np.abs(run.position.values[:, :, 3:])
    if angles.max() > SMALL:
        _, b, j = np.unravel_index(angles.argmax(), angles.shape)
        yield (
            f"solver.kinematics: linear is for small angles, and {run.dof.values[3 + j]} of"
            f" {run.body.values[b]} reached {np.degrees(angles.max()):.3g} deg; expected less than"
            f" {np.degrees(SMALL):.2g} deg. Choose exact."
        )


def _shallow(scene: Scene, run: xr.Dataset) -> Iterator[str]:
    """Tanks that are not cut, and whose free surface met bottom or top."""
    names = run.variables["tank"].values.tolist() if "tank_mass" in run else []
    angles = np.abs(run.position.values[:, :, 3:5])
    for b, body in enumerate(scene.bodies):
        for tank in body.tanks:
            if tank.surface == FreeSurface.FROZEN or cut_shape(tank, scene):
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
                    f"bodies.{body.name}.tanks.{tank.name}: its free surface is that of upright"
                    f" walls, and met bottom or top: at {run.time.values[at]:.4g} s"
                    f" {('heel', 'trim')[k]} was {np.degrees(angles[at, b, k]):.3g} deg; expected"
                    f" less than {np.degrees(reach[at, k]):.3g} deg at its level then. Give it as"
                    " a box or a mesh, with solver.kinematics: exact."
                )


def _slow(run: xr.Dataset, name: str, sea: Sample) -> np.ndarray:
    """Surge, sway and yaw (nt, 3) without what is as fast as the waves: running means."""
    of = run.variables["body"].values.tolist().index(name)
    q = run.variables["position"].values[:, of, [0, 1, 5]]
    step = float(np.median(np.diff(run.variables["time"].values)))
    width = min(max(round(PERIODS * 2.0 * np.pi / float(sea.omega.mean()) / step), 1), len(q))
    sums = np.cumsum(np.vstack([np.zeros((1, 3)), q]), axis=0)
    means = (sums[width:] - sums[:-width]) / width
    before = (len(q) - len(means)) // 2
    return np.pad(means, ((before, len(q) - len(means) - before), (0, 0)), mode="edge")


def _drifted(body: Body, run: xr.Dataset, slow: np.ndarray, sea: Sample) -> Iterator[str]:
    """A body that was far from its place at rest while waves met it there."""
    blocks = (slow[k : k + BLOCK] for k in range(0, len(slow), BLOCK))
    phase = np.concatenate([_phases(block, sea) for block in blocks])
    at = int(phase.argmax())
    if phase[at] > PHASE:
        yield (
            f"bodies.{body.name}: waves met it as at rest, and at {run.time.values[at]:.4g} s it"
            f" was {np.hypot(*slow[at, :2]):.3g} m away, {phase[at]:.2g} rad of the waves' phase;"
            f" expected less than {PHASE:g} rad. Set wave_forces.position: slow."
        )


def _phases(slow: np.ndarray, sea: Sample) -> np.ndarray:
    """Root mean square phase [rad], (nt,), of the waves along the places ``slow`` (nt, 3)."""
    along = slow[:, :1] * np.cos(sea.heading) + slow[:, 1:2] * np.sin(sea.heading)
    return np.asarray(np.sqrt(np.mean(np.square(sea.wavenumber * along), axis=1)))


def _turned_first(
    body: Body, run: xr.Dataset, slow: np.ndarray, sea: Sample, db: HydroDatabase
) -> Iterator[str]:
    """A body that was turned from the heading at which waves met it."""
    at, yaw = _most_turned(slow)
    if yaw == 0.0 or not body.wave_forces.first_order:
        return
    to = sea.heading - body.heading
    here, turned = (excitation_at(db, to - x, sea.omega) for x in (0.0, yaw))
    change = _change(here, turned, yaw, 0.0)
    if change > CHANGED:
        yield (
            f"bodies.{body.name}: waves met it at its heading at rest, and {_there(run, at, yaw)}"
            f" {change:.0%}; expected less than {CHANGED:.0%}. Set wave_forces.headings: slow."
        )


def _turned_second(
    body: Body, run: xr.Dataset, slow: np.ndarray, sea: Sample, db: HydroDatabase
) -> Iterator[str]:
    """The same of second-order loads, as mean drift has it."""
    at, yaw = _most_turned(slow)
    if yaw == 0.0 or db.mean_drift is None:
        return
    to = sea.heading - body.heading
    here, turned = (mean_drift_at(db, to - x, sea.omega).mean(axis=0)[None] for x in (0.0, yaw))
    change = _change(here, turned, yaw, float(np.sqrt(body.inertia[2, 2] / body.mass)))
    if change > CHANGED:
        yield (
            f"bodies.{body.name}: second-order loads are those of its heading at rest, and"
            f" {_there(run, at, yaw)} {change:.0%}; expected less than {CHANGED:.0%}. Set"
            " wave_forces.headings: slow, with loads for headings all round (of QTFs, too); or give"
            f" bodies.{body.name}.heading as it lies on average."
        )


def _most_turned(slow: np.ndarray) -> tuple[int, float]:
    """Index of the largest slow yaw, and that yaw [rad]."""
    at = int(np.abs(slow[:, 2]).argmax())
    return at, float(slow[at, 2])


def _there(run: xr.Dataset, at: int, yaw: float) -> str:
    return (
        f"at {run.time.values[at]:.4g} s its slow yaw was {np.degrees(yaw):.3g} deg, where the"
        " loads are others by"
    )


def _change(here: np.ndarray, turned: np.ndarray, yaw: float, arm: float) -> float:
    """Root mean square change of forces or moments (n, 6), the larger, over that of ``here``; a
    moment being no less than the force on an ``arm`` [m]: by symmetry it may happen to be zero."""
    change, size = (
        np.sqrt(np.mean(np.abs(x.reshape(-1, 2, 3)) ** 2, axis=(0, 2)))
        for x in (loads_about_z(turned, yaw) - here, here)
    )
    size[1] = max(size[1], arm * size[0])
    return float(np.divide(change, size, out=np.zeros(2), where=size > 0.0).max())


def _sampled(seas: Sequence[Components]) -> Sample:
    """Waves of equal energy out of all seas."""
    omega, heading, k, amplitude = (
        np.concatenate([getattr(waves, name) for waves in seas])
        for name in ("omega", "heading", "wavenumber", "amplitude")
    )
    energy = np.cumsum(amplitude**2)
    wanted = energy[-1] * (np.arange(SAMPLES) + 0.5) / SAMPLES
    at = np.searchsorted(energy, wanted)
    return Sample(omega[at], heading[at], k[at])


def _beyond_draughts(group: WetGroup, run: xr.Dataset) -> Iterator[str]:
    """A body that was slowly at draughts that its family of databases has not."""
    if not group.members:
        return
    draughts = [member.draught for member in group.members]
    (name,) = group.names
    slow = run.slow_draught.sel(body=name).values
    beyond = np.maximum(draughts[0] - slow, slow - draughts[-1])
    at = int(beyond.argmax())
    if beyond[at] > BEYOND * float(np.diff(draughts).min()):
        yield (
            f"bodies.{name}.hydrodynamics: at {run.time.values[at]:.4g} s its slow draught was"
            f" {slow[at]:.4g} m, and its databases are for {draughts[0]:g} to {draughts[-1]:g} m:"
            " coefficients were those of the nearest. Add a database for that draught."
        )


def _coupled(group: WetGroup, run: xr.Dataset) -> Iterator[str]:
    """Bodies of one database that have moved from the places for which their waves were coupled."""
    names = run.variables["body"].values.tolist()
    of = [names.index(name) for name in group.names]
    q = run.variables["position"].values[:, of]
    places = run.variables["reference_position"].values[of, :2]
    for one, other in combinations(range(len(group.bodies)), 2):
        away = np.hypot(*(q[:, one, :2] - q[:, other, :2]).T)
        turned = np.abs(q[:, one, 5] - q[:, other, 5])
        distance = float(np.hypot(*(places[one] - places[other])))
        if away.max() > APART * distance or turned.max() > TURNED:
            yield (
                f"bodies.{group.names[one]}, {group.names[other]}: their waves are coupled as at"
                f" rest, {distance:.4g} m apart and parallel, and they came {away.max():.3g} m and"
                f" {np.degrees(turned.max()):.3g} deg away from that; expected less than"
                f" {APART * distance:.3g} m and {np.degrees(TURNED):.2g} deg. What one does to the"
                " other is uncertain by as much; compute a database for the places that they take."
            )
