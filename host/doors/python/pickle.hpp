// SPDX-License-Identifier: MIT
// Values as bytes, for pickle and copy: every member in its order, behind the build that wrote them. A structure is
// listed by a structured binding of all its members, so that a new member does not compile before it stands here.
#pragma once

#include "dermis/contact.hpp"
#include "dermis/fit.hpp"
#include "host/doors/python/module.hpp"

#include <concepts>
#include <cstring>

namespace dermis::python {

template <class T, class Struct>
concept Like = std::same_as<std::remove_const_t<T>, Struct>;

#define DERMIS_MEMBERS(Struct, ...)                                                                                    \
    template <class Archive> void members(Archive& each, Like<Struct> auto& s) {                                       \
        auto& [__VA_ARGS__] = s;                                                                                       \
        each(__VA_ARGS__);                                                                                             \
    }
DERMIS_MEMBERS(Cell, x, y)
DERMIS_MEMBERS(Grid, width, height, spacing)
DERMIS_MEMBERS(Surface, kind, ridges, noise, noise_length, relief, map, ridge_period)
DERMIS_MEMBERS(KelvinVoigt, modulus, viscosity, modulus_map, viscosity_map)
DERMIS_MEMBERS(Material, modulus, viscosity, thickness, length, modulus_map, viscosity_map, elements, spring, dashpot)
DERMIS_MEMBERS(Receptors, sa2_adaptation, fa2, fa2_gains)
DERMIS_MEMBERS(Site, type, cell)
DERMIS_MEMBERS(Envelope, kind, start, rise, frequency, phase, mean, amplitude, length, period, times, values)
DERMIS_MEMBERS(Load, kind, center, radius, intensity, map, envelope, path, interval)
DERMIS_MEMBERS(Time, step, duration)
DERMIS_MEMBERS(FieldRequest, at, what)
DERMIS_MEMBERS(Output, traces, probes, fields, extremes)
template <class Archive> void members(Archive& each, Like<Scene> auto& s) { // has a base, which no binding can name
    each(s.grid, s.surface, s.material, s.stencil, s.edges, s.receptors, s.sites);
    each(s.model, s.precision, s.tolerance, s.method, s.allow_unstable, s.load, s.time, s.output);
}
DERMIS_MEMBERS(SkinOptions, responses, precision, count, materials)
DERMIS_MEMBERS(Trace, quantity, mean, min, max, probes)
DERMIS_MEMBERS(Impulse, time, quantity, mean, min, max, probes)
DERMIS_MEMBERS(Field, at, quantity, values)
DERMIS_MEMBERS(DeviceInfo, name, kind, driver, vulkan, exact, refused)
DERMIS_MEMBERS(Result, time, traces, responses, impulses, fields, device, model, precision, steps, left_out, dispatches,
               seconds, tau_min, tau_max, predicted_error, measured_error, reduced, cells_per_ridge, stencil_estimate,
               greatest_curvature, greatest_gain, kinks, pressed_cells, cells_compared, cells_different)
DERMIS_MEMBERS(Figure, value, least, greatest)
DERMIS_MEMBERS(Report, strain, indentation, gain, cells_per_ridge, retardation_times, sign_changed)
DERMIS_MEMBERS(Relaxation, moduli, times, equilibrium)
DERMIS_MEMBERS(Fit, elements, errors, residual, model, undetermined)
DERMIS_MEMBERS(Candidate, model, precision, device, steps, dispatches, bytes, traffic, flops, seconds, error, refused,
               reduced)
DERMIS_MEMBERS(Explanation, candidates, chosen, estimate, curvature, retardation_times, tolerance, binding)
DERMIS_MEMBERS(contact::Contact, x, y, force, radius, area)
DERMIS_MEMBERS(contact::WorldContact, position, force, radius, area, direction)
DERMIS_MEMBERS(contact::Pose, position, rotation)
DERMIS_MEMBERS(contact::Report, asked, placed, outside, sideways, greatest, cells, below_cell, beside, too_far,
               turned_away, level)
#undef DERMIS_MEMBERS

// Writes values into `bytes`.
class Writer {
  public:
    template <class... T> void operator()(const T&... values) { (add(values), ...); }
    std::string bytes;

  private:
    template <class T> void add(const T& value) {
        if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>)
            bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
        else members(*this, value);
    }
    template <class T> void add(const std::optional<T>& value) {
        add(value.has_value());
        if (value) add(*value);
    }
    template <class T, size_t n> void add(const std::array<T, n>& items) {
        for (const T& item : items) add(item);
    }
    template <class T> void add(const std::vector<T>& items) {
        add(items.size());
        if constexpr (std::is_same_v<T, double>)
            bytes.append(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(double));
        else
            for (const T& item : items) add(item);
    }
    void add(const Map& map) { add(map.values()); }
    void add(const std::string& text) {
        add(text.size());
        bytes += text;
    }
};

// Reads what a Writer has written. Throws Error::bad_input where the bytes end too early.
class Reader {
  public:
    explicit Reader(string_view bytes) : bytes_(bytes) {}
    template <class... T> void operator()(T&... values) { (take(values), ...); }

  private:
    // Copies `count` items of `size` bytes each.
    void copy(void* to, size_t count, size_t size) {
        if (count > bytes_.size() / size) scene::refuse("state", "cut bytes", "the bytes that pickle was given");
        if (count) std::memcpy(to, bytes_.data(), count * size);
        bytes_.remove_prefix(count * size);
    }
    // Returns how many items follow, which is never more than there are bytes.
    size_t count() {
        size_t n = 0;
        take(n);
        if (n > bytes_.size()) scene::refuse("state", "cut bytes", "the bytes that pickle was given");
        return n;
    }
    template <class T> void take(T& value) {
        if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) copy(&value, 1, sizeof value);
        else members(*this, value);
    }
    template <class T> void take(std::optional<T>& value) {
        bool has_value = false;
        take(has_value);
        if (has_value) take(value.emplace());
    }
    template <class T, size_t n> void take(std::array<T, n>& items) {
        for (T& item : items) take(item);
    }
    template <class T> void take(std::vector<T>& items) {
        items.resize(count());
        if constexpr (std::is_same_v<T, double>) copy(items.data(), items.size(), sizeof(double));
        else
            for (T& item : items) take(item);
    }
    void take(Map& map) {
        std::vector<double> values;
        take(values);
        if (!values.empty()) map = std::move(values);
    }
    void take(std::string& text) {
        text.resize(count());
        copy(text.data(), text.size(), 1);
    }

    string_view bytes_;
};

// What stands before the members: only the same build reads them.
inline std::string written_by() { return std::string("dermis ") + version() + " of commit " + commit(); }

// Reads what the same build wrote.
inline Reader reader_of(const nb::bytes& state) {
    Reader reader(string_view(state.c_str(), state.size()));
    std::string by;
    reader(by);
    if (by != written_by()) scene::refuse("state", "pickled by " + by, written_by());
    return reader;
}

// Lets values be pickled and copied.
template <class T> void bind_pickle(nb::class_<T>& type) {
    type.def("__getstate__",
             [](const T& value) {
                 Writer writer;
                 writer(written_by(), value);
                 return nb::bytes(writer.bytes.data(), writer.bytes.size());
             })
        .def("__setstate__", [](T& self, const nb::bytes& state) {
            Reader reader = reader_of(state);
            T value{};
            reader(value);
            new (&self) T(std::move(value));
        });
}

} // namespace dermis::python
