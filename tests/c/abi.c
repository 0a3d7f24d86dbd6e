/* SPDX-License-Identifier: MIT */
/* Prints the numbers that the ABI fixes beside its symbols. */
#include <dermis/dermis.h>

#include <stdio.h>

#define NUMBER(name) printf(#name " %d\n", (int)name)
#define SIZE(type) printf("sizeof " #type " %d\n", (int)sizeof(type))
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
    SIZE(dermis_report);
    OFFSET(dermis_report, strain);
    OFFSET(dermis_report, indentation);
    OFFSET(dermis_report, gain);
    OFFSET(dermis_report, cells_per_ridge);
    OFFSET(dermis_report, retardation_times);
    OFFSET(dermis_report, retardation_time_count);
    OFFSET(dermis_report, sign_changed);
    SIZE(dermis_skin_options);
    OFFSET(dermis_skin_options, count);
    OFFSET(dermis_skin_options, responses);
    OFFSET(dermis_skin_options, precision);
    return 0;
}
