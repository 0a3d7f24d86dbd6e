// SPDX-License-Identifier: MIT
#include "host/doors/c/handles.hpp"

#include "host/core/contact/landing.hpp"

#include <algorithm>
#include <cstring>

using namespace dermis::c;
namespace contact = dermis::contact;

contact::Pad dermis::c::pad_of(const dermis_contact_pad* pad, const char* argument) {
    const size_t versions[] = {offsetof(dermis_contact_pad, tiled), offsetof(dermis_contact_pad, radius_x),
                               offsetof(dermis_contact_pad, shear_x), offsetof(dermis_contact_pad, keep)};
    need_size(pad, argument, versions[0], versions[1], versions[2], versions[3]);
    const bool has_radii = pad->size > versions[1], has_shear = pad->size > versions[2];
    return {.width = pad->width,
            .height = pad->height,
            .spacing = pad->spacing,
            .pressure = pad->pressure,
            .pitch = pad->pitch,
            .tiled = pad->size >= versions[1] && flag(pad->tiled, std::string(argument) + "->tiled"),
            .radius_x = has_radii ? pad->radius_x : 0,
            .radius_y = has_radii ? pad->radius_y : 0,
            .shear_x = has_shear ? pad->shear_x : nullptr,
            .shear_y = has_shear ? pad->shear_y : nullptr,
            .keep = pad->size > versions[3] && flag(pad->keep, std::string(argument) + "->keep")};
}

void dermis::c::need_report(const dermis_contact_report* report) {
    need_size(report, "report", offsetof(dermis_contact_report, shear_x), offsetof(dermis_contact_report, by_body));
}

void dermis::c::fill(dermis_contact_report* to, const contact::ContactReport& r) {
    const size_t size = to->size;
    const dermis_contact_report whole = {.size = size,
                                         .asked = r.asked,
                                         .placed = r.placed,
                                         .outside = r.outside,
                                         .greatest = r.greatest,
                                         .level = r.level,
                                         .cells = r.cells,
                                         .below_cell = r.below_cell,
                                         .beside = r.beside,
                                         .plausible = r.plausible(),
                                         .sideways = r.sideways,
                                         .too_far = r.too_far,
                                         .turned_away = r.turned_away,
                                         .shear_x = r.shear[0],
                                         .shear_y = r.shear[1],
                                         .by_body = r.by_body,
                                         .by_patch = r.by_patch,
                                         .tilted = r.tilted,
                                         .centre_off = r.centre_off,
                                         .clipped = r.clipped};
    std::memcpy(to, &whole, size);
}

namespace {

contact::Pose pose_of(const dermis_pose* pose) {
    need_pointer(pose, "pose");
    return contact::Pose::from_matrix(pose->position, pose->rotation);
}

void fill(dermis_pose* to, const contact::Pose& pose) {
    std::copy(pose.position.begin(), pose.position.end(), to->position);
    std::copy(pose.rotation.begin(), pose.rotation.end(), to->rotation);
}

contact::Pad checked_pad(const dermis_contact_pad* pad) {
    const contact::Pad made = pad_of(pad, "pad");
    contact::check(made);
    return made;
}

// Adds to a pad, and fills the caller's report.
template <class Add> void add(const dermis_contact_pad* pad, dermis_contact_report* report, Add&& add) {
    need_report(report);
    dermis::c::fill(report, add(checked_pad(pad)));
}

} // namespace

dermis_status dermis_contact_report_get_doubts(const dermis_contact_report* report, char* text, size_t size) {
    return guarded([&] {
        need_pointer(text, "text");
        need_report(report);
        contact::ContactReport own;
        own.asked = report->asked, own.placed = report->placed;
        own.outside = report->outside, own.sideways = report->sideways;
        own.greatest = report->greatest;
        own.below_cell = report->below_cell;
        own.beside = report->beside, own.too_far = report->too_far, own.turned_away = report->turned_away;
        if (report->size == sizeof *report) own.clipped = report->clipped;
        const std::string doubts = own.doubts();
        if (size <= doubts.size())
            dermis::scene::refuse("size", std::to_string(size), std::to_string(doubts.size() + 1) + " bytes or more");
        std::memcpy(text, doubts.c_str(), doubts.size() + 1);
    });
}

