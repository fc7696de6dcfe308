"""What it costs when the constants of U's drive are not what the controller believes.

>>> worse({"u": {"delay_us": 100}})["u.delay_us"]
105.0
>>> sorted(worse({"u": {"kind": "force"}}))
['u.amplifier_hz', 'u.delay_us', 'u.mass_kg']
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

from camtools.base.quantities import length_text
from camtools.base.text import Json
from camtools.sim.machine_file import Machine, emit_machine, mistaken, nominal_of, read_machine
from camtools.sim.simulate import Result, simulate
from camtools.sim.uncertain import usual_spreads

# Each is off to the side that makes U later than believed, so that the errors add up.
_LATER = {key: spread for key, spread in usual_spreads().items() if spread.later}
SHARE = max(spread.sd for spread in _LATER.values() if spread.sd)  # of the nominal values
_NO_LEARNING = ("rehearse_turns", "learn_harmonics", "ripple_turns")
_MOST_TICKS = 300_000  # of a cut: a third of a second
_USUAL_TICK_HZ = 20_000  # of a machine file that gives none


class Mismatch(NamedTuple):
    """Form errors of a cut on a machine whose drive differs from what is believed."""

    without_um: float | None  # the largest, without learning; none where a fault ended the cut
    with_um: float | None  # with learning
    learns: bool  # the controller learns on this machine
    turns: float  # turns that were cut
    planned_turns: float  # turns of the whole part
    faults: tuple[str, ...] = ()  # that ended one of the cuts

    def text(self) -> str:
        """Return it in one line.

        >>> Mismatch(2.8, 0.12, True, 622.0, 622.0).text()
        'form error 2.8 µm without learning, 120 nm with it'
        >>> Mismatch(2.8, 0.12, True, 200.0, 622.0).text()
        'form error 2.8 µm without learning, 120 nm with it, over the first 200 of 622 turns'
        >>> Mismatch(2.8, None, True, 622.0, 622.0, ("setpoint_speed",)).text()
        'form error 2.8 µm without learning, no result with it: fault setpoint_speed'
        """
        if self.faults:
            return f"{self._errors()}: fault {', '.join(self.faults)}"
        if self.turns > self.planned_turns - 1:
            return self._errors()
        of = f"{self.turns:.0f} of {self.planned_turns:.0f} turns"
        return f"{self._errors()}, over the first {of}"

    def _errors(self) -> str:
        without = "no result" if self.without_um is None else length_text(self.without_um)
        if not self.learns:
            return f"form error {without}; learning is off"
        learned = "no result" if self.with_um is None else length_text(self.with_um)
        return f"form error {without} without learning, {learned} with it"

    def facts(self) -> Json:
        """Return it as data."""
        return {"share": SHARE} | self._asdict()


def worse(tree: Mapping[str, Any]) -> dict[str, float]:
    """Return the true constants of a drive that is later than believed by one deviation of each."""
    kind: Literal["position", "force"]
    kind = "force" if tree.get("u", {}).get("kind") == "force" else "position"
    found = {}
    for key, spread in _LATER.items():
        nominal = nominal_of(tree, key)
        if nominal is not None and spread.sd is not None and kind in spread.later:
            found[key] = nominal * (1 + spread.later[kind] * spread.sd)
    return found


def _error_um(result: Result) -> float | None:
    ended = result.summary["end"] in ("done", "stopped")
    return result.form_error_um if ended else None


def mismatch(table: Path, machine: str, words: Sequence[str], speed_rpm: float) -> Mismatch:
    """Return what such a drive costs at a mean speed, in 300 000 ticks of the cut at most.

    Raises CamtoolsError: the simulator refuses such a machine, or its file is no TOML.
    """
    tree = read_machine(machine, "machine file")
    tick_hz = nominal_of(tree, "machine.tick_hz") or _USUAL_TICK_HZ
    turns = max(_MOST_TICKS / tick_hz * speed_rpm / 60, 1.0)
    chosen = Machine("machine file", emit_machine(mistaken(tree, worse(tree))))
    learned = simulate(table, chosen, turns=turns, options=words)
    parameters = learned.summary["parameters"]
    off = [name for name in _NO_LEARNING if name in parameters]
    learns = any(parameters[name] for name in off)
    # Later words overrule earlier ones.
    plain = [word for name in off for word in ("--set", f"{name}=0")]
    without = simulate(table, chosen, turns=turns, options=[*words, *plain]) if learns else learned
    cut = without.summary["cut"]
    faults = dict.fromkeys(
        name for result in (without, learned) for name in result.summary.get("first_faults", ())
    )
    turns_of = float(cut["turns"]), float(cut["planned_turns"])
    return Mismatch(_error_um(without), _error_um(learned), learns, *turns_of, tuple(faults))
