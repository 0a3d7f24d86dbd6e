// SPDX-License-Identifier: MIT
// Status codes, the last error of each thread, and what functions on different handles share.
#include "host/doors/c/handles.hpp"

#include <algorithm>
#include <cstring>
#include <new>

namespace dermis::c {
namespace {

thread_local std::string last_error;
thread_local bool message_lost = false; // there was no memory for it

dermis_status keep(dermis_status status, const char* message) noexcept {
    try {
        last_error = message;
        message_lost = false;
    } catch (...) {
        message_lost = true;
    }
    return status;
}

constexpr dermis_status statuses[] = {DERMIS_BAD_INPUT, DERMIS_NO_DEVICE, DERMIS_DEVICE_FAILED, DERMIS_IO,
                                      DERMIS_NO_MEMORY}; // by Error::Code

dermis_figure figure_of(const Figure& f) { return {.value = f.value, .least = f.least, .greatest = f.greatest}; }

} // namespace

dermis_status status_of_exception() noexcept {
    try {
        throw;
    } catch (const Error& e) {
        return keep(statuses[size_t(e.code())], e.what());
    } catch (const std::bad_alloc&) {
        return keep(DERMIS_NO_MEMORY, "memory could not be allocated");
    } catch (const std::exception& e) {
        return keep(DERMIS_INTERNAL, e.what());
    } catch (...) {
        return keep(DERMIS_INTERNAL, "an exception without a message");
    }
}

// The quantities by their numbers in C, which never change.
constexpr Quantity quantities[] = {
    Quantity::strain,    Quantity::sa1,         Quantity::sa2,         Quantity::fa1,     Quantity::fa2,
    Quantity::curvature, Quantity::deformation, Quantity::indentation, Quantity::shear_x, Quantity::shear_y,
    Quantity::stretch_x, Quantity::stretch_y,   Quantity::stretch_xy};
static_assert(quantities[DERMIS_STRAIN] == Quantity::strain && quantities[DERMIS_FA2] == Quantity::fa2 &&
              quantities[DERMIS_STRETCH_XY] == Quantity::stretch_xy);

Quantity quantity_of(dermis_quantity q) {
    if (q < DERMIS_STRAIN || q > DERMIS_STRETCH_XY)
        scene::refuse("quantity", std::to_string(q), "DERMIS_STRAIN (0) .. DERMIS_STRETCH_XY (12)");
    return quantities[q];
}

Device device_of(const dermis_device* device) { return device ? device->device : Device::cpu(); }

void fill(dermis_report* to, const Report& from) {
    constexpr size_t most = sizeof to->retardation_times / sizeof(dermis_figure);
    if (from.retardation_times.size() > most)
        throw std::length_error("a report has " + std::to_string(from.retardation_times.size()) + " retardation times");
    dermis_report report{};
    report.size = to->size;
    report.strain = figure_of(from.strain);
    report.indentation = figure_of(from.indentation);
    report.gain = figure_of(from.gain);
    report.cells_per_ridge = figure_of(from.cells_per_ridge);
    for (const Figure& f : from.retardation_times)
        report.retardation_times[report.retardation_time_count++] = figure_of(f);
    for (Quantity q : from.sign_changed)
        report.sign_changed |= DERMIS_BIT(std::ranges::find(quantities, q) - std::begin(quantities));
    report.vibration = figure_of(from.vibration);
    report.fine_load = figure_of(from.fine_load);
    std::memcpy(to, &report, report.size);
}

} // namespace dermis::c

const char* dermis_version(void) { return dermis::version(); }

const char* dermis_last_error(void) {
    return dermis::c::message_lost ? "memory for a message could not be allocated" : dermis::c::last_error.c_str();
}
