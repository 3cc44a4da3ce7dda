"""Runs CoACD in a process of its own: `python -m plannercheck.bodies.coacd_worker`.

In, on standard input: an npz with `points` (n, 3), `triangles` (m, 3), `threshold`, `most_pieces`, `seed`,
`preprocess`, `preprocess_resolution`. Out, on standard output: an npz with the points of each piece. It has to be
another process: after the library's C++ runtime is loaded, urdfdom can't read numbers, and a failure of the library
stops the process.
"""

from __future__ import annotations

import io
import os
import sys

import numpy as np

# What the search for cuts may cost: a quarter to a tenth of CoACD's own settings in time (the UR10's upper arm: 13 s of
# CPU time), for as many pieces.
_ITERATIONS, _NODES, _RESOLUTION = 40, 10, 1000


def main() -> None:
    """Decomposes one mesh."""
    given = np.load(io.BytesIO(sys.stdin.buffer.read()))
    out = os.dup(1)
    os.dup2(2, 1)  # the library writes to standard output
    import coacd

    coacd.set_log_level("error")
    mesh = coacd.Mesh(given["points"], given["triangles"])
    pieces = coacd.run_coacd(
        mesh,
        threshold=float(given["threshold"]),
        max_convex_hull=int(given["most_pieces"]),
        seed=int(given["seed"]),
        preprocess_mode=str(given["preprocess"]),
        preprocess_resolution=int(given["preprocess_resolution"]),
        mcts_iterations=_ITERATIONS,
        mcts_nodes=_NODES,
        resolution=_RESOLUTION,
    )
    content = io.BytesIO()
    np.savez(content, *(np.asarray(points) for points, _ in pieces))
    with os.fdopen(out, "wb") as file:
        file.write(content.getvalue())


if __name__ == "__main__":
    main()
