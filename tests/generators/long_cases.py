"""What cases of 60 to 120 s have in common: their solver, records, and what a file says of them."""

from typing import Any

from tests.generators.random_cases import FINE, STEPS, Case, Draw, rounded

METHODS = {"rk4": 45.0, "dopri5": 25.0, "esdirk4": 12.0, "rk2": 6.0, "automatic": 12.0}
RECORDED = (0.1, 0.2, 0.5, 1.0)  # s
BY_DEFAULT = 0.3  # of the cases: they name no method and no step
ACCEPTED = ("angles", "fall", "friction", "lift", "lines", "periods", "plane", "softness", "speed")
"""Questions that these cases are not to be asked: they mean what they say."""
LOSSES = ("linear_damping", "quadratic_damping", "viscous_roll")
FREE_OF_LOSSES = ("fender", "landing")
"""Elements whose damping stays: contacts need it, others may do without."""


def long_duration(d: Draw) -> float:
    """A duration of 60 to 120 s."""
    return float(round(d.between(60.0, 120.0)))


def long_case(d: Draw, seed: int, rate: float, duration: float, **parts: Any) -> Case:
    """A case with these ``parts``, and a step that goes with its fastest ``rate`` [rad/s]."""
    output = d.one(RECORDED)
    case: Case = {"title": f"long case {seed}", "duration": duration, "accept": list(ACCEPTED)}
    case |= {"environment": {"water_depth": "infinite"}, **parts, "output": {"step": output}}
    if not d.chance(BY_DEFAULT):
        case["solver"] = _solver(d, rate, output)
    return case


def _solver(d: Draw, rate: float, output: float) -> Case:
    method = d.one(tuple(METHODS), *METHODS.values())
    wanted = min(FINE.get(method, 1.0) * d.order(0.08, 0.8) / rate, output)
    step = next((h for h in STEPS if h <= wanted), STEPS[-1])
    return {"method": method, "step": rounded(output / round(output / step))}


def lengthened(case: Case, number: int) -> Case:
    """The ``case`` for 60 to 120 s."""
    return {**case, "duration": long_duration(Draw(number))}


def undamped(case: Case) -> Case:
    """The ``case`` without damping of joints, lines and motions."""
    forces = {name: force for name, force in case["forces"].items() if force["type"] not in LOSSES}
    for name, force in forces.items():
        forces[name] = force if force["type"] in FREE_OF_LOSSES else _without_damping(force)
    return {**case, "joints": _without_damping(case.get("joints", {})), "forces": forces}


def _without_damping(part: Any) -> Any:
    if not isinstance(part, dict):
        return part
    lost = ("damping", "damping_ratio")
    return {key: _without_damping(x) for key, x in part.items() if key not in lost}
