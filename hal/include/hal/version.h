// SPDX-License-Identifier: Apache-2.0
/// version: of firmware, ports, simulator, tools and packages. CMake and tools/pyproject.toml read
/// it here. Tables and stored parameters have format versions of their own.
#ifndef HAL_VERSION_H
#define HAL_VERSION_H

#define CAMTURN_VERSION "1.0.0"

#endif
