"""hydrosim: multibody 6-DOF time-domain simulation of floating bodies, with exact stick-slip.

import hydrosim as hs
case = hs.load_case("cases/reverse_float_over/base.yaml")
print(hs.check(case))            # warnings, step limits, natural periods
print(hs.analyse(case))          # modes, RAOs, response in the sea
run = hs.simulate(case)          # xarray.Dataset
run.hydrosim.plot.motions()      # and .extremes(), .explain(), .compare(...), .report()

Each command has its function here: `new`, `check`, `analyse`, `simulate`, `study`, `compare`,
`export`, `decay`, `build_database`. Both write the same files.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from collections.abc import Callable
    from inspect import Signature

    from hydrosim.case import Case, load_case
    from hydrosim.compile.compile import compile_scene
    from hydrosim.coupling.moordyn import moordyn
    from hydrosim.coupling.simulation import Simulation
    from hydrosim.database import HydroDatabase
    from hydrosim.database.load import load as load_database
    from hydrosim.elements.external import UserForce
    from hydrosim.errors import HydrosimError, InputError, SimulationError
    from hydrosim.interface.analyse import analyse
    from hydrosim.interface.analyse import fit_decay as decay
    from hydrosim.interface.compare import compare, export
    from hydrosim.interface.database import build_database
    from hydrosim.interface.new import write_new_case as new
    from hydrosim.interface.study import study
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
    "UserForce": "elements.external",
    "analyse": "interface.analyse",
    "build_database": "interface.database",
    "compare": "interface.compare",
    "decay": "interface.analyse",
    "export": "interface.compare",
    "new": "interface.new",
    "study": "interface.study",
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
    "catenary": "Catenary Chain LineDrag Seabed Segment StretchCurve",
    "contacts": "Coulomb Fender Frictionless FrictionSlope Landing LoadPowers NormalCurve"
    " NormalLoop PrescribedNormal Seats StickSlip Wall",
    "damping": "LinearDamping QuadraticDamping SharpBarge ViscousRoll",
    "environment": "Current CurrentPower CurrentTable Environment Gusts Jonswap RegularWave Stream"
    " WaveTrain Wind WindPower",
    "force": "Active When",
    "hydrodynamics": "Coefficients",
    "joint": "Ball BallInitial Cylindrical Fixed Guide Hinge Joint JointWindow Planar Ratchet Rod"
    " Slide SlideFriction SlideInitial SlideStops Slider SlidingPawl Turn TurnFriction TurnInitial"
    " TurnStops TurningPawl Universal",
    "links": "Compensator DryFriction GasSpring Spring SpringDamper Stop Strut StrutCurve"
    " TensionCurve TorsionCurve TorsionSpring",
    "loads": "AppliedForce CurrentLoad WindLoad",
    "plane": "Plane",
    "restraints": "Bushing Drive LinearMooring",
    "scene": "RunOutput Solver Start Tolerance",
    "winch": "Compensation Drum DrumFriction Winch",
}
"""Classes of `hydrosim.scene`, to write a scene with: numbers are in SI, or texts with a unit."""
for _home, _names in _OF_SCENES.items():
    _HOME |= dict.fromkeys(_names.split(), f"scene.{_home}")
__all__ = sorted(_HOME)
_OLD_NAMES = {
    "External": "UserForce",
    "Figure": "ScalarResult",
    "WhyResult": "MotionCauseResult",
}
"""Names of 0.2, which work for one version more."""
_OTHER_WORDS = {
    **dict.fromkeys(("run", "solve", "sim", "Model", "Run"), "hs.simulate(case) runs a case"),
    **dict.fromkeys(
        ("load", "read", "open", "read_run", "load_run"),
        "hs.open_run('run.nc') reads a run, hs.load_case('case.yaml') a case",
    ),
    **dict.fromkeys(
        ("open_study", "load_study", "read_study"), "xarray.open_dataset('study.nc') reads a study"
    ),
    **dict.fromkeys(("sweep", "run_many", "batch"), "hs.simulate_many(cases) runs many cases"),
    **dict.fromkeys(
        ("plot", "extremes", "statistics", "explain", "report", "channel", "channels"),
        "a run has it: run.hydrosim",
    ),
}
"""What is called instead, by the name that was probably expected."""
_NAMES_THERE = {"load_database": "load", "decay": "fit_decay", "new": "write_new_case"}
"""Names of functions in their modules, where another one is public."""
_OF_RUNS = {"analyse", "compare", "open_run", "simulate", "simulate_many", "Simulation", "study"}
"""Functions that return datasets; loading one of them registers `run.hydrosim`."""


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


def __getattr__(name: str) -> Any:
    """Load public names when they are first used, so that a command loads only the modules it
    needs."""
    if name == "__version__":
        return import_module("hydrosim.files.cache").program_version()
    name = _OLD_NAMES.get(name, name)
    if name not in _HOME:
        hint = f"; {_OTHER_WORDS[name]}" if name in _OTHER_WORDS else ""
        raise AttributeError(f"module 'hydrosim' has no attribute {name!r}{hint}")
    if name in _OF_RUNS:
        import_module("hydrosim.interface.accessor")
    module = import_module(f"hydrosim.{_HOME[name]}")
    return getattr(module, _NAMES_THERE.get(name, name))


class _FolderAndFunction(ModuleType):
    """A folder of the package that can be called as the function of the same name."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        return self._function(*arguments, **options)

    @property
    def __signature__(self) -> Signature:
        from inspect import signature

        return signature(self._function)

    @property
    def __doc__(self) -> str | None:  # type: ignore[override]
        """That of the function, which notebooks show."""
        return self._function.__doc__

    @property
    def _function(self) -> Callable[..., Any]:
        name = self.__name__.rpartition(".")[2]
        function: Callable[..., Any] = getattr(import_module(f"hydrosim.{_HOME[name]}"), name)
        return function


class _Folder(ModuleType):
    """A folder of the package with the name of a command whose function has another name."""

    def __call__(self, *_: Any, **__: Any) -> NoReturn:
        name = self.__name__.rpartition(".")[2]
        raise TypeError(f"hs.{name} is no function; {_OTHER_WORDS[name]}")


class _Package(ModuleType):
    """The package. Python sets its folders as attributes once they are imported."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name in _HOME and isinstance(value, ModuleType):
            value.__class__ = _FolderAndFunction
        elif name in _OTHER_WORDS and isinstance(value, ModuleType):
            value.__class__ = _Folder
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
if "xarray" in sys.modules:  # otherwise xarray does it with its first file: `interface.backend`
    import_module("hydrosim.interface.accessor")
