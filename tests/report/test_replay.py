"""What a replay draws: hulls, waves, places; and what it says where it cannot."""

from base64 import b64decode
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from browser import COLOURS, opened, until
from command_line import Command, command
from recorded_runs import made_run
from report_pages import Page, data_of, hostile_run
from scipy.spatial.transform import Rotation

from hydrosim.case import load_case
from hydrosim.report.page import MAX_PAGE_BYTES, html
from hydrosim.report.replay import (
    box,
    column,
    keel_of,
    replay_document,
    scene_of,
    shape_of,
    supports_of,
    tanks_of,
    waves_of,
)
from hydrosim.results.dataset import write_run
from hydrosim.water.loads import elevations

ROOT = Path(__file__).parents[2]
MOVE = """(x) => {
  const slider = document.querySelector("#replay input[type=range]");
  slider.value = x;
  slider.dispatchEvent(new Event("input"));
}"""


def page_of(run: xr.Dataset) -> str:
    return html(replay_document(run), "hydrosim 0: replay of [run.nc]")


def test_a_box_has_the_radii_of_gyration_it_is_made_for() -> None:
    sides = np.array([3.0, 2.0, 1.0])
    square = np.array([(4 + 1) / 12, (9 + 1) / 12, (9 + 4) / 12])  # of a homogeneous box
    np.testing.assert_allclose(6.0 * (square.sum() - 2.0 * square), sides**2)
    corners = box(sides)
    np.testing.assert_allclose(np.abs(corners).reshape(-1, 3).max(axis=0), sides / 2)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.sum(np.sum(normals * corners[:, 0], axis=1)) / 6 == pytest.approx(6.0)


def test_the_barge_is_its_hull_and_the_water_its_waves(base_run: xr.Dataset) -> None:
    scene = scene_of(base_run)
    assert scene is not None
    shape = shape_of(scene.bodies[0])
    assert np.ptp(shape.triangles[..., 0]) == pytest.approx(260.0)
    assert np.ptp(shape.triangles[..., 1]) == pytest.approx(63.0)
    low = shape.triangles[..., 2].min() + scene.bodies[0].centre_of_gravity[2]
    assert low == pytest.approx(-12.4)
    kept, said = waves_of(scene, base_run)
    assert "1200 largest of" in said
    time = base_run.time.values[::100]
    made = elevations(kept, np.zeros((1, 2)), time)[:, 0]
    off = made - base_run.wave_elevation.values[::100]
    share = float(said.split("have ")[1].split("%")[0]) / 100.0
    assert np.var(off) < 2.0 * (1.0 - share) * np.var(base_run.wave_elevation.values)


def test_tanks_are_where_they_are_and_as_full_as_they_are() -> None:
    """Of the case, from z -12 to 2 m with the centre of gravity at -4.9 m. A tank that is not in
    the run stays as the case has it."""
    scene = load_case(ROOT / "cases" / "topside_removal" / "tanks.yaml").scene()
    names = [f"{tank.name} of {body.name}" for body in scene.bodies for tank in body.tanks]
    level = 14.0 * np.array([[0.0, 0.25, 0.5], [0.1, 0.35, 0.6]])
    coords = {"time": [0.0, 1.0], "tank": names[:3]}
    found = tanks_of(xr.Dataset({"tank_level": (("time", "tank"), level)}, coords), scene)
    first = found["tanks"][0]
    assert len(found["tanks"]) == len(names) == 4
    assert first["low"] == pytest.approx([10.0, 1.0, -7.1])
    assert first["high"] == pytest.approx([70.0, 28.0, 6.9])
    full = np.frombuffer(b64decode(found["levels"]), "<f4").reshape(2, 4)
    np.testing.assert_allclose(full, [[0.0, 0.25, 0.5, 12 / 14], [0.1, 0.35, 0.6, 12 / 14]], 1e-6)


def test_a_topside_stands_on_its_supports() -> None:
    """Keel at -12.4 m of the topside; legs at z 3.6 m of the earth, where their points are at rest,
    in the order in which contacts are recorded."""
    scene = load_case(ROOT / "cases" / "topside_removal" / "removal.yaml").scene()
    barge, topside = (shape_of(b, keel_of(scene, b.name)) for b in scene.bodies)
    assert keel_of(scene, "barge") is None
    assert topside.triangles[..., 2].min() == pytest.approx(-12.4)
    assert "its contact from below" in topside.said
    found = supports_of(scene, [barge.triangles, topside.triangles], 100.0)
    assert [(each["body"], each["contact"]) for each in found] == [
        (body, k) for k in range(4) for body in (1, -1)
    ]
    legs = np.array([[x, y] for x in (25.0, -25.0) for y in (40.0, -40.0)])
    for k, (arm, under) in enumerate(zip(found[::2], found[1::2], strict=True)):
        corners = np.frombuffer(b64decode(under["triangles"]), "<f4").reshape(-1, 3)
        assert corners[:, 2].max() == pytest.approx(3.6)
        np.testing.assert_allclose(corners[:, :2].mean(axis=0), legs[k], atol=1e-4)
        ends = np.frombuffer(b64decode(arm["triangles"]), "<f4").reshape(-1, 3)
        assert np.abs(ends[:, 1]).max() == pytest.approx(40.0)
        assert np.abs(ends[:, 1]).min() == pytest.approx(np.abs(topside.triangles[..., 1]).max())


