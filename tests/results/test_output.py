"""The dataset of a run: what is in it, what it says of itself, and its file."""

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pint
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from scenes import CASES, block, hull, in_contact, scene_of

import hydrosim as hs
from hydrosim.dofs import DOFS
from hydrosim.results import phases
from hydrosim.results.channels import CHANNEL_KINDS, channel_series
from hydrosim.results.dataset import PURPOSE, RESTART, read_run, write_run
from hydrosim.results.variables import MIXED, VARIABLES
from hydrosim.scene import Environment, Method, RegularWave, Scene, Solver, WaveTrain
from hydrosim.scene.contacts import Frictionless, PrescribedNormal
from hydrosim.scene.signal import Table

MOTION = ("time", "body", "dof")
EXPECTED = {
    **dict.fromkeys(("position", "velocity"), MOTION),
    "reference_position": ("body", "axis"),
    "wave_elevation": ("time",),
    **dict.fromkeys(("force_hydrostatic", "force_radiation"), MOTION),
    **dict.fromkeys(("force_wave_first_order", "force_wave_second_order"), MOTION),
    **dict.fromkeys(("force_mooring", "force_deballast", "force_interface"), MOTION),
    **dict.fromkeys(("fender_compression", "fender_normal_force"), ("time", "fender")),
    **dict.fromkeys(("fender_mode", "fender_slip_distance"), ("time", "fender")),
    **dict.fromkeys(("fender_friction", "fender_node"), ("time", "fender", "axis")),
    "contact_phase": ("time", "contact_group"),
    **dict.fromkeys(("energy_kinetic", "energy_stored_hydrostatic"), ("time",)),
    **dict.fromkeys(("energy_stored_mooring", "energy_stored_interface"), ("time",)),
    **dict.fromkeys(("energy_dissipated_radiation", "energy_dissipated_mooring"), ("time",)),
    **dict.fromkeys(("energy_dissipated_interface", "energy_work_deballast"), ("time",)),
    **dict.fromkeys(("energy_work_wave_first_order", "energy_residual"), ("time",)),
    **dict.fromkeys(("energy_work_wave_second_order", "energy_wave_absolute"), ("time",)),
}


def test_variables_and_dimensions(base_run: xr.Dataset) -> None:
    assert {name: base_run[name].dims for name in EXPECTED} == EXPECTED
    assert list(base_run.dof.values) == list(DOFS)
    assert list(base_run.body.values) == ["barge"]
    assert list(base_run.axis.values) == ["x", "y", "z"]
    assert list(base_run.fender.values) == [f"interface {i}" for i in (1, 2, 3, 4)]
    assert_allclose(base_run.time, 0.5 * np.arange(4001), rtol=1e-12)


def test_elevation_at_probes() -> None:
    """At the origin as the kernel has it, elsewhere as it arrives there."""
    wave = WaveTrain(RegularWave(0.8, 10.0, 0.3), heading=np.pi / 2, ramp=5.0)
    ahead = 9.81 * 10.0**2 / (2 * np.pi) / 4  # a quarter of the wavelength
    scene = Scene(
        "probes",
        20.0,
        (block(2.0, ["surge"]),),
        environment=Environment(waves=(wave,)),
        output={"wave_probes": {"here": (0.0, 0.0), "there": (7.0, ahead)}},
    )
    run = hs.simulate(scene)
    probes = run.wave_elevation_at_probe
    assert probes.dims == ("time", "probe")
    assert (probes.units, float(run.probe_y.sel(probe="there"))) == ("m", ahead)
    assert_allclose(probes.sel(probe="here"), run.wave_elevation, atol=1e-12)
    later = run.time.values > 5.0
    expected = 0.8 * np.sin(2 * np.pi / 10.0 * run.time + 0.3)
    assert_allclose(probes.sel(probe="there")[later], expected[later], atol=1e-12)


@pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5])
@pytest.mark.parametrize("duration", [9.2, 9.23])
def test_the_end_is_recorded_whatever_the_duration(method: Method, duration: float) -> None:
    """On an output time or not, on the grid of the steps or not; the last interval is shorter."""
    scene = replace(in_contact(10.0), solver=Solver(method=method, step=0.1)).with_output(step=0.5)
    run, longer = (hs.simulate(replace(scene, duration=end)) for end in (duration, 10.0))
    assert_allclose(run.time, [*0.5 * np.arange(19), duration], rtol=1e-12)
    assert_array_equal(run.position[:-1], longer.position[:19])
    exact = hs.simulate(
        replace(scene, solver=Solver(step=0.01), duration=10.0).with_output(step=0.01)
    )
    there = exact.position.sel(time=duration, method="nearest")
    assert_allclose(run.position[-1], there, atol=1e-5)  # the steps' error by then


