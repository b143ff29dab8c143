"""Suggestions for an unknown word: a synonym, other capitals, a typing error."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from difflib import get_close_matches

MIN_SIMILARITY = 0.7  # similarity of words, 0 to 1: below it no word is suggested
SYNONYMS = {
    "significant_height": "hs hsig hm0 h_s swh significant_wave_height wave_height",
    "peak_period": "tp t_p wave_period",
    "peak_enhancement": "gamma peakedness peak_factor peak_enhancement_factor",
    "amplitude": "a wave_amplitude height h",
    "period": "t",
    "heading": "direction dir angle course azimuth mean_direction wave_direction bearing",
    "spreading": "s spread spreading_exponent",
    "seed": "random_seed rng",
    "water_depth": "depth d h waterdepth",
    "water_density": "rho density sea_density rho_water",
    "density": "rho water_density",
    "gravity": "g gravity_acceleration",
    "waves": "wave sea seastate",
    "depth": "water_depth d h",
    "speed": "velocity v u magnitude",
    "spectrum": "type spectrum_type",
    "jonswap": "jonswop jons",
    "pierson_moskowitz": "pm pierson moskowitz",
    "regular": "airy linear sinusoidal monochromatic",
    "none": "no off still calm",
    "mass": "m displacement weight",
    "centre_of_gravity": "cog cg com center_of_gravity centre_of_mass center_of_mass",
    "centre_of_buoyancy": "cob cb center_of_buoyancy",
    "radii_of_gyration": "kxx kyy kzz rxx ryy rzz gyradii radius_of_gyration k_xx k_yy k_zz",
    "inertia": "ixx iyy izz i44 i55 i66 moments_of_inertia moment_of_inertia",
    "draught": "draft t",
    "length": "l lpp loa unstretched_length l0",
    "beam": "breadth width b",
    "database_body": "body body_number number index",
    "hydrodynamics": "database hydro bem rao wamit",
    "location": "place xy origin",
    "dofs": "dof degrees_of_freedom free",
    "initial": "start initial_condition initial_conditions",
    "position": "offset offsets displacement",
    "forces": "elements force connections constraints",
    "bodies": "body vessels vessel objects",
    "environment": "env sea metocean ocean",
    "duration": "simulation_time t_end end_time length end stop",
    "step": "dt time_step timestep h delta_t",
    "method": "integrator scheme",
    "solver": "integration numerics time_integration simulation",
    "output": "outputs results record",
    "title": "name",
    "stiffness": "k spring spring_constant ks",
    "damping": "c damper dashpot",
    "damping_ratio": "zeta xi",
    "static": "mu_s mus static_friction mu friction_static",
    "kinetic": "mu_k muk dynamic kinetic_friction mu_d friction_kinetic",
    "coefficient": "mu friction_coefficient",
    "law": "type model",
    "type": "kind law element",
    "normal": "n direction normal_vector",
    "points": "point locations positions fender_points",
    "anchor": "end fairlead_b end_b",
    "point": "position location fairlead",
    "spring": "line rope cable hawser wire",
    "catenary": "mooring_line chain anchor_line",
    "linear_mooring": "mooring",
    "winch": "tugger drum hoist capstan",
    "strut": "rod two_sided_spring link spring_damper",
    "power_take_off": "pto",
    "rotary_power_take_off": "rotary_pto",
    "torsion_spring": "rotational_spring angular_spring",
    "to": "other_body",
    "fender": "bumper contact quay",
    "applied_force": "force load external_force",
    "linear_damping": "damper",
    "quadratic_damping": "drag viscous_damping morison",
    "viscous_roll": "roll_damping bilge bilge_keels",
    "wind_load": "wind wind_force",
    "current_load": "current current_force",
    "coulomb": "dry",
    "automatic": "auto",
    "rk4": "runge_kutta runge_kutta_4",
    "rk2": "midpoint",
    "convolution": "cummins impulse_response",
    "parameters": "parameter variables vary",
    "seeds": "seed",
    "figures": "results outputs statistics",
    "criteria": "limits criterion",
    "latin_hypercube": "lhs latin lhc",
    "sobol": "qmc quasi_monte_carlo",
    "grid": "full_factorial factorial",
    "one_at_a_time": "oat ofat",
    "largest": "max maximum",
    "smallest": "min minimum",
    "std": "sigma rms sd stdev standard_deviation",
    "mean": "average avg",
    "end": "last final",
    "surge": "x",
    "sway": "y",
    "heave": "z",
    "roll": "rx phi",
    "pitch": "ry theta",
    "yaw": "rz psi",
}
"""Other technical words for keys and values of hydrosim, in lower case."""


def suggestion(word: str, known: Iterable[str]) -> str:
    """Question with the word of ``known`` that was probably meant; empty if none is similar."""
    found = closest_word(word, known)
    return f'did you mean "{found}"?' if found else ""


def closest_word(word: str, known: Iterable[str]) -> str:
    """The word of ``known`` that was probably meant; empty if none is similar."""
    return next(_closest_words(_plain(word), list(known)), "")


def _closest_words(word: str, known: list[str]) -> Iterator[str]:
    plain = {_plain(name): name for name in known}
    yield from [plain[word]] if word in plain else []
    yield from (name for name in known if word in SYNONYMS.get(name, "").split())
    yield from (name for name in known if "_" in word and _has_words(name, word))
    yield from (plain[name] for name in get_close_matches(word, plain, n=1, cutoff=MIN_SIMILARITY))


def _has_words(name: str, word: str) -> bool:
    """Whether a name has all words of ``word``, in any order."""
    return {*word.split("_")} <= {*_plain(name).split("_")}


def _plain(word: str) -> str:
    """A word in lower case, with its parts joined by one underscore."""
    parts = re.sub(r"([a-z0-9])([A-Z][a-z])", r"\1_\2", word)
    return re.sub(r"[\s_-]+", "_", parts.strip().lower())
