"""Mooring lines of MoorDyn as an external force (Hall & Goupee 2015; BSD licence, the extra
``moordyn``).

MoorDyn advances its lines itself, by its own short steps ``dtM``. It is called once where each
accepted step ends, and is led there along the path of its coupled points since the call before:
the cubic through their places and velocities at both ends, in straight pieces of ``dtM``. One
straight piece for the whole step would give its dampers a velocity that is half a step old, an
error of order 1. The forces that it gives at t_n act over the next step: held, order 1, or
extrapolated, order 2. At the start it finds its own state of rest, with its options for that.
"""

from __future__ import annotations

from base64 import b64decode, b64encode
from collections.abc import Mapping
from importlib import import_module
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from hydrosim.elements.external import BodyState, Coupling, UserForce
from hydrosim.errors import InputError

USUAL_STEP = 1e-3  # s, of MoorDyn where its file gives none
EQUAL_STEP_RTOL = 1e-9  # of a step: longer steps by less than this are one step


def moordyn(
    file: str | Path,
    body: str | Mapping[int, str],
    coupling: Coupling | str = Coupling.EXTRAPOLATED,
) -> UserForce:
    """Lines of a MoorDyn input ``file`` as an `UserForce`, for ``forces`` of `simulate` or
    `Simulation`.

    Every coupled point of the file is fixed to ``body``, or to the body that a mapping has for its
    ID. The file has its place in the earth frame [m] with that body at rest. ``coupling`` is "held"
    (order 1) or "extrapolated" (order 2). Each run needs an object of its own. MoorDyn writes its
    own results beside the file. Raises InputError if MoorDyn is missing or cannot read the file.
    """
    if coupling not in (Coupling.HELD, Coupling.EXTRAPOLATED):
        raise InputError(
            f"moordyn: found coupling {coupling}; expected held or extrapolated: MoorDyn advances"
            " its own state, so it cannot be asked again at a stage of a step."
        )
    lines = MoorDyn(Path(file), body)
    first, *others = lines.bodies
    return UserForce(first, lines, coupling, also=tuple(others))


