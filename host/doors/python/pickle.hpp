// SPDX-License-Identifier: MIT
// Values as bytes, for pickle and copy: every member in its order, behind the build that wrote them. A structure is
// listed by a structured binding of all its members, so that a new member does not compile before it stands here.
#pragma once

#include "dermis/contact.hpp"
#include "host/doors/python/module.hpp"

#include <cstring>

namespace dermis::python {

#define DERMIS_MEMBERS(Struct, ...)                                                                                    \
    template <class Archive> void members(Archive& each, Struct& s) {                                                  \
        auto& [__VA_ARGS__] = s;                                                                                       \
        each(__VA_ARGS__);                                                                                             \
    }
DERMIS_MEMBERS(Cell, x, y)
DERMIS_MEMBERS(Grid, width, height, spacing)
DERMIS_MEMBERS(Surface, kind, ridges, noise, noise_length, relief, map, curvature, ridge_period)
DERMIS_MEMBERS(KelvinVoigt, modulus, viscosity, modulus_map, viscosity_map)
DERMIS_MEMBERS(Material, modulus, viscosity, thickness, length, modulus_map, viscosity_map, elements, spring, dashpot)
DERMIS_MEMBERS(Depths, sa1, sa2, fa1, fa2)
DERMIS_MEMBERS(DepthKernels, sa1, sa2, fa1, fa2)
DERMIS_MEMBERS(Follow, sa1, sa2)
DERMIS_MEMBERS(Receptors, sa2_adaptation, fa2, fa2_gains, depth, kernel, poisson, follow)
DERMIS_MEMBERS(Site, type, cell)
DERMIS_MEMBERS(AfterCurrent, amplitude, time)
DERMIS_MEMBERS(AfferentModel, time_constants, frequency, quality, value, rate, gains, membrane_time, refractory_time,
               reset, after, sensitivity, spread)
DERMIS_MEMBERS(Afferents, type, model, cells, follow, endings, radius, seed)
DERMIS_MEMBERS(Envelope::Window, start, rise, until, fall)
DERMIS_MEMBERS(Envelope, kind, start, rise, frequency, phase, mean, amplitude, length, period, times, values, window)
DERMIS_MEMBERS(Grating, wavelength, direction, velocity, amplitudes, phases)
DERMIS_MEMBERS(Texture, map, width, height, spacing, velocity)
DERMIS_MEMBERS(Taxels, spread, spacing, origin, columns, rows, skip, unit, offset, first_at_rest)
DERMIS_MEMBERS(Load, kind, center, radius, intensity, map, envelope, path, interval, hold, texture, contact, share,
               length, control, radius_y, ball_radius, taxels, grating)
DERMIS_MEMBERS(Time, step, duration)
DERMIS_MEMBERS(FieldRequest, at, what)
DERMIS_MEMBERS(Output, traces, probes, fields, extremes)
template <class Archive> void members(Archive& each, Scene& s) { // has a base, which no binding can name
    each(s.grid, s.surface, s.material, s.stencil, s.edges, s.receptors, s.sites);
    each(s.model, s.precision, s.tolerance, s.method, s.allow_unstable, s.load, s.time, s.output, s.more_loads,
         s.afferents);
}
template <class Archive> void members(Archive& each, SkinOptions& s) { // progress is the same of every skin
    auto& [responses, precision, count, materials, hold, control, afferents, shear, sa2_stretch, progress] = s;
    each(responses, precision, count, materials, hold, control, afferents, shear, sa2_stretch);
}
DERMIS_MEMBERS(Trace, quantity, mean, min, max, probes)
DERMIS_MEMBERS(Impulse, time, quantity, mean, min, max, probes)
DERMIS_MEMBERS(Field, at, quantity, values)
DERMIS_MEMBERS(DeviceInfo, name, kind, driver, uuid, vulkan, exact, refused)
DERMIS_MEMBERS(FiredSpike, time, afferent)
DERMIS_MEMBERS(Result, time, traces, responses, impulses, fields, device, model, precision, steps, left_out, dispatches,
               seconds, tau_min, tau_max, predicted_error, measured_error, measured_cells, unmeasured, cells_per_ridge,
               fine_load, stencil_estimate, greatest_curvature, greatest_gain, kinks, pressed_cells, cells_compared,
               cells_different, spikes)
DERMIS_MEMBERS(Figure, value, least, greatest)
DERMIS_MEMBERS(Report, strain, indentation, gain, cells_per_ridge, retardation_times, sign_changed, vibration,
               fine_load)
DERMIS_MEMBERS(Relaxation, moduli, times, equilibrium)
DERMIS_MEMBERS(Candidate, model, precision, device, steps, dispatches, bytes, seconds, error, refused)
DERMIS_MEMBERS(Explanation, candidates, chosen, estimate, curvature, retardation_times, strain_between, fa1_between,
               fine_load, tolerance, binding)
DERMIS_MEMBERS(contact::Contact, x, y, force, radius, area)
DERMIS_MEMBERS(contact::WorldContact, position, force, radius, area, direction)
DERMIS_MEMBERS(contact::Pose, position, rotation)
DERMIS_MEMBERS(contact::ContactReport, asked, placed, outside, sideways, shear, greatest, cells, below_cell, beside,
               too_far, turned_away, level, by_body, by_patch, tilted, centre_off, clipped)
#undef DERMIS_MEMBERS

enum class Way { write, read };

// Appends values to bytes, or reads what has been written, and throws Error::bad_input where the bytes end too early.
template <Way way> class Archive {
  public:
    using Bytes = std::conditional_t<way == Way::read, string_view, std::string>;
    explicit Archive(Bytes bytes = {}) : bytes_(std::move(bytes)) {}
    // Only reading changes the values.
    template <class... T> void operator()(T&&... values) { (item(const_cast<std::remove_cvref_t<T>&>(values)), ...); }
    const Bytes& bytes() const { return bytes_; }

  private:
    void need(bool ok) const {
        if (!ok) scene::refuse("state", "cut bytes", "the bytes that pickle was given");
    }
    template <class Number> void numbers(Number* first, size_t count) {
        const size_t size = count * sizeof *first;
        if constexpr (way == Way::read) {
            need(size <= bytes_.size());
            if (count) std::memcpy(first, bytes_.data(), size);
            bytes_.remove_prefix(size);
        } else bytes_.append(reinterpret_cast<const char*>(first), size);
    }
    template <class T> void item(T& value) {
        if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) numbers(&value, 1);
        else if constexpr (requires { value.resize(0); }) items(value);
        else members(*this, value);
    }
    template <class Items> void items(Items& items) { // a vector or a text
        size_t count = items.size();
        item(count);
        if constexpr (way == Way::read) {
            need(count <= bytes_.size()); // an item has at least a byte
            items.resize(count);
        }
        if constexpr (std::is_arithmetic_v<typename Items::value_type>) numbers(items.data(), count);
        else
            for (auto& each : items) item(each);
    }
    template <class T, size_t n> void item(std::array<T, n>& items) {
        for (T& each : items) item(each);
    }
    template <class T> void item(std::optional<T>& value) {
        bool has_value = value.has_value();
        item(has_value);
        if (has_value) item(way == Way::read ? value.emplace() : *value);
    }
    void item(Map& map) {
        if constexpr (way == Way::write) return (*this)(map.values());
        std::vector<double> values;
        items(values);
        if (!values.empty()) map = std::move(values);
    }

