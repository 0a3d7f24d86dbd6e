// SPDX-License-Identifier: MIT
#include "tests/support.hpp"
