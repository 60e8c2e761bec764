"""Recorded lessons are kept by their sources: a changed lesson is recorded again alone, a changed shared source records all again."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pytest
from test_architecture import PICTURE

from observer_lab.cli.commands import publish
from observer_lab.cli.entry import main
from observer_lab.engine.kernels import kernels_off
from observer_lab.lessons import LESSONS
from observer_lab.static_pages.store import MOST_KEPT, UNSHOWN, Sources, Store

APP, COURSE = Path(publish.__file__).parents[2], Path(__file__).parents[1] / "lessons"
SCENE = {"lesson.toml": '\n[[scenes]]\nid = "meet"\ndo = "play"\nfigures = ["error"]\n',
         "lesson.md": "\n## scene meet: Meet\nLook.\n### do\nPress *play*.\n### say\nIt moves.\n"}
Keys = Callable[[], Mapping[str, str]]


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the sources that a test may change for a while."""
    house = tmp_path_factory.mktemp("house")
    for name, root in (("app", APP), ("lessons", COURSE)):
        shutil.copytree(root, house / name, ignore=shutil.ignore_patterns("__pycache__", "*.woff2"))
    return house


@pytest.fixture(scope="module")
def keys(house: Path) -> Keys:
    places = {id: house / "lessons" / id.replace("-", "_") for id in LESSONS}
    return lambda: Sources(house / "app", house / "lessons", places).keys(LESSONS, ["en", "zh"], "options")


@pytest.fixture(scope="module")
def before(keys: Keys) -> Mapping[str, str]:
    return keys()


def changed_by(path: Path, keys: Keys, before: Mapping[str, str]) -> set[str]:
    """The lessons that are recorded again while a file has a line more."""
    content = path.read_bytes()
    path.write_bytes(content + b"\n")
    after = keys()
    path.write_bytes(content)
    return {id for id, key in after.items() if key != before[id]}


def test_a_changed_source_of_a_lesson_records_that_lesson_alone(house: Path, keys: Keys, before: Mapping[str, str]) -> None:
    for id in ("error-dynamics", "kalman"):
        own = house / "lessons" / id.replace("-", "_")
        for path in (own / "lesson.py", own / "path.md", *(house / "app" / "locale" / "zh").glob(f"{id}.*")):
            assert changed_by(path, keys, before) == {id}, path


@pytest.mark.parametrize("name", ["app/static_pages/recorder.py", "app/engine/systems/balance.py", "app/page/web/viser_page/viser_dom.js",
                                  "app/locale/zh/page.po", "app/colours.py", "lessons/toolkit/boards.py", "lessons/glossary.md"])
def test_a_changed_shared_source_records_all_lessons(house: Path, keys: Keys, before: Mapping[str, str], name: str) -> None:
    path = house / name
    assert changed_by(path, keys, before) == set(LESSONS)


@pytest.mark.parametrize("name", ["cli/options.py", "page/record/published_page.py", "page/web/styles/published.css",
                                  "page/web/viser_page/published.js"])
def test_a_command_or_the_page_around_changes_no_recorded_lesson(house: Path, keys: Keys, before: Mapping[str, str], name: str) -> None:
    assert changed_by(house / "app" / name, keys, before) == set()


def test_parts_that_no_page_shows_are_not_reached_from_the_recorder() -> None:
    """What is left out of a key is imported neither by the recorder, by what it imports, nor by a lesson."""
    reached, todo = set[str](), ["observer_lab.static_pages", "observer_lab.lessons"]
    while todo:
        room = todo.pop()
        if room not in reached:
            reached.add(room)
            todo += PICTURE.get(room, ())
    assert not {f"observer_lab.{name}" for name in UNSHOWN} & reached


def test_options_and_what_other_pages_show_are_part_of_a_key(house: Path) -> None:
    sources = Sources(house / "app", house / "lessons", {id: house / "lessons" / id.replace("-", "_") for id in LESSONS})
    some = {id: LESSONS[id] for id in ("separation", "kalman")}
    one = sources.keys(some, ["en"], 7)["separation"]
    assert one != sources.keys(some, ["en"], 8)["separation"]
    assert one != sources.keys({**some, "noise": LESSONS["noise"]}, ["en"], 7)["separation"]


