"""Text data files of OrcaFlex with one vessel type, made from a database by the program's help."""

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from hydrosim.database import HydroDatabase, move_reference

USED = slice(4, 104, 20)
HULL = np.array([30.0, -12.0, 12.4])  # the frame of our database in OrcaFlex's vessel axes
CENTRE = HULL + np.array([0.0, 0.0, -4.9])
RAO_ORIGIN = HULL + np.array([5.0, 3.0, 0.0])
PHASE_ORIGIN = HULL + np.array([-20.0, 0.0, 0.0])
DOFS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
COLUMNS = [f"RAO{dof}{what}" for dof in DOFS for what in ("Amp", "Phase")]
MATRIX = ("X", "Y", "Z", "Rx", "Ry", "Rz")
OURS = {
    "RAOResponseUnits": "degrees",
    "RAOWaveUnit": "amplitude",
    "WavesReferredToBy": "period (s)",
    "RAOPhaseConvention": "lags",
    "RAOPhaseUnitsConvention": "degrees",
    "RAOPhaseRelativeToConvention": "crest",
    "SurgePositive": "forward",
    "SwayPositive": "port",
    "HeavePositive": "up",
    "RollPositiveStarboard": "down",
    "PitchPositiveBow": "down",
    "YawPositiveBow": "port",
    "Symmetry": "xz plane",
}
OTHERS = {
    "WavesReferredToBy": "frequency (Hz)",
    "RAOPhaseConvention": "leads",
    "RAOPhaseUnitsConvention": "radians",
    "RAOPhaseRelativeToConvention": "zero up-crossing",
    "SurgePositive": "aft",
    "SwayPositive": "starboard",
    "HeavePositive": "down",
    "RollPositiveStarboard": "up",
    "PitchPositiveBow": "up",
    "YawPositiveBow": "starboard",
}


def wave(db: HydroDatabase, point: np.ndarray) -> np.ndarray:
    """(nw, nh): exp(-i k (x cos b + y sin b)) in deep water, z and the hull's place aside."""
    k = db.frequency[USED] ** 2 / 9.80665
    return np.exp(-1j * np.outer(k, point[0] * np.cos(db.heading) + point[1] * np.sin(db.heading)))


def rows(loads: np.ndarray, other: bool) -> np.ndarray:
    """Amplitudes and phases (..., 12) in kN; ``other`` for the phase by which the load leads the
    zero up-crossing, which itself leads the crest by a quarter of a period."""
    phase = np.angle(loads) - np.pi / 2 if other else -np.degrees(np.angle(loads))
    return np.stack([np.abs(loads) / 1e3, phase], axis=-1).reshape(*loads.shape[:-1], 12)


def contents(db: HydroDatabase, other: bool = False) -> dict[str, Any]:
    """The model, by the program's help, in our conventions or in all others."""
    conventions = OURS | (OTHERS if other else {})
    sign = -1.0 if other else 1.0
    waves = db.frequency[USED] / 2 / np.pi if other else 2 * np.pi / db.frequency[USED]
    at_rao = move_reference(db, [RAO_ORIGIN - HULL])
    loads = at_rao.excitation[USED] / wave(db, PHASE_ORIGIN - HULL)[..., None]
    table = rows(sign * loads, other)
    drift = rows(sign * at_rao.mean_drift[USED].astype(complex), other)
    drift[..., 1::2] = np.where(at_rao.mean_drift[USED] * sign < 0, np.pi if other else 180.0, 0.0)
    drag = [
        {
            "AMDPeriodOrFrequency": value,
            f"AddedMassMatrix{', AddedMassMatrix'.join(MATRIX)}": (A / 1e3).tolist(),
            f"Damping{', Damping'.join(MATRIX)}": (B / 1e3).tolist(),
        }
        for value, A, B in [
            *zip(waves.tolist(), db.added_mass[USED], db.radiation_damping[USED], strict=True),
            ("Infinity" if other else 0, db.added_mass_infinite, np.zeros((6, 6))),
        ]
    ]
    own = db.inertia_matrix / 1e3
    draught = {
        "Name": "Draught1",
        "Mass": own[0, 0].item(),
        "MomentOfInertiaTensorX, MomentOfInertiaTensorY, MomentOfInertiaTensorZ": own[
            3:, 3:
        ].tolist(),
        "CentreOfGravity": CENTRE.tolist(),
        "LoadRAOs": {
            "RAOOrigin": RAO_ORIGIN.tolist(),
            "PhaseOrigin": PHASE_ORIGIN.tolist(),
            "RAOs": directions(db, waves, table),
        },
        "WaveDriftQTFMethod": "Newman's approximation",
        "WaveDrift": {"RAOOrigin": RAO_ORIGIN.tolist(), "RAOs": directions(db, waves, drift)},
        "SumFrequencyQTFs": {
            "RAOOrigin": [0, 0, 0],
            "PhaseOrigin": ["~", "~", "~"],
            ", ".join([*pair_columns(), *COLUMNS]): [],
        },
        "AMDMethod": "Frequency dependent",
        "ReferenceOrigin": CENTRE.tolist(),
        "ReferenceOriginDatumPosition": [-4.9, 0, 0],
        "DisplacedVolume": db.volume[0].item(),
        "CentreOfBuoyancy": (HULL + db.centre_of_buoyancy[0]).tolist(),
        "HydrostaticStiffnessz, HydrostaticStiffnessRx, HydrostaticStiffnessRy": (
            db.hydrostatic_stiffness[2:5, 2:5] / 1e3
        ).tolist(),
        "FrequencyDependentAddedMassAndDamping": drag,
    }
    return {
        "General": {"UnitsSystem": "SI"},
        "Environment": {"Density": 1.025, "WaterDepth": "Infinity"},
        "VesselTypes": [{"Name": "Barge", **conventions, "Draughts": [draught]}],
    }


def pair_columns() -> list[str]:
    return [f"RAO{name}{i}" for name in ("PeriodOrFrequency", "Direction") for i in (1, 2)]


def directions(db: HydroDatabase, waves: np.ndarray, table: np.ndarray) -> list[dict[str, Any]]:
    key = ", ".join(["RAOPeriodOrFrequency", *COLUMNS])
    return [
        {
            "RAODirection": np.degrees(beta).item(),
            key: np.column_stack([waves, table[:, b]]).tolist(),
        }
        for b, beta in enumerate(db.heading)
    ]


def write(path: Path, model: dict[str, Any]) -> Path:
    """With the mark and the directive that OrcaFlex writes."""
    text = yaml.dump(model, Dumper=getattr(yaml, "CSafeDumper", yaml.SafeDumper), width=10**6)
    path.write_bytes(b"\xef\xbb\xbf" + ("%YAML 1.1\n# Type: Model\n---\n" + text).encode())
    return path
