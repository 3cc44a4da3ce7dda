"""Sets of configurations of any size, and paths: read, judged, journaled, written, proved, held against FCL.

Sets go one way: files (`formats.chunks`, one module a format) → a `Judge` (`judging`), here or on a cluster (`engines`,
`cluster`) → `journal` → `outputs`. `run` puts these together for `plannercheck validate`; `validate` and
`certification` are what it asks of each chunk. `paths` judges whole paths, `path_recheck` and `fcl_agreement` hold
verdicts against FCL, `problem_sets` plans the problems of MotionBenchMaker.
"""
