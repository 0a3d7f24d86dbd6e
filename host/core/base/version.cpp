// SPDX-License-Identifier: MIT
#include "dermis/version.hpp"

#include "commit.h"

namespace dermis {

const char* version() noexcept { return DERMIS_VERSION; }
const char* commit() noexcept { return DERMIS_COMMIT; }

} // namespace dermis
