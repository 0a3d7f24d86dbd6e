// SPDX-License-Identifier: MIT
#include "host/doors/c/handles.hpp"

using namespace dermis::c;

namespace {

using dermis::scene::refuse;

// Pads::numbers are int.
static_assert(std::is_same_v<int32_t, int>);
static_assert(sizeof(dermis_spike) == sizeof(dermis::Spike));
static_assert(offsetof(dermis_spike, pad) == offsetof(dermis::Spike, pad));
static_assert(offsetof(dermis_spike, afferent) == offsetof(dermis::Spike, afferent));
static_assert(offsetof(dermis_spike, frame) == offsetof(dermis::Spike, frame));
static_assert(offsetof(dermis_spike, share) == offsetof(dermis::Spike, share));

// The options of a skin of this material.
dermis::SkinOptions options_of(const dermis_skin_options* given, const dermis::Material& material) {
    dermis::SkinOptions options;
    if (!given) return options;
    if (given->size != offsetof(dermis_skin_options, shear))
        need_size(given, "options", offsetof(dermis_skin_options, hold));
    if (given->count < 1 || given->count > 1048576) // before a material is made for each
        refuse("options->count", std::to_string(given->count), "1..1048576 pads");
    options.count = given->count;
    if (flag(given->materials, "options->materials")) {
        if (!dermis::scene::is_uniform(material))
            refuse("options->materials", "1", "0, where the scene's material is one of maps");
        options.materials.assign(size_t(options.count), material);
    }
    uint32_t unknown = given->responses;
    if (unknown) options.responses.clear();
    for (const dermis::scene::ReceptorClass& c : dermis::scene::receptor_classes) {
        const uint32_t bit = DERMIS_BIT(int(c.type));
        if (given->responses & bit) options.responses.push_back(c.type);
        unknown &= ~bit;
    }
    if (unknown)
        refuse("options->responses", std::to_string(given->responses),
               "bits of " + dermis::scene::receptor_class_names() + ", at most 30");
    if (given->precision < DERMIS_DEFAULT_PRECISION || given->precision > DERMIS_F32_COMPENSATED)
        refuse("options->precision", std::to_string(given->precision),
               "DERMIS_DEFAULT_PRECISION (0) .. DERMIS_F32_COMPENSATED (2)");
    if (given->precision != DERMIS_DEFAULT_PRECISION)
        options.precision =
            given->precision == DERMIS_F32 ? dermis::Precision::f32 : dermis::Precision::f32_compensated;
    if (given->size >= offsetof(dermis_skin_options, shear)) {
        if (given->hold != DERMIS_LINEAR && given->hold != DERMIS_PARABOLIC)
            refuse("options->hold", std::to_string(given->hold), "DERMIS_LINEAR (0), DERMIS_PARABOLIC (1)");
        options.hold = given->hold == DERMIS_PARABOLIC ? dermis::Hold::parabolic : dermis::Hold::linear;
        if (given->control != DERMIS_PRESSURE && given->control != DERMIS_DEPTH)
            refuse("options->control", std::to_string(given->control), "DERMIS_PRESSURE (0), DERMIS_DEPTH (1)");
        options.control = given->control == DERMIS_DEPTH ? dermis::Control::depth : dermis::Control::pressure;
    }
    if (given->size == sizeof *given) {
        options.shear = flag(given->shear, "options->shear");
        if (flag(given->sa2_stretch, "options->sa2_stretch"))
            options.sa2_stretch = {given->stretch_direction[0], given->stretch_direction[1]};
    }
    return options;
}

// Null stands for all pads.
dermis::Pads pads_of(const dermis_pads* pads) {
    if (!pads) return {};
    if (pads->count > 0) need_pointer(pads->numbers, "pads->numbers");
    return dermis::Pads(pads->numbers, pads->count);
}

} // namespace

dermis_status dermis_skin_create(const dermis_device* device, const dermis_scene* scene,
                                 const dermis_skin_options* options, dermis_skin** skin) {
    return guarded([&] {
        need_output(skin, "skin");
        need_pointer(scene, "scene");
        dermis::SkinOptions wanted = options_of(options, scene->scene.material);
        wanted.afferents = scene->scene.afferents;
        *skin = new dermis_skin{dermis::Skin(device_of(device), scene->scene, wanted)};
    });
}

