"""Who can reach what is started on this machine: nobody but the user who started it.

The listening sockets are read from /proc, for all processes of a running cluster; clients without its certificate, and
pages of others, try to connect.
"""

import asyncio
import os
import sys
from pathlib import Path

import numpy as np
import pytest

from plannercheck.cli.main import main
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene
from plannercheck.validation.formats.chunks import Chunk
from plannercheck.validation.judging import Judge
from plannercheck.view.picture import picture

FAILED = 3  # exit code
LISTENING = "0A"
LOOPBACK = {"0100007F", "00000000000000000000000001000000"}

needs_proc = pytest.mark.skipif(not Path("/proc/self/net/tcp").exists(), reason="reads /proc")


def descendants(pid: int) -> set[int]:
    parents = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        parents[int(stat.parent.name)] = int(fields[1])
    found = {pid}
    while more := {child for child, parent in parents.items() if parent in found} - found:
        found |= more
    return found


def listening_sockets(pids: set[int]) -> set[tuple[str, int]]:
    """(address in hex, port) of all TCP sockets on which one of the processes listens."""
    links = {str(link.readlink()) for pid in pids for link in Path(f"/proc/{pid}/fd").glob("*") if link.is_symlink()}
    lines = [
        line.split() for name in ("tcp", "tcp6") for line in Path(f"/proc/net/{name}").read_text().splitlines()[1:]
    ]
    return {
        (address, int(port, 16))
        for address, port, state, inode in ((*f[1].split(":"), f[3], f[9]) for f in lines)
        if state == LISTENING and f"socket:[{inode}]" in links
    }


@needs_proc
def test_a_cluster_of_this_machine_listens_to_its_own_processes_alone():
    distributed = pytest.importorskip("distributed")
    from distributed.comm import connect

    from plannercheck.validation.cluster import ClusterEngine

    checker = Checker(Robot.load("panda"), Scene())
    before = listening_sockets(descendants(os.getpid()))
    with ClusterEngine(checker, Judge(), workers=2) as engine:
        rows = checker.robot.random_configurations(200, 0)
        ((_, findings),) = engine.findings([Chunk(0, rows)])
        assert np.array_equal(findings.arrays["first_pair"], checker.first_colliding_pair(rows))

        pids = descendants(os.getpid())
        assert set(engine.client.run(os.getpid).values()) <= pids
        opened = listening_sockets(pids) - before
        assert {address for address, _ in opened} <= LOOPBACK, opened
        # Each socket asks for the certificate: nothing is left for pages, and no node talks without it.
        assert len(opened) == 1 + 2 * 2, opened  # the scheduler; each worker and the nanny that minds it
        for _, port in opened:
            assert asyncio.run(first_answer(port)) == b""
        address = engine.client.scheduler.address
        assert address.startswith("tls://127.0.0.1:")
        strangers = [distributed.Security.temporary(), distributed.Security()]
        for node, security in zip((address, address.replace("tls", "tcp")), strangers, strict=True):
            with pytest.raises((OSError, TimeoutError)):
                asyncio.run(connect(node, timeout=2, **security.get_connection_args("client")))


async def first_answer(port: int) -> bytes:
    """What a socket says to a client of HTTP, or of dask's protocol, without TLS."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(b"GET / HTTP/1.0\r\n\r\n")
    try:
        return await asyncio.wait_for(reader.read(100), 5)
    except (ConnectionError, asyncio.TimeoutError):
        return b""
    finally:
        writer.close()


def test_a_worker_that_dies_at_the_start_is_no_invalid_state(tmp_path, capsys, monkeypatch):
    pytest.importorskip("distributed")
    import dask

    (tmp_path / "dies_at_the_start.py").write_text("import os, sys\nif 'pytest' not in sys.modules: os._exit(5)\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    np.save(tmp_path / "q.npy", Robot.load("panda").random_configurations(3, 0))
    with dask.config.set({"distributed.worker.preload": ["dies_at_the_start"]}):
        command = ["validate", "--robot", "panda", str(tmp_path / "q.npy"), "--engine", "dask", "--workers", "1"]
        assert main(command) == FAILED
    assert "the cluster on this machine did not start" in capsys.readouterr().err


def test_without_certificates_no_cluster_starts(tmp_path, capsys, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setitem(sys.modules, "cryptography", None)
    np.save(tmp_path / "q.npy", np.zeros((1, 7)))
    command = ["validate", "--robot", "panda", str(tmp_path / "q.npy"), "--engine", "dask", "--workers", "1"]
    assert main(command) == 2
    assert "pip install 'plannercheck[dask]'" in capsys.readouterr().err


def test_only_the_servers_own_page_may_connect():
    viser = pytest.importorskip("viser")
    from urllib.request import urlopen

    from websockets.exceptions import InvalidStatus
    from websockets.sync.client import connect

    from plannercheck.view.server import serve

    checker = Checker(Robot.load("panda"), Scene())
    stage = serve(picture(checker, checker.robot.random_configurations(1, 0)), port=0)
    try:
        port = stage.server.get_port()
        options = {"subprotocols": [f"viser-v{viser.__version__}"], "proxy": None}
        here = f"localhost:{port}"
        for origin in ["http://evil.example", "null", f"http://localhost:{port + 1}", f"http://evil.example:{port}"]:
            with pytest.raises(InvalidStatus) as refused, connect(f"ws://{here}", origin=origin, **options):
                pass
            assert refused.value.response.status_code == 403
        rebound = {"additional_headers": {"B": f"evil.example:{port}"}, **options}
        with pytest.raises(InvalidStatus), connect(f"ws://{here}", origin=f"http://evil.example:{port}", **rebound):
            pass
        with pytest.raises(InvalidStatus), connect(f"ws://{here}", origin=None, **options):
            pass
        with connect(f"ws://{here}", origin=f"http://{here}", **options) as socket:
            assert len(socket.recv(timeout=20)) > 0
        with urlopen(f"http://{here}", timeout=10) as answer:
            assert b"<html" in answer.read()
    finally:
        stage.server.stop()


@pytest.mark.parametrize(
    ("origin", "body_b", "served", "own"),
    [
        (None, "localhost:8080", "localhost", True),
        ("http://localhost:8080", "localhost:8080", "localhost", True),
        ("http://LOCALHOST:8080", "LOCALHOST:8080", "localhost", True),
        ("https://localhost:9000", "localhost:9000", "localhost", True),  # a port that ssh forwards
        ("http://192.0.2.7:8080", "192.0.2.7:8080", "0.0.0.0", True),
        ("http://[::1]:8080", "[::1]:8080", "::1", True),
        ("http://robots.lab:8080", "robots.lab:8080", "robots.lab", True),
        ("http://robots.lab:8080", "robots.lab:8080", "0.0.0.0", False),  # a name that may be anyone's
        ("http://evil.example", "localhost:8080", "localhost", False),
        ("http://evil.example:8080", "evil.example:8080", "localhost", False),
        ("http://localhost:8081", "localhost:8080", "localhost", False),
        ("http://localhost:8080@evil.example", "localhost:8080", "localhost", False),
        ("file://localhost:8080", "localhost:8080", "localhost", False),
        ("null", "localhost:8080", "localhost", False),
        ("http://[::1", "[::1", "localhost", False),
        ("http://localhost:8080", None, "localhost", False),
    ],
)
def test_pages_are_told_apart_by_where_they_came_from(origin, body_b, served, own):
    from plannercheck.view.origins import is_own_page

    assert is_own_page(origin, body_b, served) is own
