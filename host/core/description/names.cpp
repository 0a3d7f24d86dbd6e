// SPDX-License-Identifier: MIT
#include "host/core/description/names.hpp"

namespace dermis {

const char* name(Quantity q) noexcept { return scene::text_of(q); }
const char* name(Precision p) noexcept { return scene::text_of(p); }

} // namespace dermis
