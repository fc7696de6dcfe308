"""Where the project lies.

>>> (ROOT / "tools" / "camtools").is_dir()
True
"""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
