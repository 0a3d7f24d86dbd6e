// SPDX-License-Identifier: MIT
#include "host/doors/c/handles.hpp"

#include <cstddef>

using namespace dermis::c;

namespace {

using dermis::scene::refuse;

static_assert(sizeof(dermis_fired_spike) == sizeof(dermis::FiredSpike));
static_assert(offsetof(dermis_fired_spike, time) == offsetof(dermis::FiredSpike, time));
static_assert(offsetof(dermis_fired_spike, afferent) == offsetof(dermis::FiredSpike, afferent));

void give(const std::vector<double>& numbers, const double** values, size_t* count) {
    *values = numbers.data();
    *count = numbers.size();
}

} // namespace

dermis_status dermis_run(const dermis_scene* scene, const dermis_device* device, dermis_result** result) {
    return guarded([&] {
        need_output(result, "result");
        need_pointer(scene, "scene");
        *result = new dermis_result{scene->scene, dermis::run(scene->scene, device_of(device))};
    });
}

dermis_status dermis_result_get_times(const dermis_result* result, const double** times, size_t* count) {
    return guarded([&] {
        begin(result, "result", times, "values", count);
        give(result->result.time, times, count);
    });
}

dermis_status dermis_result_get_spikes(const dermis_result* result, const dermis_fired_spike** spikes, size_t* count) {
    return guarded([&] {
        begin(result, "result", spikes, "spikes", count);
        *spikes = reinterpret_cast<const dermis_fired_spike*>(result->result.spikes.data());
        *count = result->result.spikes.size();
    });
}

dermis_status dermis_result_get_trace(const dermis_result* result, dermis_quantity quantity, dermis_column column,
                                      const double** values, size_t* count) {
    return guarded([&] {
        begin(result, "result", values, "values", count);
        const dermis::Trace& trace = result->result.trace(quantity_of(quantity));
        if (column < DERMIS_MEAN || column > DERMIS_MAX)
            refuse("column", std::to_string(column), "DERMIS_MEAN (0) .. DERMIS_MAX (2)");
        if (column != DERMIS_MEAN && trace.min.empty())
            refuse("column", std::to_string(column), "DERMIS_MEAN (0), without output.extremes");
        give(column == DERMIS_MEAN ? trace.mean : column == DERMIS_MIN ? trace.min : trace.max, values, count);
    });
}

dermis_status dermis_result_get_probe(const dermis_result* result, dermis_quantity quantity, size_t probe,
                                      const double** values, size_t* count) {
    return guarded([&] {
        begin(result, "result", values, "values", count);
        const dermis::Trace& trace = result->result.trace(quantity_of(quantity));
        if (probe >= trace.probes.size())
            refuse("probe", std::to_string(probe), "less than " + std::to_string(trace.probes.size()) + ", the probes");
        give(trace.probes[probe], values, count);
    });
}

dermis_status dermis_result_get_field(const dermis_result* result, dermis_quantity quantity, double at,
                                      const double** values, size_t* count) {
    return guarded([&] {
        begin(result, "result", values, "values", count);
        const dermis::Quantity wanted = quantity_of(quantity);
        std::string allowed;
        for (const dermis::Field& f : result->result.fields) {
            if (f.quantity == wanted && f.at == at) return give(f.values, values, count);
            if (f.quantity == wanted) allowed += (allowed.empty() ? "" : ", ") + dermis::shortest(f.at);
        }
        refuse(std::string("at of ") + name(wanted), dermis::shortest(at),
               allowed.empty() ? "nothing: output.fields asks for no field of it" : allowed);
    });
}

dermis_status dermis_result_get_responses(const dermis_result* result, const double** values, size_t* times,
                                          size_t* sites) {
    return guarded([&] {
        need_output(sites, "sites");
        begin(result, "result", values, "values", times);
        const std::vector<double>& responses = result->result.responses;
        *values = responses.empty() ? nullptr : responses.data();
        *times = result->result.time.size();
        *sites = result->scene.sites.size();
    });
}

dermis_status dermis_result_get_report(const dermis_result* result, dermis_report* report) {
    return guarded([&] {
        need_pointer(result, "result");
        need_size(report, "report", offsetof(dermis_report, vibration), offsetof(dermis_report, fine_load));
        fill(report, dermis::report(result->scene, result->result));
    });
}

void dermis_result_destroy(dermis_result* result) { delete result; }
