// SPDX-License-Identifier: MIT
// What the calls of a skin take and give: pads, steps, pressures and responses, as arrays.
#pragma once

#include "host/doors/python/module.hpp"

namespace dermis::python {

// A skin, and what it was made of: the shapes of its arrays follow from it, and a copy is made of it. Materials are
// those that the pads have now.
struct SkinWithShapes {
    std::shared_ptr<std::recursive_mutex> in_use; // one thread at a time may use a skin
    SharedDevice device;
    std::vector<int> leading; // lengths of the axes of pads; empty: arrays have none
    Scene scene;
    SkinOptions options;
    std::vector<double> time;                                    // of each pad, s: how long it has been pressed
    std::vector<double> step = std::vector<double>(time.size()); // and its step in the last call that pressed it
    std::optional<Skin> skin;          // never empty before the destructor, which uses a Vulkan device too
    double done = 0;                   // the fraction of a call's frames that had been pressed when it last looked
    size_t presses = 0, next_look = 0; // calls that pressed; the one after which strains are looked at
    int look_at = 0;                   // the pad to begin with, modulo their number

    ~SkinWithShapes() {
        const Computing computing(in_use.get());
        skin.reset();
    }
};

template <class Array> bool has_shape(const Array& array, const std::vector<size_t>& shape) {
    bool same = array.ndim() == shape.size();
    for (size_t i = 0; same && i < shape.size(); ++i) same = array.shape(i) == shape[i];
    return same;
}

// The numbers of the pads that an argument names. None: all pads. A list or an array of integers: these numbers. An
// array of bools, one for each pad: the pads where it is true. Pads of several axes are named by an index of these.
class PadNumbers {
  public:
    PadNumbers(nb::handle argument, const std::vector<int>& axes) : shape_(axes.begin(), axes.end()) {
        if (argument.is_none()) return;
        all_ = false;
        nb::object named = nb::borrow(argument);
        if (axes.size() > 1) {
            const nb::object places = nb::module_::import_("dermis._arrays").attr("places_of")(named, axes);
            shape_ = nb::cast<std::vector<size_t>>(places.attr("shape"));
            named = places.attr("ravel")();
        }
        const int count = axes.empty() ? 1 : axes[0];
        const std::optional<AnyArray> array = array_in(named);
        if (array ? !take(*array, count) : !take(named))
            scene::refuse("pads", description_of(argument),
                          "a list of integers, or an array of " + std::to_string(count) + " bools, one for each pad");
        if (axes.size() == 1) shape_ = {numbers_.size()};
    }
    Pads pads() const { return all_ ? Pads() : Pads(numbers_); }
    const std::vector<size_t>& shape() const { return shape_; } // of an array with one item for each of these pads

  private:
    bool take(const AnyArray& array, int count) {
        if (array.ndim() != 1) return false;
        if (array.dtype() == nb::dtype<bool>())
            return array.size() == size_t(count) && is_dense(array) &&
                   take_mask(static_cast<const bool*>(array.data()), count);
        if (array.size() == 0) return true; // even of doubles: what NumPy makes of an empty list
        return take_as_one_of<int64_t, int32_t, int16_t, int8_t, uint64_t, uint32_t, uint16_t, uint8_t>(array);
    }
    template <class... Integers> bool take_as_one_of(const AnyArray& array) {
        return (take_as<Integers>(array) || ...);
    }
    bool take_mask(const bool* mask, int count) {
        for (int i = 0; i < count; ++i)
            if (mask[i]) numbers_.push_back(i);
        return true;
    }
    template <class Integer> bool take_as(const AnyArray& array) {
        if (array.dtype() != nb::dtype<Integer>()) return false;
        const auto numbers = array.view<const Integer, nb::ndim<1>>();
        for (size_t i = 0; i < numbers.shape(0); ++i) numbers_.push_back(pad((long long)(numbers(i))));
        return true;
    }
    // A bool is an integer in Python, but a list of them is meant as a mask.
    bool take(nb::handle argument) {
        if (!is_row(argument)) return false;
        for (nb::handle item : nb::borrow<nb::sequence>(argument)) {
            long long number = 0;
            if (PyBool_Check(item.ptr()) || !nb::try_cast(item, number)) return false;
            numbers_.push_back(pad(number));
        }
        return true;
    }
    static int pad(long long number) {
        if (int(number) != number) scene::refuse("pads", std::to_string(number), "numbers of pads, from 0 on");
        return int(number);
    }

    bool all_ = true;
    std::vector<int> numbers_;
    std::vector<size_t> shape_;
};

// The shape of pressures and of the responses of cells.
std::vector<size_t> shape_of(const SkinWithShapes&, const PadNumbers&);
// The shape of a response's numbers.
std::vector<size_t> shape_of(const SkinWithShapes&, const Skin::Response&);

// The steps of a press, one for each pad: in a row, or an array with the axes of pads.
std::vector<double> steps_in(const SkinWithShapes&, nb::handle dt, const PadNumbers&);
// Returns the numbers as they stand in memory: nothing is converted. Pressures may also be one row. first: what a
// further axis before all counts, "frames", of any number, or "2", the directions of tractions.
AnyArray pressure_in(const SkinWithShapes&, nb::handle argument, const PadNumbers&, const char* parameter = "pressure",
                     const std::string& first = "");

// The responses that a skin gives.
std::vector<Quantity> responses_of(const SkinWithShapes&);
// Returns the response of that name. It must be one of these, which the skin has.
Skin::Response response_of(const SkinWithShapes&, nb::handle named, const std::vector<Quantity>& these);

// An array of the caller's to be filled, in C order and of this shape. Throws Error::bad_input for any other one.
template <class Number> using Output = nb::ndarray<Number, nb::device::cpu>;
[[noreturn]] void refuse_output(nb::handle argument, nb::dlpack::dtype, const std::vector<size_t>& shape);
template <class Number> Output<Number> output_in(nb::handle argument, const std::vector<size_t>& shape) {
    Output<Number> array;
    if (!nb::try_cast(readable(argument, true), array, false) || !is_dense(array) || !has_shape(array, shape))
        refuse_output(argument, nb::dtype<Number>(), shape);
    return array;
}
// Arrays to be filled with responses.
using Outputs = std::vector<std::pair<Skin::Response, Output<float>>>;
Outputs outputs_in(const SkinWithShapes&, nb::handle out);
void fill(const Outputs&);

} // namespace dermis::python
