"""The sample configuration in the whole of LinuxCNC, without its screen: a program of mkgcode's."""

import os
import re
import shutil
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from checks.patience import until
from tests.linuxcnc.halbox import Halbox
from tests.linuxcnc.test_recorder import read
from tests.tools.cases.part_cases import ROOT, TableOf

pytest_plugins = ["tests.linuxcnc.halrun_fixtures"]

SIM = ROOT / "hal" / "linuxcnc" / "sim"
MESA = ROOT / "hal" / "linuxcnc" / "mesa"
PROGRAMS = ("linuxcncsvr", "io", "milltask", "halui")
PANEL_PINS = Path(__file__).with_name("panel_pins.py")
AXIS_DRO = Path(__file__).with_name("axis_dro.py")
AUTO = Path(__file__).with_name("auto.py")
SLOW = "K0.01"  # the program can be ended in the cut, which takes a minute
README = ROOT / "hal" / "linuxcnc" / "README.md"
# In place of the dwell of the printed program, which is by the clock: waits for camturn.ready.
READY = "M66 P1 L3 Q600"
# A loaded computer starts the spindle late after F2: 100 times stopped-ms are 300 s.
PATIENT_HAL = "setp camturn.stopped-ms 3000\n"
READY_HAL = "net panel-ready camturn.ready => motion.digital-in-01\n"
BLOCKS = (
    "M3 S500", READY, "M64 P0", "M66 P0 L3 Q600", "G33 Z5 K0.25", "M65 P0",
    "M66 P0 L4 Q600",
)  # fmt: skip


def _settings(box: Halbox, table: Path, hal: Path = SIM / "lathe.hal") -> None:
    """Copy the configuration with other places of files, and more time for motion to answer."""
    shutil.copy(table, box.folder / "part.camtab")
    for file in (hal, SIM / "lathe.tbl"):
        shutil.copy(file, box.folder)
    text = (SIM / "lathe.ini").read_text()
    nml = f"NML_FILE = {box.folder / 'linuxcnc.nml'}\n[CAMTURN]"
    for old, new in (
        ("[CAMTURN]", nml),
        ("/tmp/perkins240.camtab", "./part.camtab"),
        ("/tmp/camturn-sim\n", f"{box.folder / 'recording'}\n"),
        ("/tmp/camturn-sim.var", str(box.folder / "sim.var")),
        ("COMM_TIMEOUT = 1.0", "COMM_TIMEOUT = 600.0"),
    ):
        assert old in text
        text = text.replace(old, new, 1)
    (box.folder / "lathe.ini").write_text(text)


@pytest.fixture
def lathe(box: Halbox, linuxcnc_root: Path, table_of: TableOf) -> Iterator[Halbox]:
    """Return the simulated lathe."""
    _settings(box, table_of("perkins240"))
    with (box.folder / "lathe.hal").open("a") as file:
        file.write(READY_HAL + PATIENT_HAL)
    with _started(box, linuxcnc_root):
        yield box


@contextmanager
def _started(box: Halbox, linuxcnc_root: Path) -> Iterator[None]:
    """Start what LinuxCNC's own script starts, in its order."""
    shutil.copy(linuxcnc_root / "usr" / "share" / "linuxcnc" / "linuxcnc.nml", box.folder)
    for name in PROGRAMS:
        shutil.copy(linuxcnc_root / "usr" / "bin" / name, box.folder)
    ini = ("-ini", "lathe.ini")
    try:
        for words in (
            ("./linuxcncsvr", *ini),
            ("./halcmd", "loadusr", "-Wn", "iocontrol", "./io", *ini),
            ("./halcmd", "loadrt", "tpmod"),
            ("./halcmd", "loadrt", "homemod"),
            ("./halcmd", "-i", "lathe.ini", "-f", "lathe.hal"),
            ("./halcmd", "start"),
            ("./halcmd", "loadusr", "-Wn", "inihal", "./milltask", *ini),
            ("./halcmd", "loadusr", "-Wn", "halui", "./halui", *ini),
        ):
            assert box.run(*words) == 0, (words, box.said())
        yield
    finally:
        _end(box)


def _end(box: Halbox) -> None:
    """End the programs that were started in this folder, and nothing else."""
    for process in Path("/proc").iterdir():
        try:
            is_ours = (process / "cwd").readlink() == box.folder
        except OSError:
            continue
        if (
            is_ours
            and process.name.isdigit()
            and (process / "comm").read_text().strip() in PROGRAMS
        ):
            os.kill(int(process.name), signal.SIGTERM)


