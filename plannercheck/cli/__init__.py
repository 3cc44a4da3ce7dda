"""The command line: `plannercheck COMMAND ...`.

Read `main` first. Each command is a module of its name with `add_arguments(parser)` and `run(options) -> exit code`,
imported only when needed. Several commands share `common`; `validate_options`, `validate_summary`,
`validate_proofs`, `validate_paths` and `proved_paths` belong to `validate`, `plan_problem_sets` to `plan`,
`stress_motions` to `stress`.
"""
