"""Channels of a run by name, ``VARIABLE.SELECTION.SELECTION``, reduced or grouped for pictures.

Every variable recorded over time gives channels (`hydrosim.files.series`):
"position.barge.surge", "fender_normal_force.interface 1", "clearance.to_leg", "wave_elevation".
Other channels are derived:

    speed.BODY                              horizontal, of the centre of gravity
    offset.BODY                             horizontal distance from the place at rest
    fender_normal_force.GROUP               sum over the contact points of a group, "interface"
    point_velocity.POINT.AXIS               of a named point, "bow of barge"
    point_acceleration.POINT.AXIS           the same, in a run that records accelerations
    relative_position.POINT to POINT.AXIS   of the first point from the second, in the earth frame
    relative_velocity.POINT to POINT.AXIS
    relative_speed.POINT to POINT           size of the relative velocity
    utilisation.UNIT                        force of a contact point or line over its capacity

`channel_series` gives the values and the unit of any channel.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from itertools import permutations, product
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.errors import InputError
from hydrosim.files.messages import suggestion
from hydrosim.files.series import columns_of, select
from hydrosim.files.text import Source
from hydrosim.files.yaml_nodes import with_hint
from hydrosim.results.variables import BY_RANK, ELEMENT_VARIABLES, VARIABLES

if TYPE_CHECKING:
    import xarray as xr

RUN = Source(Path("run"))
DEFAULT_VARIABLES = {
    *("position", "velocity", "wave_elevation", "wind_speed"),
    *(name for name, variable in ELEMENT_VARIABLES.items() if not variable.is_detail),
}
"""Variables whose channels are taken if none are named; forces on bodies beside these."""
TO = " to "  # between two points
MAX_NAMES_SHOWN = 40  # names in a message


class Channel(NamedTuple):
    """A channel of a run, and its unit."""

    name: str
    unit: str


def recorded_channels(run: xr.Dataset) -> list[Channel]:
    """All recorded channels of a run."""
    return [Channel(name, select(RUN, run, name)[1]) for name in columns_of(run)]


def lowest_value(name: str) -> float:
    """Lower bound of a channel, or of the channels of a variable."""
    kind = name.partition(".")[0]
    described = VARIABLES.get(kind) or CHANNEL_KINDS.get(kind)
    return -np.inf if described is None else described.lowest


def channel_names(run: xr.Dataset) -> list[str]:
    """Names of all channels of a run, including derived ones."""
    derived = (
        f"{kind}.{of}"
        for kind, channel_kind in CHANNEL_KINDS.items()
        for of in channel_kind.names(run)
    )
    return [*columns_of(run), *derived]


def channel_series(run: xr.Dataset, name: str) -> tuple[np.ndarray, str]:
    """Values (nt,) and unit of the channel ``name`` of a run, or of the numbers of a mode. Raises
    InputError that lists the channels if the run has no such channel."""
    kind, _, of = name.partition(".")
    if kind in CHANNEL_KINDS and of in CHANNEL_KINDS[kind].names(run):
        return CHANNEL_KINDS[kind].values(run, of), CHANNEL_KINDS[kind].unit
    if name in columns_of(run) or name in columns_of(run, modes=True):
        return select(RUN, run, name)
    raise InputError(unknown_channel_message(run, name))


def unknown_channel_message(run: xr.Dataset, name: str) -> str:
    """Message that a run has no channel ``name``, and which channels it has."""
    kind = name.partition(".")[0]
    channels = channel_names(run)
    alike = [channel for channel in channels if channel.partition(".")[0] == kind]
    if kind in NEEDS and not alike:
        return f"found {name}, but the run has no channels {kind}: they need {NEEDS[kind]}."
    text = (
        f"found {name}; expected a channel of the run: {', '.join(_names_to_show(name, channels))}"
    )
    return with_hint(text, _channel_hint(name, channels))


def _channel_hint(name: str, channels: Sequence[str]) -> str:
    """Question with the channel that was probably meant: of a similar name, or of the same label
    and, if there is one, a kind with the same word."""
    kind, _, label = name.rpartition(".")
    alike = [channel for channel in channels if channel.endswith(f".{label}")]
    channel = next((channel for channel in alike if kind in channel), next(iter(alike), ""))
    similar = suggestion(name, channels)
    return similar or (f'did you mean "{channel}"?' if channel else "")


def default_channels(run: xr.Dataset) -> list[str]:
    """Channels of `DEFAULT_VARIABLES` and of forces that are not zero throughout."""
    return [
        name
        for name in columns_of(run)
        if (name.startswith("force_") or name.partition(".")[0] in DEFAULT_VARIABLES)
        and select(RUN, run, name)[0].any()
    ]


def match_channels(names: Iterable[str], patterns: Sequence[str], option: str) -> list[str]:
    """Names that match one of the patterns ("position.*"). Raises InputError if a pattern of the
    ``option`` matches none."""
    channels = list(names)
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in channels):
            names_text = ", ".join(_names_to_show(pattern, channels))
            text = f"{option}: found {pattern}; expected one of: {names_text}"
            raise InputError(with_hint(text, _channel_hint(pattern, channels)))
    return [name for name in channels if _matches_any(name, patterns)]


def _names_to_show(name: str, channels: Sequence[str]) -> list[str]:
    """All names if they are few; else the names of the same kind as ``name``, or "KIND.*" of every
    kind."""
    if len(channels) <= MAX_NAMES_SHOWN:
        return list(channels)
    alike = [channel for channel in channels if channel.partition(".")[0] == name.partition(".")[0]]
    kinds = (
        f"{channel.partition('.')[0]}.*" if "." in channel else channel for channel in channels
    )
    return alike or list(dict.fromkeys(kinds))


def _matches_any(name: str, patterns: Sequence[str]) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns)


class ChannelKind(NamedTuple):
    """Derived channels: their names after the kind, for a run; the values (nt,) of one channel; the
    unit and the lower bound of all."""

    names: Callable[[xr.Dataset], Iterable[str]]
    values: Callable[[xr.Dataset, str], np.ndarray]
    unit: str
    lowest: float = -np.inf


def _labels_of_dim(run: xr.Dataset, dim: str) -> list[str]:
    return [str(label) for label in run[dim].values] if dim in run.coords else []


def _horizontal_size(variable: str) -> Callable[[xr.Dataset, str], np.ndarray]:
    """Size of the horizontal part of a vector of a body."""

    def values(run: xr.Dataset, body: str) -> np.ndarray:
        vector = run[variable].sel(body=body)
        return np.hypot(vector.sel(dof="surge").values, vector.sel(dof="sway").values)

    return values


def _contact_groups(run: xr.Dataset) -> list[str]:
    return _labels_of_dim(run, "contact_group")


def _group_force(run: xr.Dataset, group: str) -> np.ndarray:
    group_forces = run.fender_normal_force.sel(fender=run.fender_group == group)
    return np.asarray(group_forces.transpose("time", "fender").values.sum(axis=1))


def _point_channel_names(run: xr.Dataset) -> Iterator[str]:
    """Names such as "bow of barge.x"."""
    return (
        ".".join(labels)
        for labels in product(_labels_of_dim(run, "point"), _labels_of_dim(run, "axis"))
    )


def _moving_points(run: xr.Dataset) -> Iterator[str]:
    return _point_channel_names(run) if "acceleration" in run else iter(())


def _clearance_names(run: xr.Dataset) -> Iterator[str]:
    """Names such as "bow of barge to foot of topside.x"."""
    return (".".join(labels) for labels in product(_point_pairs(run), _labels_of_dim(run, "axis")))


def _place_of_point(run: xr.Dataset, point: str) -> np.ndarray:
    return np.asarray(run.point_position.sel(point=point).transpose("time", "axis").values)


def _body_of(run: xr.Dataset, point: str) -> str:
    """Body of a named point. Files of earlier versions have it only in the name of the point."""
    if "point_body" in run.coords:
        return str(run.point_body.sel(point=point).item())
    named = (body for body in _labels_of_dim(run, "body") if point.endswith(f" of {body}"))
    return max(named, key=len)


def _arm_of_point(run: xr.Dataset, point: str) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Lever (nt, 3) of a point about the centre of gravity of its body; velocities and, if
    recorded, accelerations (nt, 6) of that body."""
    body = _body_of(run, point)
    moves = {
        name: run[name].sel(body=body).transpose("time", "dof").values
        for name in ("velocity", "acceleration")
        if name in run
    }
    centre = run.position.sel(body=body).transpose("time", "dof").values[:, :3]
    return _place_of_point(run, point) - centre - run.reference_position.sel(
        body=body
    ).values, moves


