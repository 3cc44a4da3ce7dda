"""Files made to do harm: an error in a second or two, no crash, no hang, nothing read that is somebody else's."""

import io
import subprocess
import sys
import tarfile
from pathlib import Path

import numpy as np
import pytest
import yaml

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.common import input_limits
from plannercheck.common.checked_yaml import parse_yaml

DEEP = 40_000
DOUBLED = 40


def _deep_yaml() -> str:
    return "name: " + "[" * DEEP + "]" * DEEP


def _deep_blocks() -> str:
    return "name:\n" + "".join(" " * k + "- \n" for k in range(1, 3000))


def _deep_in_a_line() -> str:
    return "name:\n " + "- " * DEEP + "x"


def _lists_of_aliases() -> str:
    lines = ["a0: &a0 [x, x]", *(f"a{k}: &a{k} [*a{k - 1}, *a{k - 1}]" for k in range(1, DOUBLED))]
    return "\n".join(lines) + f"\nname: *a{DOUBLED - 1}"


def _merged_keys() -> str:
    lines = ["a0: &a0 {k: 1}", *(f"a{k}: &a{k} {{<<: [*a{k - 1}, *a{k - 1}]}}" for k in range(1, DOUBLED))]
    return "\n".join(lines)


YAMLS = {
    "deep": _deep_yaml,
    "deep blocks": _deep_blocks,
    "deep in a line": _deep_in_a_line,
    "lists of aliases": _lists_of_aliases,
    "merged keys": _merged_keys,
}
_LOAD = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
resource.setrlimit(resource.RLIMIT_CPU, (20, 20))
import plannercheck as pc
try:
    {call}
except pc.PlannercheckError as error:
    print(error)
    sys.exit(2)
