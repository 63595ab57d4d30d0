"""What is installed, and that it is found from anywhere."""

import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from app import paths

ROOT = Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))


def test_data_is_found_beside_a_checkout() -> None:
    assert paths.data("networks") == ROOT / "networks"
    assert "jacksboro" in paths.networks()
    assert paths.checkout() == ROOT


def test_data_is_found_in_a_wheel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    inside = tmp_path / "app" / "_data" / "networks"
    inside.mkdir(parents=True)
    monkeypatch.setattr(paths, "HERE", tmp_path / "app")
    assert paths.data("networks") == inside
    assert paths.networks() == {}
    assert paths.checkout() is None
    with pytest.raises(FileNotFoundError, match="install"):
        paths.data("resources")


def test_a_foreign_package_called_modules_is_told(tmp_path: Path) -> None:
    (tmp_path / "modules").mkdir()
    (tmp_path / "modules" / "__init__.py").write_text("")
    path = [str(tmp_path), str(ROOT)]
    code = f"import sys; sys.path[:0] = {path!r}; from app.cli import main; sys.exit(main(['modules']))"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode in (1, 2)
    assert "Traceback" not in done.stderr
    assert "another package called 'modules' is in the way" in done.stderr
    assert str(tmp_path / "modules") in done.stderr


def test_the_broken_binding_is_not_installed() -> None:
    (binding,) = [d for d in PROJECT["project"]["dependencies"] if d.startswith("pyside6")]
    assert "!=6.12.0" in binding


def test_versions_are_one() -> None:
    from app import __version__

    assert PROJECT["project"]["version"] == __version__


def test_what_is_imported_is_declared() -> None:
    declared = " ".join(PROJECT["project"]["dependencies"]).lower()
    for name in ("numpy", "scipy", "numba", "networkx", "pyvista", "matplotlib", "pillow"):
        assert name in declared


@pytest.fixture(scope="session")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built without a network."""
    hatchling = pytest.importorskip("hatchling.build")
    folder = tmp_path_factory.mktemp("wheel")
    code = f"import os, hatchling.build as b; os.chdir({str(ROOT)!r}); print(b.build_wheel({str(folder)!r}))"
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
    assert hatchling
    (built,) = folder.glob("*.whl")
    return built


def test_the_wheel_holds_packages_networks_and_resources(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    for wanted in ("app/cli.py", "modules/api.py", "app/_data/networks/jacksboro.json", "app/_data/resources/docs/files.md"):
        assert wanted in names
    assert not [n for n in names if n.startswith(("tests/", "networks/", "resources/")) or "~1" in n or n.endswith(".pyc")]


def test_the_wheel_runs_a_network_by_its_bare_name_from_anywhere(wheel: Path, tmp_path: Path) -> None:
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    code = f"""
import sys
sys.path.insert(0, {str(tmp_path / "site")!r})
from app import cli, paths
assert paths.data("networks").parent.name == "_data", paths.data("networks")
assert paths.checkout() is None
assert cli.main(["check", "jacksboro"]) == 0
assert cli.main(["describe", "contour"]) == 0
assert cli.main(["bench"]) == 2
"""
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    done = subprocess.run([sys.executable, "-c", code], cwd=elsewhere, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "it could run" in done.stdout
    assert "jacksboro" in done.stdout.split("used in")[1]
