from dataclasses import replace
from pathlib import Path

import damaged
import numpy as np
import pytest

from hydrosim.database import HydroDatabase, move_reference
from hydrosim.database.load import load, read
from hydrosim.errors import InputError

USED = slice(0, 60, 10)
POINT = np.array([0.0, 0.0, -2.0])  # that the bodies turn about
PRINTED = 2e-7  # seven digits
SPREAD = np.radians([0.0, 60.0, 120.0, 180.0])
EVERY = slice(0, 73, 24)  # these headings among the barge's


def _tec(head: str, titles: list[str], omega: np.ndarray, tables: list[np.ndarray]) -> str:
    lines = [head, '"A   1   1" "B   1   1"']
    for title, table in zip(titles, tables, strict=True):
        lines.append(f'Zone t="{title}",I={len(omega):6d},F=POINT')
        for w, row in zip(omega, table, strict=True):
            lines.append("".join(f" {value:14.7E}" for value in [w, *row.ravel()]))
    return "\n".join([*lines, ""])


def _cal(bodies: int, count: str, wave_point: str = "0.\t0.") -> str:
    point = " ".join(f"{x:f}" for x in POINT)
    axes = ["1. 0. 0.", "0. 1. 0.", "0. 0. 1."]
    six = [f"1 {axis} 0. 0. 0.\t! Translation" for axis in axes]
    six += [f"2 {axis} {point}\t! Rotation about a point" for axis in axes]
    body = ["--- Body ---", "hull.dat ! mesh", "400 380 ! points, panels", "6 ! DOFs", *six]
    body += ["6 ! forces", *six, "1 ! lines of additional information", "anything"]
    return "\n".join(
        [
            "--- Environment ---",
            "1025.0\t! RHO",
            "9.81 ! G",
            "0. ! DEPTH",
            f"{wave_point} ! XEFF YEFF",
            "--- Description of floating bodies ---",
            f"{bodies} ! Number of bodies",
            *body * bodies,
            "--- Load cases to be solved ---",
            f"{count} ! frequencies",
            "4 0. 180. ! Number of wave directions, Min and Max (degrees)",
            "--- Post processing ---",
        ]
    )


def written(db: HydroDatabase, folder: Path, wave_point: str = "0.\t0.") -> Path:
    """A project as Nemoh 2 writes it: exp(-i w t), rows of a zone are loads by one motion."""
    results, mesh = folder / "Results", folder / "Mesh"
    for path in (results, mesh):
        path.mkdir(parents=True)
    omega, n = db.frequency[USED], 6 * db.bodies
    coefficients = np.stack([db.added_mass[USED], db.radiation_damping[USED]], axis=-1)
    head = 'VARIABLES="w (rad/s)"'
    motions = [f"Motion of body {dof // 6 + 1} in DoF {dof % 6 + 1}" for dof in range(n)]
    zones = [coefficients[:, :, motion] for motion in range(n)]
    (results / "RadiationCoefficients.tec").write_text(_tec(head, motions, omega, zones))
    for name, loads in (("ExcitationForce", db.excitation), ("FKForce", db.froude_krylov)):
        own = loads[USED].conj()
        polar = np.stack([np.abs(own), np.angle(own)], axis=-1)
        titles = [f"Diffraction force - beta = {np.degrees(b):7.3f} deg" for b in db.heading]
        table = [polar[:, b] for b in range(db.heading.size)]
        (results / f"{name}.tec").write_text(_tec(head, titles, omega, table))
    for body in range(db.bodies):
        _write_hydrostatics(db, mesh, body)
    cal = folder / "Nemoh.cal"
    cal.write_text(_cal(db.bodies, f"{omega.size}\t{omega[0]:g}\t{omega[-1]:g}", wave_point))
    return cal


