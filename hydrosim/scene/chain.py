"""Chain by its bar diameter d: mass per length and axial stiffness (Orcina, OrcaFlex manual,
"Chain: mechanical properties"), and the breaking load of offshore grades (IACS UR W22),

    C d^2 (44 - 0.08 d) kN,   d in mm,   C = 0.0223 (R3), 0.0249 (R3S), 0.0274 (R4), 0.0320 (R5).
"""

from __future__ import annotations

STEEL = 7850.0  # kg/m^3
CHAIN = {"studless": (19.9e3, 85.4e9), "studlink": (21.9e3, 101.0e9)}
"""Mass per length over squared diameter [kg/m^3] and axial stiffness over squared diameter
[N/m^2]."""
STRONGEST = 0.0320  # C of grade R5


def strongest_breaking_load(diameter: float) -> float:
    """Breaking load [N] of chain of grade R5 with this bar ``diameter`` [m]."""
    d = 1e3 * diameter
    return 1e3 * STRONGEST * d**2 * (44.0 - 0.08 * d)
