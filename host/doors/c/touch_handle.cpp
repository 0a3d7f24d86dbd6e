// SPDX-License-Identifier: MIT
#include "host/doors/c/handles.hpp"

using namespace dermis::c;
namespace contact = dermis::contact;

dermis_status dermis_touch_create(const dermis_contact_pad* shape, int32_t count, double reach, int32_t shear,
                                  dermis_touch** touch) {
    return guarded([&] {
        need_output(touch, "touch");
        const bool sheared = flag(shear, "shear");
        *touch = new dermis_touch{contact::Touch(pad_of(shape, "shape"), count, reach, sheared)};
    });
}

dermis_status dermis_touch_add(dermis_touch* touch, const dermis_poses* poses, const dermis_contacts* contacts,
                               dermis_contact_report* report) {
    return guarded([&] {
        need_pointer(touch, "touch");
        need_size(contacts, "contacts");
        need_report(report);
        if (contacts->count > 0) need_pointer(poses, "poses");
        const contact::Poses where = poses ? contact::Poses{.position = poses->position,
                                                            .rotation = poses->rotation,
                                                            .position_step = poses->position_step,
                                                            .rotation_step = poses->rotation_step}
                                           : contact::Poses{};
        fill(report, touch->touch.add(where, {.count = contacts->count,
                                              .pad = contacts->pad,
                                              .position = contacts->position,
                                              .force = contacts->force,
                                              .radius = contacts->radius,
                                              .ball = contacts->ball,
                                              .modulus = contacts->modulus,
                                              .pad_step = contacts->pad_step,
                                              .position_step = contacts->position_step,
                                              .force_step = contacts->force_step,
                                              .radius_step = contacts->radius_step,
                                              .ball_step = contacts->ball_step}));
    });
}

dermis_status dermis_touch_get_report(const dermis_touch* touch, int32_t pad, dermis_contact_report* report) {
    return guarded([&] {
        need_pointer(touch, "touch");
        need_report(report);
        fill(report, touch->touch.report(pad));
    });
}

dermis_status dermis_touch_get_pressure(const dermis_touch* touch, const float** pressure, const float** traction,
                                        size_t* numbers) {
    return guarded([&] {
        need_output(pressure, "pressure");
        need_output(numbers, "numbers");
        need_pointer(touch, "touch");
        const contact::Pad& pad = touch->touch.shape();
        *pressure = touch->touch.pressure();
        if (traction) *traction = touch->touch.traction();
        *numbers = size_t(touch->touch.count()) * size_t(pad.width) * size_t(pad.height);
    });
}

dermis_status dermis_skin_press_touch(dermis_skin* skin, const dermis_touch* touch, double dt) {
    return guarded([&] {
        need_pointer(skin, "skin");
        need_pointer(touch, "touch");
        skin->skin.press(touch->touch, dt);
    });
}

void dermis_touch_destroy(dermis_touch* touch) { delete touch; }