def _write_hydrostatics(db: HydroDatabase, mesh: Path, body: int) -> None:
    """The stiffness is about the centre of gravity."""
    own = move_reference(db, db.centre_of_gravity).hydrostatic_stiffness
    number = f"_{body}" if db.bodies > 1 else ""
    part = slice(6 * body, 6 * body + 6)
    np.savetxt(mesh / f"KH{number}.dat", own[part, part], fmt=" %13.6E")
    centres = zip("XYZ", db.centre_of_buoyancy[body], db.centre_of_gravity[body], strict=True)
    lines = [f" {axis}F = {b:10.6f} - {axis}G = {g:10.6f}" for axis, b, g in centres]
    lines += [f" Displacement = {db.volume[body]:14.7E}", " Waterplane area =  0.6357517E+02"]
    (mesh / f"Hydrostatics{number}.dat").write_text("\n".join(lines))


def thinned(db: HydroDatabase) -> HydroDatabase:
    """The barge about the point of rotation, with headings evenly spread as Nemoh has them."""
    fewer = replace(
        db,
        heading=db.heading[EVERY],
        excitation=db.excitation[:, EVERY],
        froude_krylov=db.froude_krylov[:, EVERY],
        **dict.fromkeys(("mean_drift", "mean_drift_held", "drift_imbalance")),
    )
    # The weight stays where it is, and a point at another height changes no moment of it.
    return replace(
        move_reference(fewer, [POINT]),
        centre_of_gravity=db.centre_of_gravity,
        hydrostatic_stiffness=db.hydrostatic_stiffness,
    )


@pytest.fixture
def project(barge, tmp_path) -> Path:
    return written(thinned(barge), tmp_path / "barge")


def test_reads_what_was_written(barge, project):
    db, other = read(project), thinned(barge)
    np.testing.assert_allclose(db.frequency, other.frequency[USED], rtol=1e-7)
    np.testing.assert_allclose(db.heading, SPREAD, atol=1e-12)
    np.testing.assert_array_equal(db.reference_point, [POINT])
    for name in ("added_mass", "radiation_damping"):
        np.testing.assert_allclose(getattr(db, name), getattr(other, name)[USED], rtol=PRINTED)
    for name in ("excitation", "froude_krylov"):
        one, two = getattr(db, name), getattr(other, name)[USED]
        assert (np.abs(one - two) <= 4e-7 * np.abs(two)).all()
    stiffness = barge.hydrostatic_stiffness
    np.testing.assert_allclose(db.hydrostatic_stiffness, stiffness, rtol=1e-5, atol=1e-6 * 1e11)
    np.testing.assert_allclose(db.centre_of_gravity, barge.centre_of_gravity, atol=1e-6)
    np.testing.assert_allclose(db.centre_of_buoyancy, barge.centre_of_buoyancy, atol=1e-6)
    assert db.volume[0] == pytest.approx(barge.volume[0], rel=PRINTED)
    assert np.isinf(db.water_depth)


def test_any_file_of_the_project_will_do(project):
    tec = project.parent / "Results" / "FKForce.tec"
    assert read(tec).checksum == read(project).checksum


@pytest.mark.filterwarnings("ignore:.*kernel truncation")
def test_passes_the_checks_of_physics(project):
    load(project)


def test_long_waves_lift_the_hull(project):
    db = read(project)
    assert db.excitation[0, 0, 2] == pytest.approx(db.hydrostatic_stiffness[2, 2], rel=0.02)
    assert np.angle(db.excitation[0, 0, 0]) == pytest.approx(np.pi / 2, abs=0.02)


def test_version_three_and_its_output_frequencies(barge, project):
    """A type precedes the number of frequencies; tables may be by period."""
    expected = read(project)
    count = expected.frequency.size
    project.write_text(project.read_text().replace(f"{count}\t", f"3 {count}\t"))
    for path in (project.parent / "Results").iterdir():
        head, *rows = path.read_text().split("\n")
        rows = [
            f" {2 * np.pi / float(row.split()[0]):14.7E}{row[15:]}" if row[:1] == " " else row
            for row in rows
        ]
        path.write_text("\n".join([head.replace("w (rad/s)", "T (s)"), *rows]))
    db = read(project)
    np.testing.assert_allclose(db.frequency, expected.frequency, rtol=1e-6)
    np.testing.assert_array_equal(db.added_mass, expected.added_mass)