"""


def _in_a_process(call: str, *arguments: Path) -> str:
    """What a call says of a file; it has 20 s of its own and 4 GB."""
    command = [sys.executable, "-W", "ignore", "-c", _LOAD.format(call=call), *map(str, arguments)]
    ran = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert (ran.returncode, ran.stderr) == (2, "")
    return ran.stdout


@pytest.mark.parametrize("kind", YAMLS)
def test_yaml(tmp_path: Path, kind: str) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(YAMLS[kind]())
    said = _in_a_process("pc.Scene.load(sys.argv[1])", file)
    assert "nested deeper than 200 levels" in said or "aliases repeat" in said
    file.write_bytes(YAMLS[kind]().encode("utf-16"))
    _in_a_process("pc.Scene.load(sys.argv[1])", file)


def test_limits_can_be_set(monkeypatch: pytest.MonkeyPatch) -> None:
    text = "a: " + "[" * 150 + "]" * 150
    assert "a" in parse_yaml(text)
    monkeypatch.setattr(input_limits.INPUT_LIMITS, "depth", 140)
    with pytest.raises(pc.PlannercheckError, match="deeper than 140 levels"):
        parse_yaml(text)


@pytest.mark.parametrize("loader", [yaml.SafeLoader, getattr(yaml, "CSafeLoader", yaml.SafeLoader)])
def test_text_about_nesting_is_not_nested(loader: type, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(input_limits, "YAML_LOADER", loader)
    input_limits.check_yaml("a: &x 1\nb: *x\nc: [maximum nesting depth: }")


def test_aliases_that_repeat_little_are_welcome() -> None:
    document = parse_yaml("a: &a {x: 1}\nb: {<<: *a, y: 2}\nc: [*a, *a]")
    assert document["b"] == {"x": 1, "y": 2}


@pytest.mark.parametrize("kind", ["URDF", "SRDF"])
def test_deep_xml(tmp_path: Path, kind: str) -> None:
    file = tmp_path / "deep.xml"
    file.write_text('<robot name="r">' + "<a>" * 30_000 + "</a>" * 30_000 + "</robot>")
    if kind == "URDF":
        said = _in_a_process("pc.Robot.from_urdf(sys.argv[1])", file)
    else:
        urdf = tmp_path / "r.urdf"
        urdf.write_text('<robot name="r"><link name="a"/></robot>')
        said = _in_a_process("pc.Robot.from_urdf(sys.argv[2], sys.argv[1])", file, urdf)
    assert "nested deeper than 200 levels" in said


def test_srdf_groups_that_double(tmp_path: Path) -> None:
    urdf, srdf = tmp_path / "r.urdf", tmp_path / "r.srdf"
    urdf.write_text(
        '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="continuous"><parent link="a"/>'
        '<child link="b"/><axis xyz="0 0 1"/></joint></robot>'
    )
    groups = ['<group name="g0"><joint name="j"/></group>']
    groups += [f'<group name="g{k}"><group name="g{k - 1}"/><group name="g{k - 1}"/></group>' for k in range(1, 60)]
    srdf.write_text(f'<robot name="r">{"".join(groups)}</robot>')
    assert pc.Robot.from_urdf(urdf, srdf, group="g59").joint_names == ("j",)


def test_an_archive_that_unpacks_to_too_much(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert input_limits.INPUT_LIMITS.archive_bytes <= 1 << 30
    monkeypatch.setattr(input_limits.INPUT_LIMITS, "archive_bytes", 1 << 26)  # gigabytes would take half a minute
    file = tmp_path / "bomb.tar.bz2"
    with tarfile.open(file, "w:bz2") as archive:
        member = tarfile.TarInfo("set/scene0001.yaml")
        member.size = 3 << 26
        archive.addfile(member, _Zeros(member.size))  # type: ignore[arg-type]  # it is read from
    assert file.stat().st_size < 100_000
    from plannercheck.scenes.motion_bench_maker import load_problems

    with pytest.raises(pc.PlannercheckError, match=r"unpacks to more than .* bytes"):
        load_problems(file)


class _Zeros(io.RawIOBase):
    def __init__(self, size: int) -> None:
        self._left = size

    def read(self, size: int = -1) -> bytes:
        size = min(size, self._left)
        self._left -= size
        return bytes(size)


@pytest.mark.parametrize("kind", ["external", "virtual", "link", "joints"])
def test_hdf5_reads_no_other_file(tmp_path: Path, kind: str, capfd: pytest.CaptureFixture[str]) -> None:
    import h5py

    secret = tmp_path / "secret"
    secret.write_bytes(np.full(70, 42.0).tobytes())
    with h5py.File(tmp_path / "other.h5", "w") as other:
        other["q"] = np.full((10, 7), 42.0)
    with h5py.File(tmp_path / "q.h5", "w") as file:
        if kind == "external":
            file.create_dataset("q", (10, 7), "f8", external=[(str(secret), 0, 560)])
        elif kind == "virtual":
            layout = h5py.VirtualLayout((10, 7), "f8")
            layout[:] = h5py.VirtualSource(str(tmp_path / "other.h5"), "q", (10, 7))
            file.create_virtual_dataset("q", layout)
        elif kind == "link":
            file["q"] = h5py.ExternalLink(str(tmp_path / "other.h5"), "q")
        else:
            for k in range(1, 8):
                file.create_dataset(f"panda_joint{k}", (10,), "f8", external=[(str(secret), 0, 80)])
    for key in ([], ["--key", "q"]):
        assert main(["validate", "--robot", "panda", str(tmp_path / "q.h5"), *key]) == 2
        assert "42" not in "".join(capfd.readouterr()).replace(str(tmp_path), "")


def test_json_that_is_deep(tmp_path: Path) -> None:
    file = tmp_path / "path.json"
    file.write_text("[" * DEEP + "]" * DEEP)
    command = [sys.executable, "-m", "plannercheck", "validate", "--robot", "panda", "--path", str(file)]
    ran = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert (ran.returncode, "nested too deep" in ran.stderr) == (2, True)
