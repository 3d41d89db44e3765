"""What is published with the code: citation, changelog, version, forms for issues, the draft of the article."""

from __future__ import annotations

import re
import tomllib
from datetime import date
from pathlib import Path
from typing import Any

import pytest

import gyroctl as gy

yaml = pytest.importorskip("yaml")

ROOT = Path(__file__).resolve().parents[1]
PAPER = ROOT / "docs" / "paper"
FORMS = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))
DOI = re.compile(r"10\.\d{4,9}/[^\s\"]+")


def text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def citation() -> dict[str, Any]:
    return dict(yaml.safe_load(text_of(ROOT / "CITATION.cff")))


def entries() -> dict[str, dict[str, str]]:
    """Entries of the bibliography by key."""
    found = {}
    for kind, key, body in re.findall(r"@(\w+)\{(\w+),\n(.*?)\n\}\n", text_of(PAPER / "paper.bib"), re.DOTALL):
        found[key] = {"kind": kind, **dict(re.findall(r"^  (\w+) = \{(.*)\},?$", body, re.MULTILINE))}
    return found


def sections(page: str) -> list[str]:
    return re.findall(r"^# (.+)$", page, re.MULTILINE)


# --- version -----------------------------------------------------------------------------------------------------


def test_one_version_stands_wherever_a_version_stands() -> None:
    project = tomllib.loads(text_of(ROOT / "pyproject.toml"))["project"]
    newest = re.search(r"^## (\S+) \((\S+)\)$", text_of(ROOT / "CHANGELOG.md"), re.MULTILINE)
    assert newest is not None
    assert {project["version"], citation()["version"], newest[1]} == {gy.__version__}
    assert citation()["date-released"] == newest[2]
    assert f"gyroctl:{gy.__version__} " in text_of(ROOT / "docs" / "examples" / "kubernetes.yaml")


def test_changelog_has_versions_from_new_to_old_each_in_groups() -> None:
    page = text_of(ROOT / "CHANGELOG.md")
    headings = re.findall(r"^## (.+)$", page, re.MULTILINE)
    told = [re.fullmatch(r"(\d+)\.(\d+)\.(\d+) \((\d{4}-\d{2}-\d{2})\)", heading) for heading in headings]
    assert all(told), headings
    versions = [tuple(int(part) for part in match.groups()[:3]) for match in told if match]
    days = [date.fromisoformat(match[4]) for match in told if match]
    assert versions == sorted(versions, reverse=True) and days == sorted(days, reverse=True)
    groups = re.findall(r"^### (.+)$", page, re.MULTILINE)
    assert set(groups) <= {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}
    for released in re.split(r"^## .+$", page, flags=re.MULTILINE)[1:]:
        assert re.match(r"\s*### ", released), "each version begins with a group"


# --- citation ----------------------------------------------------------------------------------------------------


def test_citation_has_what_its_format_asks_for() -> None:
    """Required keys and their forms, of the Citation File Format 1.2.0."""
    found = citation()
    assert found["cff-version"] == "1.2.0" and found["type"] == "software"
    assert found["message"] and found["title"].startswith("gyroctl") and found["abstract"]
    assert all({"name"} <= one.keys() or {"family-names", "given-names"} <= one.keys() for one in found["authors"])
    assert found["license"] == "MIT" and text_of(ROOT / "LICENSE").startswith("MIT License")
    date.fromisoformat(found["date-released"])
    for reference in found["references"]:
        assert {"type", "title", "authors"} <= reference.keys() and DOI.fullmatch(reference["doi"])


def test_addresses_of_the_project_are_real() -> None:
    urls = tomllib.loads(text_of(ROOT / "pyproject.toml"))["project"]["urls"]
    assert urls and all(re.fullmatch(r"https://[\w./-]+", url) for url in urls.values())
    assert not [url for url in urls.values() if "example" in url or "localhost" in url]


# --- the draft of the article ------------------------------------------------------------------------------------


def test_draft_has_the_sections_of_the_checklist_and_its_length() -> None:
    page = text_of(PAPER / "paper.md")
    wanted = ["Summary", "Statement of need", "State of the field", "Software design", "Research impact statement"]
    assert sections(page) == [*wanted, "AI usage disclosure", "Acknowledgements", "References"]
    assert 750 <= len(page.split()) <= 1750


def test_head_of_the_draft_has_what_the_journal_reads() -> None:
    head = yaml.safe_load(text_of(PAPER / "paper.md").split("---\n")[1])
    assert {"title", "tags", "authors", "affiliations", "date", "bibliography"} <= head.keys()
    places = {place["index"] for place in head["affiliations"]}
    assert all(author["name"] and author["affiliation"] in places for author in head["authors"])
    assert (PAPER / head["bibliography"]).is_file()


def test_every_reference_is_cited_and_every_citation_has_one() -> None:
    cited = set(re.findall(r"@(\w+)", text_of(PAPER / "paper.md").split("---\n", 2)[2]))
    assert cited == entries().keys()
    for key, entry in entries().items():
        venue = {"article": "journal", "inproceedings": "booktitle"}[entry["kind"]]
        assert {"author", "title", "year", venue} <= entry.keys(), key
        assert key.endswith(entry["year"]) and ("doi" not in entry or DOI.fullmatch(entry["doi"])), key


def test_article_of_the_device_is_the_same_in_all_places() -> None:
    (reference,) = citation()["references"]
    entry = entries()["zhang2017"]
    assert reference["doi"] == entry["doi"] and reference["title"] == entry["title"]
    assert entry["pages"] == f"{reference['start']}--{reference['end']}"
    assert reference["title"] in re.sub(r"\s+", " ", text_of(ROOT / "README.md"))


# --- forms for issues, checklist of a release --------------------------------------------------------------------


def test_forms_ask_for_what_is_needed_and_are_forms() -> None:
    forms = {path.stem: yaml.safe_load(text_of(path)) for path in FORMS if path.stem != "config"}
    assert forms.keys() == {"bug", "law", "question"}
    for form in forms.values():
        assert {"name", "description", "body"} <= form.keys()
        names = [field["id"] for field in form["body"]]
        assert len(set(names)) == len(names) and "version" in names
        for field in form["body"]:
            assert field["type"] in {"textarea", "input"} and field["attributes"]["label"]


def test_checklist_of_a_release_names_files_that_are_there() -> None:
    page = text_of(ROOT / "docs" / "release.md")
    named = set(re.findall(r"`((?:[\w.-]+/)*[\w.-]+\.(?:py|md|toml|cff|txt|yaml))`", page))
    named |= set(re.findall(r"`python ((?:\w+/)+\w+\.py)", page))
    assert len(named) >= 8
    assert not [name for name in named if not (ROOT / name).exists()]
    links = re.findall(r"\]\(([^)#]+)\)", page)
    assert not [link for link in links if "://" not in link and not (ROOT / "docs" / link).exists()]
