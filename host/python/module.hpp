// SPDX-License-Identifier: MIT
// The files of the Python module share this. A dermis::Error becomes dermis.Error with its code and parameter.
#pragma once

#include "host/scene/names.hpp"
#include "host/scene/refusal.hpp"

#include <mutex>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

namespace dermis::python {

namespace nb = nanobind;

void bind_contact(nb::module_&);
void bind_device(nb::module_&);
void bind_fit(nb::module_&);
void bind_report(nb::module_&);
void bind_result(nb::module_&);
void bind_scene(nb::module_&);
void bind_skin(nb::module_&);

// A device. in_use: set for a Vulkan device, which one thread at a time may use, with all its skins and runs.
struct SharedDevice {
    Device device;
    std::shared_ptr<std::mutex> in_use;
};
SharedDevice share(Device);
// The device of an argument: a Device, the text that Device.open takes, or None for the CPU path.
SharedDevice device_of(nb::handle);

// Releases the interpreter's lock while it lives, so that other Python threads run, and holds `in_use`, unless that is
// null. It unlocks `in_use` before it takes the interpreter's lock again, so that two threads never wait for each
// other.
class Computing {
  public:
    explicit Computing(std::mutex* in_use) {
        if (in_use) lock_ = std::unique_lock(*in_use);
    }

  private:
    nb::gil_scoped_release released_;
    std::unique_lock<std::mutex> lock_;
};

// An array of numbers that belong to `owner`, which lives as long as the array. It cannot be written to.
template <class Number> using View = nb::ndarray<nb::numpy, const Number>;
template <class Number> View<Number> view(const Number* data, const std::vector<size_t>& shape, nb::handle owner) {
    return View<Number>(data, shape.size(), shape.data(), owner);
}
inline View<double> view(const std::vector<double>& numbers, nb::handle owner) {
    return view(numbers.data(), {numbers.size()}, owner);
}

// Returns a buffer as a memoryview, and other objects as they are: ctypes gives buffers without strides, which nanobind
// reads unasked, and a memoryview has them.
nb::object with_strides(nb::handle);

// Any array in the memory of the CPU, by DLPack or the buffer protocol, to be read; nothing where it is none.
using AnyArray = nb::ndarray<nb::ro, nb::device::cpu>;
std::optional<AnyArray> array_in(nb::handle);
// Says what an argument is, as in "float64 array of shape (25, 20)", or gives the beginning of its repr.
std::string description_of(nb::handle);
std::string shape_text(const std::vector<size_t>& shape); // "(25, 20)"

template <class Enum> Enum value_named(const std::string& parameter, const std::string& name) {
    const std::optional<Enum> value = scene::value_of<Enum>(name);
    if (!value) scene::refuse(parameter, "\"" + name + "\"", scene::quoted_names<Enum>());
    return *value;
}
std::vector<Quantity> quantities_named(const std::string& parameter, const std::vector<std::string>& names);

} // namespace dermis::python