def test_how_the_kernels_are_compiled_is_part_of_a_key(
        keys: Keys, before: Mapping[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> str:
        if name == "numba":
            raise PackageNotFoundError
        return version(name)
    for name, other in (("kernels_off", lambda: not kernels_off()), ("version", missing)):
        with monkeypatch.context() as patch:
            patch.setattr(f"observer_lab.static_pages.store.{name}", other)
            assert not set(keys().items()) & set(before.items()), name


def test_a_recording_that_is_stopped_is_not_taken_for_a_whole_one(tmp_path: Path) -> None:
    store = Store(tmp_path)

    def stopped(write: Callable[[str, str], object]) -> None:
        write("a.js", "1")
        raise KeyboardInterrupt
    with pytest.raises(KeyboardInterrupt):
        store.keep("separation", "k", stopped)
    assert not store.has("separation", "k") and list((tmp_path / "separation").iterdir()) == []


def test_a_folder_holds_the_recorded_lesson_and_nothing_older(tmp_path: Path) -> None:
    store, target = Store(tmp_path / "store"), tmp_path / "site" / "data" / "separation"
    store.keep("separation", "old", lambda write: write("scene/gone.js", "1"))
    store.copy("separation", "old", target)
    store.keep("separation", "new", lambda write: write("scene/here.js", "2"))
    store.copy("separation", "new", target)
    assert sorted(path.name for path in target.rglob("*.js")) == ["here.js"] and len(list(target.parent.iterdir())) == 1
    for k in range(MOST_KEPT + 2):
        store.keep("separation", f"key {k}", lambda write: write("a.js", "1"))
    assert len(list((tmp_path / "store" / "separation").iterdir())) == MOST_KEPT and store.has("separation", f"key {MOST_KEPT + 1}")


def recorded(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The lessons that are recorded from now on, without the work."""
    found: list[str] = []

    def write_lesson(lessons: object, lesson: str, looks: object, points: object, write: Callable[[str, str], object],
                     advance: Callable[[], object]) -> None:
        found.append(lesson)
        if lesson == "noise":
            raise KeyboardInterrupt
        write("a.js", lesson)
        advance()
    monkeypatch.setattr("observer_lab.static_pages.site.write_lesson", write_lesson)
    return found


def test_a_second_folder_is_copied_from_the_store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found, options = recorded(monkeypatch), ["--cache", str(tmp_path / "store"), "--lang", "en"]
    for name in ("one", "two"):
        assert main(["publish", "separation", "kalman", "-o", str(tmp_path / name), *options]) == 0
        assert (tmp_path / name / "data" / "kalman" / "a.js").read_text() == "kalman"
    assert found == ["separation", "kalman"]


def test_ctrl_c_keeps_the_lessons_that_are_done(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    found, options = recorded(monkeypatch), ["--cache", str(tmp_path / "store"), "--lang", "en"]
    for _ in range(2):
        assert main(["publish", "separation", "noise", "-o", str(tmp_path / "site"), *options]) == 130
    assert found == ["separation", "noise", "noise"] and "1 of 2 lessons recorded" in capsys.readouterr().err


def test_the_lessons_of_a_lecture_are_published_with_a_page_of_its_scenes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found, talk = recorded(monkeypatch), tmp_path / "talk.toml"
    stops = (f'[[stops]]\nlesson = "{lesson}"\nscene = "{LESSONS[lesson].path[3].id}"\n' for lesson in ("kalman", "separation"))
    talk.write_text("".join(('title = "Ten minutes"\n', *stops)))
    site = tmp_path / "site"
    assert main(["publish", "--lecture", str(talk), "-o", str(site), "--cache", str(tmp_path / "store")]) == 0
    assert found == ["kalman", "separation"]
    page = (site / "lecture-en.html").read_text(encoding="utf-8")
    assert "Ten minutes" in page and page.index("lesson=kalman") < page.index("lesson=separation&amp;lang=en&amp;scene=predict&amp;stop=1")
    assert (site / "lecture-zh.html").is_file()


def test_own_lessons_are_published_and_one_with_a_fault_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                                                   capsys: pytest.CaptureFixture[str]) -> None:
    found, own = recorded(monkeypatch), tmp_path / "own"
    assert main(["new-lesson", "my-plant", "--folder", str(own)]) == 0
    options = ["-o", str(tmp_path / "site"), "--lessons", str(own), "--cache", str(tmp_path / "store"), "--lang", "en"]
    assert main(["publish", "my-plant", *options]) == 2 and "no scenes yet" in capsys.readouterr().err
    for file, more in SCENE.items():
        with (own / "my-plant" / file).open("a", encoding="utf-8") as open_file:
            open_file.write(more)
    assert main(["publish", "my-plant", *options]) == 0 and found == ["my-plant"]
    (own / "my-plant" / "lesson.toml").write_text("broken")
    assert main(["publish", "my-plant", *options]) == 2 and "cannot be published" in capsys.readouterr().err
