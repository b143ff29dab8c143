"""Random moored scenes, a few of those that `tests.generators.scene_trials` runs."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from markers import few

from hydrosim.case import load_case
from hydrosim.compile.compile import compile_scene
from hydrosim.elements import Catenary, Spring, Winch
from tests.generators.moored_cases import moored_case
from tests.generators.moored_lines import LINES
from tests.generators.random_cases import text_of
from tests.generators.scene_trials import offences, scene_of, tried

FIRST = 1_000_000


CONTROLS = ("length", "tension", "speed", "compensation")


def test_a_random_moored_case_is_one_that_a_case_file_may_hold(tmp_path: Path) -> None:
    """All kinds of lines are drawn, winches of all controls, and all that acts besides them."""
    path = tmp_path / "case.yaml"
    kinds, controls, sizes = Counter[type](), Counter[type](), Counter[int]()
    given = Counter[str]()
    for number in range(FIRST, FIRST + 60):
        text = text_of(moored_case(number))
        assert text == text_of(moored_case(number))
        path.write_text(text)
        scene = load_case(path).scene()
        lines = [e for e in scene.forces.values() if isinstance(e, Catenary | Spring | Winch)]
        assert 2 <= len(lines) <= LINES + 2
        kinds.update(map(type, lines))
        winches = [e for e in lines if isinstance(e, Winch)]
        controls.update(k for e in winches for k in CONTROLS if getattr(e, k) is not None)
        sizes[len(scene.bodies)] += 1
        given["segments"] += any(isinstance(e, Catenary) and len(e.segments) > 1 for e in lines)
        given["friction"] += any(isinstance(e, Catenary) and bool(e.friction) for e in lines)
        given["breaks"] += any(e.active and e.active.until and e.active.until.above for e in lines)
        given["joints"] += bool(scene.joints)
        given["gusts"] += scene.environment.gusts is not None
        given["profile"] += scene.environment.current.profile is not None
    assert kinds.keys() == {Catenary, Spring, Winch}
    assert controls.keys() == set(CONTROLS)
    assert sizes.keys() == {1, 2, 3}
    assert all(given.values())


def test_a_moored_case_is_turned_as_a_whole() -> None:
    scene, turned = scene_of(moored_case, FIRST), scene_of(moored_case, FIRST, 0.7)
    for body, other in zip(scene.bodies, turned.bodies, strict=True):
        assert other.heading == pytest.approx(body.heading + 0.7)
    for name, line in scene.forces.items():
        if isinstance(line, Catenary | Spring | Winch) and line.anchor_body is None:
            before, after = (np.array(e.anchor) for e in (line, turned.forces[name]))
            assert np.hypot(*after[:2]) == pytest.approx(np.hypot(*before[:2]))
            assert after[2] == before[2]


@pytest.mark.parametrize("number", few(range(FIRST, FIRST + 12), 4))
def test_a_random_moored_scene(number: int) -> None:
    """It runs or says why not; its ledger closes; turned, it turns; it goes on to the bit."""
    trial = tried(moored_case, number)
    assert trial.status in ("complete", "failed", "refused"), trial.said
    assert trial.said or trial.status == "complete"
    assert list(offences(trial)) == []


def test_a_place_at_rest_does_not_know_where_north_is() -> None:
    """Newton's method gets stuck on the slack lines of this scene, turned by 0.7 rad."""
    x, y = (compile_scene(scene_of(moored_case, 22, turn)).state.y[:2] for turn in (0.0, 0.7))
    c, s = np.cos(0.7), np.sin(0.7)
    np.testing.assert_allclose(y, [c * x[0] - s * x[1], s * x[0] + c * x[1]], atol=1e-6)
