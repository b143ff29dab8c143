"""ARK4(3)6L[2]SA, the implicit part (Kennedy & Carpenter 2003, appendix C). It has order 4, is
L-stable and stiffly accurate, and has stages of order 2, the first explicit. For stiff friction and
stiff steel."""

from hydrosim.integrate.method import method_of
from hydrosim.integrate.runge_kutta import tableau

GAMMA = 1 / 4
ESDIRK4_WEIGHTS = [82889 / 524892, 0.0, 15625 / 83664, 69875 / 102672, -2260 / 8211, GAMMA]

ESDIRK4 = method_of(
    "esdirk4",
    tableau(
        [
            [1 / 4, GAMMA],
            [8611 / 62500, -1743 / 31250, GAMMA],
            [5012029 / 34652500, -654441 / 2922500, 174375 / 388108, GAMMA],
            [
                *(15267082809 / 155376265600, -71443401 / 120774400),
                *(730878875 / 902184768, 2285395 / 8070912, GAMMA),
            ],
            ESDIRK4_WEIGHTS,
        ],
        ESDIRK4_WEIGHTS,
        order=4,
        embedded=[
            *(4586570599 / 29645900160, 0.0, 178811875 / 945068544),
            *(814220225 / 1159782912, -3700637 / 11593932, 61727 / 225920),
        ],
    ),
    "implicit, chooses its own steps",
)
