// SPDX-License-Identifier: MIT
// A skin in C: a round indenter presses a pad for half a second and lets go, and FA1 answers to both.
#include <dermis/dermis.h>

#include <math.h>
#include <stdio.h>

enum { width = 32, height = 24, cells = width * height };

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

// Stands for a simulator: pressure in Pa under the indenter, row 0 first.
static void contact(float* pressure, float peak) {
    for (int i = 0; i < cells; ++i) {
        const float r = hypotf((float)(i % width - width / 2), (float)(i / width - height / 2)) / 8;
        pressure[i] = r < 1 ? peak * sqrtf(1 - r * r) : 0;
    }
}

static int press(dermis_skin* skin) {
    static float pressure[cells];
    for (int ms = 1; ms <= 1000; ++ms) {
        const float *sa1, *fa1;
        size_t count;
        contact(pressure, ms <= 500 ? 2.0f : 0.0f);
        if (failed(dermis_skin_press(skin, pressure, cells, 0.001)) ||
            failed(dermis_skin_get_response(skin, DERMIS_SA1, &sa1, &count)) ||
            failed(dermis_skin_get_response(skin, DERMIS_FA1, &fa1, &count)))
            return 1;
        if (ms % 250 == 1)
            printf("%3d ms: greatest SA1 %.4f, FA1 %.4f\n", ms, greatest(sa1, count), greatest(fa1, count));
    }
    return 0;
}

int main(void) {
    const char* text = "[grid]\nwidth = 32\nheight = 24\n"
                       "[surface]\nkind = \"wave\"\nridges = 4\nnoise = 0\n";
    dermis_device* device = NULL;
    dermis_scene* scene = NULL;
    dermis_skin* skin = NULL;
    const int error = failed(dermis_device_open_cpu(1, &device)) || // one thread, the caller's own
                      failed(dermis_scene_from_string(text, NULL, &scene)) ||
                      failed(dermis_scene_set(scene, "material.viscosity", "0.2")) ||
                      failed(dermis_skin_create(device, scene, NULL, &skin)) || press(skin);
    dermis_skin_destroy(skin);
    dermis_scene_destroy(scene);
    dermis_device_close(device);
    return error;
}
