// SPDX-License-Identifier: MIT
// toml++ under a name of our own, because a host may have it with other options. It returns results in place of
// exceptions, which end the process if memory runs out while they are made, and has no streams, which would hide that.
#pragma once

#define toml dermis_toml
#define TOML_EXCEPTIONS 0
#define TOML_FLOAT_CHARCONV 1
#include <toml++/toml.h>