def execute(lathe: Halbox, linuxcnc_root: Path, *blocks: str) -> None:
    """Switch the machine on and carry out blocks."""
    _control(lathe, linuxcnc_root, Path(__file__).with_name("mdi.py"), *blocks)


def _control(lathe: Halbox, linuxcnc_root: Path, script: Path, *words: str) -> None:
    modules = str(linuxcnc_root / "usr" / "lib" / "python3" / "dist-packages")
    shutil.copy(script, lathe.folder)
    program = ("/usr/bin/python3", script.name, str(lathe.folder / "linuxcnc.nml"), *words)
    assert lathe.run(*program, PYTHONPATH=modules) == 0, lathe.said()


def test_a_program_starts_waits_cuts_and_stops(lathe: Halbox, linuxcnc_root: Path) -> None:
    """M64 starts, M66 sees "in cut", G33 moves Z meanwhile, M65 ends it, M66 sees that."""
    execute(lathe, linuxcnc_root, *BLOCKS)
    said = lathe.said().splitlines()
    assert "M66 P0 L3 Q600: 1 1 1 0.000" in said
    assert "G33 Z5 K0.25: 1 1 1 5.000" in said
    assert "M66 P0 L4 Q600: 1 0 0 5.000" in said
    assert lathe.get("camturn.error-number") == "0"
    assert lathe.get("camturn.homed") == "TRUE"
    assert lathe.get("camturn.fault") == "FALSE"


@pytest.mark.long
@pytest.mark.parametrize("sense", [-1, 1])
def test_u_is_homed_before_the_first_enable(lathe: Halbox, linuxcnc_root: Path, sense: int) -> None:
    """By its switch at -0.3 mm of the scale, which is -0.5 mm of U; in the wrong sense it fails."""
    setting = f"setp lathe-sim.u-switch -0.3\nsetp camturn.u-home-sense {sense}\n"
    assert lathe.load(setting) == 0
    assert lathe.get("camturn.homed") == "FALSE"
    execute(lathe, linuxcnc_root, "G4 P0.1")
    if sense > 0:
        lathe.wait_said("camturn: home U: no home within the stroke: check u-home-switch")
        lathe.wait("camturn.state-number", "0")
        assert lathe.get("camturn.homed") == "FALSE"
        return
    lathe.wait("camturn.homed", "TRUE")
    lathe.wait("camturn.state-number", "1")  # searches the index of a spindle that stands still
    assert float(lathe.get("camturn.u")) == pytest.approx(
        float(lathe.get("lathe-sim.u-fb")) - 0.2, abs=0.002
    )


def _show_panel(lathe: Halbox, linuxcnc_root: Path) -> None:
    for file in (SIM / "panel.xml", SIM / "panel.hal", PANEL_PINS):
        shutil.copy(file, lathe.folder)
    pins = ("/usr/bin/python3", PANEL_PINS.name, "panel.xml")
    modules = str(linuxcnc_root / "usr" / "lib" / "python3" / "dist-packages")
    assert lathe.run("./halcmd", "loadusr", "-Wn", "pyvcp", *pins, PYTHONPATH=modules) == 0
    assert lathe.run("./halcmd", "-f", "panel.hal") == 0, lathe.said()


@pytest.mark.long
def test_panel_is_connected(lathe: Halbox, linuxcnc_root: Path) -> None:
    """Every widget has a signal of camturn."""
    _show_panel(lathe, linuxcnc_root)
    shown = lathe.ask("-s", "show", "pin", "pyvcp.*").strip().splitlines()
    assert len(shown) == (SIM / "panel.xml").read_text().count("<halpin>")
    assert [line for line in shown if "=>" not in line and "<=" not in line] == []
    execute(lathe, linuxcnc_root, "G4 P0.1")
    lathe.wait("pyvcp.homed", "TRUE")


def _start_program(lathe: Halbox, linuxcnc_root: Path, pitch: str = "K0.1") -> None:
    """Run the program printed in the README in AUTO, until it cuts."""
    text = README.read_text().split("`/tmp/oval.ngc`")[1].split("The button **stop**")[0]
    text = text[text.index("    M65 P0") :].replace("K0.1", pitch)
    text = text.replace("G4 P2", READY)
    program = lathe.folder / "oval.ngc"
    program.write_text(re.sub(r"Q\d+", "Q600", text))
    _control(lathe, linuxcnc_root, AUTO, str(program))
    lathe.wait("camturn.in-cut", "TRUE")


