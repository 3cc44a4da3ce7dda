"""A gate before a controller: chunks of waypoints judged as the controller will run them, each with a stop behind it.

Read `settings` (what a gate is told), `chunks` (what the controller runs between the waypoints), `limits` and `stops`
(how the joints brake), then `gate`, and `verdict`, which says why and how far. `record` and `replay` keep a judgement
and repeat it.
"""
