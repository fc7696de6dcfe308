"""Each package of camtools sees only those below it, as pyproject.toml draws the layers."""

import subprocess
import sys
import tomllib
from pathlib import Path

from tests.tools.cases.part_cases import ROOT, environment

TOOLS = ROOT / "tools"
LINT = "from importlinter.cli import lint_imports_command; lint_imports_command()"


def lint(config: Path, tools: Path = TOOLS) -> subprocess.CompletedProcess[str]:
    """Run import-linter on the packages of a folder."""
    return subprocess.run(
        [sys.executable, "-c", LINT, "--config", str(config), "--no-cache"],
        env=environment() | {"PYTHONPATH": str(tools)},
        capture_output=True,
        text=True,
        check=False,
    )


def test_no_package_sees_one_above_it() -> None:
    """All contracts of import-linter are kept."""
    done = lint(TOOLS / "pyproject.toml")
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_package_has_its_layer() -> None:
    """A package that the import check does not know would see everything."""
    settings = tomllib.loads((TOOLS / "pyproject.toml").read_text())
    contracts = settings["tool"]["importlinter"]["contracts"]
    [layers] = [one["layers"] for one in contracts if one.get("containers") == ["camtools"]]
    named = {name.strip() for layer in layers for name in layer.split("|")}
    packages = {path.parent for path in (TOOLS / "camtools").glob("*/__init__.py")}
    kinds = {path.name for path in packages if (path / "kind.py").exists()} - {"pipeline"}
    assert {path.name for path in packages} - kinds <= named
    assert kinds >= {"skirt", "lobe"}
