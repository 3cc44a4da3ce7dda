"""Where the fields of a serialised body are, as polytope_serialisation.cpp writes them; for tests that damage them."""

import struct

HEAD = [("dimension", 4), ("swell", 8), ("triangles", [12]), ("source", [4]), ("centre", 24), ("reach", 8)]
HEAD += [("radius", 8), ("low", 24), ("high", 24), ("is_box", 4)]
LEVELS = [("points", [24]), ("level", [4]), ("depth", 4), ("ring_start", [4]), ("rings", [4]), ("top", [4])]
LEVELS += [("top_blocks", [96]), ("top_stands", [128]), ("edge", 4), ("cells", [16])]
LEVELS += [("cell_groups", [8]), ("cell_blocks", [128])]
LEVELS += [("chains", [8]), ("blocks", [128]), ("fan_of", [4]), ("fans", [40]), ("wedges", [24])]
LEVELS += [("entries", [4]), ("largest_coordinate", 8)]
TAIL = [("polar_triangles", [12]), ("polar_radius", 8), ("facet_count", 4)]


def fields(data):
    """Bytes of each field, name: (first, end); sizes in a list are those of an array's entries."""
    parts = [
        (f"{part}.{name}", size)
        for part in ("inner", "top_levels", "polar", "polar_top_levels")
        for name, size in LEVELS
    ]
    found, place = {}, 0
    for name, size in [*HEAD, *parts, *TAIL]:
        count = 1
        if isinstance(size, list):
            (count,), (size,), place = struct.unpack_from("<Q", data, place), size, place + 8
        found[name] = place, place + count * size
        place += count * size
    assert place == len(data)
    return found