dermis_status dermis_add_contacts(const dermis_contact_pad* pad, const dermis_contact* contacts, size_t count,
                                  dermis_contact_report* report) {
    return guarded([&] {
        if (count > 0) need_pointer(contacts, "contacts");
        add(pad, report, [&](const contact::Pad& on) {
            return contact::add_each(on, count, [&](size_t i) {
                const dermis_contact& c = contacts[i];
                return contact::Contact{.x = c.x, .y = c.y, .force = c.force, .radius = c.radius, .area = c.area};
            });
        });
    });
}

dermis_status dermis_pose_from_quaternion(const double* position, const double* quaternion, dermis_pose* pose) {
    return guarded([&] {
        need_pointer(pose, "pose");
        need_pointer(position, "position");
        need_pointer(quaternion, "quaternion");
        fill(pose, contact::Pose::from_quaternion(position, quaternion));
    });
}

dermis_status dermis_pose_from_middle(dermis_pose* pose, const dermis_contact_pad* pad) {
    return guarded([&] { fill(pose, pose_of(pose).from_middle(checked_pad(pad))); });
}

dermis_status dermis_add_contacts_world(const dermis_contact_pad* pad, const dermis_pose* pose, double reach,
                                        const dermis_world_contact* contacts, size_t count,
                                        dermis_contact_report* report) {
    return guarded([&] {
        if (count > 0) need_pointer(contacts, "contacts");
        add(pad, report, [&](const contact::Pad& on) {
            return contact::add_each(on, pose_of(pose), reach, count, [&](size_t i) {
                const dermis_world_contact& c = contacts[i];
                return contact::WorldContact{.position = {c.position[0], c.position[1], c.position[2]},
                                             .force = c.force,
                                             .radius = c.radius,
                                             .area = c.area,
                                             .direction = {c.direction[0], c.direction[1], c.direction[2]}};
            });
        });
    });
}

dermis_status dermis_fill_depths(const dermis_contact_pad* pad, const dermis_pose* pose, const dermis_body* body,
                                 float* depth, size_t pitch) {
    return guarded([&] {
        need_size(body, "body");
        if (body->kind < DERMIS_SPHERE || body->kind > DERMIS_ELLIPSOID)
            dermis::scene::refuse("body->kind", std::to_string(body->kind),
                                  "DERMIS_SPHERE (0) .. DERMIS_ELLIPSOID (5)");
        const contact::Body made{.kind = contact::Body::Kind(body->kind),
                                 .size = {body->extent[0], body->extent[1], body->extent[2]},
                                 .pose = pose_of(&body->pose)};
        contact::fill_depths(pad_of(pad, "pad"), pose_of(pose), made, depth, pitch);
    });
}

dermis_status dermis_add_depths(const dermis_contact_pad* pad, const dermis_depths* depths,
                                dermis_contact_report* report) {
    return guarded([&] {
        need_size(depths, "depths");
        const contact::DepthMap d{
            .depth = depths->depth, .force = depths->force, .stiffness = depths->stiffness, .pitch = depths->pitch};
        add(pad, report, [&](const contact::Pad& on) { return contact::add_depths(on, d); });
    });
}

