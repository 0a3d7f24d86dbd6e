/* SPDX-License-Identifier: MIT */
/* Prints the numbers that the ABI fixes beside its symbols. */
#include <dermis/dermis.h>

#include <stdio.h>

#define NUMBER(name) printf(#name " %d\n", (int)name)
#define SIZE(type) printf("sizeof " #type " %d\n", (int)sizeof(type))
/* The size of a struct's first version, up to its last member. */
#define FIRST_SIZE(type, last) printf("sizeof " #type " %d\n", (int)(offsetof(type, last) + sizeof((type*)0)->last))
/* The size of a struct's version before it got the member `next`. */
#define EARLIER_SIZE(type, next) printf("sizeof " #type " %d\n", (int)offsetof(type, next))
#define OFFSET(type, member) printf("offsetof " #type " " #member " %d\n", (int)offsetof(type, member))

int main(void) {
    NUMBER(DERMIS_OK);
    NUMBER(DERMIS_BAD_INPUT);
    NUMBER(DERMIS_NO_DEVICE);
    NUMBER(DERMIS_DEVICE_FAILED);
    NUMBER(DERMIS_IO);
    NUMBER(DERMIS_NO_MEMORY);
    NUMBER(DERMIS_INTERNAL);
    NUMBER(DERMIS_STRAIN);
    NUMBER(DERMIS_SA1);
    NUMBER(DERMIS_SA2);
    NUMBER(DERMIS_FA1);
    NUMBER(DERMIS_FA2);
    NUMBER(DERMIS_CURVATURE);
    NUMBER(DERMIS_DEFORMATION);
    NUMBER(DERMIS_INDENTATION);
    NUMBER(DERMIS_MEAN);
    NUMBER(DERMIS_MIN);
    NUMBER(DERMIS_MAX);
    NUMBER(DERMIS_DEFAULT_PRECISION);
    NUMBER(DERMIS_F32);
    NUMBER(DERMIS_F32_COMPENSATED);
    SIZE(dermis_status);
    SIZE(dermis_figure);
    SIZE(dermis_device_info);
    OFFSET(dermis_device_info, name);
    OFFSET(dermis_device_info, kind);
    OFFSET(dermis_device_info, driver);
    OFFSET(dermis_device_info, refused);
    OFFSET(dermis_device_info, vulkan);
    OFFSET(dermis_device_info, exact);
    FIRST_SIZE(dermis_report, sign_changed);
    OFFSET(dermis_report, strain);
    OFFSET(dermis_report, indentation);
    OFFSET(dermis_report, gain);
    OFFSET(dermis_report, cells_per_ridge);
    OFFSET(dermis_report, retardation_times);
    OFFSET(dermis_report, retardation_time_count);
    OFFSET(dermis_report, sign_changed);
    FIRST_SIZE(dermis_skin_options, own_materials);
    OFFSET(dermis_skin_options, count);
    OFFSET(dermis_skin_options, responses);
    OFFSET(dermis_skin_options, precision);
    OFFSET(dermis_skin_options, own_materials);
    SIZE(dermis_pads);
    OFFSET(dermis_pads, numbers);
    OFFSET(dermis_pads, count);
    NUMBER(DERMIS_NEWTON);
    NUMBER(DERMIS_PASCAL);
    FIRST_SIZE(dermis_contact_pad, pitch);
    OFFSET(dermis_contact_pad, width);
    OFFSET(dermis_contact_pad, height);
    OFFSET(dermis_contact_pad, spacing);
    OFFSET(dermis_contact_pad, pressure);
    OFFSET(dermis_contact_pad, pitch);
    EARLIER_SIZE(dermis_contact_report, shear_x);
    OFFSET(dermis_contact_report, asked);
    OFFSET(dermis_contact_report, placed);
    OFFSET(dermis_contact_report, outside);
    OFFSET(dermis_contact_report, greatest);
    OFFSET(dermis_contact_report, level);
    OFFSET(dermis_contact_report, cells);
    OFFSET(dermis_contact_report, below_cell);
    OFFSET(dermis_contact_report, beside);
    OFFSET(dermis_contact_report, plausible);
    OFFSET(dermis_contact_report, sideways);
    OFFSET(dermis_contact_report, too_far);
    OFFSET(dermis_contact_report, turned_away);
    SIZE(dermis_contact);
    OFFSET(dermis_contact, x);
    OFFSET(dermis_contact, y);
    OFFSET(dermis_contact, force);
    OFFSET(dermis_contact, radius);
    OFFSET(dermis_contact, area);
    SIZE(dermis_pose);
    OFFSET(dermis_pose, position);
    OFFSET(dermis_pose, rotation);
    SIZE(dermis_world_contact);
    OFFSET(dermis_world_contact, position);
    OFFSET(dermis_world_contact, direction);
    OFFSET(dermis_world_contact, force);
    OFFSET(dermis_world_contact, radius);
    OFFSET(dermis_world_contact, area);
    SIZE(dermis_depths);
    OFFSET(dermis_depths, depth);
    OFFSET(dermis_depths, pitch);
    OFFSET(dermis_depths, force);
    OFFSET(dermis_depths, stiffness);
    SIZE(dermis_taxels);
    OFFSET(dermis_taxels, values);
    OFFSET(dermis_taxels, unit);
    OFFSET(dermis_taxels, columns);
    OFFSET(dermis_taxels, rows);
    OFFSET(dermis_taxels, width);
    OFFSET(dermis_taxels, height);
    OFFSET(dermis_taxels, x);
    OFFSET(dermis_taxels, y);
    OFFSET(dermis_taxels, column_step);
    OFFSET(dermis_taxels, row_step);
    OFFSET(dermis_contact_pad, tiled);
    EARLIER_SIZE(dermis_contact_pad, radius_x);
    NUMBER(DERMIS_LINEAR);
    NUMBER(DERMIS_PARABOLIC);
    OFFSET(dermis_skin_options, hold);
    EARLIER_SIZE(dermis_skin_options, shear);
    OFFSET(dermis_report, vibration);
    SIZE(dermis_report);
    NUMBER(DERMIS_PRESSURE);
    NUMBER(DERMIS_DEPTH);
    OFFSET(dermis_skin_options, control);
    SIZE(dermis_spike);
    OFFSET(dermis_spike, pad);
    OFFSET(dermis_spike, afferent);
    OFFSET(dermis_spike, frame);
    OFFSET(dermis_spike, share);
    SIZE(dermis_fired_spike);
    OFFSET(dermis_fired_spike, time);
    OFFSET(dermis_fired_spike, afferent);
    OFFSET(dermis_contact_pad, radius_x);
    OFFSET(dermis_contact_pad, radius_y);
    EARLIER_SIZE(dermis_contact_pad, shear_x);
    OFFSET(dermis_contact_pad, shear_x);
    OFFSET(dermis_contact_pad, shear_y);
    SIZE(dermis_contact_pad);
    OFFSET(dermis_contact_report, shear_x);
    OFFSET(dermis_contact_report, shear_y);
    SIZE(dermis_contact_report);
    OFFSET(dermis_skin_options, shear);
    SIZE(dermis_skin_options);
    NUMBER(DERMIS_SHEAR_X);
    NUMBER(DERMIS_SHEAR_Y);
    NUMBER(DERMIS_STRETCH);
    SIZE(dermis_poses);
    OFFSET(dermis_poses, position);
    OFFSET(dermis_poses, rotation);
    OFFSET(dermis_poses, position_step);
    OFFSET(dermis_poses, rotation_step);
    SIZE(dermis_contacts);
    OFFSET(dermis_contacts, count);
    OFFSET(dermis_contacts, pad);
    OFFSET(dermis_contacts, position);
    OFFSET(dermis_contacts, force);
    OFFSET(dermis_contacts, radius);
    OFFSET(dermis_contacts, ball);
    OFFSET(dermis_contacts, modulus);
    OFFSET(dermis_contacts, pad_step);
    OFFSET(dermis_contacts, position_step);
    OFFSET(dermis_contacts, force_step);
    OFFSET(dermis_contacts, radius_step);
    OFFSET(dermis_contacts, ball_step);
    return 0;
}
