import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as in the command: small matrices only wait

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import hypothesis
import kept_fits
import pytest
import xarray as xr
from command_line import Command, command
from rich.console import Console
from scenes import scene_of
from stated_lines import WRITING, unlike

import hydrosim as hs
from hydrosim.cli.terminal import announce_compiling
from hydrosim.report.evidence import EvidenceLine, Feature, Kind
from hydrosim.water.radiation import kept

hypothesis.settings.register_profile(  # no test is about wall time
    "hydrosim", deadline=None, suppress_health_check=[hypothesis.HealthCheck.too_slow]
)
hypothesis.settings.load_profile("hydrosim")


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compiles the kernels before workers begin, or each of them would compile them all."""
    if not hasattr(session.config, "workerinput"):
        kept_fits.unpack()
    if session.config.getoption("numprocesses", None):
        with announce_compiling(Console()):
            hs.simulate(replace(scene_of("base"), duration=1.0))


@pytest.fixture(scope="session")
def base_run() -> xr.Dataset:
    """The base case: 2000 s at a step of 0.1 s."""
    return hs.simulate(scene_of("base"))


@pytest.fixture
def fits_made_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """No fit of radiation is read from a store: another processor that made one may have rounded
    otherwise, and a fit of the same numbers then has other states."""
    for name in ("stored", "read_shipped"):
        monkeypatch.setattr(kept, name, lambda *_: None)
    monkeypatch.setattr(kept, "store", lambda *_: None)


@pytest.fixture
def hydrosim(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Command:
    """Runs `hydrosim` in this process, as the installed script does: in an empty folder, on a wide
    terminal."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    return command(monkeypatch, capsys)


@pytest.fixture
def figure(record_property: Callable[[str, object], None]) -> Callable[[str, float], None]:
    """Notes a measured figure: in the test report, and on the terminal with ``pytest -rP``."""

    def note(name: str, value: float) -> None:
        record_property(name, float(value))  # execnet sends no numbers of numpy
        print(f"{name}: {value:.6g}")

    return note


@pytest.fixture
def validated(
    request: pytest.FixtureRequest, record_property: Callable[[str, object], None]
) -> Callable[..., None]:
    """Asserts that an error against a reference is within its limit, and notes it as a line of
    evidence: kind of the reference, claim, name of the reference, error, limit, features of the
    scenes that the line is about, and what others have there.

    A line that is noted several times counts with its largest error. Each must be on the page of
    evidence, with this limit and with no smaller error than this.
    """
    writing = request.config.pluginmanager.has_plugin(WRITING)

    def note(
        kind: Kind,
        claim: str,
        against: str,
        error: float,
        limit: float,
        *features: Feature,
        others: str = "",
    ) -> None:
        test = request.node.nodeid.split("[")[0]
        line = EvidenceLine(claim, against, kind, float(error), limit, features, test, "", others)
        record_property(WRITING, line.as_dict())
        print(f"{claim}, against {against}: {error:.2g} of {limit:g} ({others})")
        assert error <= limit
        if not writing:
            assert unlike(line) == ""

    return note
