"""Mutated mesh files in every format: each is loaded or refused, within 10 s and 2 GB, and without a warning.

In: a count, a seed. Out: a table; files of failures are kept. A file that loads must have the triangles that a plain
reading of its lines gives: the same corners for texts, as many as its counts say for others. Exits with 1 on a failure.

    python tests/benchmarks/mutated_meshes.py 20000 --seed 1 --keep /tmp/failures
"""

import argparse
import base64
import json
import re
import struct
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import numpy as np
from long_runs import forked

from plannercheck.bodies.mesh_files import MeshFile, read_mesh
from plannercheck.common.errors import PlannercheckError

_WORDS = (
    b"nan -1 3.0 x inf 1e400 0 7 99999999999999999999 4294967295 -0 1_0 0x10 1e 1,5 # \\ / // 1/ -2147483648".split()
)

CORNERS = [
    (0, 0, 0),
    (1.1, 0, 0),
    (1.1, 1.3, 0),
    (0, 1.3, 0),
    (0, 0, 0.7),
    (1.1, 0, 0.7),
    (1.1, 1.3, 0.7),
    (0, 1.3, 0.7),
]
QUADS = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (2, 3, 7, 6), (1, 2, 6, 5), (3, 0, 4, 7)]
_TRIANGLES = [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]


def _line(values) -> str:
    return " ".join(map(str, values)) + "\n"


def _stl_text() -> bytes:
    facets = "".join(
        "facet normal 0 0 1\n outer loop\n"
        + "".join("  vertex " + _line(CORNERS[k]) for k in t)
        + " endloop\nendfacet\n"
        for t in _TRIANGLES
    )
    return "".join(f"solid {name}\n{facets}endsolid {name}\n" for name in ("left", "right")).encode()


def _stl_bytes() -> bytes:
    facets = [struct.pack("<12fH", 0, 0, 1, *(x for k in t for x in CORNERS[k]), 0) for t in _TRIANGLES]
    return b"solid or not".ljust(80) + struct.pack("<I", len(facets)) + b"".join(facets)


def _obj() -> bytes:
    text = "# a box, twice\nmtllib m.mtl\no left\n" + "".join("v " + _line(c) for c in CORNERS) + "vt 0 0\nvn 0 0 1\n"
    text += "".join("f " + _line(f"{k + 1}/1/1" for k in q) for q in QUADS) + "g right\nusemtl red\n"
    text += "".join("v " + _line((*c, 0.5, 0.5, 1)) for c in CORNERS)
    return (text + "".join("f " + _line(k - 8 for k in t) for t in _TRIANGLES) + "f 1 2 \\\n3\nl 1 2\n").encode()


def _ply(form: str) -> bytes:
    head = (
        f"ply\nformat {form} 1.0\ncomment c\nelement vertex 8\nproperty double x\nproperty float y\nproperty float z\n"
    )
    head += "property uchar red\nelement face 7\nproperty uchar q\nproperty list uchar int vertex_indices\n"
    head += "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    faces, strip = [*QUADS, (0, 1, 2)], (0, 1, 2, 3, -1, 4, 5, 6)
    if form == "ascii":
        rows = [*((*c, 9) for c in CORNERS), *((5, len(f), *f) for f in faces), (len(strip), *strip)]
        return (head + "".join(map(_line, rows))).encode()
    order = "<" if "little" in form else ">"
    body = b"".join(struct.pack(f"{order}dffB", *c, 9) for c in CORNERS)
    body += b"".join(struct.pack(f"{order}BB{len(f)}i", 5, len(f), *f) for f in faces)
    return head.encode() + body + struct.pack(f"{order}{len(strip) + 1}i", len(strip), *strip)


def _off() -> bytes:
    text = "COFF # with colours\n# counts\n8 7 0\n" + "".join(_line((*c, 1, 0, 0, 1)) for c in CORNERS) + "\n"
    return (text + "".join(_line((4, *q, 255, 0, 0)) for q in QUADS) + "3 0 1 2 # last\n").encode()