@pytest.mark.long
def test_printed_program_cuts_to_its_end(lathe: Halbox, linuxcnc_root: Path) -> None:
    """In AUTO, with its explanations: Z is at its end, U has retracted, no fault."""
    _start_program(lathe, linuxcnc_root)
    lathe.wait("halui.program.is-idle", "TRUE")
    assert float(lathe.get("joint.1.motor-pos-cmd")) == 5.0
    for pin in ("camturn.start", "camturn.in-cut", "spindle.0.on"):
        lathe.wait(pin, "FALSE")
    assert lathe.get("camturn.fault") == "FALSE", lathe.said()


@pytest.mark.long
def test_lag_of_u_is_measured_in_a_slow_cut(lathe: Halbox, linuxcnc_root: Path) -> None:
    """(u-cmd - u-fb) / u-vel without feed-forward is k1 and lead: RETROFIT, step 6."""
    believed_ns = sum(float(lathe.get(f"camturn.{name}")) for name in ("k1-ns", "lead-ns"))
    for name in ("k1-ns", "k2-us2", "lead-ns"):
        assert lathe.load(f"setp camturn.{name} 0\n") == 0
    assert lathe.load("setp camturn.following-limit-nm 1000000\n") == 0
    _start_program(lathe, linuxcnc_root, SLOW)
    assert lathe.load("setp camturn.record 1\n") == 0
    time.sleep(1.0)
    assert lathe.load("setp camturn.record 0\n") == 0
    lathe.wait("camturn.recording", "FALSE")
    found = read(lathe.folder / "recording-1.csv")
    command_nm, actual_nm = (found[f"u_{name}_nm"].astype(float) for name in ("command", "actual"))
    speed = np.gradient(command_nm, 1e6)  # nm per ns
    lag_ns = speed @ (command_nm - actual_nm) / (speed @ speed)
    assert lag_ns == pytest.approx(believed_ns, rel=0.03)  # lathe_sim: steps of 0.1 ms


@pytest.mark.long
@pytest.mark.parametrize("by", ["stop", "abort"])
def test_cut_is_ended_at_any_time(lathe: Halbox, linuxcnc_root: Path, by: str) -> None:
    """In G33 of a program: U and Z end, and only a new M64 P0 starts camturn again."""
    _show_panel(lathe, linuxcnc_root)
    _start_program(lathe, linuxcnc_root, SLOW)
    assert lathe.load("unlinkp pyvcp.stop\n") == 0, lathe.said()  # to set its signal here
    if by == "abort":
        _control(lathe, linuxcnc_root, AUTO, "abort")
    else:
        assert lathe.load("sets panel-stop 1\n") == 0, lathe.said()
    lathe.wait("camturn.start", "FALSE")
    lathe.wait("halui.program.is-idle", "TRUE")
    assert lathe.load("sets panel-stop 0\n") == 0
    assert lathe.get("motion.digital-out-00") == "TRUE"
    lathe.wait("camturn.fault", "TRUE")  # the spindle has stopped before U was out
    lathe.wait_said("camturn: fault spindle_stopped")
    assert 0.0 < float(lathe.get("joint.1.motor-pos-cmd")) < 4.0
    assert lathe.get("camturn.in-cut") == "FALSE"
    assert float(lathe.get("camturn.u")) < -0.4
    _control(lathe, linuxcnc_root, AUTO, "off")
    execute(lathe, linuxcnc_root, "M3 S500", READY)
    assert lathe.get("camturn.ready") == "TRUE"
    assert lathe.get("camturn.start") == "FALSE"
    _start_program(lathe, linuxcnc_root)
    assert lathe.get("camturn.fault") == "FALSE"


@pytest.mark.long
def test_axis_shows_u_and_whether_it_is_homed(lathe: Halbox, linuxcnc_root: Path) -> None:
    """In the DRO of AXIS itself, started on a virtual screen with the sample configuration."""
    if linuxcnc_root != Path("/") or shutil.which("xvfb-run") is None:
        pytest.skip("AXIS needs an installed LinuxCNC and xvfb-run")
    for file in (SIM / "panel.xml", SIM / "panel.hal", SIM / "axis_u.py", AXIS_DRO):
        shutil.copy(file, lathe.folder)
        (lathe.folder / file.name).chmod(0o666)
    screen = ("xvfb-run", "-a", "-s", "-screen 0 1280x1024x24")
    nml = str(lathe.folder / "linuxcnc.nml")
    assert lathe.run(*screen, "/usr/bin/python3", AXIS_DRO.name, nml) == 0, lathe.said()


