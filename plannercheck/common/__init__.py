"""Basics that all folders use, without robots, bodies or scenes.

Read `errors`, `user_warnings` and `core` first (the one family of errors; warnings that name the user's line; the
compiled core for the best instruction set), then `array_types`, `arrays`, `transforms` and `angles` (numbers as the
core reads them) and `counters` (sums of its counters). Files: `package_data`, `package_files`, `checked_yaml` and
`input_limits` find and read them, `written_yaml` and `atomic_files` write them, `escaping` and `html_tables` put names
into them. `optional_imports`, `isolated_process`, `silence` and `threads` deal with other libraries and processes.
`motion_paths` names how free bodies move. `version` and `public_names` hold the package's version and its public names,
and `model_comparisons` the functions that the package registers for `proofs`.
"""