def _dae() -> bytes:
    places = " ".join(str(x) for c in CORNERS for x in c)
    quads = " ".join(f"{k} 0" for q in QUADS for k in q)
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="inch" meter="0.0254"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g" name="box"><mesh>
<source id="p"><float_array id="pa" count="24">{places}</float_array>
<technique_common><accessor source="#pa" count="8" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="6"><input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#n" offset="1"/>
<vcount>4 4 4 4 4 4</vcount><p>{quads}</p></polylist>
<triangles count="2"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2 0 2 3</p></triangles>
<tristrips count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2 3</p></tristrips>
</mesh></geometry></library_geometries>
<library_nodes><node id="part"><rotate>0 0 1 90</rotate><instance_geometry url="#g"/></node></library_nodes>
<library_visual_scenes><visual_scene id="s">
<node id="n"><matrix>1 0 0 1 0 1 0 2 0 0 1 3 0 0 0 1</matrix><instance_geometry url="#g"/>
<node id="m"><translate>1 2 3</translate><scale>1 2 1</scale><instance_node url="#part"/></node></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
""".encode()


def _gltf(binary: bool) -> bytes:
    body = b"".join(struct.pack("<3f", *c) for c in CORNERS) + struct.pack("<36H", *(k for t in _TRIANGLES for k in t))
    body += struct.pack("<2H6f", 0, 7, *range(6))
    views = [(0, 96), (96, 72), (168, 4), (172, 24)]
    file = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"name": "root", "children": [1, 2], "rotation": [0.5, 0.5, 0.5, 0.5]},
            {"name": "a", "mesh": 0, "translation": [1, 2, 3], "scale": [1, 2, 1]},
            {"name": "a", "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]},
        ],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}, {"attributes": {"POSITION": 2}, "mode": 5}]}
        ],
        "buffers": [{"byteLength": len(body)}],
        "bufferViews": [{"buffer": 0, "byteOffset": a, "byteLength": n} for a, n in views],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": 8,
                "type": "VEC3",
                "sparse": {
                    "count": 2,
                    "indices": {"bufferView": 2, "componentType": 5123},
                    "values": {"bufferView": 3},
                },
            },
        ],
    }
    if not binary:
        file["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(body).decode()
        return json.dumps(file, indent=0).encode()
    text = json.dumps(file).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


BASES = {
    "text.stl": _stl_text(),
    "bytes.stl": _stl_bytes(),
    "box.obj": _obj(),
    "text.ply": _ply("ascii"),
    "little.ply": _ply("binary_little_endian"),
    "big.ply": _ply("binary_big_endian"),
    "box.off": _off(),
    "box.dae": _dae(),
    "box.gltf": _gltf(False),
    "box.glb": _gltf(True),
}


def mutated(content: bytes, seed: int) -> bytes:
    """A file after one random change, or up to three."""
    random = np.random.default_rng(seed)
    for _ in range(int(random.choice([1, 1, 1, 2, 3]))):
        content = _CHANGES[int(random.integers(len(_CHANGES)))](content, random)
    return content


def _flip(content: bytes, random: np.random.Generator) -> bytes:
    array = bytearray(content)
    for _ in range(int(random.integers(1, 4)) if array else 0):
        array[int(random.integers(len(array)))] ^= 1 << int(random.integers(8))
    return bytes(array)


def _cut(content: bytes, random: np.random.Generator) -> bytes:
    return content[: int(random.integers(len(content) + 1))]


def _remove(content: bytes, random: np.random.Generator) -> bytes:
    at = int(random.integers(len(content) + 1))
    return content[:at] + content[at + int(random.integers(1, 9)) :]


def _insert(content: bytes, random: np.random.Generator) -> bytes:
    at = int(random.integers(len(content) + 1))
    pieces = [b"\n", b" ", b"\t", b"\r\n", b"\n \n", b"# c\n", b"\n# c 1 2 3\n", b"\0", b"\\\n", bytes(4), b"\xff" * 4]
    return content[:at] + pieces[int(random.integers(len(pieces)))] + content[at:]


def _lines(content: bytes, random: np.random.Generator) -> bytes:
    lines = content.split(b"\n")
    a, b = random.integers(len(lines), size=2)
    kind = int(random.integers(4))
    if kind == 0:
        lines[a], lines[b] = lines[b], lines[a]
    elif kind == 1:
        lines.insert(a, lines[b])
    elif kind == 2:
        del lines[a]
    else:
        lines.insert(a, [b"", b" ", b"# comment", b"comment x"][int(random.integers(4))])
    return b"\n".join(lines)


def _word(content: bytes, random: np.random.Generator) -> bytes:
    found = list(re.finditer(rb'[^\s<>",:\[\]]+', content))
    if not found:
        return content
    at = found[int(random.integers(len(found)))]
    other = (
        found[int(random.integers(len(found)))][0]
        if random.random() < 0.2
        else _WORDS[int(random.integers(len(_WORDS)))]
    )
    return content[: at.start()] + other + content[at.end() :]


def _number(content: bytes, random: np.random.Generator) -> bytes:
    at = int(random.integers(max(len(content) - 3, 1)))
    value = int(random.choice(np.array([0, 1, 2**31 - 1, 2**31, 2**32 - 1, 1 << 20, 255], dtype=np.int64)))
    return content[:at] + struct.pack("<I", value) + content[at + 4 :]


_CHANGES = (_flip, _cut, _remove, _insert, _lines, _word, _word, _number)


def difference(name: str, content: bytes, mesh: MeshFile) -> str:
    """How a mesh differs from what a plain reading of the file's lines gives; "" if it does not."""
    kind = Path(name).suffix
    count = len(mesh.triangles)
    if name == "bytes.stl" and not re.match(rb"\s*solid\b.*?\n.*endsolid", content, re.DOTALL | re.IGNORECASE):
        return "" if count == (len(content) - 84) // 50 else f"{count} triangles"
    if kind in (".gltf", ".glb"):
        return ""
    if kind == ".dae":
        least = sum(int(n) for n in re.findall(rb'<(?:polylist|triangles|tristrips)[^>]*count="\s*(\d+)', content))
        return "" if count >= least else f"{count} triangles of {least}"
    if kind == ".ply" and b"\nformat ascii" not in content.replace(b"\r", b"\n"):
        said = re.search(rb"element\s+face\s+(\d+)", content)
        return "" if said is None or count >= int(said[1]) else f"{count} triangles of {int(said[1])}"
    corners = {".obj": _plain_obj, ".stl": _plain_stl, ".ply": _plain_ply, ".off": _plain_off}[kind](content)
    found = sorted(set(map(tuple, mesh.points.tolist())))
    wanted = sorted({corner for face in corners for corner in face})
    triangles = sum(max(len(face) - 2, 1) for face in corners)
    if count != triangles:
        return f"{count} triangles, not {triangles}"
    return "" if found == wanted else f"points {set(found) ^ set(wanted)}"


