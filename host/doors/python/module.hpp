// SPDX-License-Identifier: MIT
// What the files of the Python module share. A dermis::Error becomes dermis.Error with its code and parameter.
#pragma once

#include "dermis/dermis.hpp"
#include "dermis/touch.hpp"
#include "host/core/base/float_environment.hpp"
#include "host/core/base/refusal.hpp"
#include "host/core/description/description.hpp"
#include "host/core/description/names.hpp"

#include <functional>
#include <mutex>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

// nanobind's conversions of arguments may not throw, so one that allocates ends the process where there is no memory.
// Functions take texts as std::string_view and other sequences as Sequence or Numbers, for items_of().
//
// A call whose arguments are none that a function takes is answered by dermis/_answers.py; a function itself refuses
// what its types cannot say.
namespace dermis::python {

namespace nb = nanobind;

using std::string_view;

// Whether an array has a mask, which a view of its numbers would lose.
inline bool is_masked(nb::handle h) { return nb::hasattr(h, "mask") && nb::hasattr(h, "filled"); }
// Whether an object has items one after another, and is no text.
bool is_row(nb::handle);

struct Items : nb::object {
    NB_OBJECT_DEFAULT(Items, nb::object, "collections.abc.Sequence", is_row)
};
template <class Item> using Sequence = nb::typed<Items, Item>;
struct Numbers : nb::object {
    NB_OBJECT_DEFAULT(Numbers, nb::object, "collections.abc.Sequence[float] | numpy.typing.NDArray[numpy.floating]",
                      is_row)
};

void bind_afferents(nb::module_&);
void bind_contact(nb::module_&);
void bind_device(nb::module_&);
void bind_fit(nb::module_&);
void bind_report(nb::module_&);
void bind_result(nb::module_&);
void bind_scene(nb::module_&);
void bind_skin(nb::module_&);
void bind_touch(nb::module_&);

// A device, which one thread at a time may use if it is a Vulkan device, with all its skins and runs.
struct OpenDevice {
    explicit OpenDevice(Device opened) : device(std::move(opened)) {}
    Device device;
    std::recursive_mutex in_use;
};
// which: the text by which Device.open opened it, which a copy in another process opens too; "cpu" with `threads` for
// Device.cpu.
struct SharedDevice {
    std::shared_ptr<OpenDevice> open;
    std::string which;
    int threads = 0;

    const Device& device() const { return open->device; }
    std::recursive_mutex* in_use() const { return device().info().vulkan ? &open->in_use : nullptr; }
};
// Pressures of a batch, which one thread at a time may use; others wait with Computing.
struct SharedTouch {
    contact::Touch touch;
    mutable std::recursive_mutex in_use{};
};
// The device of an argument: a Device, the text that Device.open takes, or None for the CPU path.
SharedDevice device_of(nb::handle);

// The bytes that this process may still take: of the machine, and of each control group, version 1 or 2, that it is in.
// Infinity where nothing is known. root: "", or a folder in place of the system's root.
double memory_at_hand(string_view root);
// Throws Error::no_memory, with both numbers, for skins that do not fit into the memory at hand. What is so small that
// it will fit is not looked at.
void need_memory(const Scene&, const SkinOptions&);

// Releases the interpreter's lock while it lives, so that other Python threads run, keeps the caller's rounding mode
// from what is computed, and holds `in_use`, unless that is null. It unlocks `in_use` before it takes the interpreter's
// lock again, so that two threads never wait for each other. `in_use` is recursive for the handlers of signals, which
// run in a press.
class Computing {
  public:
    explicit Computing(std::recursive_mutex* in_use) : state_(PyEval_SaveThread()) {
        if (in_use) lock_ = std::unique_lock(*in_use);
    }
    ~Computing() { come_back(); }
    Computing& operator=(Computing&&) = delete; // and no copies

    // Returns what a run calls while it computes. It lets Ctrl-C and other signals act, by an exception that ends the
    // run, and calls `progress` with the fraction done, unless that is None.
    std::function<void(double)> progress(nb::handle progress);

  private:
    void come_back() noexcept;

    DefaultFloats floats_;
    PyThreadState* state_;
    std::unique_lock<std::recursive_mutex> lock_;
};

// A skin calls this in a press: on the main thread it lets Ctrl-C and other signals act, by an exception that ends the
// press. `in_use` stays locked: no other thread may use the skin in the middle of a press.
void let_signals_act(double done);

// An array of numbers that belong to `owner`, which lives as long as the array. It cannot be written to.
template <class Number> using View = nb::ndarray<nb::numpy, const Number>;
template <class Number> View<Number> view(const Number* data, const std::vector<size_t>& shape, nb::handle owner) {
    return View<Number>(data, shape.size(), shape.data(), owner);
}
inline View<double> view(const std::vector<double>& numbers, nb::handle owner) {
    return view(numbers.data(), {numbers.size()}, owner);
}

// Returns what nanobind can safely read an array from. An object with __dlpack__ gives its capsule, which is then used
// up: a second array from the same capsule would share one owner. A buffer becomes a memoryview: ctypes gives buffers
// without strides, which nanobind reads unasked. Other objects are returned as they are. to_write: a buffer goes before
// DLPack, because it says whether it can be written to, which DLPack of JAX and of NumPy 1 does not.
nb::object readable(nb::handle, bool to_write = false);

// Any array in the memory of the CPU, by DLPack or the buffer protocol, to be read; nothing where it is none.
using AnyArray = nb::ndarray<nb::ro, nb::device::cpu>;
std::optional<AnyArray> array_in(nb::handle);
template <class Array> bool is_dense(const Array& array) {
    if (array.size() == 0) return true;
    int64_t expected = 1;
    for (size_t i = array.ndim(); i-- > 0; expected *= int64_t(array.shape(i)))
        if (array.shape(i) != 1 && array.stride(i) != expected) return false;
    return true;
}
// Says what an argument is, as in "strided float64 array of shape (25, 20)", or gives the beginning of its repr.
std::string description_of(nb::handle);
std::string type_of(const nb::dlpack::dtype&);            // "float32"
std::string shape_text(const std::vector<size_t>& shape); // "(25, 20)"

// allowed: what the message says; empty: any name, and of quantities the classes of receptors.
template <class Enum> Enum value_named(const char* parameter, string_view name, std::string allowed = {}) {
    const std::optional<Enum> value = scene::value_of<Enum>(name);
    if (value) return *value;
    if (allowed.empty())
        allowed = std::is_same_v<Enum, Quantity> ? scene::receptor_class_names() : scene::quoted_names<Enum>();
    scene::refuse(parameter, "\"" + std::string(name) + "\"", allowed);
}

// The items of a sequence. Throws Error::bad_input if an item is no Item. allowed: what the message says is allowed.
template <class Item> std::vector<Item> items_of(nb::handle sequence, const char* parameter, const char* allowed) {
    std::vector<Item> items;
    for (nb::handle item : sequence) {
        Item value{};
        if (item.is_none() || !nb::try_cast(item, value)) scene::refuse(parameter, description_of(item), allowed);
        items.push_back(std::move(value));
    }
    return items;
}
inline std::vector<Afferents> afferents_in(const Sequence<Afferents>& given) {
    std::vector<Afferents> all;
    for (const Afferents* a : items_of<const Afferents*>(given, "afferents", "a list of Afferents")) all.push_back(*a);
    return all;
}
inline std::vector<double> numbers_in(const Numbers& numbers, const char* parameter) {
    return items_of<double>(numbers, parameter, "numbers");
}

} // namespace dermis::python
