"""Time stepping without physics: methods as tableaux, stage combination, event location."""

from hydrosim.integrate.control import Control, error_norm, step_factor
from hydrosim.integrate.dopri5 import DOPRI5
from hydrosim.integrate.events import between, left_behind, phi, scaled
from hydrosim.integrate.explicit import Tableau, advance_state, hermite, stage_state
from hydrosim.integrate.heun import HEUN
from hydrosim.integrate.rk2 import RK2
from hydrosim.integrate.rk4 import RK4
