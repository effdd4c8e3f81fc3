"""Functions of the shoulder's angles for its controller, exported in integers.

    ccgen export shoulder.toml -o firmware/shoulder --functions functions/tendons.py

u and v are the angles of the twelve segments in radians. Any polynomial of them will do.
"""

import math

import casadi

SEGMENTS, LENGTH = 12, 0.24  # metres
RADIUS = 0.03  # of the tendons around the neutral axis, metres
PLACES = (90.0, 210.0, 330.0)  # degrees around it
STIFFNESS = 0.4  # bending stiffness, N m²

u = casadi.SX.sym("u", SEGMENTS)
v = casadi.SX.sym("v", SEGMENTS)

# A tendon at radius r and angle a is longer than the neutral axis by r (sin a u - cos a v) in
# every segment: exact for segments of constant curvature.
bends = casadi.sum1(u), casadi.sum1(v)
lengths = [
    LENGTH + RADIUS * (round(math.sin(angle), 9) * bends[0] - round(math.cos(angle), 9) * bends[1])
    for angle in map(math.radians, PLACES)
]
tendons = casadi.Function("tendons", [u, v], [casadi.vertcat(*lengths)], ["u", "v"], ["lengths"])

# A segment of length h that bends by an angle holds the energy EI angle² / 2 h.
bent = casadi.sumsqr(u) + casadi.sumsqr(v)
energy = casadi.Function(
    "bending_energy", [u, v], [STIFFNESS * bent * SEGMENTS / (2 * LENGTH)], ["u", "v"], ["energy"]
)

errors = {"tendons": 1e-6, "bending_energy": {"energy": 1e-4}}  # metres, joules