def _velocity_of_point(run: xr.Dataset, point: str) -> np.ndarray:
    """Velocity of a point: v + omega x r."""
    r, moves = _arm_of_point(run, point)
    v = moves["velocity"]
    return np.asarray(v[:, :3] + np.cross(v[:, 3:], r))


def _acceleration_of_point(run: xr.Dataset, point: str) -> np.ndarray:
    """Acceleration of a point: a + alpha x r + omega x (omega x r)."""
    r, moves = _arm_of_point(run, point)
    a = moves["acceleration"]
    omega = moves["velocity"][:, 3:]
    return np.asarray(a[:, :3] + np.cross(a[:, 3:], r) + np.cross(omega, np.cross(omega, r)))


def _axis_value(
    of: Callable[[xr.Dataset, str], np.ndarray],
) -> Callable[[xr.Dataset, str], np.ndarray]:
    """One axis of a quantity of a point, or of the difference between two points."""

    def values(run: xr.Dataset, name: str) -> np.ndarray:
        points, _, axis = name.rpartition(".")
        labels = _labels_of_dim(run, "point")
        pairs = (pair for pair in permutations(labels, 2) if TO.join(pair) == points)
        first, *second = (of(run, point) for point in next(pairs, (points,)))
        difference = first - second[0] if second else first
        return np.asarray(difference[:, _labels_of_dim(run, "axis").index(axis)])

    return values


