from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as in the command: small matrices only wait

from collections.abc import Callable
from dataclasses import replace

import hypothesis
import pytest
import xarray as xr
from moored_barge import scene_of
from rich.console import Console

import hydrosim as hs
from hydrosim.commands.compiling import announced

hypothesis.settings.register_profile(  # no test is about wall time
    "hydrosim", deadline=None, suppress_health_check=[hypothesis.HealthCheck.too_slow]
)
hypothesis.settings.load_profile("hydrosim")


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compiles the kernels before workers begin, or each of them would compile them all."""
    if session.config.getoption("numprocesses", None):
        with announced(Console()):
            hs.simulate(replace(scene_of("base"), duration=1.0))


@pytest.fixture(scope="session")
def base_run() -> xr.Dataset:
    """The base case: 2000 s at a step of 0.1 s."""
    return hs.simulate(scene_of("base"))


@pytest.fixture
def figure(record_property: Callable[[str, object], None]) -> Callable[[str, float], None]:
    """Notes a measured figure: in the test report, and on the terminal with ``pytest -rP``."""

    def note(name: str, value: float) -> None:
        record_property(name, float(value))  # execnet sends no numbers of numpy
        print(f"{name}: {value:.6g}")

    return note


@pytest.fixture
def validated(record_property: Callable[[str, object], None]) -> Callable[..., None]:
    """Notes a relative error against a reference that is not this code, for the table of
    ``python -m benchmarks validation``: the case, the reference, our error, and what the best of
    others has there. A case that is noted several times counts with its largest error."""

    def note(case: str, reference: str, error: float, others: str = "") -> None:
        record_property("validation", (case, reference, float(error), others))
        print(f"{case}, against {reference}: {error:.2g}" + (f" ({others})" if others else ""))

    return note
