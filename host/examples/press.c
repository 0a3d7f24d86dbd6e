// SPDX-License-Identifier: MIT
// A grip in C: thumb and index finger, two pads of one skin, hold an object for half a second and let go. Contacts, as
// a simulator has them, become pressure on the pads, one press takes both, and FA1 answers to grip and release.
#include <dermis/dermis.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { width = 160, height = 120, cells = width * height, pads = 2 };
static const double spacing = 5e-5; // m, as in the preset

// Prints the last error, and returns whether there was one.
static int failed(dermis_status status) {
    if (status != DERMIS_OK) fprintf(stderr, "%s\n", dermis_last_error());
    return status != DERMIS_OK;
}

static float greatest(const float* values, size_t count) {
    float most = 0;
    for (size_t i = 0; i < count; ++i) most = fmaxf(most, fabsf(values[i]));
    return most;
}

// Fills a pad with the pressure of one contact, and returns whether that failed. It warns of a pressure that no touch
// has.
static int fill(float* pressure, dermis_contact contact) {
    const dermis_contact_pad pad = {
        .size = sizeof pad, .width = width, .height = height, .spacing = spacing, .pressure = pressure};
    dermis_contact_report report = {.size = sizeof report};
    char doubts[400];
    memset(pressure, 0, cells * sizeof *pressure);
    if (failed(dermis_add_contacts(&pad, &contact, 1, &report))) return 1;
    if (!report.plausible) {
        if (failed(dermis_contact_report_get_doubts(&report, doubts, sizeof doubts))) return 1;
        fprintf(stderr, "%s\n", doubts);
    }
    return 0;
}

static int grip(dermis_skin* skin) {
    static float pressure[pads * cells]; // pad by pad
    const double dt = 0.001;
    for (int ms = 1; ms <= 1000; ++ms) {
        const float *sa1, *fa1;
        size_t count;
        const double force = ms <= 500 ? 0.1 : 0;                                            // N
        const dermis_contact thumb = {.x = 4e-3, .y = 3e-3, .force = force, .radius = 2e-3}; // in the middle
        const dermis_contact index = {.x = 5e-3, .y = 3e-3, .force = force, .radius = 1.5e-3};
        if (fill(pressure, thumb) || fill(pressure + cells, index) ||
            failed(dermis_skin_press(skin, pressure, pads * cells, &dt, 1, NULL)) ||
            failed(dermis_skin_get_response(skin, DERMIS_SA1, &sa1, &count)) ||
            failed(dermis_skin_get_response(skin, DERMIS_FA1, &fa1, &count)))
            return 1;
        for (int pad = 0; pad < pads && ms % 250 == 1; ++pad)
            printf("%3d ms, %s: greatest SA1 %.4f, FA1 %.4f\n", ms, pad == 0 ? "thumb" : "index",
                   greatest(sa1 + pad * cells, cells), greatest(fa1 + pad * cells, cells));
    }
    return 0;
}

int main(void) {
    const char* text = "preset = \"fingertip\"\nreceptors.depth = \"fingertip\"\n[grid]\nwidth = 160\nheight = 120\n";
    const dermis_skin_options options = {
        .size = sizeof options, .count = pads, .responses = DERMIS_BIT(DERMIS_SA1) | DERMIS_BIT(DERMIS_FA1)};
    dermis_device* device = NULL;
    dermis_scene* scene = NULL;
    dermis_skin* skin = NULL;
    const int error = failed(dermis_device_open_cpu(1, &device)) || // one thread, the caller's own
                      failed(dermis_scene_from_string(text, NULL, &scene)) ||
                      failed(dermis_scene_set(scene, "surface.kind", "wave")) ||
                      failed(dermis_skin_create(device, scene, &options, &skin)) || grip(skin);
    dermis_skin_destroy(skin);
    dermis_scene_destroy(scene);
    dermis_device_close(device);
    return error;
}