dermis_status dermis_add_taxels(const dermis_contact_pad* pad, const dermis_taxels* taxels,
                                dermis_contact_report* report) {
    return guarded([&] {
        need_size(taxels, "taxels");
        using Unit = contact::TaxelReadings::Unit;
        if (taxels->unit != DERMIS_NEWTON && taxels->unit != DERMIS_PASCAL)
            dermis::scene::refuse("taxels->unit", std::to_string(taxels->unit), "DERMIS_NEWTON (0), DERMIS_PASCAL (1)");
        const contact::TaxelReadings t{.unit = taxels->unit == DERMIS_NEWTON ? Unit::newton : Unit::pascal,
                                       .values = taxels->values,
                                       .columns = taxels->columns,
                                       .rows = taxels->rows,
                                       .width = taxels->width,
                                       .height = taxels->height,
                                       .x = taxels->x,
                                       .y = taxels->y,
                                       .column_step = taxels->column_step ? taxels->column_step : 1,
                                       .row_step = taxels->row_step};
        add(pad, report, [&](const contact::Pad& on) { return contact::add_taxels(on, t); });
    });
}

dermis_status dermis_touch_create(const dermis_contact_pad* shape, int32_t count, double reach, int32_t shear,
                                  dermis_touch** touch) {
    return dermis_touch_create_on(shape, count, reach, shear, 0, nullptr, touch);
}

dermis_status dermis_touch_create_on(const dermis_contact_pad* shape, int32_t count, double reach, int32_t shear,
                                     double stiffness, const double* around, dermis_touch** touch) {
    return guarded([&] {
        need_output(touch, "touch");
        const bool sheared = flag(shear, "shear");
        contact::Source source{.stiffness = stiffness};
        if (around) std::copy_n(around, 4, source.around.begin());
        *touch = new dermis_touch{contact::Touch(pad_of(shape, "shape"), count, reach, sheared, source)};
    });
}

dermis_status dermis_touch_add(dermis_touch* touch, const dermis_poses* poses, const dermis_contacts* contacts,
                               dermis_contact_report* report) {
    dermis_shapes none = {};
    none.size = sizeof none;
    return dermis_touch_add_shapes(touch, poses, contacts, &none, report);
}

dermis_status dermis_touch_add_shapes(dermis_touch* touch, const dermis_poses* poses, const dermis_contacts* contacts,
                                      const dermis_shapes* shapes, dermis_contact_report* report) {
    return guarded([&] {
        need_pointer(touch, "touch");
        need_size(contacts, "contacts", offsetof(dermis_contacts, body));
        need_size(shapes, "shapes");
        need_report(report);
        if (contacts->count > 0) need_pointer(poses, "poses");
        const contact::Poses where = poses ? contact::Poses{.position = poses->position,
                                                            .rotation = poses->rotation,
                                                            .position_step = poses->position_step,
                                                            .rotation_step = poses->rotation_step}
                                           : contact::Poses{};
        contact::Contacts forces{.count = contacts->count,
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
                                 .ball_step = contacts->ball_step};
        if (contacts->size == sizeof *contacts) {
            forces.body = contacts->body, forces.body_step = contacts->body_step;
            forces.torque = contacts->torque, forces.torque_step = contacts->torque_step;
        }
        fill(report, touch->touch.add(where, forces,
                                      {.count = shapes->count,
                                       .pad = shapes->pad,
                                       .body = shapes->body,
                                       .kind = shapes->kind,
                                       .size = shapes->extent,
                                       .position = shapes->position,
                                       .rotation = shapes->rotation,
                                       .faces = shapes->faces,
                                       .face_count = shapes->face_count,
                                       .pad_step = shapes->pad_step,
                                       .body_step = shapes->body_step,
                                       .kind_step = shapes->kind_step,
                                       .size_step = shapes->extent_step,
                                       .position_step = shapes->position_step,
                                       .rotation_step = shapes->rotation_step}));
    });
}

dermis_status dermis_touch_add_depths(dermis_touch* touch, const float* depth, const double* force, int32_t gaps,
                                      dermis_contact_report* report) {
    return guarded([&] {
        need_pointer(touch, "touch");
        need_report(report);
        fill(report, touch->touch.add({.depth = depth, .force = force, .gaps = flag(gaps, "gaps")}));
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