def _point_pairs(run: xr.Dataset) -> Iterator[str]:
    return (TO.join(pair) for pair in permutations(_labels_of_dim(run, "point"), 2))


def _relative_speed(run: xr.Dataset, points: str) -> np.ndarray:
    components = [
        _axis_value(_velocity_of_point)(run, f"{points}.{axis}")
        for axis in _labels_of_dim(run, "axis")
    ]
    return np.asarray(np.linalg.norm(components, axis=0))


def load_variables(run: xr.Dataset) -> dict[str, tuple[str, str]]:
    """The variable and the dimension of the load of each contact point, line and rod."""
    names = (name for name, variable in BY_RANK.items() if variable.is_load and name in run)
    return {
        unit: (name, str(dim))
        for name in names
        for dim in run[name].dims
        if dim != "time"
        for unit in _labels_of_dim(run, str(dim))
    }


def _capacities(run: xr.Dataset) -> dict[str, float]:
    """The capacity [N] of each unit that has one."""
    dims = dict.fromkeys(dim for _, dim in load_variables(run).values())
    return {
        str(unit): float(capacity)
        for dim in dims
        if f"{dim}_capacity" in run.coords
        for unit, capacity in zip(run[dim].values, run[f"{dim}_capacity"].values, strict=True)
        if np.isfinite(capacity)
    }


def _load_of_unit(run: xr.Dataset, unit: str) -> np.ndarray:
    name, dim = load_variables(run)[unit]
    return np.abs(run[name].sel({dim: unit}).values)


class LargestLoad(NamedTuple):
    """The ``largest`` load [N] of a ``unit`` with a ``capacity`` [N], and its ``time`` [s]."""

    unit: str
    largest: float
    time: float
    capacity: float


