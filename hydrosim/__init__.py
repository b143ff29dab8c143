"""hydrosim: multibody 6-DOF time-domain simulation of floating bodies, with exact stick-slip.

import hydrosim as hs
case = hs.load_case("cases/reverse_float_over/base.yaml")
print(hs.check(case))            # warnings, step limits, natural periods
run = hs.simulate(case)          # xarray.Dataset
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hydrosim.case import Case, load_case
    from hydrosim.compile.compile import compile_scene
    from hydrosim.coupling.moordyn import moordyn
    from hydrosim.coupling.simulation import Simulation
    from hydrosim.database import HydroDatabase
    from hydrosim.database.load import load as load_database
    from hydrosim.elements.external import External
    from hydrosim.errors import HydrosimError, InputError, SimulationError
    from hydrosim.linear.linearise import linearise
    from hydrosim.linear.modes import natural_modes
    from hydrosim.report.sentences.check import check
    from hydrosim.scene import Scene
    from hydrosim.simulation import open_run, simulate
    from hydrosim.statistics.figures import ScalarResult
    from hydrosim.statistics.results import MotionCauseResult, StageResult
    from hydrosim.study.executors import Pool
    from hydrosim.study.many_runs import simulate_many

_HOME = {
    "Case": "case",
    "load_case": "case",
    "HydroDatabase": "database",
    "load_database": "database",
    "External": "elements.external",
    "HydrosimError": "errors",
    "InputError": "errors",
    "SimulationError": "errors",
    "linearise": "linear.linearise",
    "natural_modes": "linear.modes",
    "moordyn": "coupling.moordyn",
    "open_run": "simulation",
    "compile_scene": "compile.compile",
    "Scene": "scene",
    "simulate": "simulation",
    "Simulation": "coupling.simulation",
    "simulate_many": "study.many_runs",
    "ScalarResult": "statistics.figures",
    "StageResult": "statistics.results",
    "MotionCauseResult": "statistics.results",
    "Pool": "study.executors",
    "check": "report.sentences.check",
}
_OF_SCENES = {
    "body": "Body Clearance Plan Pump Tank WaveForces",
    "contacts": "Coulomb Fender Frictionless FrictionSlope Landing LoadPowers NormalCurve"
    " NormalLoop PrescribedNormal Seats StickSlip Wall",
    "damping": "LinearDamping QuadraticDamping SharpBarge ViscousRoll",
    "environment": "Environment Gusts Jonswap RegularWave Stream WaveTrain",
    "force": "Active When",
    "hydrodynamics": "Coefficients",
    "joint": "Joint",
    "links": "Compensator DryFriction GasSpring Spring SpringDamper Strut TorsionSpring",
    "loads": "AppliedForce CurrentLoad WindLoad",
    "plane": "Plane",
    "restraints": "Bushing LinearMooring",
    "scene": "Solver Start Tolerance",
}
"""Classes of `hydrosim.scene`, to write a scene with: numbers are in SI, or texts with a unit."""
for _home, _names in _OF_SCENES.items():
    _HOME |= dict.fromkeys(_names.split(), f"scene.{_home}")
__all__ = sorted(_HOME)
_OLD_NAMES = {"Figure": "ScalarResult", "WhyResult": "MotionCauseResult"}
"""Names of 0.2, which work for one version more."""
_OF_RUNS = {"open_run", "simulate", "simulate_many", "Simulation"}
"""Functions that return runs; loading one of them registers `run.hydrosim`."""


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


def __getattr__(name: str) -> Any:
    """Load public names when they are first used, so that a command loads only the modules it
    needs."""
    if name == "__version__":
        return import_module("hydrosim.files.cache").program_version()
    name = _OLD_NAMES.get(name, name)
    if name not in _HOME:
        raise AttributeError(f"module 'hydrosim' has no attribute {name!r}")
    if name in _OF_RUNS:
        import_module("hydrosim.report.accessor")
    module = import_module(f"hydrosim.{_HOME[name]}")
    return getattr(module, "load" if name == "load_database" else name)