def test_no_number_is_missing(base_run: xr.Dataset) -> None:
    assert all(np.isfinite(base_run[name]).all() for name in base_run.data_vars)


def test_every_variable_says_what_it_is(base_run: xr.Dataset) -> None:
    for name, variable in base_run.data_vars.items():
        for key in ("long_name", "frame"):
            assert variable.attrs.get(key), f"{name} has no {key}"
        given = variable.attrs.keys() & {"units", "dof_units", "comment"}
        assert len(given) == 1, f"{name} says {given} of its units"
    assert len({v.attrs["long_name"] for v in base_run.data_vars.values()}) == len(base_run)
    assert base_run.time.attrs["units"] == "s"


def test_what_has_translations_and_rotations_says_the_unit_of_each(base_run: xr.Dataset) -> None:
    for name, unit in (("position", "m"), ("velocity", "m/s"), ("force_mooring", "N")):
        said = dict(zip(DOFS, base_run[name].attrs["dof_units"].split(", "), strict=True))
        for dof in DOFS:
            _, found = channel_series(base_run, f"{name}.barge.{dof}")
            assert (found == said[dof], found == unit) == (True, dof in DOFS[:3])
    for name, variable in base_run.data_vars.items():
        assert ("dof_units" in variable.attrs) == ("dof" in variable.dims), name


def test_every_unit_is_one_that_others_know() -> None:
    """Those of variables, of stages and of channels that follow, by pint, which refuses others."""
    units = {unit for v in VARIABLES.values() for unit in v.units.split(" or ")} - {MIXED}
    units |= {unit for _, unit in phases.FIGURES.values()} | {
        kind.unit for kind in CHANNEL_KINDS.values()
    }
    known = pint.UnitRegistry()
    assert {"m", "rad/s", "N m", "m/s^2", "kg/s"} <= units
    for unit in units:
        known.parse_units(unit)
    with pytest.raises(pint.errors.PintError):
        known.parse_units("m or rad")


def test_a_file_says_its_format_and_date_and_later_ones_are_refused(
    base_run: xr.Dataset, tmp_path: Path
) -> None:
    path, older = tmp_path / "run.nc", base_run.isel(time=slice(9))
    assert older.attrs["format"] == "hydrosim run 2"
    assert abs(datetime.now(UTC) - datetime.fromisoformat(older.attrs["date_created"])).days == 0
    older.assign_attrs(format="hydrosim run 3").to_netcdf(path)
    with pytest.raises(hs.InputError, match="format hydrosim run 3; expected hydrosim run 2 or"):
        read_run(path)
    older.attrs = {"program": "hydrosim 0.1.0", "status": "complete"}
    older.position.attrs = {"units": "m or rad"}
    older.to_netcdf(path)
    found = [channel_series(read_run(path), f"position.barge.{dof}")[1] for dof in DOFS]
    assert found == ["m"] * 3 + ["rad"] * 3


def test_modes_are_flags(base_run: xr.Dataset) -> None:
    """CF conventions 1.11, section 3.5; and every mode occurs in the base case."""
    mode = base_run.fender_mode
    assert mode.dtype == np.int8
    assert_array_equal(mode.attrs["flag_values"], [0, 1, 2])
    assert mode.attrs["flag_meanings"] == "open stick slip"
    assert set(np.unique(mode)) == {0, 1, 2}


def test_phases_are_those_of_each_element() -> None:
    """A fender of constant force, in contact throughout, hides nothing of the interface."""
    scene = in_contact(20.0)
    interface = scene.forces["interface"]
    pressed = PrescribedNormal(Table(np.array([0.0]), np.array([1e3])))
    alongside = replace(interface, normal=pressed, friction=Frictionless())
    lifted = replace(interface, plane=replace(interface.plane, point=np.array([0.0, 0.0, 9.0])))
    forces = {**scene.forces, "interface": lifted, "alongside": alongside}
    run = hs.simulate(replace(scene, forces=forces))
    assert list(run.contact_group.values) == ["interface", "alongside"]
    assert list(run.fender_group.values) == ["interface"] * 4 + ["alongside"] * 4
    names = run.contact_phase.attrs["flag_meanings"].split()
    interface_phase, alongside_phase = run.contact_phase.values.T
    assert set(interface_phase) == {names.index("moored")}
    assert set(alongside_phase) == {names.index("compressed")}