def largest_loads(run: xr.Dataset) -> Iterator[LargestLoad]:
    """Largest loads, at output times, of all units that have a capacity."""
    for unit, capacity in _capacities(run).items() if run.sizes["time"] else ():
        load = _load_of_unit(run, unit)
        at = int(load.argmax())
        yield LargestLoad(unit, float(load[at]), float(run.time.values[at]), capacity)


def _utilisation_of_unit(run: xr.Dataset, unit: str) -> np.ndarray:
    return _load_of_unit(run, unit) / _capacities(run)[unit]


CHANNEL_KINDS = {
    "speed": ChannelKind(
        lambda run: _labels_of_dim(run, "body"), _horizontal_size("velocity"), "m/s", 0.0
    ),
    "offset": ChannelKind(
        lambda run: _labels_of_dim(run, "body"), _horizontal_size("position"), "m", 0.0
    ),
    "fender_normal_force": ChannelKind(_contact_groups, _group_force, "N"),
    "point_velocity": ChannelKind(_point_channel_names, _axis_value(_velocity_of_point), "m/s"),
    "point_acceleration": ChannelKind(_moving_points, _axis_value(_acceleration_of_point), "m/s^2"),
    "relative_position": ChannelKind(_clearance_names, _axis_value(_place_of_point), "m"),
    "relative_velocity": ChannelKind(_clearance_names, _axis_value(_velocity_of_point), "m/s"),
    "relative_speed": ChannelKind(_point_pairs, _relative_speed, "m/s", 0.0),
    "utilisation": ChannelKind(_capacities, _utilisation_of_unit, "1", 0.0),
}
NEEDS = {
    "acceleration": "output: {accelerations: true} in the case",
    "clearance": "output: {clearances: ...} in the case",
    "point_position": "named points of bodies in the case (bodies.NAME.points)",
    "point_velocity": "named points of bodies in the case (bodies.NAME.points)",
    "point_acceleration": "output: {accelerations: true} and named points of bodies in the case",
    "relative_position": "two named points of bodies in the case (bodies.NAME.points)",
    "relative_speed": "two named points of bodies in the case (bodies.NAME.points)",
    "relative_velocity": "two named points of bodies in the case (bodies.NAME.points)",
    "utilisation": "a capacity of a contact, line, winch, compensator or strut in the case",
    "impulse": "output: {impulses: true} in the case",
}
"""Remedy: keys of a case that give a run the channels of a kind."""


# Envelopes of long series, for pictures.


def interval_envelope(x: np.ndarray, size: int) -> np.ndarray:
    """Smallest and largest values (2, n) of intervals of ``size`` records; x (1, nt) itself if that
    is 1."""
    if size == 1:
        return x[None]
    starts = np.arange(0, x.size, size)
    return np.array([np.fmin.reduceat(x, starts), np.fmax.reduceat(x, starts)])


def interval_means(x: np.ndarray, size: int) -> np.ndarray:
    """Mean (n,) of the finite values in each interval of ``size`` records."""
    starts, is_known = np.arange(0, x.size, size), np.isfinite(x)
    count = np.add.reduceat(is_known.astype(float), starts)
    total = np.add.reduceat(np.where(is_known, x, 0.0), starts)
    return np.where(count > 0.0, total / np.maximum(count, 1.0), np.nan)


# `group_by_size`: series that can share an axis.

MIN_SHARE_OF_AXIS = 0.1
"""Size, relative to the largest series on an axis, below which a series has an axis of its own."""


def group_by_size(series: Mapping[str, np.ndarray]) -> list[dict[str, np.ndarray]]:
    """Series of similar size together, the largest first, each group in the order of ``series``.
    Series that are zero throughout go with the smallest others."""
    sizes = {name: float(np.abs(np.nan_to_num(x)).max(initial=0.0)) for name, x in series.items()}
    groups: list[list[str]] = []
    top = 0.0
    for name in sorted(series, key=lambda name: -sizes[name]):
        if not groups or 0.0 < sizes[name] < MIN_SHARE_OF_AXIS * top:
            groups.append([])
            top = sizes[name]
        groups[-1].append(name)
    return [{name: series[name] for name in series if name in group} for group in groups]
