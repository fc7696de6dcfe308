#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# usage: can_source.sh DBC FOLDER
# Runs camtools.cli.can_source in the Python of the project, which is set up if need be.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR/.. source=../setup.sh
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../setup.sh"
camturn_venv base
exec "$CAMTURN_PYTHON" -m camtools.cli.can_source "$@"