def test_contact_points_are_where_the_deck_is(base_run: xr.Dataset) -> None:
    """Compression is how far the deck is above 3.6 m, by rotation matrices written out here for
    pitch alone (waves along the barge); without contact there is no force."""
    q = base_run.position.sel(body="barge")
    for i, x in enumerate((20.0, 20.0, -20.0, -20.0)):
        height = -4.9 + q.sel(dof="heave") - x * np.sin(q.sel(dof="pitch"))
        height = height + 7.5 * np.cos(q.sel(dof="pitch"))
        assert_allclose(base_run.fender_compression[:, i], height - 3.6, atol=1e-9)
    closed = base_run.fender_mode.values > 0
    normal = base_run.fender_normal_force.values
    assert not normal[~closed].any()
    assert_allclose(normal[closed], 98.1e6 * base_run.fender_compression.values[closed], rtol=1e-9)


def test_friction_stays_below_its_limits(base_run: xr.Dataset) -> None:
    """mu_s N in stick, mu_k N + C3 |v2| in slip, where v2 is less than the deck's own speed."""
    friction = np.linalg.norm(base_run.fender_friction.values, axis=2)
    mode, normal = base_run.fender_mode.values, base_run.fender_normal_force.values
    stick, slip = mode == 1, mode == 2
    assert (friction[stick] <= 0.2 * normal[stick] * (1 + 1e-6) + 1.0).all()
    fastest = float(np.abs(base_run.velocity.sel(dof="surge")).max()) + 0.1
    assert (friction[slip] <= 0.1 * normal[slip] + 0.25e6 * fastest).all()
    assert not friction[mode == 0].any()
    assert (np.diff(base_run.fender_slip_distance, axis=0) >= 0.0).all()


def test_reference_position_is_the_place_at_rest() -> None:
    scene = scene_of("free_floating")
    (body,) = scene.bodies
    moved = replace(scene, bodies=(replace(body, location=(100.0, -50.0)),), duration=1.0)
    assert_array_equal(hs.simulate(moved).reference_position, [[100.0, -50.0, -4.9]])


def test_provenance(base_run: xr.Dataset) -> None:
    a = base_run.attrs
    assert a["title"] == "Reverse float-over, base case"
    assert a["case"] == (CASES / "base.yaml").read_text()
    assert a["case_file"].endswith("base.yaml")
    assert a["seeds"] == [1]
    assert a["program"].startswith("hydrosim ")
    assert (a["solver_method"], a["solver_step"], a["solver_rejected"]) == ("rk4", 0.1, 0)
    assert a["solver_steps"] >= 20000  # of the grid, and the pieces between events
    assert a["solver_events"] > 0
    assert a["solver_evaluations"] >= 4 * a["solver_steps"]
    assert a["wall_time"] > 0.0
    assert a["status"] == "complete"
    assert "states for surge, heave, pitch" in a["radiation_barge"]


def test_the_database_is_known_by_its_checksum(base_run: xr.Dataset) -> None:
    assert base_run.attrs["database_barge"] == hull().source
    assert base_run.attrs["database_checksum_barge"] == hull().checksum


def test_without_fenders_there_is_nothing_of_them() -> None:
    run = hs.simulate(replace(scene_of("free_floating"), duration=1.0))
    assert "fender" not in run.dims
    assert not [name for name in run.data_vars if str(name).startswith("fender")]


@pytest.mark.parametrize("scene", ["free_floating", "base"])
def test_round_trip_through_netcdf(scene: str, tmp_path: Path) -> None:
    run = hs.simulate(replace(scene_of(scene), duration=5.0))
    write_run(run, tmp_path / "run.nc")
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]
    back = read_run(tmp_path / "run.nc")
    xr.testing.assert_equal(back, run)
    restart = [name for name, of in run.variables.items() if of.attrs.get(PURPOSE) == RESTART]
    plain = xr.load_dataset(tmp_path / "run.nc")
    xr.testing.assert_equal(plain, run.drop_vars(restart))
    with xr.open_dataset(tmp_path / "run.nc", group=RESTART) as continuation:
        assert {*continuation.variables} == {*restart}
    for name in run.data_vars:
        assert {k: np.asarray(v).tolist() for k, v in back[name].attrs.items()} == {
            k: np.asarray(v).tolist() for k, v in run[name].attrs.items()
        }
    assert back.attrs.keys() - {"history"} == run.attrs.keys()
    for key in ("case", "title", "status", "solver_step", "solver_steps", "wall_time"):
        assert back.attrs[key] == run.attrs[key]
    assert np.ravel(back.attrs["seeds"]).tolist() == [1]


def test_writing_replaces_the_file_at_once(tmp_path: Path) -> None:
    """A result that cannot be written leaves the last one as it was."""
    path = tmp_path / "run.nc"
    run = hs.simulate(in_contact(1.0).with_output(step=0.1))
    write_run(run, path)
    before = path.read_bytes()
    with pytest.raises((TypeError, ValueError)):
        write_run(run.assign_attrs(bad=object()), path)
    assert path.read_bytes() == before
