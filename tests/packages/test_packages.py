"""camturn as others get it: a Python package, a library, a base for a port, a Debian package."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
from pathlib import Path

import pytest

from camtools.base.project import VERSION
from tests.linux.kernel import UML, Kernel
from tests.tools.cases.camsim_cases import BUILD, ROOT

pytest_plugins = ["tests.linux.linux_fixtures"]

HERE = Path(__file__).parent
TEMPLATE = ROOT / "hal" / "template"
LINUX = ROOT / "build" / "linux"
SCRIPTS = tomllib.loads((ROOT / "tools" / "pyproject.toml").read_text())["project"]["scripts"]
OURS = re.compile(r"^(PYTHON|CAMTURN_|PIP_)")
# Runs scripts in one process, where what they all import is imported once.
HELP_OF = """
import contextlib, runpy, sys
def help_of(paths):
    for path in paths:
        sys.argv = [path, "--help"]
        with contextlib.suppress(SystemExit):
            runpy.run_path(path, run_name="__main__")
"""
BUILT = "no camturn-linux; build it: cmake --workflow --preset linux"


def run(*words: str | Path, cwd: Path = ROOT, status: int = 0) -> str:
    """Run a command without what points to the clone; return its output."""
    done = subprocess.run(
        [str(word) for word in words],
        cwd=cwd,
        env={name: text for name, text in os.environ.items() if not OURS.match(name)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert done.returncode == status, done.stdout
    return done.stdout


@pytest.fixture(scope="module")
def scripts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the Python package in an environment of its own; return the folder of its commands.

    What it depends on is taken from this environment, so nothing is fetched.
    """
    folder = tmp_path_factory.mktemp("installed")
    venv.create(folder, symlinks=True)
    (site,) = folder.glob("lib/python*/site-packages")
    here = sysconfig.get_path("purelib")
    (site / "dependencies.pth").write_text(f"import site; site.addsitedir({here!r})\n")
    pip = (sys.executable, "-m", "pip", "--python", folder / "bin" / "python", "-q", "install")
    run(*pip, "--no-deps", "--no-build-isolation", "--no-index", ROOT / "tools")
    return folder / "bin"


@pytest.mark.long
def test_part_is_cut_without_a_clone(scripts: Path, tmp_path: Path) -> None:
    """Generator and simulator come from the package, results go to the working folder."""
    assert run(scripts / "mktables", "--version", cwd=tmp_path) == f"mktables {VERSION}\n"
    assert run(scripts / "camturn-run", "--version", cwd=tmp_path) == f"camturn-run {VERSION}\n"
    part = tmp_path / "mine.toml"
    text = (ROOT / "tools" / "parts" / "hexagon.toml").read_text()
    part.write_text(text.replace('name = "hexagon"', 'name = "mine"'))
    run(scripts / "mktables", part, "-o", "tables", cwd=tmp_path)
    assert (tmp_path / "tables" / "mine.camtab").exists()
    said = run(scripts / "camturn-run", part, cwd=tmp_path)
    assert "mine: within tolerance" in said
    report = tmp_path / "build" / "run" / "mine" / "report.html"
    assert f"camturn-run {part}" in report.read_text(encoding="utf-8")


@pytest.mark.long
def test_help_names_the_installed_commands(scripts: Path, tmp_path: Path) -> None:
    """Each starts; no help and no complaint speaks of the scripts of a clone."""
    assert run(scripts / "camctl", "--help", cwd=tmp_path).startswith("usage: camctl ")
    assert "  camturn-run -o " in run(scripts / "camturn-run", "--help", cwd=tmp_path)
    said = run(scripts / "camturn-run", "--rpm", cwd=tmp_path, status=2)
    assert said.endswith("; see camturn-run --help\n")
    said = run(scripts / "camturn-run", "none.toml", cwd=tmp_path, status=2)
    assert said.startswith("camturn-run: none.toml: ")
    paths = [str(scripts / name) for name in SCRIPTS]
    told = run(scripts / "python", "-c", f"{HELP_OF}\nhelp_of({paths})", cwd=tmp_path)
    assert told.count("usage: ") == len(SCRIPTS)
    assert not re.search(r"\btools/(?!docs/)", told), told


@pytest.mark.long
def test_missing_extra_is_named(scripts: Path, tmp_path: Path) -> None:
    """A command whose packages are not installed names the remedy."""
    (tmp_path / "nicegui.py").write_text("raise ModuleNotFoundError(name='nicegui')\n")
    python = (scripts / "python", "-c")
    script = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); sys.argv[0] = 'camturn-panel'"
    start = f"{script}; from camtools.cli.installed import main; sys.exit(main())"
    said = run(*python, start, cwd=tmp_path, status=2)
    assert said == "camturn-panel: needs the Python package nicegui; pip install 'camturn[panel]'\n"