    Bytes bytes_;
};
using Writer = Archive<Way::write>;
using Reader = Archive<Way::read>;

// What stands before the members: only the same build reads them.
inline std::string written_by() { return std::string("dermis ") + version() + " of commit " + commit(); }

// What is more than its members has overloads of these two. make() makes the object at `self`.
template <class Type> void write(Writer& writer, const Type& value) { writer(value); }
template <class Type> void make(Type* self, Reader& reader) {
    Type value{};
    reader(value);
    new (self) Type(std::move(value));
}

void write(Writer&, const SharedDevice&);
void make(SharedDevice*, Reader&);
SharedDevice device_in(Reader&); // opened by the same text in this process, or now

// Lets objects be pickled and copied, with the attributes that a subclass in Python gives them.
struct Pickled : nb::def_visitor<Pickled> {
    using Attributes = nb::typed<nb::dict, nb::str, nb::object>;
    using State = std::tuple<nb::bytes, Attributes>;
    template <class Class> static void execute(Class& bound) {
        using Type = typename Class::Type;
        bound
            .def("__getstate__",
                 [](nb::handle self) {
                     Writer writer;
                     writer(written_by());
                     write(writer, nb::cast<const Type&>(self));
                     return State(nb::bytes(writer.bytes().data(), writer.bytes().size()),
                                  nb::borrow<Attributes>(nb::getattr(self, "__dict__", nb::dict())));
                 })
            .def("__setstate__", [](nb::pointer_and_handle<Type> self, const State& state) {
                const auto& [bytes, attributes] = state;
                Reader reader({bytes.c_str(), bytes.size()});
                std::string by;
                reader(by);
                if (by != written_by()) scene::refuse("state", "pickled by " + by, written_by());
                make(self.p, reader);
                if (attributes.size()) self.h.attr("__dict__").attr("update")(attributes);
            });
    }
};

} // namespace dermis::python
