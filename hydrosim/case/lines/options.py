"""Options of MoorDyn's input files: a value, then its name; or a name, then its value.

Options of the solution by time steps, of the search for a start and of outputs are no concern of a
line in static balance. All others that are not read are told.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from hydrosim.case.lines import quantities
from hydrosim.case.lines.sections import FileSection, read_number
from hydrosim.documents.text import Source
from hydrosim.documents.units import Quantity
from hydrosim.scene import OmittedEntry, Question

NUMBER_OPTIONS: dict[str, tuple[tuple[str, ...], Quantity]] = {
    "density": (("wtrdnsty", "rho", "rhow"), quantities.DENSITY),
    "gravity": (("g", "gravity"), quantities.GRAVITY),
    "depth": (("wtrdpth", "depth", "wtrdepth"), quantities.DEPTH),
    "friction": (("frictioncoefficient", "mu_ka"), quantities.FRICTION_COEFFICIENT),
}
SOLUTION_OPTIONS = {
    *(
        "dtm",
        "dt",
        "cfl",
        "tscheme",
        "dtout",
        "fileic",
        "echo",
        "writelog",
        "writeunits",
        "outswitch",
    ),
    *("disableoutput", "disableouttime", "inertialf", "inertialf_rampt"),
    *("kb", "kbot", "cb", "cbot", "fricdamp", "cv", "statdynfricscale", "mc"),
    *("dtic", "icdt", "tmaxic", "ictmax", "cdscaleic", "icdfac", "threshic", "icthresh"),
    *("icgendynamic", "dtwave", "wavekin_rampt", "unifycurrentgrid"),
}
"""Options that a line in static balance does not have. The stiffness of the bed is one of them: the
bed is rigid here."""
WATER_OPTIONS = {"wavekin", "waterkin", "currents", "wavekinfile"}
"""Options for waves and current, which the case has."""
BATHYMETRY_OPTIONS = ("seafloorfile", "seafloorpath", "bathymetry", "bathymetryfile")
EMPTY_VALUES = ("0", "0.0", "none", "null", "false", "-", '""', "''")


@dataclass(frozen=True)
class Options:
    """What the options of a file say, None where they do not: ``density`` [kg/m^3], ``gravity``
    [m/s^2], ``depth`` [m]; ``friction`` along the line; what is ``left_out``."""

    density: float | None
    gravity: float | None
    depth: float | None
    friction: float
    left_out: tuple[OmittedEntry, ...]


def read_options(source: Source, section: FileSection) -> Options:
    """The options of a section. Raises InputError for values out of bounds, for two values of one
    quantity, and for a seabed in a file of its own."""
    values: dict[str, tuple[float, int]] = {}
    left_out: list[OmittedEntry] = []
    for line, words in section.rows.items():
        name, value = _name_and_value(words)
        what = next((key for key, (names, _) in NUMBER_OPTIONS.items() if name in names), None)
        if name in BATHYMETRY_OPTIONS and value.lower() not in EMPTY_VALUES:
            source.wrong(f"found {name} {value}; expected a level seabed, by WtrDpth", line)
        if what is None:
            left_out.extend(_describe_left_out(name, value, line))
            continue
        number = read_number(source, line, value, NUMBER_OPTIONS[what][1], name)
        if what in values and values[what][0] != number:
            text = f"found {what} {number:g}; expected {values[what][0]:g} again, as in line"
            source.wrong(f"{text} {values[what][1]}, or one of both", line)
        values[what] = number, line
    density, gravity, depth, friction = (values.get(key, (None,))[0] for key in NUMBER_OPTIONS)
    return Options(density, gravity, depth, friction or 0.0, tuple(left_out))


def _name_and_value(words: Sequence[str]) -> tuple[str, str]:
    """Name in small letters and value of an option, which may be written ``depth = 150``."""
    apart = " ".join(words).replace("=", " = ").split()
    if len(apart) > 2 and apart[1] == "=":
        return apart[0].lower(), apart[2]
    if len(apart) < 2:
        return apart[0].lower(), ""
    value, name = apart[:2]
    return (
        (value.lower(), name) if not _is_known(name) and _is_known(value) else (name.lower(), value)
    )


def _is_known(word: str) -> bool:
    name = word.lower()
    numbers = {name for names, _ in NUMBER_OPTIONS.values() for name in names}
    return name in {*numbers, *SOLUTION_OPTIONS, *WATER_OPTIONS, *BATHYMETRY_OPTIONS, "mu_kt"}


def _describe_left_out(name: str, value: str, line: int) -> Iterator[OmittedEntry]:
    """What is left out by passing over an option."""
    is_known = name in WATER_OPTIONS or name in BATHYMETRY_OPTIONS or name == "mu_kt"
    if name in SOLUTION_OPTIONS or (is_known and value.lower() in EMPTY_VALUES):
        return
    if name in WATER_OPTIONS:
        advice = "Waves and current are those of the case."
    elif name == "mu_kt":
        advice = "Friction across a line is neglected."
    else:
        advice = "No option of this name is known here; see that the line is as you mean it."
    found = f"the option {name} {value}".strip()
    yield OmittedEntry(Question.FILES, f"{found} in line {line}", "it is left out", advice)
