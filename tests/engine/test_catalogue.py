"""Which modules there are, how they are found, and what happens to those that would not load."""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest

from app.engine import catalogue as catalogues
from app.engine import user_folder
from app.engine.catalogue import Catalogue
from app.engine.errors import CatalogueError, UnknownName

HEAD = """
from modules.data.accuracy import EXACT
from modules.data.wires import Value
from modules.declare import reader
"""
BODY = '''
@reader("{title}"{more})
def {name}() -> Value:
    """{title}.

    Accuracy: exact.
    """
    return Value(value={value}, accuracy=EXACT)
'''


def module(name: str = "one", value: str = "1.0", title: str = "One", more: str = "") -> str:
    return HEAD + BODY.format(name=name, value=value, title=title, more=more)


def test_a_file_in_the_users_folder_is_a_module(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(module())
    catalogue = Catalogue.of([], tmp_path)
    assert [record.id for record in catalogue] == ["user.mine.one"]
    assert catalogue["user.mine.one"].digest


def test_a_broken_file_is_kept_with_its_reason_and_stops_nothing(tmp_path: Path) -> None:
    (tmp_path / "good.py").write_text(module())
    (tmp_path / "crash.py").write_text("1 / 0")
    (tmp_path / "syntax.py").write_text("def (")
    (tmp_path / "leaves.py").write_text("raise SystemExit(1)")
    (tmp_path / "room.py").write_text(module().replace("-> Value", "-> int"))
    catalogue = Catalogue.of([], tmp_path)
    assert [record.id for record in catalogue] == ["user.good.one"]
    sentences = {Path(place).name: broken.sentence for place, broken in catalogue.broken.items()}
    assert sentences["crash.py"] == "ZeroDivisionError: division by zero"
    assert sentences["syntax.py"].startswith("line 1: ")
    assert "the first output of a module in readers may be" in sentences["room.py"]
    assert "leaves.py" in sentences
    assert "crash.py" in catalogue.broken[str(tmp_path / "crash.py")].traceback
    with pytest.raises(UnknownName, match=r"crash\.py did not load: ZeroDivisionError"):
        catalogue.find("user.crash.it")


def test_a_dataclass_in_a_users_file_and_a_helper_by_relative_import(tmp_path: Path) -> None:
    (tmp_path / "_help.py").write_text("VALUE = 5.0\n")
    more = "from dataclasses import dataclass\nfrom ._help import VALUE\n@dataclass\nclass Pair:\n    a: int\n"
    (tmp_path / "mine.py").write_text("from __future__ import annotations\n" + more + module(value="VALUE"))
    catalogue = Catalogue.of([], tmp_path)
    assert not catalogue.broken
    assert catalogue["user.mine.one"].function().value == 5.0
    assert str(tmp_path) not in sys.path


def test_a_changed_file_is_read_again_also_if_size_and_second_are_the_same(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text(module(value="1.0"))
    catalogue = Catalogue.of([], tmp_path)
    before = catalogue["user.mine.one"]
    path.write_text(module(value="2.0"))
    assert catalogue.reload() == ("user.mine.one",)
    after = catalogue["user.mine.one"]
    assert (before.function().value, after.function().value) == (1.0, 2.0)
    assert before.digest != after.digest
    assert catalogue.reload() == ()


def test_a_changed_helper_changes_the_digest_and_the_result(tmp_path: Path) -> None:
    (tmp_path / "_help.py").write_text("VALUE = 5.0\n")
    (tmp_path / "mine.py").write_text("from ._help import VALUE\n" + module(value="VALUE"))
    catalogue = Catalogue.of([], tmp_path)
    before = catalogue["user.mine.one"].digest
    (tmp_path / "_help.py").write_text("VALUE = 6.0\n")
    catalogue.reload()
    assert catalogue["user.mine.one"].function().value == 6.0
    assert catalogue["user.mine.one"].digest != before


def test_a_repaired_file_comes_back_and_a_removed_one_goes(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text("1 / 0")
    catalogue = Catalogue.of([], tmp_path)
    path.write_text(module())
    assert catalogue.reload() == ("user.mine.one",)
    assert not catalogue.broken
    path.unlink()
    assert catalogue.reload() == ("user.mine.one",)
    assert len(catalogue) == 0


def test_a_snapshot_stays_as_it_was(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text(module(value="1.0"))
    catalogue = Catalogue.of([], tmp_path)
    snapshot = catalogue.snapshot()
    path.write_text(module(value="2.0"))
    catalogue.reload()
    assert snapshot["user.mine.one"].function().value == 1.0


def test_a_former_id_leads_to_the_module(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(module(more=', was=("user.old.one",)'))
    catalogue = Catalogue.of([], tmp_path)
    assert catalogue["user.old.one"].id == "user.mine.one"
    assert "user.old.one" in catalogue
    (tmp_path / "other.py").write_text(module(name="two", more=', was=("user.old.one",)'))
    catalogue.reload()
    assert "take one out" in catalogue.broken["user.old.one"].sentence


def test_two_modules_of_one_id_are_refused(lab: Any) -> None:
    function = lab.catalogue["user.fakes.zero"].function
    with pytest.raises(CatalogueError, match=r"two modules of the id 'user\.fakes\.zero': rename"):
        Catalogue.of([function, function])


def test_modules_are_found_by_part_of_their_id(tmp_path: Path) -> None:
    for stem in ("contour", "trace"):
        (tmp_path / f"{stem}.py").write_text(module(name=stem) + BODY.format(name="grey", title="Grey", value=1, more=""))
    catalogue = Catalogue.of([], tmp_path)
    assert catalogue.find("contour").id == "user.contour.contour"
    assert catalogue.find("contour.grey").id == "user.contour.grey"
    with pytest.raises(UnknownName, match=r"may be any of user\.contour\.grey, user\.trace\.grey: write the whole id"):
        catalogue.find("grey")
    with pytest.raises(UnknownName, match=r"no module 'contuor'; did you mean 'contour'\?"):
        catalogue.find("contuor")
    with pytest.raises(UnknownName, match=r"did you mean 'user\.trace\.trace'"):
        catalogue["mappers.trace.trace"]
    with pytest.raises(UnknownName, match="`nonius modules` lists what there is"):
        catalogue.find("qqqqq")


def test_packages_bring_modules_by_entry_point(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "brings_modules"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "more.py").write_text(module())
    monkeypatch.syspath_prepend(str(tmp_path))
    entries = [
        EntryPoint("good", "brings_modules", catalogues.GROUP),
        EntryPoint("gone", "is_not_installed", catalogues.GROUP),
    ]
    monkeypatch.setattr("importlib.metadata.entry_points", lambda group: entries)
    catalogue = Catalogue.load(tmp_path / "nothing")
    assert catalogue["brings_modules.more.one"].digest
    assert "is_not_installed" in catalogue.broken["gone"].sentence


def test_the_users_folder_is_named_by_the_environment_or_the_platform(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NONIUS_MODULES", str(tmp_path))
    assert user_folder.default() == tmp_path
    monkeypatch.delenv("NONIUS_MODULES")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "share"))
    monkeypatch.setattr(sys, "platform", "linux")
    assert user_folder.default() == tmp_path / "share" / "nonius" / "modules"


def test_the_engine_loads_neither_windows_nor_compilers() -> None:
    script = (
        "import sys, app.engine.executor, app.engine.document, app.engine.history\n"
        "from app.engine.catalogue import Catalogue; from pathlib import Path\n"
        "Catalogue.load(Path('nowhere'))\n"
        "heavy = {'numba', 'pyvista', 'vtkmodules', 'PySide6'} & set(sys.modules); print(sorted(heavy))"
    )
    root = Path(__file__).parents[2]
    out = subprocess.run([sys.executable, "-c", script], cwd=root, capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"