@pytest.fixture(params=["u_velocity.hal", "u_step.hal"])
def mesa(
    request: pytest.FixtureRequest, box: Halbox, linuxcnc_root: Path, table_of: TableOf
) -> Iterator[Halbox]:
    """Return the Mesa sample, with simulated pins of the card in place of its drivers."""
    _settings(box, table_of("perkins240"), MESA / "lathe.hal")
    script = box.folder / "lathe.hal"
    lines = script.read_text().splitlines()
    drivers = [
        i for i, line in enumerate(lines) if line.startswith(("loadrt hostmot2", "loadrt hm2_"))
    ]
    lines[drivers[0] : drivers[-1] + 1] = ["loadrt mesa_pins"]
    lines += (MESA / request.param).read_text().splitlines()
    script.write_text("\n".join(lines) + "\n")
    with _started(box, linuxcnc_root):
        yield box


@pytest.mark.long
def test_mesa_configuration_is_taken_by_hal(mesa: Halbox) -> None:
    """Every line of it; the card is written last."""
    assert mesa.get("camturn.tick-hz-used") == "1000"
    functions = mesa.ask("show", "thread").split()
    ours = [name for name in functions if name.startswith(("u-", "camturn.", "hm2_5i25."))]
    assert ours[:3] == ["hm2_5i25.0.read", "camturn.update", "camturn.poll"]
    assert ours[-1] == "hm2_5i25.0.write"
    assert len(ours) > 5


@pytest.mark.long
@pytest.mark.parametrize("mesa", ["u_step.hal"], indirect=True)
def test_mesa_emergency_stop_reaches_linuxcnc(mesa: Halbox) -> None:
    """Chain and watchdog: each stops LinuxCNC, which remains in emergency stop until its reset."""

    def load(script: str) -> None:
        assert mesa.load(script) == 0, mesa.said()

    def is_reset() -> bool:
        """Press the button, as often as a person would: a loaded task may miss it."""
        load("setp halui.estop.reset 1\n")
        time.sleep(0.5)
        load("setp halui.estop.reset 0\n")
        return mesa.get("halui.estop.is-activated") == "FALSE"

    load("unlinkp hm2_5i25.0.7i77.0.0.input-00\n")
    for opens, closes in (
        ("sets estop-chain 0\n", "sets estop-chain 1\n"),
        ("sets watchdog-bit 1\n", "sets watchdog-bit 0\n"),
    ):
        load(opens)
        mesa.wait("halui.estop.is-activated", "TRUE")
        load(closes)
        mesa.wait("camturn.estop-ok", "TRUE")
        assert mesa.get("iocontrol.0.emc-enable-in") == "FALSE"
        until(is_reset, "the reset of the emergency stop")
        assert mesa.get("iocontrol.0.emc-enable-in") == "TRUE"


@pytest.mark.long
@pytest.mark.parametrize("mesa", ["u_step.hal"], indirect=True)
def test_mesa_step_drive_is_enabled_where_u_stands(mesa: Halbox) -> None:
    """U was moved while off: enable causes no step, and then steps follow the set-point."""
    off = "unlinkp {0}.encoder.01.position\nunlinkp {0}.stepgen.02.position-fb\n"
    values = "unlinkp camturn.drive-enable\nsets u-fb 0.1\nsets u-step-fb 0.03\n"
    assert mesa.load((off + values).format("hm2_5i25.0")) == 0, mesa.said()

    def commands(mm: float) -> None:
        command = "hm2_5i25.0.stepgen.02.position-cmd"
        until(lambda: float(mesa.get(command)) == pytest.approx(mm), f"{mm} mm")

    commands(0.03)
    assert mesa.load("sets u-enable 1\nsets u-fb 0.2\nsets u-step-fb 0.13\n") == 0
    commands(0.13)
    assert float(mesa.get("u-offset.out")) == pytest.approx(-0.07)
    assert mesa.load("unlinkp camturn.u-cmd\nsets u-cmd 0.3\n") == 0  # by hand: RETROFIT, step 5
    commands(0.23)
