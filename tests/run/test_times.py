"""Step limits and periods of bodies whose mass changes: at the start, at the end, in between."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from reading import number, rows, tables
from scenes import CASES, block, scene

import hydrosim as hs
from hydrosim.analysis.ballast import with_contents_at
from hydrosim.elements import LinearMooring
from hydrosim.errors import InputError
from hydrosim.files.document import Document
from hydrosim.files.document_nodes import Value, Verdict
from hydrosim.linear.linearise import linearise
from hydrosim.linear.modes import natural_modes
from hydrosim.report.sentences.check import check_document
from hydrosim.scene import Box, Environment, Method, Pump, Scene, Tank, Unstable, Weight

MASS, STIFFNESS, RATE = 2e4, 8e5, 80.0
END = 200.0


def lightening(step: float = 0.1, **solver: object) -> Scene:
    """A mass on a spring that loses 16 of its 20 t."""
    tank = Tank("hold", Box((-1.0, -1.0, -2.0), (1.0, 1.0, 2.5)), 4.25, 1000.0)
    pump = Pump("out", RATE, "hold", None)
    body = block(MASS, ("heave",), weight=Weight.CARRIED, tanks=(tank,), pumps=(pump,))
    spring = {"line": LinearMooring("block", np.diag([0, 0, STIFFNESS, 0, 0, 0.0]))}
    hung = scene(body, spring, END, 5 * step, step=step, **solver)
    return replace(hung, environment=Environment(gravity=1e-6))


def periods(document: Document) -> dict[str, float]:
    """Those of heave, by what the tables are of."""
    found = tables(document.nodes, "body", "mode")
    return {t.title: number(rows([t], "body")[0]["natural period"], "s") for t in found}


def test_periods_and_limits_are_told_of_the_mass_at_each_time() -> None:
    """2 pi sqrt(m / k); rk4 is stable up to 2.78 / w."""
    document = check_document(lightening(), [100.0])
    found = periods(document)
    names = ("at the start of the run", "at 100 s", "at 200 s")
    assert [*found] == [f"Natural periods {name}" for name in names]
    omega = np.sqrt(STIFFNESS / (MASS - RATE * np.array([0.0, 100.0, 200.0])))
    assert_allclose([*found.values()], 2.0 * np.pi / omega, rtol=1e-5)
    verdicts = [node for node in document.nodes if isinstance(node, Verdict)]
    limits = [verdict.parts[1] for verdict in verdicts if "stable step" in verdict.text]
    steps = [limit.number for limit in limits if isinstance(limit, Value)]
    assert_allclose(steps, 2.785 / omega, rtol=0.02)


def test_waves_along_a_slow_path_do_not_count_later() -> None:
    """At the end of a run the table of their loads, which is of the block at the start, has nothing
    to say: beyond it, it grows like its third power."""
    path = CASES.parent / "topside_removal" / "tanks.yaml"
    case = hs.load_case(path, {"bodies.barge.tanks.fore_sb.box.0.0": "0 m"})
    end = with_contents_at(hs.compile_scene(case.scene()), 10800.0)
    modes = natural_modes(linearise(end.model, end.state, time=10800.0))
    heave = next(mode for mode in modes if mode.coordinate == 2)
    assert heave.natural_period == pytest.approx(10.14, abs=0.01)


def test_a_step_that_the_end_does_not_stand_is_warned_of() -> None:
    """Stable with 20 t up to 0.44 s, with 4 t up to 0.2 s."""
    run = hs.simulate(replace(lightening(0.25, method=Method.RK4), duration=5.0))
    assert "stable step" not in run.attrs.get("warnings", "")
    refused = lightening(0.25, unstable=Unstable.ERROR)
    with pytest.raises(InputError, match=r"stable step 0\.2 s.*with tanks as at the end, 200 s"):
        hs.simulate(refused)
