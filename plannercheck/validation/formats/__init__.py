"""Files of configurations and of paths, in common formats.

Read `chunks` first (checked rows of any file), then `columns` (the joint of each column) and `blocks` (the output of
readers). Each format has a module: `npy`, `csv`, `hdf5`, `parquet`. `paths` and `trajectories` read the output of
planners.
"""