def test_phases_refer_to_the_wave_measurement_point(barge, tmp_path):
    """A wave along x comes to a point 100 m ahead later, by k x."""
    db = read(written(thinned(barge), tmp_path / "ahead", wave_point="100. 0."))
    here = read(written(thinned(barge), tmp_path / "here"))
    late = np.exp(-100j * here.frequency**2 / 9.81)
    np.testing.assert_allclose(db.excitation[:, 0, 2], here.excitation[:, 0, 2] * late, rtol=1e-9)


def test_a_real_file_is_the_sphere_that_wamit_has(validation, tmp_path):
    """Rows at 1.0 rad/s of what Nemoh 2.3 wrote for a half-submerged sphere of 5 m radius about a
    point 2 m deep (WEC-Sim's examples): 2 per cent and 1 degree from WAMIT, for other panels."""
    radiation = [0.1721014e6, 0.2763689e5, *[0.0] * 6, 0.3441041e6, 0.5525722e5, 0.0, 0.0]
    loads = [0.3213887e6, -0.1515387e1, 0.6599379, -0.1949728, 0.4073798e6, -0.2286643]
    loads += [0.4869803, 0.2963469e1, 0.6425847e6, -0.1515387e1, 0.7655562e-7, 0.1399648e1]
    results = tmp_path / "Results"
    results.mkdir()
    head, omega = 'VARIABLES="w (rad/s)"', np.array([1.0])
    motions = [f"Motion of body    1 in DoF   {dof}" for dof in range(1, 7)]
    rows = [np.array([radiation if dof == 0 else [0.0] * 12]) for dof in range(6)]
    (results / "RadiationCoefficients.tec").write_text(_tec(head, motions, omega, rows))
    title = ["Diffraction force - beta =   0.000 deg"]
    (results / "ExcitationForce.tec").write_text(_tec(head, title, omega, [np.array([loads])]))
    cal = tmp_path / "Nemoh.cal"
    cal.write_text(_cal(1, "420\t0.02\t8.4").replace("4 0. 180.", "1\t0.\t0."))
    db, other = read(cal), read(validation / "sphere" / "sphere.h5")
    w = int(np.argmin(np.abs(other.frequency - 1.0)))
    for dof in (0, 2, 4):
        ratio = db.excitation[0, 0, dof] / other.excitation[w, 0, dof]
        assert abs(ratio) == pytest.approx(1.0, abs=0.02)
        assert abs(np.degrees(np.angle(ratio))) < 1
    for dof in (0, 4):
        assert db.added_mass[0, dof, 0] == pytest.approx(other.added_mass[w, dof, 0], rel=0.02)
        damping = other.radiation_damping[w, dof, 0]
        assert db.radiation_damping[0, dof, 0] == pytest.approx(damping, rel=0.03)


def test_two_bodies(made_up, tmp_path):
    """Rows of a motion are the loads on all bodies; stiffness is each body's own."""
    loads = np.ones((4, SPREAD.size, 12)) + 1j
    db = made_up(
        2,
        heading=SPREAD,
        excitation=loads,
        froude_krylov=loads,
        reference_point=np.tile(POINT, (2, 1)),
        centre_of_gravity=np.tile(POINT, (2, 1)),
        **dict.fromkeys(("mean_drift", "mean_drift_held", "drift_imbalance")),
    )
    other = read(written(db, tmp_path / "two"))
    np.testing.assert_allclose(other.added_mass, db.added_mass[USED], rtol=PRINTED)
    stiffness = other.hydrostatic_stiffness
    np.testing.assert_allclose(stiffness[6:, 6:], db.hydrostatic_stiffness[6:, 6:], rtol=2e-6)
    assert not stiffness[:6, 6:].any()


