"""Mapping files, and guesses where there is none."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from hydrosim.compare import compare, read_mapping
from hydrosim.compare.align import guess
from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.files.recordings import (
    RecordedColumn,
    Recording,
    read_recording,
    recording_of_frame,
)
from hydrosim.files.text import Source, name_and_unit
from hydrosim.results.channels import Channel

CHANNELS = [
    *(Channel(f"position.barge.{dof}", "m") for dof in ("surge", "heave")),
    *(Channel(f"position.deck.{dof}", "m") for dof in ("surge", "heave")),
    Channel("position.barge.pitch", "rad"),
    Channel("velocity.barge.heave", "m/s"),
    Channel("velocity.barge.pitch", "rad/s"),
    Channel("wave_elevation", "m"),
    Channel("force_mooring.barge.surge", "N"),
    Channel("force_lift.barge.heave", "N"),
    Channel("fender_normal_force.interface 1", "N"),
    Channel("fender_normal_force.interface 2", "N"),
    Channel("fender_compression.interface 1", "m"),
]


def guessed(*names: str) -> dict[str, str]:
    """The column of each channel that is guessed; a unit in brackets is the column's."""
    numbers = np.arange(4.0)
    columns = [RecordedColumn(name, name_and_unit(name)[1], numbers) for name in ("time", *names)]
    recording = Recording(Source(Path("data.txt")), "text", columns)
    found = guess(recording, CHANNELS)
    return {name: recording.column(place.column).name for name, place in found.items()}


@pytest.mark.parametrize(
    ("column", "channel"),
    [
        ("wave_elevation", "wave_elevation"),
        ("Eta [mm]", "wave_elevation"),
        ("Wave", "wave_elevation"),
        ("Barge heave (m)", "position.barge.heave"),
        ("BARGE Z", "position.barge.heave"),
        ("barge_heave_vel", "velocity.barge.heave"),
        ("pitch [deg]", "position.barge.pitch"),
        ("pitch (deg/s)", "velocity.barge.pitch"),
        ("surge [kN]", "force_mooring.barge.surge"),
        ("mooring x", "force_mooring.barge.surge"),
        ("fender 2 [tonne_force]", "fender_normal_force.interface 2"),
        ("Fender1", "fender_normal_force.interface 1"),
        ("fender 1 [m]", "fender_compression.interface 1"),
        ("position.deck.surge", "position.deck.surge"),
        ("PITCH_deg", "position.barge.pitch"),
        ("run1.PITCH_deg", "position.barge.pitch"),
        ("run1.barge.Heave_m", "position.barge.heave"),
        ("FENDER_2_kN", "fender_normal_force.interface 2"),
    ],
)
def test_guesses(column: str, channel: str) -> None:
    assert guessed(column) == {channel: column}


@pytest.mark.parametrize(
    "column",
    ["heave [m]", "barge", "InWave", "fender [kN]", "barge heave [kg]", "fender 3 [kN]", "X1", "2"],
)
def test_what_is_not_guessed(column: str) -> None:
    """Two bodies heave; no degree of freedom or number; a unit of something else."""
    assert guessed(column) == {}


def test_a_unit_at_the_end_of_a_name_is_the_unit() -> None:
    """Or degrees would be taken for radians."""
    columns = [
        RecordedColumn(name, None, np.arange(4.0)) for name in ("time", "run1.PITCH_deg", "WAVE_cm")
    ]
    found = guess(Recording(Source(Path("data.mat")), "MATLAB", columns), CHANNELS)
    assert {name: place.unit for name, place in found.items()} == {
        "position.barge.pitch": "deg",
        "wave_elevation": "cm",
    }
    assert guessed("run1.PITCH_deg", "run2.PITCH_deg") == {}


def test_two_columns_of_one_channel() -> None:
    """Neither is taken, unless one is called as the channel."""
    assert guessed("pitch [deg]", "barge pitch [rad]") == {}
    both = guessed("pitch [deg]", "position.barge.pitch")
    assert both == {"position.barge.pitch": "position.barge.pitch"}


