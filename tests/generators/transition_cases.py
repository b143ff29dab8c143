"""Dry cases that go through the transitions that random cases seldom reach.

All elements that act for a time, compensators on both stops, guides, edges, pumps, locks, springs
about an axis that turn over, and conditions that must last.
"""

from collections.abc import Mapping
from typing import Any

from tests.generators.long_cases import ACCEPTED
from tests.generators.random_cases import Case

MASS = 1000.0  # kg
SLOW = 1000.0  # N/m: with it a cart has a period of 6.28 s
FOR_A_TIME = {"from": 3.0, "until": 9.0}
SHORT_TIME = {"from": 5.0, "until": 6.0}
EAST = [1, 0, 0]
UP = [0, 0, 1]


def transition_cases() -> Mapping[str, Case]:
    """The cases by name."""
    return {
        "elements for a time": _elements_for_a_time(),
        "compensators": _compensators(),
        "turning over": _turning_over(),
        "guides": _guides(),
        "edges": _edges(),
        "pumps": _pumps(),
        "locks": _locks(),
        "drums": _drums(),
        "lasting conditions": _lasting_conditions(),
    }


def _case(bodies: Case, forces: Case, duration: float, **parts: Any) -> Case:
    case = {"title": "transitions", "duration": duration, "accept": list(ACCEPTED)}
    case |= {"environment": {"water_depth": "infinite"}, "bodies": bodies, "forces": forces}
    return {**case, "solver": {"method": "rk4", "step": 0.01}, **parts}


def _body(dofs: list[str], position: Mapping[int, float] | None = None, **velocity: float) -> Case:
    """A body with its displacements [m, rad] at the start by number, and its velocities by name."""
    names = ("surge", "sway", "heave", "roll", "pitch", "yaw")
    start = position or {}
    position = [start.get(i, 0.0) for i in range(6)]
    body = {"mass": MASS, "centre_of_gravity": [0, 0, 0], "radii_of_gyration": [1, 1, 1]}
    initial = {"position": position, "velocity": [velocity.get(name, 0.0) for name in names]}
    return {**body, "dofs": dofs, "initial": initial}


def _spring(body: str, **stiffness: float) -> Case:
    return {"type": "linear_mooring", "body": body, "stiffness": stiffness}


def _push(body: str, **force: Any) -> Case:
    return {"type": "applied_force", "body": body, "force": force}


def _elements_for_a_time() -> Case:
    """A cart that swings by a metre, and elements that act from 3 to 9 s."""
    line = {"body": "cart", "point": [0, 0, 0], "stiffness": 500.0}
    ahead = {**line, "anchor": [20, 0, 0]}
    floor = {"plane": {"point": [0, 0, 0], "normal": UP}, "body": "cart", "points": [[0, 0, 0]]}
    forces = {
        "spring": _spring("cart", surge=SLOW),
        "strut": {**ahead, "type": "strut", "length": 20.0},
        "twist": {"type": "torsion_spring", "body": "cart", "axis": UP, "stiffness": 10.0},
        "bushing": {"type": "bushing", "body": "cart", "stiffness": {"surge": 500.0}},
        "taut": {**ahead, "type": "spring", "length": 18.0},
        "slack": {**ahead, "type": "spring", "length": 22.0},
        "gas": {
            **ahead,
            "type": "compensator",
            "length": 20.0,
            "tension": 500.0,
            "stroke": 1.0,
            "gas_length": 4.0,
            "exponent": 1.3,
            "stiffness": 2000.0,
        },
        "winch": {
            **ahead,
            "type": "winch",
            "stiffness": 20000.0,
            "tension": 300.0,
            "speed": 0.2,
            "dead_band": 0.3,
            "drum": {"shortest": 10.0, "longest": 40.0},
        },
        "held": {
            **ahead,
            "type": "winch",
            "stiffness": 20000.0,
            "tension": 10000.0,
            "speed": 0.2,
            "dead_band": 0.9,
            "drum": {"shortest": 1.0, "longest": 40.0},
            "length": 14.0,
        },
        "floor": {
            **floor,
            "type": "fender",
            "normal": {"prescribed": {"time": [0], "force": [100]}},
            "friction": {"law": "coulomb", "static": 0.3, "kinetic": 0.2},
        },
    }
    for name, element in forces.items():
        if name != "spring":
            element["active"] = dict(FOR_A_TIME)
    return _case({"cart": _body(["surge", "yaw"], {0: 1.0})}, forces, 12.0)