def test_stiffness_moves_from_the_centre_of_gravity_to_the_point_of_rotation(project):
    """100 N/m in heave at 2 m ahead: pitching about the point lifts it by -2 m per radian."""
    mesh = project.parent / "Mesh"
    np.savetxt(mesh / "KH.dat", np.diag([0.0, 0.0, 100.0, 0.0, 0.0, 0.0]))
    path = mesh / "Hydrostatics.dat"
    path.write_text(path.read_text().replace("XG =   0.000000", "XG =   2.000000"))
    stiffness = read(project).hydrostatic_stiffness
    assert stiffness[2, 4] == stiffness[4, 2] == -200.0
    assert (stiffness[2, 2], stiffness[4, 4]) == (100.0, 400.0)


def test_quadratic_transfer_functions(project):
    """Over rho g, w_1 >= w_2; a phase of 30 degrees for exp(-i w t)."""
    folder = project.parent / "Results" / "QTF"
    folder.mkdir()
    rows = ["w1 w2 [rad/s] bet1 bet2 DOF abs phase re im"]
    rows += [f"{a} {b} 0. 0. 1 2.0 30. 1.732 1.0" for a in (0.5, 0.6) for b in (0.5, 0.6) if b <= a]
    (folder / "OUT_QTFM_N.dat").write_text("\n".join(rows))
    db = read(project)
    assert db.qtf_sum is None
    value = 2.0 * 1025.0 * 9.81 * np.exp(-1j * np.radians(30))
    np.testing.assert_allclose(db.qtf_frequency, [0.5, 0.6])
    assert db.qtf_difference[0, 1, 0, 0] == pytest.approx(value)
    assert db.qtf_difference[0, 0, 1, 0] == pytest.approx(np.conj(value))
    assert not db.qtf_difference[..., 1:].any()
    (folder / "OUT_QTFM_N.dat").write_text("\n".join(rows[:-1]))
    with pytest.raises(InputError, match=r"found 2 rows of quadratic .* expected at least 3"):
        read(project)


def test_messages_name_the_file_and_line(project):
    text = project.read_text()
    project.write_text(text.replace("6 ! DOFs", "1 ! DOFs"))
    with pytest.raises(InputError, match=r"Nemoh\.cal: line 11: .*expected 6 degrees of freedom"):
        read(project)
    project.write_text(text.replace("\n4 0. 180.", "\n999999999 0. 180."))
    with pytest.raises(InputError, match=r"found 4 zones of \[6\] rows, expected 999999999"):
        read(project)
    project.write_text(text)
    (project.parent / "Results" / "ExcitationForce.tec").unlink()
    with pytest.raises(InputError, match=r"ExcitationForce\.tec: no such file"):
        read(project)


@pytest.mark.parametrize(
    "name",
    [
        "Nemoh.cal",
        "Results/RadiationCoefficients.tec",
        "Results/ExcitationForce.tec",
        "Mesh/KH.dat",
        "Mesh/Hydrostatics.dat",
    ],
)
def test_damaged_files_are_refused(project, name):
    path = project.parent / name
    count = damaged.refused(lambda _: read(project), path, path.read_bytes(), str(project.parent))
    assert 30 < count


def test_a_table_of_another_program_is_not_taken_for_nemohs(tmp_path):
    """Tecplot's files have that suffix, too."""
    (tmp_path / "Results").mkdir()
    path = tmp_path / "Results" / "pressure.tec"
    path.write_text('VARIABLES="X" "Y"\n1 2\n')
    with pytest.raises(InputError, match="a table for Tecplot that belongs to no Nemoh project"):
        read(path)


def test_files_of_programs_that_are_not_read_are_told_apart(tmp_path):
    (tmp_path / "heave.rao").write_text("1 2 3\n")
    with pytest.raises(InputError, match=r"HydroStar.* write WAMIT's format; expected one of"):
        read(tmp_path / "heave.rao")
