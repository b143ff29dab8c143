"""Quantities in mooring files of other programs, with their bounds."""

from hydrosim.documents.units import Quantity

DIAMETER = Quantity("diameter", "m", "0.1", at_least=0)
MASS_PER_LENGTH = Quantity("mass per length", "kg/m", "150", at_least=0)
AXIAL_STIFFNESS = Quantity("axial stiffness EA", "N", "1e8", above=0)
BENDING_STIFFNESS = Quantity("bending stiffness", "N*m^2", "0", at_least=0)
DRAG_COEFFICIENT = Quantity("drag coefficient", "", "1.2", at_least=0)
MASS = Quantity("mass", "kg", "0", at_least=0)
VOLUME = Quantity("volume", "m^3", "0", at_least=0)
COORDINATE = Quantity("coordinate", "m", "-150")
LINE_LENGTH = Quantity("length", "m", "300", above=0)
ANY_FORCE = Quantity("force", "N", "0")
DENSITY = Quantity("density", "kg/m^3", "1025", above=0)
GRAVITY = Quantity("acceleration", "m/s^2", "9.81", above=0)
DEPTH = Quantity("depth", "m", "150", above=0)
FRICTION_COEFFICIENT = Quantity("coefficient of friction", "", "0.5", at_least=0, at_most=3)
ANGLE_DEG = Quantity("angle in degrees", "", "90")
