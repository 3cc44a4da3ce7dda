"""Sets of configurations of any size: read in chunks, judged, journaled, and written.

Data goes one way: files (`opening`, one module a format) → `chunks` → a `Judge`, here or on a cluster (`engines`,
`cluster`) → `journal` → `outputs`. `run` puts these together for `plannercheck validate`.
"""
