"""The scene: what is simulated, as frozen dataclasses in SI units and radians.

A scene comes from a case file (`hydrosim.case`) or is written in Python; `hydrosim.compiling.model`
compiles it to arrays. Nothing here computes.
"""

from hydrosim.scene.body import (
    Body,
    Clearance,
    Place,
    SecondOrder,
    WaveForces,
    Weight,
)
from hydrosim.scene.environment import (
    Amplitudes,
    Environment,
    Stream,
    WaveTrain,
)
from hydrosim.scene.force import (
    ForceElement,
    Turns,
)
from hydrosim.scene.given import (
    FrequencyColumn,
    Given,
)
from hydrosim.scene.hydrodynamics import (
    AtDraught,
    ChangedDatabase,
    Changes,
    Coefficients,
    Family,
    Hull,
    Hydrodynamics,
    Without,
)
from hydrosim.scene.joint import (
    Joint,
    JointFriction,
    JointType,
    Ratchet,
    Stops,
    Window,
)
from hydrosim.scene.joint import Resistance as JointResistance
from hydrosim.scene.radiation import (
    BY_NAME,
    AutomaticRadiation,
    ConstantRadiation,
    ConvolutionRadiation,
    Radiation,
    RadiationModel,
    StateSpaceRadiation,
)
from hydrosim.scene.scene import (
    Question,
    Scene,
    Start,
)
from hydrosim.scene.solver import (
    Kinematics,
    LinearScenes,
    Method,
    Solver,
    Symmetry,
    Tolerance,
    Unstable,
)
from hydrosim.scene.spectra import (
    Density,
    DirectionalTable,
    GivenComponents,
    Jonswap,
    OchiHubble,
    OchiHubblePeak,
    RecordedElevation,
    RegularWave,
    Spectrum,
    SpectrumTable,
    Tma,
    Torsethaugen,
    WhiteNoise,
)
from hydrosim.scene.tanks import (
    Box,
    FreeSurface,
    Plan,
    Pump,
    Tank,
    TankMesh,
    TankShape,
    TankTable,
)
from hydrosim.scene.triggers import (
    Active,
    LevelReached,
    When,
)

__all__ = [
    "BY_NAME",
    "Active",
    "Amplitudes",
    "AtDraught",
    "AutomaticRadiation",
    "Body",
    "Box",
    "ChangedDatabase",
    "Changes",
    "Clearance",
    "Coefficients",
    "ConstantRadiation",
    "ConvolutionRadiation",
    "Density",
    "DirectionalTable",
    "Environment",
    "Family",
    "ForceElement",
    "FreeSurface",
    "FrequencyColumn",
    "Given",
    "GivenComponents",
    "Hull",
    "Hydrodynamics",
    "Joint",
    "JointFriction",
    "JointResistance",
    "JointType",
    "Jonswap",
    "Kinematics",
    "LevelReached",
    "LinearScenes",
    "Method",
    "OchiHubble",
    "OchiHubblePeak",
    "Place",
    "Plan",
    "Pump",
    "Question",
    "Radiation",
    "RadiationModel",
    "RecordedElevation",
    "RegularWave",
    "Scene",
    "SecondOrder",
    "Solver",
    "Spectrum",
    "SpectrumTable",
    "Start",
    "StateSpaceRadiation",
    "Stops",
    "Stream",
    "Symmetry",
    "Tank",
    "TankMesh",
    "TankShape",
    "TankTable",
    "Tma",
    "Tolerance",
    "Torsethaugen",
    "Turns",
    "Unstable",
    "WaveForces",
    "WaveTrain",
    "Weight",
    "When",
    "WhiteNoise",
    "Without",
]
