"""A campaign draws hard cases at random, judges each, and counts what fails.

Read `campaign`, then `tallies`. The campaigns are `stress` (pairs of hulls), `stress_solids`, `stress_parts` and
`stress_motions`.
"""
