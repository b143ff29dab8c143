"""What is said of a scene before it runs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
from scenes import block, hull, scene_of

import hydrosim as hs
from hydrosim import check, simulate
from hydrosim.compile.compile import compile_scene
from hydrosim.compile.questions.waters import OUTSIDE_REFUSED, ask_about_ranges
from hydrosim.compile.scene_notes import OUTSIDE_WARNED, range_warnings
from hydrosim.report.document import run_document as report_document
from hydrosim.report.sentences.run import run_document
from hydrosim.scene import Question, SpectrumTable, WhiteNoise
from hydrosim.water.components import sea

NOISE = hs.WaveTrain(WhiteNoise(1.0, 0.5, 1.5))  # a band of 1 rad/s: shares of it are frequencies


@dataclass(frozen=True, eq=False)
class Loads:
    """What is read of a database."""

    frequency: np.ndarray
    excitation: np.ndarray


def said(share: float, power: float = 0.0, **forces: bool) -> tuple[list[str], list[str]]:
    """Warnings and refusals, if a share of energy is above a database; loads go as w^power."""
    body = replace(block(1.0), wave_forces=hs.WaveForces(**forces))
    frequency = np.linspace(0.1, 1.5 - share, 50)
    loads = np.tile(frequency[:, None, None] ** power + 0j, (1, 8, 6))
    database = Loads(frequency, loads)
    seas = sea(hs.Environment(waves=(NOISE,)))
    about = SimpleNamespace(floating_bodies=lambda: [(0, body, database)], sea=seas)
    asked = [doubt.found for doubt in ask_about_ranges(about)]
    return list(range_warnings(seas, body, database)), asked


def test_energy_outside_a_database() -> None:
    """Of the waves, where loads do not fall as those on a wall do."""
    # the last 0.1 % is cut off, and a component is 0.06 % of the energy
    assert said(0.5 * OUTSIDE_WARNED, 8.0) == ([], [])
    (warning,), refused = said(0.8 * OUTSIDE_REFUSED, 8.0)
    assert not refused
    assert "of the waves' energy outside the frequencies of the database of block" in warning
    warned, (found,) = said(1.2 * OUTSIDE_REFUSED + 1e-3, 8.0)
    assert not warned
    assert "1.2% of the waves' energy outside" in found
    assert said(0.9, 8.0, first_order=False) == ([], [])


def test_loads_outside_a_database() -> None:
    """With loads as w^-2, those above 1.2 rad/s are int w^-4 dw from there over that of all."""
    share = (1.2**-3 - 1.5**-3) / (0.5**-3 - 1.5**-3)
    _, (found,) = said(0.3, -2.0)
    assert "29.9% of the waves' energy" in found
    assert f"an estimated fraction {share:.2g} of the energy of its loads" in found
    (warning,), refused = said(0.1, -2.0)
    assert not refused
    assert warning.endswith("these waves have no first-order loads.")


def test_each_sea_is_in_one_line_of_check_run_and_report() -> None:
    """Of a triangle from 0.5 to 2.5 about 1.5 of the lowest frequency an eighth is below it."""
    base = scene_of("base")
    low = float(hull().frequency[0])
    triangle = SpectrumTable(low * np.array([0.5, 1.5, 2.5]), np.array([0.0, 1e-2, 0.0]) / low)
    swell = hs.WaveTrain(triangle, np.pi / 2.0, spreading=4.0, repeat_period=36000.0)
    waves = (swell, hs.WaveTrain(hs.RegularWave(0.5, 9.0), 0.25))
    environment = replace(base.environment, waves=waves)
    scene = replace(base, environment=environment, duration=2.0, accept=tuple(Question))
    table, regular = compile_scene(scene).notes.seas
    peak = f"table, Hs 0.4 m, Tp {2.0 * np.pi / (1.5 * low):.3g} s, goes to 90 deg, spreading"
    assert table.startswith(f"{peak} {np.degrees(np.sqrt(0.4)):.2g} deg; 12.50% of its energy")
    assert table.endswith(f"outside the frequencies of {scene.bodies[0].name}")
    assert regular.startswith("regular wave, amplitude 0.5 m, period 9 s, goes to 14.3 deg, long")
    run = simulate(scene)
    for document in (check(scene), run_document(run), report_document(run)):
        text = str(document)
        assert table in " ".join(text.split())
        assert regular in " ".join(text.split())
