"""Compiled code: never that of an older version, and always somewhere."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ncmodel import jit

PROGRAM = "import ncmodel.outer; print(ncmodel.outer.doubled(1.0))"


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package of this one's name, in which the kernel of one module compiles in what another defines."""
    folder = tmp_path / "site" / "ncmodel"
    folder.mkdir(parents=True)
    shutil.copy(jit.__file__, folder)
    (folder / "__init__.py").write_text("")
    (folder / "inner.py").write_text(INNER)
    head = "from ncmodel.inner import factor\nfrom ncmodel.jit import kernel\n"
    (folder / "outer.py").write_text(head + "@kernel\ndef doubled(x):\n    return factor() * x\n")
    return folder


INNER = "from ncmodel.jit import kernel\n@kernel\ndef factor():\n    return 2.0\n"


def run(package: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Call the kernel in a process of its own, whose caches are all beside the package."""
    home = {"HOME": str(package.parent), "XDG_CACHE_HOME": str(package.parent / "cache")}
    kept = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    paths = {"PYTHONPATH": str(package.parent), "PYTHONSAFEPATH": "1"}
    return subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env=kept | home | paths | environment,
        cwd=package.parent,
        capture_output=True,
        text=True,
        check=True,
    )


def kept_in(folder: Path) -> list[str]:
    """The folders of compiled modules somewhere under a folder."""
    return sorted({path.parent.parent.name.split("-")[0] for path in folder.rglob("*.nbc")})


def test_a_change_of_another_module_is_compiled_in(package: Path) -> None:
    assert run(package).stdout == "2.0\n"
    assert kept_in(package) == ["inner", "outer"]
    (package / "inner.py").write_text(INNER.replace("2.0", "3.0"))
    assert run(package).stdout == "3.0\n"
    assert len(list((package / "__pycache__").glob("outer-*"))) == 1, "the older version's code is dropped"


def test_only_what_is_imported_counts(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit, "PACKAGE", package)
    before = jit.fingerprint(package / "outer.py")
    (package / "other.py").write_text("")
    assert jit.fingerprint(package / "outer.py") == before
    (package / "inner.py").write_text(INNER + "\n")
    assert jit.fingerprint(package / "outer.py") != before


def test_an_installation_that_cant_be_written_uses_the_users_cache(package: Path) -> None:
    (package / "__pycache__").write_text("a file where a folder is needed: nobody, not even root, can write there")
    done = run(package)
    assert (done.stdout, done.stderr) == ("2.0\n", "")
    assert kept_in(package.parent / "cache") == ["inner", "outer"]


def test_no_place_at_all_is_told_once_and_works(package: Path) -> None:
    (package / "__pycache__").write_text("")
    (package.parent / "cache").write_text("")
    done = run(package)
    assert done.stdout == "2.0\n"
    assert done.stderr.count("NUMBA_CACHE_DIR") == 1


def test_the_users_choice_goes_first(package: Path, tmp_path: Path) -> None:
    assert run(package, NUMBA_CACHE_DIR=str(tmp_path / "mine")).stdout == "2.0\n"
    assert kept_in(tmp_path / "mine") == ["inner", "outer"]
    assert kept_in(package) == []
