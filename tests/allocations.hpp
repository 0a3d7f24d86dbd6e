// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace test {

// How often operator new has been called in this process, by any thread; always 0 in a sanitizer's build.
size_t allocations();

} // namespace test
