"""The ground that everything stands on: no robot, no body, no scene.

Read `errors` and `core` first (the one family of errors; the compiled core of the best instruction set), then `arrays`,
`transforms` and `angles` (numbers as the core reads them) and `counters` (sums of what it counts). Files:
`package_data`, `checked_yaml` and `input_limits` read them, `atomic_files` writes them, `escaping` and `html_tables`
put names into them. `optional_imports`, `isolated_process`, `silence` and `threads` deal with other libraries and
processes; `version` and `public_names` are what the package says of itself.
"""