def _compensators() -> Case:
    """Gas springs on both stops, slack, and cut by their damping."""
    bodies = {}
    forces = {}
    for i, damping in enumerate((0.0, 3000.0)):
        name = f"cart{i}"
        bodies[name] = _body(["surge"], {0: 2.0})
        forces[f"spring{i}"] = _spring(name, surge=SLOW)
        gas = {"type": "compensator", "body": name, "point": [0, 0, 0], "anchor": [-20, 0, 0]}
        gas |= {"length": 20.0, "tension": 800.0, "stroke": 1.0, "gas_length": 2.0}
        gas |= {"exponent": 1.3, "stiffness": 2000.0, "damping": damping}
        forces[f"gas{i}"] = gas
        forces[f"push{i}"] = _push(name, surge={"amplitude": 2000.0, "period": 3.0})
    return _case(bodies, forces, 20.0)


def _turning_over() -> Case:
    """A body that turns over and back against a spring about its axis, of a bent curve."""
    twist = {"type": "torsion_spring", "body": "top", "axis": UP}
    curve = {"angle": [-10.0, -1.0, 1.0, 10.0], "moment": [-1000.0, -400.0, 400.0, 1000.0]}
    bodies = {"top": _body(["yaw"], yaw=4.0)}
    return _case(bodies, {"twist": {**twist, "curve": curve}}, 20.0)


def _guides() -> Case:
    """A pin that comes down beside its guide and in it, is pressed to the wall, and leaves it."""
    bodies = {}
    forces = {}
    for i, (aside, active) in enumerate(((0.0, None), (1.2, None), (0.0, {"from": 7.3}))):
        name = f"pin{i}"
        bodies[name] = _body(["surge", "heave"], {2: 1.5})
        forces[f"spring{i}"] = _spring(name, surge=4000.0, heave=SLOW)
        swing = {"amplitude": 3000.0, "period": 2.6, "mean": 4000.0 * aside}
        forces[f"push{i}"] = _push(name, surge=swing)
        landing = {"type": "landing", "body": name, "points": [[0, 0, 0]]}
        landing |= {"on": {"points": [[0, 0, -1.0]]}, "normal": {"stiffness": 20000.0}}
        wall = {"gap": 0.2, "compression": [0, 0.1, 1], "force": [0, 1000, 30000], "depth": 1}
        landing |= {"friction": {"law": "none"}, "wall": wall}
        landing |= {"active": {**active, "until": 15.2}} if active else {}
        forces[f"seat{i}"] = landing
    bodies["still"] = _body(["surge"])
    forces["still"] = _spring("still", surge=SLOW)
    for name, seat in {"free": [0, 0, 0.5], "beside": [0.5, 0, 0.5], "away": [0, 0, -3]}.items():
        wall = {"gap": 0.2, "stiffness": 1000.0, "depth": 1}
        still = {"type": "landing", "body": "still", "points": [[0, 0, 0.6]], "wall": wall}
        still |= {"on": {"points": [seat]}, "normal": {"stiffness": 1.0}}
        still |= {"friction": {"law": "none"}, "active": dict(FOR_A_TIME)}
        forces[f"still_{name}"] = still
    return _case(bodies, forces, 25.0)


def _edges() -> Case:
    """A block that slides over the edge of a table, falls on a spring, and comes back below."""
    table = [[-3, -1, 0], [0.5, -1, 0], [0.5, 1, 0], [-3, 1, 0]]
    normal = {"stiffness": 50000.0, "damping": 500.0}
    law: Case = {"law": "stick_slip", "static": 0.05, "kinetic": 0.04}
    friction = {**law, "stiffness": 20000.0, "damping": 500.0}
    fender = {"type": "fender", "body": "block", "points": [[0, 0, 0]], "normal": normal}
    plane = {"point": [0, 0, 0], "normal": UP, "corners": table}
    bodies = {"block": _body(["surge", "heave"], {0: -1.0})}
    deep = {**fender, "points": [[0, 0, -1]], "plane": {**plane, "point": [0, 0, -2]}}
    forces = {
        "spring": _spring("block", surge=SLOW, heave=3.0 * SLOW),
        "load": _push("block", heave=-2000.0),
        "push": _push("block", surge={"amplitude": 1500.0, "period": 5.0}),
        "table": {**fender, "plane": plane, "friction": friction},
        "deep": {**deep, "friction": friction, "active": {"from": 2.0, "until": 14.0}},
    }
    forces["deep"]["plane"]["corners"] = [[x, y, -2] for x, y, _ in table]
    return _case(bodies, forces, 30.0)


