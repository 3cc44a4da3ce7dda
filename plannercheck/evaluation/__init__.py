"""Compares plannercheck with exact arithmetic, and measures it beside other methods.

Read `campaign` (how hard cases are drawn, judged and counted), then `stress` (hard pairs of bodies), `stress_solids`
(pairs of concave ones), `stress_parts` (sets of parts), `stress_motions` (motions with contact by construction).
`bench` measures time against error; `sensing` gives what cameras see. The commands are `stress` and `bench`; nothing
else in the package needs them.
"""