def test_mapping_file(tmp_path: Path) -> None:
    (tmp_path / "map.yaml").write_text(
        "time: {column: T, unit: min, offset: -2 min}\n"
        "channels:\n"
        "  wave_elevation: 3\n"
        "  position.barge.heave:\n"
        "    {column: Z, unit: kNm, sign: -1, offset: 5 cm, point: [80 m, 0, 1]}\n"
    )
    mapping = read_mapping(tmp_path / "map.yaml")
    assert (mapping.time.column, mapping.time.unit, mapping.time.offset) == ("T", "min", -120.0)
    assert mapping.channels["wave_elevation"].column == 3
    heave = mapping.channels["position.barge.heave"]
    assert (heave.unit, heave.sign, heave.offset.value) == ("kN*m", -1, 0.05)
    assert heave.point == (80.0, 0.0, 1.0)


UNITS = {"dof_units": "m, m, m, rad, rad, rad"}


@pytest.mark.parametrize(
    ("channel", "place", "message"),
    [
        ("heave", "{column: z, unit: tonnes}", '"tonnes" is another kind of quantity; expected a'),
        ("heave", "zz", 'found no column "zz"'),
        ("heav", "z", 'found no selection from position "heav"'),
    ],
)
def test_a_message_about_a_channel_names_the_line_of_the_mapping(
    tmp_path: Path, channel: str, place: str, message: str
) -> None:
    path = tmp_path / "map.yaml"
    path.write_text(f"channels:\n  wave_elevation: z\n  position.barge.{channel}: {place}\n")
    (tmp_path / "data.csv").write_text("t,z\n" + "".join(f"{t},{t % 3}\n" for t in range(20)))
    time = np.arange(20.0)
    run = xr.Dataset(
        {
            "position": (("time", "body", "dof"), np.zeros((20, 1, 6)), UNITS),
            "wave_elevation": ("time", time, {"units": "m"}),
        },
        {"time": time, "body": ["barge"], "dof": list(DOFS)},
    )
    with pytest.raises(InputError) as error:
        compare(run, read_recording(tmp_path / "data.csv"), read_mapping(path))
    assert str(error.value).startswith(f"{path}:3: channels.position.barge.{channel}: ")
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("channels: {a: {colum: 1}}", r"map\.yaml:1: channels\.a\.colum: found an unknown key"),
        ("channels: {a: {sign: -1}}", r'channels\.a: found no key "column"'),
        ("channels: {a: {column: 1, sign: 2}}", r"channels\.a\.sign: .*expected 1 or -1"),
        ("channels: {a: {column: 1, unit: kilo}}", r'unit: found "kilo"; expected a known unit'),
        ("channels: {a: {column: 1, offset: far}}", r'offset: found "far"; expected an? offset'),
        ("channels: {}", "channels: found nothing in it; expected one or more"),
        ("time: {offset: 2 m}\nchannels: {a: 1}", r"time\.offset: found .2 m.; expected a time"),
        ("time: {shift: yes}\nchannels: {a: 1}", r"time\.shift: found .yes.; expected true or"),
    ],
)
def test_bad_mapping_files(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "map.yaml").write_text(text)
    with pytest.raises(InputError, match=message):
        read_mapping(tmp_path / "map.yaml")


def test_a_mapping_is_read_from_its_keys() -> None:
    mapping = read_mapping({"channels": {"wave_elevation": {"column": "eta", "unit": "mm"}}})
    assert mapping.channels["wave_elevation"].column == "eta"
    with pytest.raises(InputError, match=r"chanels: found an unknown key"):
        read_mapping({"chanels": {}})


def test_a_frame_is_a_recording() -> None:
    """With units in its names; its index is the time where no column is."""
    frame = pd.DataFrame({"Eta [mm]": [1.0, 2.0, 3.0]}, index=[0.0, 0.5, 1.0])
    recording = recording_of_frame(frame)
    assert recording.time_column().value.tolist() == [0.0, 0.5, 1.0]
    assert (recording.column("Eta").unit, recording.column("Eta").value[2]) == ("mm", 3.0)
    assert recording_of_frame(frame.rename_axis("t").reset_index()).time_column().name == "t"
