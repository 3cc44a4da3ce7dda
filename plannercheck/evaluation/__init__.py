"""Compares plannercheck with exact arithmetic, and measures it beside other methods.

Read `stress` (hard pairs of bodies), `stress_solids` (pairs of concave ones), `stress_motions` (motions with contact by
construction) and `bench` (time against error). Each is a command of the command line; nothing else in the package needs
them.
"""
