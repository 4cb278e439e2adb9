"""The case that `billow check --example` prints: every table a first case needs, each line explained."""

EXAMPLE = """\
# A driver bag on a plate, against an obstacle. Numbers are SI, or text with a unit: thickness = "0.3 mm".
# What stands here is the default, unless the comment says otherwise. All keys, units and ranges: docs/case.md.
title = "Driver bag against an obstacle"

[bag]                           # two round panels sewn at the rim, flat on z = 0; shape = "mesh" reads your own mesh
diameter = 0.70                 # of the flat panels [m]
element_size = 0.020            # edge of the triangles [m]; the default of 0.010 is finer, and takes 8 times as long
mouth_radius = 0.05             # of the retainer ring [m]

[bag.vents]                     # holes in the rear panel
count = 2
diameter = 0.035                # [m]
distance = 0.17                 # of their centres from the bag's axis [m]
discharge = 0.7                 # discharge coefficient: typical, measure yours
opening_pressure = 0.0          # gauge pressure at which they open [Pa]

[bag.straps]                    # tethers from the retainer ring to the front panel
count = 4
length = 0.28                   # [m]

[fabric]                        # woven nylon: typical values, not measured
law = "linear"                  # "curves-shear" takes stress-strain curves, from CSV files or the library
density = 800.0                 # of the uncoated fabric [kg/m^3]
thickness = 0.30e-3             # [m]
young_warp = 0.40e9             # Young's modulus along the warp [Pa]
young_weft = 0.35e9             # along the weft [Pa]
shear = 10e6                    # shear modulus between them [Pa]
permeability = 0.0              # leak speed in units of 1 m/s at 500 Pa; 0 for coated fabric

[gas]
model = "uniform-pressure"      # or "corpuscular": particles, for jets, folds and chambers; or "mesh"
heat_transfer = 0.0             # to the surroundings through the fabric [W/(m^2 K)]

[inflator]                      # 50 g of pyrotechnic gas within 50 ms; typical, take yours from a tank test
temperature = 650.0             # total temperature of the gas [K]

[inflator.gas]                  # mole fractions; their sum is 1
N2 = 0.45
H2O = 0.30
CO2 = 0.25

[inflator.mass_flow]            # piecewise linear, zero outside
time = ["0 ms", "8 ms", "50 ms"]
value = [0.0, 2.0, 0.0]         # [kg/s]

[inflator.jets]                 # a ring of holes around the bag's axis
count = 12
ring_radius = "fits"            # 38 mm, or less in a smaller mouth; or [m]
hole_diameter = 0.005           # [m]
angle = 45.0                    # of the jets from the bag's axis [deg]

[ambient]
pressure = 101325.0             # absolute [Pa]
temperature = 295.0             # [K]

[[obstacles]]                   # what the bag lies on
shape = "plate"
height = 0.0                    # at which it crosses the z axis [m]

[[obstacles]]                   # what it meets; not there by default
shape = "super-ellipsoid"
name = "impactor"
radii = 0.15                    # one number, or three [m]
degree = 2.0                    # 2 is an ellipsoid, larger is boxier
clearance = 0.15                # gap to the flat bag [m]
locked = true                   # false: free to move, with mass and velocity
slope = 1e5                     # contact: force per penetration of 1 cm^2 of fabric [N/m]

[run]
end_time = "50 ms"
frames = 50                     # pictures for ParaView
histories_per_frame = 10        # rows of histories.csv for each
dt_scale = 1.0                  # fraction of the stable step; 0.5 cures most that a verdict of REVIEW or FAIL names
"""
