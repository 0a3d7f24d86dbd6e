// SPDX-License-Identifier: MIT
// toml++ with results in place of exceptions, whose constructors end the process where memory runs out, and without
// streams, which swallow that. It has a name of our own, because a host may have toml++ with other options.
#pragma once

#define toml dermis_toml
#define TOML_EXCEPTIONS 0
#define TOML_FLOAT_CHARCONV 1
#include <toml++/toml.h>
