"""Each feature that the README and the how-to guides name is proved by tests that exist; see ``features.toml``."""

import re
import tomllib
from pathlib import Path

from tests.audits.source import PACKAGE, ROOT

LEDGER = tomllib.loads((Path(__file__).parent / "features.toml").read_text(encoding="utf-8"))
GUIDES = {path.stem: path for path in (PACKAGE / "docs" / "howto").glob("*.md") if path.stem != "index"}


def headings(page: Path) -> set[str]:
    """Titles of a page and of its sections, without what stands in its code blocks."""
    return set(re.findall(r"^##? (.+)$", re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S), re.M))


def test_each_point_of_the_readme_has_a_test():
    list_of_features = (ROOT / "README.md").read_text(encoding="utf-8").partition("## What it does")[2].partition("\n## ")[0]
    assert set(re.findall(r"^(\d+)\. ", list_of_features, re.M)) == set(LEDGER["readme"])


def test_each_section_of_the_how_to_guides_has_a_test():
    assert {name: headings(path) for name, path in GUIDES.items()} == {
        name: set(sections) for name, sections in LEDGER.items() if name != "readme"
    }


def test_tests_of_the_ledger_exist():
    files = {file for sections in LEDGER.values() for tests in sections.values() for file in tests}
    assert sorted(file for file in files if not (ROOT / file).is_file()) == []
    assert all(tests for sections in LEDGER.values() for tests in sections.values())


def test_generated_parts_of_the_documentation_are_current():
    from mbconstrained.docs.generated import PAGES, current

    assert {page.name for page in PAGES if page.read_text(encoding="utf-8") != current(page)} == set(), (
        "write them by: python -m mbconstrained.docs.generated"
    )
