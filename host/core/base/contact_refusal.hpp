// SPDX-License-Identifier: MIT
// A refusal of contact.hpp, which needs no library, as the library's Error.
#pragma once

#include "dermis/description.hpp"

#include <stdexcept>

namespace dermis {

// Calls, and turns a refusal of contact.hpp into an Error::bad_input with the parameter that it names first.
template <class Call> auto refusing(Call&& call) {
    try {
        return call();
    } catch (const std::invalid_argument& refused) {
        const std::string what = refused.what();
        throw Error(Error::Code::bad_input, what.substr(0, what.find(" = ")), what);
    }
}

} // namespace dermis