dermis_status dermis_skin_press(dermis_skin* skin, const float* pressure, size_t cells, const double* dt, size_t steps,
                                const dermis_pads* pads) {
    return guarded([&] {
        need_pointer(skin, "skin");
        if (cells > 0) need_pointer(pressure, "pressure");
        if (steps > 0) need_pointer(dt, "dt");
        if (steps == 1) skin->skin.press(pressure, cells, *dt, pads_of(pads));
        else skin->skin.press(pressure, cells, dt, steps, pads_of(pads));
    });
}

dermis_status dermis_skin_press_tractions(dermis_skin* skin, const float* pressure, const float* traction, size_t cells,
                                          double dt, const dermis_pads* pads) {
    return guarded([&] {
        need_pointer(skin, "skin");
        if (cells > 0) need_pointer(pressure, "pressure");
        need_pointer(traction, "traction");
        skin->skin.press(pressure, traction, cells, dt, pads_of(pads));
    });
}

dermis_status dermis_skin_press_frames(dermis_skin* skin, const float* frames, size_t count, size_t cells, double dt,
                                       const dermis_pads* pads) {
    return guarded([&] {
        need_pointer(skin, "skin");
        if (count > 0 && cells > 0) need_pointer(frames, "frames");
        skin->skin.press_frames(frames, count, cells, dt, pads_of(pads));
    });
}

dermis_status dermis_skin_get_cells(dermis_skin* skin, const int32_t** cells, size_t* count) {
    return guarded([&] {
        begin(skin, "skin", cells, "cells", count);
        if (skin->cells.empty()) skin->cells = skin->skin.cells();
        *cells = skin->cells.data();
        *count = skin->cells.size();
    });
}

dermis_status dermis_skin_press_cells(dermis_skin* skin, const float* pressure, size_t numbers, double dt,
                                      const dermis_pads* pads) {
    return guarded([&] {
        need_pointer(skin, "skin");
        if (numbers > 0) need_pointer(pressure, "pressure");
        skin->skin.press_cells(pressure, numbers, dt, pads_of(pads));
    });
}

dermis_status dermis_skin_get_response(const dermis_skin* skin, dermis_quantity quantity, const float** values,
                                       size_t* count) {
    return guarded([&] {
        begin(skin, "skin", values, "values", count);
        const dermis::Skin::Response response = skin->skin.response(quantity_of(quantity));
        *values = response.data;
        *count = response.size;
    });
}

dermis_status dermis_skin_get_spikes(const dermis_skin* skin, const dermis_spike** spikes, size_t* count) {
    return guarded([&] {
        begin(skin, "skin", spikes, "spikes", count);
        const dermis::Skin::Spikes last = skin->skin.spikes();
        *spikes = reinterpret_cast<const dermis_spike*>(last.data);
        *count = last.size;
    });
}

dermis_status dermis_skin_reset(dermis_skin* skin, const dermis_pads* pads) {
    return guarded([&] {
        need_pointer(skin, "skin");
        skin->skin.reset(pads_of(pads));
    });
}

dermis_status dermis_skin_get_state_size(const dermis_skin* skin, size_t* bytes, const dermis_pads* pads) {
    return guarded([&] {
        need_output(bytes, "bytes");
        need_pointer(skin, "skin");
        *bytes = skin->skin.state_bytes(pads_of(pads));
    });
}

dermis_status dermis_skin_save(const dermis_skin* skin, void* state, size_t bytes, const dermis_pads* pads) {
    return guarded([&] {
        need_pointer(skin, "skin");
        skin->skin.save(state, bytes, pads_of(pads));
    });
}

dermis_status dermis_skin_load(dermis_skin* skin, const void* state, size_t bytes, const dermis_pads* pads) {
    return guarded([&] {
        need_pointer(skin, "skin");
        skin->skin.load(state, bytes, pads_of(pads));
    });
}

dermis_status dermis_skin_set_material(dermis_skin* skin, const dermis_scene* scene, const dermis_pads* pads) {
    return guarded([&] {
        need_pointer(skin, "skin");
        need_pointer(scene, "scene");
        skin->skin.set_material(scene->scene.material, pads_of(pads));
    });
}

dermis_status dermis_skin_get_report(const dermis_skin* skin, int32_t pad, dermis_report* report) {
    return guarded([&] {
        need_pointer(skin, "skin");
        need_size(report, "report", offsetof(dermis_report, vibration), offsetof(dermis_report, fine_load));
        fill(report, skin->skin.report(pad));
    });
}

void dermis_skin_destroy(dermis_skin* skin) { delete skin; }
