// SPDX-License-Identifier: MIT
#include "host/core/base/process.hpp"

#include "dermis/description.hpp"

#include <unistd.h>

namespace dermis::simd {

Process::Process() : id_(getpid()) {}

bool Process::calls() const { return getpid() == id_; }

void Process::refuse(const std::string& what) const {
    throw Error(
        Error::Code::device, "",
        what + " opened by another process, " + std::to_string(id_) +
            ", which has forked this one; allowed: skins that are made after the fork on a device of the CPU, or a "
            "process that is spawned");
}

} // namespace dermis::simd
