// SPDX-License-Identifier: MIT
#include "host/c/handles.hpp"

using namespace dermis::c;

namespace {

using dermis::scene::refuse;

dermis::SkinOptions options_of(const dermis_skin_options* given) {
    dermis::SkinOptions options;
    if (!given) return options;
    need_size(given, "options");
    if (given->count != 1) refuse("options->count", std::to_string(given->count), "1");
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
    switch (given->precision) {
    case DERMIS_DEFAULT_PRECISION: break;
    case DERMIS_F32: options.precision = dermis::Precision::f32; break;
    case DERMIS_F32_COMPENSATED: options.precision = dermis::Precision::f32_compensated; break;
    default:
        refuse("options->precision", std::to_string(given->precision),
               "DERMIS_DEFAULT_PRECISION (0) .. DERMIS_F32_COMPENSATED (2)");
    }
    return options;
}

} // namespace

dermis_status dermis_skin_create(const dermis_device* device, const dermis_scene* scene,
                                 const dermis_skin_options* options, dermis_skin** skin) {
    return guarded([&] {
        need_output(skin, "skin");
        need_pointer(scene, "scene");
        const dermis::SkinOptions wanted = options_of(options);
        const dermis::Device on = device_of(device);
        *skin = new dermis_skin{on, scene->scene, wanted, dermis::Skin(on, scene->scene, wanted)};
    });
}

dermis_status dermis_skin_press(dermis_skin* skin, const float* pressure, size_t cells, double dt) {
    return guarded([&] {
        need_pointer(skin, "skin");
        need_pointer(pressure, "pressure");
        skin->skin.press(pressure, cells, dt);
    });
}

dermis_status dermis_skin_get_response(const dermis_skin* skin, dermis_quantity quantity, const float** values,
                                       size_t* count) {
    return guarded([&] {
        need_output(values, "values");
        need_output(count, "count");
        need_pointer(skin, "skin");
        const dermis::Skin::Response response = skin->skin.response(quantity_of(quantity));
        *values = response.data;
        *count = response.size;
    });
}

dermis_status dermis_skin_reset(dermis_skin* skin) {
    return guarded([&] {
        need_pointer(skin, "skin");
        skin->skin.reset();
    });
}

dermis_status dermis_skin_get_state_size(const dermis_skin* skin, size_t* bytes) {
    return guarded([&] {
        need_output(bytes, "bytes");
        need_pointer(skin, "skin");
        *bytes = skin->skin.state_bytes();
    });
}

dermis_status dermis_skin_save(const dermis_skin* skin, void* state, size_t bytes) {
    return guarded([&] {
        need_pointer(skin, "skin");
        skin->skin.save(state, bytes);
    });
}

dermis_status dermis_skin_load(dermis_skin* skin, const void* state, size_t bytes) {
    return guarded([&] {
        need_pointer(skin, "skin");
        skin->skin.load(state, bytes);
    });
}

dermis_status dermis_skin_set_material(dermis_skin* skin, const dermis_scene* scene) {
    return guarded([&] {
        need_pointer(skin, "skin");
        need_pointer(scene, "scene");
        dermis::SkinDescription description = skin->description;
        description.material = scene->scene.material;
        dermis::Skin other(skin->device, description, skin->options);
        std::vector<unsigned char> state(skin->skin.state_bytes());
        skin->skin.save(state.data(), state.size());
        other.load(state.data(), state.size());
        skin->description = std::move(description);
        skin->skin = std::move(other);
    });
}

dermis_status dermis_skin_get_report(const dermis_skin* skin, dermis_report* report) {
    return guarded([&] {
        need_pointer(skin, "skin");
        need_size(report, "report");
        fill(report, skin->skin.report());
    });
}

void dermis_skin_destroy(dermis_skin* skin) { delete skin; }
