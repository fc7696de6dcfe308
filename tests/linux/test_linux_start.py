"""How camturn-linux starts, or does not: what needs neither CAN nor GPIO."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PORT = ROOT / "hal" / "linux"
PROGRAM = ROOT / "build" / "linux" / "hal" / "linux" / "camturn-linux"

pytestmark = pytest.mark.skipif(
    not PROGRAM.exists(), reason="no camturn-linux; build it: cmake --workflow --preset linux"
)


def run(*words: str | Path, config: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run the program; it must come back."""
    environment = {name: word for name, word in os.environ.items() if name != "CAMTURN_CONFIG"}
    if config is not None:
        environment["CAMTURN_CONFIG"] = str(config)
    return subprocess.run(
        [PROGRAM, *words], env=environment, capture_output=True, text=True, check=False
    )


def refused(*words: str | Path, config: Path | None = None) -> str:
    """Return the one line that it says when it does not start."""
    done = run(*words, config=config)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    return done.stderr


@pytest.mark.parametrize("name", ["camturn.toml", "desk.toml"])
def test_example_files_are_right(name: str) -> None:
    """Both are taken, by the option and by the environment."""
    for done in (
        run("--check", "--config", PORT / name),
        run("--check", f"--config={PORT / name}"),
        run("--check", config=PORT / name),
    ):
        assert done.returncode == 0
        assert done.stdout.endswith("the configuration is valid\n")
        is_warned = "warning: thread.tick_hz = 1000: takes up to 144 %" in done.stderr
        assert is_warned == (name == "desk.toml")


def test_help_lists_options_and_exit_status() -> None:
    """The help needs no configuration."""
    done = run("--help")
    assert done.returncode == 0
    assert "--config FILE" in done.stdout and "Exit status" in done.stdout


def test_wrong_words_are_refused(tmp_path: Path) -> None:
    """No configuration, an empty one, a word too many, a file that is not there."""
    assert "no configuration; write --config FILE" in refused()
    assert "not a path" in refused("--config")
    assert "--fast: unknown option" in refused("--fast")
    assert "cannot be opened" in refused("--config", tmp_path / "nobody.toml")
    assert "cannot be opened" in refused(config=tmp_path / "nobody.toml")


def test_option_wins_over_the_environment(tmp_path: Path) -> None:
    """The command line is nearer to the user."""
    assert "first.toml" in refused("--config", tmp_path / "first.toml", config=tmp_path / "second")


def test_wrong_configuration_names_line_field_value_and_remedy(tmp_path: Path) -> None:
    """One line on stderr, with all of it."""
    config = tmp_path / "machine.toml"
    config.write_text("[thread]\ntick_hz = 9000\n")
    line = f"{config}:2: thread.tick_hz = 9000: give a whole number, 500 .. 4000"
    assert refused("--config", config) == f"camturn-linux: {line}\n"


def test_machine_that_is_not_there_is_refused(tmp_path: Path) -> None:
    """An interface that no kernel has; on a kernel without CAN that is said."""
    config = tmp_path / "machine.toml"
    text = (PORT / "desk.toml").read_text().replace("vcan0", "nowhere0").replace("1000", "500")
    config.write_text(text.replace("table.camtab", str(tmp_path / "table.camtab")))
    words = refused("--config", config)
    assert "nowhere0: no such CAN interface" in words or "no CAN sockets in this kernel" in words


def test_parameters_have_a_file_of_their_own(tmp_path: Path) -> None:
    """One file for table and parameters is refused."""
    config = tmp_path / "machine.toml"
    config.write_text('[table]\nfile = "one"\n[parameters]\nfile = "one"\n')
    assert "parameters.file is table.file" in refused("--check", "--config", config)
