"""plannercheck held against exact arithmetic, and measured beside other methods.

Read `stress` (hard pairs of bodies), `stress_motions` (motions with contact by construction) and `bench` (time against
error). Nothing else in the package needs them; each is a command of the command line.
"""