class MoorDyn:
    """The function of the force: MoorDyn's lines, which remember."""

    def __init__(self, file: Path, body: str | Mapping[int, str]) -> None:
        self._library = _load_library()
        if not file.is_file():
            raise InputError(f"moordyn: there is no file {file}; expected an input of MoorDyn.")
        self._file = file
        try:
            self._system = self._library.Create(str(file))
        except RuntimeError as error:
            text = f"{file}: MoorDyn cannot read it ({error}); what it printed above has the line."
            raise InputError(text) from error
        coupled = self._coupled_points()
        self._owners = _point_owners(file, coupled, body)
        self._rest = np.array(list(coupled.values()))
        self.bodies = list(dict.fromkeys(self._owners))
        self._points: np.ndarray | None = None
        self._time = -np.inf
        self._place = np.zeros(self._rest.shape)
        self._speed = np.zeros(self._rest.shape)
        self._own_step = _own_step(file)

    def _coupled_points(self) -> dict[int, tuple[float, ...]]:
        """Places (3,) [m] of the coupled points, by their ID."""
        library = self._library
        locations = {}
        for number in range(1, library.GetNumberPoints(self._system) + 1):
            point = library.GetPoint(self._system, number)
            if library.GetPointType(point) == library.POINT_TYPE_COUPLED:
                locations[number] = tuple(library.GetPointPos(point))
        freedoms = library.NCoupledDOF(self._system)
        if not locations or freedoms != 3 * len(locations):
            raise InputError(
                f"{self._file}: found {freedoms} coupled degrees of freedom and {len(locations)}"
                " coupled points; expected 3 for each of one or more points. Replace coupled"
                " bodies and rods by coupled points."
            )
        return locations

    def __call__(self, t: float, state: Mapping[str, BodyState]) -> np.ndarray:
        """Wrenches (k, 6) [N, N m] on the bodies; raises ValueError if MoorDyn fails or if time
        does not rise."""
        if self._points is None:
            self._points = self._in_body_frames(state)
        owners = [state[name] for name in self._owners]
        parts = list(zip(owners, self._points, strict=True))
        place = np.array([body.place(point) for body, point in parts])
        speed = np.array([body.velocity_of(point) for body, point in parts])
        if self._time == -np.inf:
            forces = self._begin(place, speed)
        else:
            forces = self._go_on(t, place, speed)
        self._time = t
        self._place = place
        self._speed = speed
        wrench = {name: np.zeros(6) for name in self.bodies}
        for name, (body, point), force in zip(self._owners, parts, forces, strict=True):
            wrench[name] += body.wrench(force, point)
        wrenches = np.array(list(wrench.values()))
        return wrenches if len(wrenches) > 1 else wrenches[0]

    def _begin(self, place: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """Forces (n, 3) [N] on the coupled points at the start."""
        library = self._library
        library.Init(self._system, place.ravel().tolist(), speed.ravel().tolist())
        numbers = range(1, library.GetNumberPoints(self._system) + 1)
        points = [library.GetPoint(self._system, number) for number in numbers]
        coupled = [p for p in points if library.GetPointType(p) == library.POINT_TYPE_COUPLED]
        return np.array([library.GetPointForce(point) for point in coupled])

    def _go_on(self, t: float, place: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """Forces (n, 3) [N] on the coupled points after a step to ``t`` [s]."""
        step = t - self._time
        if step <= 0.0:
            raise ValueError(
                f"MoorDyn is at {self._time:g} s and cannot go back to {t:g} s; make a new"
                " hydrosim.moordyn for each run"
            )
        pieces = max(ceil(step / self._own_step * (1.0 - EQUAL_STEP_RTOL)), 1)
        short = float(f"{step / pieces:.12g}")  # it takes one step more for a rounding above dtM
        before = self._place
        for k in range(pieces):
            x = (k + 1) / pieces
            after = _places_on_cubic(x, step, self._place, self._speed, place, speed)
            rate = (after - before) / short
            now = self._time + k * short
            there = before.ravel().tolist()
            forces = self._library.Step(self._system, there, rate.ravel().tolist(), now, short)
            before = after
        return np.array(forces).reshape(-1, 3)

    def _in_body_frames(self, state: Mapping[str, BodyState]) -> np.ndarray:
        """Coupled points (n, 3) [m] in the frames of their bodies."""
        points = []
        for name, place in zip(self._owners, self._rest, strict=True):
            body = state[name]
            points.append(_turned_back(body, place - body.reference))
        return np.array(points)

    def get_state(self) -> dict[str, Any]:
        """State of the lines, for a restart."""
        points = None if self._points is None else self._points.tolist()
        lines = b64encode(self._library.Serialize(self._system)).decode()
        return {
            "time": self._time,
            "place": self._place.tolist(),
            "speed": self._speed.tolist(),
            "points": points,
            "lines": lines,
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Go on from a state that `get_state` gave."""
        if state["points"] is None:
            return
        self._points = np.array(state["points"])
        self._place = np.array(state["place"])
        self._speed = np.array(state["speed"])
        rest = self._place.ravel().tolist()
        if self._time == -np.inf:
            self._library.Init_NoIC(self._system, rest, np.zeros(len(rest)).tolist())
        self._library.Deserialize(self._system, b64decode(state["lines"]))
        self._time = float(state["time"])

    def __del__(self) -> None:
        if getattr(self, "_system", None) is not None:
            self._library.Close(self._system)


def _load_library() -> Any:
    try:
        return import_module("moordyn")
    except ImportError:
        raise InputError(
            "moordyn: the package is not installed; expected the extra: pip install"
            " hydrosim[moordyn]."
        ) from None


def _point_owners(
    file: Path, points: Mapping[int, tuple[float, ...]], body: str | Mapping[int, str]
) -> list[str]:
    """Name of the body of each coupled point."""
    if isinstance(body, str):
        return [body] * len(points)
    if {*body} != {*points}:
        raise InputError(
            f"moordyn: found bodies for the points {sorted(body)}; expected one for each coupled"
            f" point of {file}: {sorted(points)}."
        )
    return [body[number] for number in points]


def _own_step(file: Path) -> float:
    """MoorDyn's own step ``dtM`` [s], from the options of the file."""
    for line in file.read_text(errors="replace").splitlines():
        value, *names = line.split() or [""]
        if names and names[0].lower() == "dtm":
            return float(value)
    return USUAL_STEP


def _places_on_cubic(
    x: float, h: float, a: np.ndarray, va: np.ndarray, b: np.ndarray, vb: np.ndarray
) -> np.ndarray:
    """Places at the fraction ``x`` of a step of ``h`` [s], on the cubic from the places ``a`` to
    ``b`` with the velocities ``va`` and ``vb``."""
    y = 1.0 - x
    ends = a * (1.0 + 2.0 * x) * y * y + b * (3.0 - 2.0 * x) * x * x
    return np.asarray(ends + h * x * y * (va * y - vb * x))


def _turned_back(body: BodyState, arm: np.ndarray) -> np.ndarray:
    """A lever arm (3,) along the earth's axes with the body at rest, in its own frame."""
    if not body.exact:
        return arm
    R = body.rotation
    heading = np.arctan2(R[1, 0], R[0, 0]) - body.position[5]
    c = np.cos(heading)
    s = np.sin(heading)
    return np.array([c * arm[0] + s * arm[1], c * arm[1] - s * arm[0], arm[2]])
