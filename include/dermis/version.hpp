// SPDX-License-Identifier: MIT
// The version. These three numbers are its only source: CMake reads them too. Before 1.0 a new minor version may break
// programs.
#pragma once

#include <dermis/export.hpp>

#define DERMIS_VERSION_MAJOR 0
#define DERMIS_VERSION_MINOR 1
#define DERMIS_VERSION_PATCH 0

// The version as a string, "0.1.0"; the two macros below it only join the numbers.
#define DERMIS_VERSION DERMIS_VERSION_TEXT(DERMIS_VERSION_MAJOR, DERMIS_VERSION_MINOR, DERMIS_VERSION_PATCH)
#define DERMIS_VERSION_TEXT(major, minor, patch) DERMIS_VERSION_JOINED(major, minor, patch)
#define DERMIS_VERSION_JOINED(major, minor, patch) #major "." #minor "." #patch

#ifdef __cplusplus
namespace dermis {

// The version of the library that runs. It differs from DERMIS_VERSION where a program was compiled with the headers of
// one version and loads the shared library of another.
DERMIS_API const char* version() noexcept;

// The commit that the library was built from, followed by "-dirty" if files had been changed since; "unknown" if the
// sources were not a git checkout of their own. After "-dirty" and after "unknown" follow "-" and twelve digits of a
// hash of the sources, so that equal texts mean equal sources.
DERMIS_API const char* commit() noexcept;

} // namespace dermis
#endif
