// SPDX-License-Identifier: MIT
// The handles of the C interface, and how a call's exception becomes a status.
#pragma once

#include "dermis/dermis.h"
#include "dermis/dermis.hpp"
#include "dermis/touch.hpp"
#include "host/core/base/float_environment.hpp"
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/scene.hpp"

struct dermis_device {
    dermis::Device device;
};

// The text stays beside the scene that it makes, because a key that is set may change how others are read.
struct dermis_scene {
    dermis::scene::SceneText text;
    std::vector<std::string> overrides; // "key=value"
    dermis::scene::NamedMaps maps;
    dermis::Scene scene;
};

struct dermis_result {
    dermis::Scene scene;
    dermis::Result result;
};

struct dermis_touch {
    dermis::contact::Touch touch;
};

struct dermis_skin {
    dermis::Skin skin;
    std::vector<int32_t> cells{}; // of dermis_skin_get_cells(), once it was called
};

namespace dermis::c {

// Returns the status of the exception that is being handled, and keeps its message for dermis_last_error.
dermis_status status_of_exception() noexcept;

// Calls `call`, in the default rounding mode, and returns the status of what it throws.
template <class Call> dermis_status guarded(Call&& call) noexcept {
    const DefaultFloats floats;
    try {
        call();
        return DERMIS_OK;
    } catch (...) {
        return status_of_exception();
    }
}

// Throws Error::bad_input where a pointer is null. need_output() also sets what the pointer points to to null or 0.
template <class T> void need_pointer(const T* pointer, const char* argument) {
    if (!pointer) scene::refuse(argument, "(null)", "a pointer");
}
template <class T> void need_output(T* output, const char* argument) {
    need_pointer(output, argument);
    *output = {};
}

// The same for a call that gives numbers of an object: sets what both outputs point to.
template <class Handle, class T>
void begin(const Handle* handle, const char* argument, T** values, const char* output, size_t* count) {
    need_output(values, output);
    need_output(count, "count");
    need_pointer(handle, argument);
}

// Returns whether a number is 1. Throws Error::bad_input where it is neither 0 nor 1.
inline bool flag(int32_t number, const std::string& argument) {
    if (number != 0 && number != 1) scene::refuse(argument, std::to_string(number), "0, 1");
    return number == 1;
}

// Throws Error::bad_input unless a struct of the caller's has the size that it has here, or that of an earlier version.
template <class Struct, class... Size> void need_size(const Struct* given, const char* argument, Size... earlier) {
    need_pointer(given, argument);
    if (given->size != sizeof(Struct) && ((given->size != earlier) && ...))
        scene::refuse(std::string(argument) + "->size", std::to_string(given->size),
                      std::to_string(sizeof(Struct)) + ", which is its sizeof");
}

// Returns the quantity of a number. Throws Error::bad_input where it has none.
Quantity quantity_of(dermis_quantity);

// The device of a handle; the CPU path for null.
Device device_of(const dermis_device*);

// Fills the caller's report, whose size is checked.
void fill(dermis_report* to, const Report&);

// The pad of an argument, whose numbers are not checked yet.
contact::Pad pad_of(const dermis_contact_pad*, const char* argument);
void need_report(const dermis_contact_report*); // throws Error::bad_input for a size of no version
void fill(dermis_contact_report* to, const contact::ContactReport&);

} // namespace dermis::c
