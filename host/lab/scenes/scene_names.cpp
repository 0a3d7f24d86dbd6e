// SPDX-License-Identifier: MIT
#include "host/lab/scenes/scene_names.hpp"

namespace dermis {

const char* name(Method m) noexcept { return scene::text_of(m); }
const char* name(Model m) noexcept { return scene::text_of(m); }

} // namespace dermis
