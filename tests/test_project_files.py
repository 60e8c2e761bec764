"""What a visitor of the repository reads first agrees with the package: citation, licences, CHANGELOG, SECURITY."""

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
KINDS = {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}  # of changes, by Keep a Changelog


def read(name: str) -> str:
    """The text of a file of the repository's root."""
    return (ROOT / name).read_text(encoding="utf-8")


def cited(key: str) -> list[str]:
    """The value of a key of CITATION.cff, or the items of its list."""
    found = re.search(rf"^{key}: *(.*)\n((?:  - .*\n)*)", read("CITATION.cff"), re.M)
    assert found is not None, key
    return [found[1]] if found[1] else [line.removeprefix("  - ") for line in found[2].splitlines()]


def test_the_citation_names_the_version_the_authors_and_the_licences_of_the_package() -> None:
    assert cited("version") == [PROJECT["version"]]
    assert cited("authors") == [f"name: {author['name']}" for author in PROJECT["authors"]]
    assert cited("keywords") == PROJECT["keywords"]
    assert " AND ".join(cited("license")) == PROJECT["license"]["text"]


def test_both_licences_stand_in_the_readme_with_what_they_cover() -> None:
    said = read("README.md").rpartition("## Licence")[2]
    assert re.search(r"code is under \[Apache-2\.0\]\(LICENSE\), the texts and figures under \[CC BY 4\.0\]\(LICENSE-texts\)", said)
    assert "Apache License" in read("LICENSE") and "creativecommons.org/licenses/by/4.0/" in read("LICENSE-texts")


def test_the_changelog_keeps_its_form() -> None:
    """Unreleased first, then versions; under each only kinds of changes, and entries of one line."""
    lines = read("CHANGELOG.md").splitlines()
    versions = [line.removeprefix("## ") for line in lines if line.startswith("## ")]
    assert versions[0] == "Unreleased" and all(re.fullmatch(r"\d+\.\d+\.\d+(?: - \d{4}-\d\d-\d\d)?", each) for each in versions[1:])
    assert {line.removeprefix("### ") for line in lines if line.startswith("### ")} <= KINDS
    released = lines[lines.index(f"## {versions[1]}"):]
    assert [line for line in released if line and not line.startswith(("- ", "## ", "### "))] == []


def test_the_security_page_is_ten_lines_and_every_file_it_names_exists() -> None:
    page = read("SECURITY.md")
    assert len(page.splitlines()) <= 10
    assert [name for name in re.findall(r"\]\(([^)]+)\)", page) if not (ROOT / name).exists()] == []


def test_every_path_that_a_contributor_is_told_exists() -> None:
    """All but those with a place for a name, and those of a lesson and a language that a reader begins."""
    for page in ("README.md", "CONTRIBUTING.md"):
        told = {word for code in re.findall(r"`([^`]+)`", read(page)) for word in code.split()
                if re.match(r"(app|lessons|tests|assets|\.ci)/", word) and "<" not in word
                and not word.startswith(("lessons/leaky_tank", "app/locale/de/"))}
        assert told, page
        assert [word for word in sorted(told) if not list(ROOT.glob(word.rstrip("/,.")))] == []


def test_a_python_that_numba_has_no_wheel_for_installs_without_it() -> None:
    assert "numba" not in [need.name for need in map(Requirement, PROJECT["dependencies"])]
    versions = [line.rpartition(" ")[2] for line in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", line)]
    for extra in ("fast", "test"):
        (numba,) = (need for need in map(Requirement, PROJECT["optional-dependencies"][extra]) if need.name == "numba")
        assert numba.marker is not None
        assert versions and all(numba.marker.evaluate({"python_version": version}) for version in versions)
        assert not numba.marker.evaluate({"python_version": "3.99"})


def test_the_readme_asks_each_lessons_question_in_its_words() -> None:
    asked = dict(re.findall(r"^\| ([a-z-]+) \| ([^|]*\?) \|", read("README.md"), re.M))
    said = {path.parent.name.replace("_", "-"): path.read_text(encoding="utf-8") for path in ROOT.glob("lessons/*/en.md")}
    assert asked.keys() == said.keys()
    assert asked == {name: re.findall(r"^> (.*)$", words, re.M)[0] for name, words in said.items()}
