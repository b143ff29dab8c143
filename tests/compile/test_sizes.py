"""What cannot fit is said before it is tried; what is estimated is about what comes."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from scenes import scene_of

import hydrosim as hs
from hydrosim.compile import sizes
from hydrosim.compile.validate_scene import check_scene
from hydrosim.errors import InputError
from hydrosim.scene import ConvolutionRadiation, Question, Scene, StateSpaceRadiation

TOO_LARGE: dict[str, tuple[dict[str, Any], str]] = {
    "steps": ({"duration": 1e12}, r"duration: found 1e\+12 s in steps of 0.1 s, 1.0e\+13 steps"),
    "records": (
        {"duration": 1e10},
        r"output.step: the run needs about [\d.]+ TB of memory, .* Record less often",
    ),
    "a fine table": (
        {"radiation": StateSpaceRadiation(length=1e4, step=0.1)},
        r"bodies.barge.radiation: found a table of 1e\+05 rows",
    ),
    "a long memory": (
        {"radiation": ConvolutionRadiation(length=1e12)},
        "bodies.barge.radiation: found a table",
    ),
    "waves": ({"repeat_period": 1e12}, r"repeat_period: found \d.*e\+11 waves in all trains"),
}


def changed(scene: Scene, **changes: Any) -> Scene:
    """The scene with other values of its own, of its body or of its waves."""
    (body,), (train,) = scene.bodies, scene.environment.waves
    if "radiation" in changes:
        return replace(scene, bodies=(replace(body, **changes),))
    if "repeat_period" in changes:
        sea = replace(scene.environment, waves=(replace(train, **changes),))
        return replace(scene, environment=sea)
    return replace(scene, **changes)


@pytest.mark.parametrize("what", TOO_LARGE)
def test_what_cannot_fit_is_refused(what: str) -> None:
    changes, told = TOO_LARGE[what]
    with pytest.raises(InputError, match=told):
        hs.compile_scene(changed(scene_of("base"), **changes))


def test_trains_count_together() -> None:
    scene = scene_of("base")
    sea = replace(scene.environment, waves=scene.environment.waves * 3000)
    with pytest.raises(InputError, match=r"found \d.*e\+0\d waves in all trains"):
        hs.compile_scene(replace(scene, environment=sea))


def test_a_run_of_many_hours_is_asked_about() -> None:
    scene = scene_of("base")
    fine = replace(scene, solver=replace(scene.solver, step=1e-6))
    with pytest.raises(InputError, match=r"solver.step: found 1e-06 s, 2.0e\+09 steps of 2000 s"):
        hs.compile_scene(fine)
    hs.compile_scene(replace(fine, accept=(Question.STEP,)))


def test_bodies_that_do_not_feel_each_other_need_memory_for_themselves_alone() -> None:
    """A table of retardation functions for each of them, not for each pair."""
    scene = scene_of("free_floating")
    still = replace(scene, environment=replace(scene.environment, waves=())).with_output(step=1e3)
    (barge,) = still.bodies
    apart = [replace(barge, name=f"{k}", location=(0.0, 500.0 * k)) for k in range(64)]
    alone = sizes.memory_needed(still)
    assert sizes.memory_needed(replace(still, bodies=tuple(apart))) < 80.0 * alone
    near = [replace(each, location=barge.location) for each in apart]
    assert sizes.memory_needed(replace(still, bodies=tuple(near))) > 1000.0 * alone


def test_what_needs_no_memory_is_none_of_it() -> None:
    """A long run with few records, in waves that are summed one by one."""
    scene = scene_of("free_floating")
    check_scene(replace(scene, duration=1e7).with_output(step=1e3))


@pytest.mark.parametrize("name", ["base", "free_floating"])
def test_the_size_of_a_result_is_foretold(name: str, tmp_path: Path) -> None:
    scene = replace(scene_of(name), duration=200.0)
    hs.simulate(scene).to_netcdf(tmp_path / "run.nc")
    size = (tmp_path / "run.nc").stat().st_size
    assert 0.5 * size < sizes.result_size(scene) + 30_000 < 2.0 * size  # names and texts are 30 kB
    assert sizes.memory_needed(scene) > sizes.result_size(scene)


def test_a_container_has_the_memory_that_it_was_given(tmp_path, monkeypatch):
    (tmp_path / "memory.max").write_text("1000000\n")
    monkeypatch.setattr(sizes, "CONTAINER", tmp_path / "memory.max")
    with pytest.raises(InputError, match=r"only 1 MB exist"):
        check_scene(scene_of("base"))
    (tmp_path / "memory.max").write_text("max\n")
    check_scene(scene_of("base"))


def test_a_plane_of_a_body_that_is_not_there() -> None:
    scene = scene_of("base")
    plane = hs.Plane((0.0, 0.0, 3.6), (0.0, 0.0, -1.0), "topside")
    lost = replace(scene.forces["interface"], plane=plane)
    said = r"forces.interface.plane.body: found topside, which is no body of the scene"
    with pytest.raises(InputError, match=said):
        hs.compile_scene(replace(scene, forces={**scene.forces, "interface": lost}))


@pytest.mark.parametrize(("size", "text"), [(2.5e6, "2.5 MB"), (1e3, "1 kB"), (3e15, "3e+03 TB")])
def test_bytes_in_words(size: float, text: str) -> None:
    assert sizes.size_text(size) == text
