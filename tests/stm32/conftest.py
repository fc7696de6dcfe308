# SPDX-License-Identifier: Apache-2.0
"""Tests of this folder go on from sessions that are made once, kept_sessions.py."""

from tests.stm32.kept_sessions import (
    cut,
    pytest_collection_modifyitems,
    pytest_runtest_protocol,
    ready,
    started,
)

__all__ = ["cut", "pytest_collection_modifyitems", "pytest_runtest_protocol", "ready", "started"]