def test_a_column_is_closed() -> None:
    """Its volume by the divergence theorem is that of length times side squared."""
    one, other = np.array([1.0, 2.0, 3.0]), np.array([4.0, -2.0, 8.0])
    a, b, c = column(one, other, 0.25).transpose(1, 0, 2)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
    assert abs(volume) == pytest.approx(0.25 * np.linalg.norm(other - one))


def test_other_waves_are_not_drawn(base_run: xr.Dataset) -> None:
    scene = scene_of(base_run)
    for run in (base_run, base_run.assign_attrs(case_resolved="")):
        other = run.assign(wave_elevation=1.01 * run.wave_elevation)
        kept, said = waves_of(scene_of(run) and scene, other)
        assert kept == []
        assert "drawn flat" in said


def test_a_run_without_its_case_has_boxes() -> None:
    page = Page(page_of(made_run(duration=60.0)))
    assert "a box, because its case cannot be read again" in page.texts["li"]
    assert "drawn flat" in page.texts["li"]


def test_hostile_names_are_names() -> None:
    text = page_of(hostile_run())
    assert Page(text).count("script") == 3
    assert Page(text).count("img") == 0


def test_the_command_writes_a_page(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    replay: Command = command(monkeypatch, capsys, "replay")
    write_run(made_run(duration=60.0), tmp_path / "made.nc")
    assert replay("made.nc").code == 0
    assert (tmp_path / "made_replay.html").stat().st_size < MAX_PAGE_BYTES
    write_run(made_run(duration=60.0).isel(time=slice(1)), tmp_path / "short.nc")
    assert "nothing to replay" in replay("short.nc").err
    many = {"status": ("run", ["complete"] * 3)}
    xr.Dataset(many).to_netcdf("many.nc")
    assert "holds 3 runs" in replay("many.nc").err


@pytest.mark.browser
def test_the_slider_moves_the_barge(base_run: xr.Dataset, tmp_path: Path) -> None:
    path = tmp_path / "replay.html"
    path.write_text(page_of(base_run), "utf-8")
    with opened(path) as (page, said, asked):
        canvas = page.locator("#replay canvas").first
        assert until(page, lambda: canvas.evaluate(COLOURS) > 8)
        first = canvas.evaluate("(canvas) => canvas.toDataURL()")
        page.evaluate(MOVE, 1200.0)
        assert until(page, lambda: "1200.0 s" in page.locator("#replay output").inner_text())
        assert until(page, lambda: canvas.evaluate("(canvas) => canvas.toDataURL()") != first)
        now = base_run.sel(time=1200.0).isel(fender=0)
        mode = ["open", "stick", "slip"][int(now.fender_mode)]
        said_of = f"interface 1: {mode} {float(now.fender_normal_force) / 1e3:.0f} kN"
        assert said_of in page.locator(".forces").inner_text()
        check_places(page, base_run)
        assert [said, asked] == [[], []]


def check_places(page: object, run: xr.Dataset) -> None:
    """Places and rotations against those of the simulation, the water against its waves."""
    evaluate = page.evaluate  # type: ignore[attr-defined]
    model = np.array(evaluate("window.hydrosim.replay.models(1200)")[0]).reshape(4, 4).T
    at = run.position.sel(time=1200.0, body="barge").values
    rest = run.reference_position.sel(body="barge").values
    np.testing.assert_allclose(model[:3, 3], rest + at[:3], atol=1e-4)
    turned = Rotation.from_euler("ZYX", at[:2:-1]).as_matrix()  # intrinsic z-y'-x''
    np.testing.assert_allclose(model[:3, :3], turned, atol=1e-6)
    surface = np.array(evaluate("Array.from(window.hydrosim.replay.surface)")).reshape(-1, 3)
    kept, _ = waves_of(scene_of(run), run)
    some = surface[::97]
    expected = elevations(kept, some[:, :2], np.array([1200.0]))[0]
    np.testing.assert_allclose(some[:, 2], expected, atol=5e-3)  # phases of four bytes at 1200 s


def test_the_data_of_a_replay_are_those_of_the_run(base_run: xr.Dataset) -> None:
    import base64

    data = data_of(page_of(base_run))["replay"]
    position = np.frombuffer(base64.b64decode(data["position"]), "<f4").reshape(-1, 1, 6)
    step = -(-base_run.time.size // len(position))
    np.testing.assert_array_equal(position, base_run.position.values[::step].astype("f4"))
    assert [contact["name"] for contact in data["contacts"]] == list(base_run.fender.values)