def _plain_obj(content: bytes) -> list[list[tuple[float, ...]]]:
    text = content.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n").replace("\\\n", " ")
    points, faces = [], []
    for words in (line.partition("#")[0].split() for line in text.split("\n")):
        if words[:1] == ["v"]:
            points.append(tuple(map(float, words[1:4])))
        elif words[:1] in (["f"], ["fo"]):
            indices = [int(word.partition("/")[0]) for word in words[1:]]
            faces.append([k - 1 if k > 0 else len(points) + k for k in indices])
    return [[points[k] for k in face] for face in faces]


def _plain_stl(content: bytes) -> list[list[tuple[float, ...]]]:
    text = re.sub(r"\bnormal\s+\S+\s+\S+\s+\S+", "", content.decode("latin-1").lower())
    found = re.findall(r"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)", re.sub(r"(?m)^[ \t]*(solid|endsolid)\b[^\r\n]*", "", text))
    points = [tuple(map(float, words)) for words in found]
    return [points[k : k + 3] for k in range(0, len(points), 3)]


def _plain_ply(content: bytes) -> list[list[tuple[float, ...]]]:
    head, _, body = content.decode("latin-1").partition("end_header")
    rows = [line.split() for line in re.split(r"[\r\n]+", body) if line.strip()]
    blocks = re.findall(
        r"^\s*element\s+(\S+)\s+(\d+)((?:\s*(?:property|comment|obj_info)\b[^\r\n]*|\s)*)", head, re.MULTILINE
    )
    points, faces = [], []
    for name, count, properties in blocks:
        these, rows = rows[: int(count)], rows[int(count) :]
        names = [(p.split()[-1], p.split()[1] == "list") for p in re.findall(r"property[^\r\n]*", properties)]
        for row in these:
            at, found = 0, {}
            for key, is_list in names:
                length = int(float(row[at])) if is_list else 1
                at += is_list
                found[key], at = row[at : at + length], at + length
            if name == "vertex":
                points.append(tuple(float(found[axis][0]) for axis in "xyz"))
                continue
            key = next((k for k in found if k in ("vertex_indices", "vertex_index")), None)
            indices = [] if key is None else [int(float(word)) for word in found[key]]  # 3.0 is whole
            if name == "face":
                faces.append(indices)
            elif name == "tristrips":
                faces += [
                    [int(w) for w in strip.split()]
                    for strip in re.split(r"(?<!\S)-1(?!\S)", " ".join(map(str, indices)))
                    if strip.strip()
                ]
    return [[points[k] for k in face] for face in faces]


