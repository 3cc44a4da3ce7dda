"""Options that would change nothing in a use of a command are refused; the error says when they count."""

import numpy as np
import pytest

from plannercheck.cli.main import main

PANDA = ("--robot", "panda", "--scene", "bookshelf")
COLUMNS = ",".join(f"j{k}" for k in range(7))

# Words of the command line, and what the error begins with.
UNHEEDED = {
    "tolerance of a set": (["validate", *PANDA, "q.npy", "--tolerance", "1e-3"], "--tolerance counts only with --path"),
    "straight set": (["validate", *PANDA, "q.npy", "--straight"], "--straight counts only with --path"),
    "tube of a set": (["validate", *PANDA, "q.npy", "--tube", "0.1"], "--tube counts only with --path"),
    "tube of straight motions": (
        ["validate", *PANDA, "--path", "t.json", "--straight", "--tube", "0.1"],
        "--tube counts only without --straight",
    ),
    "key of an npy": (["validate", *PANDA, "q.npy", "--key", "q"], "--key counts only for .npz"),
    "columns of an npy": (["validate", *PANDA, "q.npy", "--columns", COLUMNS], "names no columns, so that --columns"),
    "columns of an npz": (["validate", *PANDA, "q.npz", "--columns", COLUMNS], "names no columns, so that --columns"),
    "columns of a csv": (["validate", *PANDA, "q.csv", "--columns", COLUMNS], "names no columns, so that --columns"),
    "ignored columns": (
        ["validate", *PANDA, "q.npy", "--ignore-columns", "finger"],
        "names no columns, so that --ignore-columns",
    ),
    **{
        f"{words[0]} of a path": (["validate", *PANDA, "--path", "q.npy", *words], f"{words[0]} counts only for sets")
        for words in (
            ["--key", "q"],
            ["--ignore-columns", "finger"],
            ["--limits", "warn"],
            ["--explain"],
            ["--only-invalid"],
            ["--progress", "none"],
            ["--workers", "2"],
            ["--scheduler", "tcp://x:1"],
        )
    },
    "two of a path": (
        ["validate", *PANDA, "--path", "q.npy", "--key", "q", "--limits", "warn"],
        "--limits and --key count only for sets, not with --path: leave them out",
    ),
    "frames of a set": (["view", *PANDA, "q.npy", "--frames", "3", "--html", "a.html"], "--frames counts only with"),
    "first of a path": (
        ["view", *PANDA, "--path", "q.npy", "--first", "3", "--html", "a.html"],
        "--first counts only with FILE",
    ),
    "invalid of one": (
        ["view", *PANDA, "--q", "0,0,0,-1,0,1,0", "--only-invalid", "--html", "a.html"],
        "--only-invalid counts only with FILE",
    ),
    "port of a page": (["view", *PANDA, "--html", "a.html", "--port", "81"], "--port counts only without --html"),
    "host of a page": (["view", *PANDA, "--html", "a.html", "--host", "h"], "--host counts only without --html"),
    "first of one problem": (["plan", *PANDA, "--first", "3"], "--first counts only with --problems"),
    "each of one problem": (["plan", *PANDA, "--each"], "--each counts only with --problems"),
    **{
        f"{words[0]} of problem sets": (
            ["plan", "--robot", "panda", "--problems", "set", *words],
            f"{words[0]} counts only for one problem",
        )
        for words in (["--padding", "0.1"], ["--no-self-collision"], ["--curve", "dubins"], ["--turning-radius", "1"])
    },
    "SRDF without a robot": (["verify", "p.json", "--srdf", "a.srdf"], "--srdf counts only with --robot"),
    "group without a robot": (["verify", "p.json", "--group", "arm"], "--group counts only with --robot"),
    "meshes without an audit": (["acm", "--robot", "ur5", "--meshes", "3"], "--meshes counts only with --audit"),
    "output of an audit": (
        ["acm", "--robot", "ur5", "--audit", "--output", "a.srdf"],
        "--output counts only without --audit",
    ),
    "verified pairs": (["stress", "--pairs", "10", "--verified", "3"], "--verified counts only with --motions"),
    "families of pairs": (["stress", "--pairs", "10", "--families", "a"], "--families counts only with --motions"),
    "peers of motions": (["stress", "--motions", "10", "--peers"], "--peers counts only without --motions"),
    "pairs of motions": (["stress", "--motions", "10", "--pairs", "7"], "--pairs counts only without --motions"),
    "pairs of solids": (["stress", "--solids", "10", "--pairs", "7"], "--pairs counts only without --solids"),
    "families of solids": (["stress", "--solids", "10", "--families", "a"], "--families counts only with --motions"),
    "solids of motions": (["stress", "--motions", "10", "--solids", "7"], "--solids counts only without --motions"),
    "pairs of sets": (["stress", "--parts", "10", "--pairs", "7"], "--pairs counts only without --parts"),
    "sets of solids": (["stress", "--solids", "10", "--parts", "7"], "--parts counts only without --solids"),
    "sets of motions": (["stress", "--motions", "10", "--parts", "7"], "--parts counts only without --motions"),
    "seed of a case": (["stress", "--case", "c.json", "--seed", "1"], "--seed counts only without --case"),
    "rounds of complexity": (["bench", "complexity", "--rounds", "3"], "unrecognized arguments: --rounds"),
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    q = np.array([[0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]])
    np.save(tmp_path / "q.npy", q)
    np.savez(tmp_path / "q.npz", q=q)
    np.savetxt(tmp_path / "q.csv", q, delimiter=",")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", UNHEEDED)
def test_unused(name, folder, capsys):
    words, begins = UNHEEDED[name]
    before = sorted(folder.iterdir())
    assert main(words) == 2
    said = capsys.readouterr().err
    assert begins in said
    assert said.rstrip().splitlines()[-1].startswith("plannercheck")
    assert sorted(folder.iterdir()) == before


def test_used(folder, capsys):
    """The same options where they count."""
    names = [f"panda_joint{k}" for k in range(1, 8)]
    row = np.load("q.npy")[0].tolist()
    (folder / "named.csv").write_text("\n".join([COLUMNS, ",".join(map(str, row))]), encoding="utf-8")
    assert main(["validate", *PANDA, "named.csv", "--columns", COLUMNS]) == 0
    np.savez(folder / "two.npz", q=np.load("q.npy"), other=np.zeros((1, 3)))
    assert main(["validate", *PANDA, "two.npz", "q.npy", "--key", "q"]) == 0
    np.savez(folder / "named.npz", q=np.load("q.npy"), joint_names=np.array(names))
    assert main(["validate", *PANDA, "named.npz", "--columns", ",".join(names)]) == 0
    assert main(["view", *PANDA, "q.npy", "--first", "1", "--html", "a.html"]) == 0
    assert main(["view", *PANDA, "--path", "q.npy", "--frames", "2", "--html", "b.html"]) == 0
    capsys.readouterr()
