"""Constraints for the lowest allowed versions."""

import re
import tomllib

from tests.tools.lowest_versions import PROJECT, lowest_versions


def test_the_highest_bound_of_a_package_counts() -> None:
    extras = {
        "one": ["b>=1.9", "c[x]>=2"],
        "two": ["b>=1.10,<2; python_version < '3.12'"],
        "dev": ["b>=3"],
        "docs": ["d>=1"],
    }
    project = {"dependencies": ["a>=1.2.3", "e"], "optional-dependencies": extras}
    assert list(lowest_versions(project)) == ["a==1.2.3", "b==1.10"]


def test_every_dependency_of_users_has_a_lowest_version() -> None:
    project = tomllib.loads(PROJECT.read_text())["project"]
    found = {each.partition("==")[0] for each in lowest_versions(project)}
    extras = (
        each
        for name, some in project["optional-dependencies"].items()
        if name not in ("dev", "docs")
        for each in some
    )
    named = {re.split(r"[><=;\[ ]", each)[0] for each in (*project["dependencies"], *extras)}
    assert named - {"seoro"} == found
