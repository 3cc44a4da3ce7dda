"""Sets of configurations of any size, and paths: read, judged, journaled, written, proved, compared with FCL.

The data flow: files (`formats.chunks`, one module for each format) → a `Judge` (`judging`), here or on a cluster
(`engines`, `cluster`) → `journal` → `outputs`. `run` puts these together for `plannercheck validate`; `validate` and
`certification` process each chunk. `paths` judges whole paths, `path_recheck` and `fcl_agreement` compare verdicts with
FCL, and `problem_sets` plans the problems of MotionBenchMaker. `gates` judges chunks of waypoints, one by one, before a
controller runs them.
"""