def test_c_program_finds_the_library(tmp_path: Path) -> None:
    """An installed libcamsim is found, compiled against and run."""
    run("cmake", "--install", BUILD, "--prefix", tmp_path / "installed")
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.25)\nproject(mine LANGUAGES C)\n"
        f"find_package(camturn {VERSION} EXACT REQUIRED)\n"
        "add_executable(mine mine.c)\n"
        "target_link_libraries(mine PRIVATE camturn::camsim)\n"
    )
    (tmp_path / "mine.c").write_text(
        '#include "sim_api.h"\n#include <stdio.h>\n'
        "int main(void) { return puts(sim_api_version()) < 0; }\n"
    )
    run("cmake", "-B", "build", "-D", "CMAKE_PREFIX_PATH=installed", cwd=tmp_path)
    run("cmake", "--build", "build", cwd=tmp_path)
    assert run(tmp_path / "build" / "mine") == f"{VERSION}\n"
    assert run(tmp_path / "installed" / "bin" / "camsim", "--version") == f"camsim {VERSION}\n"


@pytest.mark.long
def test_port_outside_this_tree(tmp_path: Path) -> None:
    """A folder anywhere is a port: hal/template has every function without a default.

    A port's own function, even alone in its file, has priority over the default; the linker names
    a missing one that has none, and a swing that is stated but neither read nor written.
    """
    port = shutil.copytree(TEMPLATE, tmp_path / "my port")
    head = '#include "hal/hal.h"\n'
    own = "bool {}(void)\n{{\n    return true;\n}}\n"
    (port / "own.c").write_text(head + own.format("hal_measures_u"))
    words = ("-S", ROOT, "-B", "build", "-G", "Ninja", "-D", "CAM_HAL_DIR=my port")
    run("cmake", *words, cwd=tmp_path)
    run("cmake", "--build", "build", cwd=tmp_path)
    symbols = run("nm", tmp_path / "build" / "hal" / "own" / "firmware")
    assert " T hal_measures_u\n" in symbols
    assert " W hal_has_edge_time\n" in symbols
    (port / "own.c").write_text(head + own.format("hal_has_swing"))
    half = run("cmake", "--build", "build", cwd=tmp_path, status=1)
    assert "multiple definition of `hal_has_swing'" in half
    (port / "own.c").write_text(head)
    source = port / "hal_template.c"
    source.write_text(source.read_text().replace("hal_outputs_write_isr", "hal_outputs"))
    missing = run("cmake", "--build", "build", cwd=tmp_path, status=1)
    assert "undefined reference to `hal_outputs_write_isr'" in missing


@pytest.mark.long
@pytest.mark.skipif(shutil.which("arm-none-eabi-gcc") is None, reason="no arm-none-eabi-gcc")
def test_recipe_for_a_new_port_builds(tmp_path: Path) -> None:
    """The commands of hal/PORTING.md, word by word."""
    (tmp_path / "camturn").symlink_to(ROOT)
    page = (ROOT / "hal" / "PORTING.md").read_text(encoding="utf-8")
    recipe = page.split("## Folder and build")[1].split("```")[0]
    commands = re.findall(r"(?m)^    ((?:cp|sed|cmake) .*)$", recipe)
    assert len(commands) == 6
    for command in commands:
        run("bash", "-c", command, cwd=tmp_path)
    assert list((tmp_path / "build").glob("**/libhal_port.a"))


@pytest.mark.long
def test_port_in_a_project_of_its_own(tmp_path: Path) -> None:
    """The project of hal/PORTING.md builds the firmware, and no test of ours becomes its own."""
    shutil.copytree(TEMPLATE, tmp_path / "port")
    page = (ROOT / "hal" / "PORTING.md").read_text(encoding="utf-8")
    project = re.findall(r"^```cmake\n(.*?)^```", page, re.MULTILINE | re.DOTALL)[0]
    (tmp_path / "CMakeLists.txt").write_text(
        re.sub(r"GIT_REPOSITORY .*\)", f'SOURCE_DIR "{ROOT}")', project) + "enable_testing()\n"
    )
    run("cmake", "-B", "build", "-G", "Ninja", cwd=tmp_path)
    run("cmake", "--build", "build", cwd=tmp_path)
    assert list(tmp_path.glob("build/_deps/camturn-build/hal/own/firmware"))
    assert "No tests were found" in run("ctest", "--test-dir", "build", cwd=tmp_path)


@pytest.mark.long
@pytest.mark.kernel
@pytest.mark.skipif(not (LINUX / "build.ninja").exists(), reason=BUILT)
def test_debian_package_comes_runs_and_goes(kernel: Kernel, tmp_path: Path) -> None:
    """Installed in the test kernel, whose changes are lost; root starts what the unit names."""
    if not kernel.is_own:
        pytest.skip("the test kernel of tools/uml is not used on this computer")
    run("cpack", "-B", tmp_path, cwd=LINUX)
    (package,) = tmp_path.glob("*.deb")
    assert package.name.startswith(f"camturn_{VERSION}_")
    script = ("sh", HERE / "debian.sh", package, tmp_path)
    try:
        run(UML, "run", "-v", "-o", tmp_path, *script)
    except AssertionError as error:
        pytest.fail(f"{error}\n{(tmp_path / 'log').read_text()}")
    said = (tmp_path / "said").read_text()
    assert f"camturn {VERSION}\n" in said
    assert "bus: listening for another controller" in said
    assert (tmp_path / "removed").read_text() == "/etc/camturn.toml\nparameters.toml\n"
    assert (tmp_path / "purged").read_text() == ""