def _pumps() -> Case:
    """Pumps that begin and end by times, levels and events, or because a tank is empty or full."""

    def tank(x: float, level: float) -> Case:
        return {"box": [[x, -1, -1], [x + 1, 1, 1]], "level": level, "density": 1000.0}

    levels = (1.0, 0.5, 1.5, 0.2, 1.9, 0.0, 1.0)
    tanks = {f"t{i}": tank(1.5 * i - 5.0, level) for i, level in enumerate(levels)}
    pump = {"target": "sea", "rate": 200.0}
    pumps = {
        "until_empty": {**pump, "source": "t0"},
        "until_full": {**pump, "source": "sea", "target": "t1", "start": 2.0},
        "until_level": {
            **pump,
            "source": "t2",
            "start": {"tank": "t0", "below": 0.6},
            "stop": {"tank": "t2", "below": 0.9},
        },
        "by_event": {
            **pump,
            "source": "t4",
            "start": {"channel": "velocity.cart.surge", "above": 0.5},
            "stop": {"channel": "velocity.cart.surge", "below": -0.9},
        },
        "nothing_to_pump": {
            **pump,
            "source": "t5",
            "start": {"channel": "velocity.cart.surge", "above": 0.5},
        },
    }
    cart = {**_body(["surge"], {0: 1.0}), "mass": 20000.0, "weight": "carried"}
    tanks["t6"]["plan"] = {"time": [0, 4, 8, 12], "level": [1.0, 0.5, 1.0, 0.8]}
    bodies = {"cart": {**cart, "tanks": tanks, "pumps": pumps}}
    return _case(bodies, {"spring": _spring("cart", surge=20.0 * SLOW)}, 16.0)


def _locks() -> Case:
    """Joints that wait, close, break and open, and ratchets."""
    fixed = {"type": "fixed", "window": {"gap": 0.1, "speed": 0.2}}
    ratchet = {"type": "ratchet", "axis": EAST}
    joints = {
        "waits": {**fixed, "window": {"gap": 0.3, "speed": 5.0}, "active": {"from": 2.0}},
        "waits_in_vain": {**fixed, "active": dict(SHORT_TIME)},
        "closes": {"type": "fixed", "active": dict(FOR_A_TIME)},
        "breaks": {"type": "fixed", "active": {"from": 2.0}, "breaks_at": 1200.0},
        "pawl": {**ratchet, "slide": {}, "active": {"from": 1.0, "until": 11.0}},
        "lifted_pawl": {**ratchet, "slide": {}, "active": {"from": 4.0, "until": 5.0}},
        "stops": {
            "type": "slider",
            "axis": EAST,
            "stops": {"range": [-0.3, 0.3], "stiffness": 20000.0, "damping": 9000.0},
        },
        "teeth": {**ratchet, "slide": {"pitch": 0.05}, "active": {"from": 4.0, "until": 7.5}},
    }
    bodies = {}
    forces = {}
    for name, joint in joints.items():
        joint["body"] = f"cart_{name}"
        bodies[joint["body"]] = _body(["surge"], {0: 1.0})
        forces[f"spring_{name}"] = _spring(joint["body"], surge=SLOW)
        if joint["type"] == "slider":
            del bodies[joint["body"]]["dofs"], bodies[joint["body"]]["initial"]
        forces[f"push_{name}"] = _push(joint["body"], surge={"amplitude": 2000.0, "period": 4.0})
    return _case(bodies, forces, 16.0, joints=joints)


def _drums() -> Case:
    """Winches that keep a tension, with drums that are soon empty or full."""
    line = {"type": "winch", "point": [0, 0, 0], "anchor": [20, 0, 0], "stiffness": 200000.0}
    law = {"tension": 1000.0, "speed": 2.0, "dead_band": 0.3}
    kinds = {"quick": {}, "damped": {"damping": 0.1}, "heavy": {"acceleration": 0.5}}
    kinds |= {"light": {"acceleration": 3.0}, "slow": {"speed": 0.2}}
    bodies = {}
    forces = {}
    for name, keys in kinds.items():
        bodies[name] = _body(["surge"])
        forces[f"spring_{name}"] = _spring(name, surge=SLOW)
        swing = {"amplitude": 6000.0, "period": 5.0, "mean": -1000.0}
        forces[f"push_{name}"] = _push(name, surge=swing)
        drum = {"shortest": 19.4, "longest": 20.3}
        forces[f"winch_{name}"] = {**line, **law, **keys, "body": name, "drum": drum}
    forces["winch_quick"]["length"] = 20.3
    return _case(bodies, forces, 30.0)


def _lasting_conditions() -> Case:
    """A force that begins when a cart has been fast for a while, and ends when it is slow."""
    fast = {"channel": "velocity.cart.surge", "above": 1.0, "lasting": 1.2}
    slow = {"channel": "speed.cart", "below": 1.5, "lasting": 0.4}
    brake = {**_push("cart", surge=-500.0), "active": {"from": fast, "until": slow}}
    push = _push("cart", surge={"amplitude": 800.0, "period": 5.9})
    forces = {"spring": _spring("cart", surge=SLOW), "push": push, "brake": brake}
    return _case({"cart": _body(["surge"])}, forces, 40.0)