def _plain_off(content: bytes) -> list[list[tuple[float, ...]]]:
    rows = [line.partition("#")[0].split() for line in re.split(r"[\r\n]+", content.decode("latin-1"))]
    rows = [row for row in rows if row]
    rows = [row for row in [rows[0][1:], *rows[1:]] if row]
    vertices, faces = int(rows[0][0]), int(rows[0][1])
    points = [tuple(map(float, row[:3])) for row in rows[1 : vertices + 1]]
    return [
        [points[int(float(k))] for k in row[1 : int(float(row[0])) + 1]]
        for row in rows[vertices + 1 : vertices + faces + 1]
    ]


def _judge(name: str, content: bytes, folder: Path) -> str:
    """ "loaded", "refused", or what is wrong."""
    path = folder / name
    path.write_bytes(content)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            mesh = read_mesh(path)
    except PlannercheckError as error:
        return "refused" if name in str(error) else f"the error does not name the file: {error}"
    except BaseException:
        return traceback.format_exc()
    try:
        found = difference(name, content, mesh)
    except (ValueError, IndexError, KeyError):
        found = f"loaded, but a plain reading ends in {traceback.format_exc()}"
    return found if found else "loaded"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int, nargs="?", default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, default=Path("mutated_meshes"))
    options = parser.parse_args()
    names = list(BASES)
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        for name in names:  # a base that is refused would prove nothing
            if (verdict := _judge(name, BASES[name], folder)) != "loaded":
                print(f"{name} itself: {verdict}")
                return 1

        def trial(number: int) -> str:
            seed = options.seed + number
            name = names[seed % len(names)]
            verdict = _judge(name, mutated(BASES[name], seed), folder)
            if verdict not in ("loaded", "refused"):
                raise AssertionError(verdict)
            return f"{name} {verdict}"

        tally = forked.run(trial, options.count, folder)
    failed = Counter[str]()
    for number, what in tally.faults:
        seed = options.seed + number
        name = names[seed % len(names)]
        options.keep.mkdir(parents=True, exist_ok=True)
        kept = options.keep / f"{seed}_{name}"
        kept.write_bytes(mutated(BASES[name], seed))
        print(f"seed {seed}, {kept}: {what}", flush=True)
        failed[name] += 1
    print(f"{'':12} {'loaded':>8} {'refused':>8} {'failed':>8}")
    for name in names:
        counts = (tally.outcomes[f"{name} loaded"], tally.outcomes[f"{name} refused"], failed[name])
        print(f"{name:12}" + "".join(f" {count:>8}" for count in counts))
    return int(bool(tally.faults))


if __name__ == "__main__":
    sys.exit(main())
