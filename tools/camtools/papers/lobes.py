"""The paper on turning and grinding cams, S4: its three figures with the worked lobe.

>>> f"{roots_mm()[0]:.6f} {roots_mm()[1]:.6f}"
'32.943059 14.111169'
"""

from __future__ import annotations

from functools import cache

import numpy as np

from camtools.lobe.part import LobePart
from camtools.papers import lobe_plots as plots
from camtools.papers.rows import Chapter, Maker, Row, part_of, png
from camtools.study.lobe import LobeStudy, LobeWishes, lobe_table, study_lobe, study_lobes

AT_DEG = -40.0  # direction of the follower in the figures
_DENSE = 7201


@cache
def studied(name: str, *, is_dense: bool = False) -> LobeStudy:
    """Return the study of the lobe of a part, five degrees apart or dense."""
    part = part_of(name, LobePart)
    [study] = study_lobes(part, LobeWishes(step_deg=5.0))
    if not is_dense:
        return study
    return study_lobe(part, 0, study.lobe, np.linspace(-180, 180, _DENSE), study.rpm)


def _index() -> int:
    return int(np.argmin(np.abs(studied("cam-345").theta_deg - AT_DEG)))


def roots_mm() -> tuple[float, float]:
    """Return OO' by the right sign of the root in (5) and by the printed one."""
    touch, i = studied("cam-345").touch, _index()
    alpha = float(touch.alpha[i] - touch.theta[i])
    along, root = (
        float(touch.radius[i]) * np.cos(alpha),
        np.sqrt(touch.roller**2 - (float(touch.radius[i]) * np.sin(alpha)) ** 2),
    )
    return float(along + root), float(along - root)


def _files() -> dict[str, Maker]:
    def csv(name: str) -> Maker:
        return lambda: lobe_table(studied(name)).encode()

    return {
        "s4_turning.csv": csv("cam-345"),
        "s4_grinding.csv": csv("cam-345-ground"),
        "s4_fig_1.png": png(lambda: plots.draw_turning(studied("cam-345"), _index())),
        "s4_fig_2.png": png(lambda: plots.draw_swing(studied("cam-345", is_dense=True))),
        "s4_fig_3.png": png(lambda: plots.draw_grinding(studied("cam-345-ground"), _index())),
    }


def chapter() -> Chapter:
    """Return the paper on cams."""
    turned, ground, i = studied("cam-345"), studied("cam-345-ground"), _index()
    dense = studied("cam-345", is_dense=True)
    right, printed = roots_mm()
    most = int(np.argmax(np.abs(dense.touch.gamma)))
    wheel = studied("cam-345-ground", is_dense=True).n_c_rpm
    at = f"at {AT_DEG:g} degrees"
    rows = (
        Row(
            *("Fig 1", "turning: contact, roller's centre, travel x"),
            f"x = OO' - r0 - r1, OO' by the root's minus: {printed:.6f} mm {at}",
            f"OO' {right:.6f} mm, x = lift = {float(turned.path.lift[i]):.7f} mm",
            "the root needs a plus: with the minus x would be -2 r1 on the base circle",
            "s4_turning.csv` `s4_fig_1.png",
        ),
        Row(
            *("Fig 2", "swing of the tool"),
            "tan gamma = v / (omega OO')",
            f"{np.degrees(turned.touch.gamma[i]):.6f} degrees {at}; at most "
            f"{np.degrees(np.abs(dense.touch.gamma[most])):.4f} at {dense.theta_deg[most]:.2f}",
            "none; (4) mixes frequency and angular speed, and alpha is no free function",
            "s4_turning.csv` `s4_fig_2.png",
        ),
        Row(
            *("Fig 3", "grinding: wheel, S, phi, N_C"),
            "S(phi), N_C = n0 r / (ds/dphi)",
            f"{at}: S {float(ground.path.lift[i]):.7f} mm, phi "
            f"{np.degrees(ground.path.phi[i]):.6f} degrees, N_C {ground.n_c_rpm[i]:.6f} r/min; "
            f"{wheel.min():.4f} .. {wheel.max():.4f} r/min in all",
            "(7) exchanges wheel and roller; the caption and S have them right "
            "([PAPERS.md](PAPERS.md#errors-of-the-printed-formulas))",
            "s4_grinding.csv` `s4_fig_3.png",
        ),
    )
    return Chapter("S4", "cams: turned with a swinging tool, ground by a wheel", rows, _files())
