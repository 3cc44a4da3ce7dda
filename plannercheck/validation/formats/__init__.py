"""Files of configurations and of paths, in the formats that users have them in.

Read `chunks` first (checked rows of any file), then `columns` (which column is which joint) and `blocks` (what readers
give); one module a format: `npy`, `csv`, `hdf5`, `parquet`. `paths` and `trajectories` read what planners write.
"""
