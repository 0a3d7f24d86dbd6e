/* SPDX-License-Identifier: MIT */
/* The C interface as a C program uses it: what it computes, and every misuse that can be seen. */
#include "check.h"

#define CELLS 12 /* of the skin's grid, 4 x 3 */

static const char pad[] = "[grid]\nwidth = 4\nheight = 3\n[surface]\nkind = \"wave\"\n[material]\nmodulus = 2\n";

static dermis_device* on = NULL; /* the device of skins; NULL: the CPU path */

static dermis_scene* scene_of(const char* text) {
    dermis_scene* scene = NULL;
    CHECK(dermis_scene_from_string(text, NULL, &scene) == DERMIS_OK);
    return scene;
}

static dermis_skin* skin_of(const char* text) {
    dermis_scene* scene = scene_of(text);
    dermis_skin* skin = NULL;
    CHECK(dermis_skin_create(on, scene, NULL, &skin) == DERMIS_OK);
    dermis_scene_destroy(scene); /* the skin keeps what it needs */
    return skin;
}

static void versions_and_errors(void) {
    CHECK(strcmp(dermis_last_error(), "") == 0);
    CHECK(strcmp(dermis_version(), DERMIS_VERSION) == 0);
    REFUSED(dermis_device_open("no such device", NULL), "device = (null)");
    dermis_device* device = NULL;
    CHECK(dermis_device_open("cpu", &device) == DERMIS_OK);
    CHECK(strcmp(dermis_last_error(), "device = (null); allowed: a pointer") == 0); /* a call that succeeds leaves it */
    dermis_device_close(device);
}

static void devices(void) {
    dermis_device* device = NULL;
    dermis_device_info info = {.size = sizeof info};
    CHECK(dermis_device_open_cpu(1, &device) == DERMIS_OK);
    CHECK(dermis_device_get_info(device, &info) == DERMIS_OK);
    CHECK(strcmp(info.name, "cpu") == 0 && strcmp(info.kind, "cpu path") == 0);
    CHECK(strcmp(info.driver, "") == 0 && strcmp(info.refused, "") == 0);
    CHECK(info.vulkan == 0 && info.exact == 1 && info.size == sizeof info);
    info.size = 3;
    REFUSED(dermis_device_get_info(device, &info), "info->size = 3; allowed: ");
    REFUSED(dermis_device_get_info(device, NULL), "info = (null)");
    REFUSED(dermis_device_get_info(NULL, &info), "device = (null)");
    dermis_device_close(device);
    dermis_device_close(NULL);
    REFUSED(dermis_device_open(NULL, &device), "which = (null)");
    REFUSED(dermis_device_open_cpu(1, NULL), "device = (null)");
    CHECK(device == NULL);
    REFUSED(dermis_device_open_cpu(-1, &device), "threads = -1; allowed: 0 (one per core) .. 1024");
}

static void scenes(void) {
    dermis_scene* scene = NULL;
    int32_t width = 0, height = 0;
    REFUSED(dermis_scene_from_string("[time]\n\nstep = -1\n", NULL, &scene), "scene:3: time.step = -1; allowed: ");
    CHECK(scene == NULL);
    CHECK(dermis_scene_fingertip(&scene) == DERMIS_OK);
    CHECK(dermis_scene_get_size(scene, &width, &height) == DERMIS_OK && width == 200 && height == 200);
    dermis_scene_destroy(scene);
    scene = NULL;
    REFUSED(dermis_scene_from_string(NULL, NULL, &scene), "text = (null)");
    REFUSED(dermis_scene_from_string("", NULL, NULL), "scene = (null)");
    REFUSED(dermis_scene_from_file("no/such/scene.toml", &scene), "no/such/scene.toml: cannot be read");
    REFUSED(dermis_scene_from_file(NULL, &scene), "path = (null)");
    REFUSED(dermis_scene_from_file("scene.toml", NULL), "scene = (null)");
    scene = scene_of(pad);
    CHECK(dermis_scene_get_size(scene, &width, &height) == DERMIS_OK && width == 4 && height == 3);
    REFUSED(dermis_scene_get_size(scene, NULL, &height), "width = (null)");
    REFUSED(dermis_scene_get_size(scene, &width, NULL), "height = (null)");
    REFUSED(dermis_scene_get_size(NULL, &width, &height), "scene = (null)");
    CHECK(width == 0 && height == 0);

    CHECK(dermis_scene_set(scene, "grid.width", "5") == DERMIS_OK);
    CHECK(dermis_scene_set(scene, "grid.width", "6") == DERMIS_OK); /* a key is set again */
    CHECK(dermis_scene_set(scene, "time", "{ step = 0.5, duration = 20 }") == DERMIS_OK);
    REFUSED(dermis_scene_set(scene, "grid.width", "-6"), "grid.width = -6; allowed: whole cells, 1..16384");
    REFUSED(dermis_scene_set(scene, "grid.widht", "6"), "did you mean width?");
    REFUSED(dermis_scene_set(scene, "grid.width=5 #", "6"), "key = \"grid.width=5 #\"");
    REFUSED(dermis_scene_set(scene, "grid.width", "6\n[load]"), "one line");
    REFUSED(dermis_scene_set(scene, "grid.width", NULL), "value = (null)");
    REFUSED(dermis_scene_set(scene, NULL, "6"), "key = (null)");
    REFUSED(dermis_scene_set(NULL, "grid.width", "6"), "scene = (null)");
    CHECK(dermis_scene_get_size(scene, &width, &height) == DERMIS_OK && width == 6); /* as it was */
    dermis_scene_destroy(scene);
    dermis_scene_destroy(NULL);
}

static void files(void) {
    const char* path = "dermis_c_scene.toml";
    FILE* file = fopen(path, "w");
    dermis_scene* scene = NULL;
    int32_t width = 0, height = 0;
    CHECK(file != NULL && fputs(pad, file) >= 0 && fclose(file) == 0);
    CHECK(dermis_scene_from_file(path, &scene) == DERMIS_OK);
    remove(path);
    CHECK(dermis_scene_set(scene, "grid.height", "7") == DERMIS_OK); /* the file has been read once */
    CHECK(dermis_scene_get_size(scene, &width, &height) == DERMIS_OK && width == 4 && height == 7);
    REFUSED(dermis_scene_set(scene, "time.step", "0"), "dermis_c_scene.toml");
    dermis_scene_destroy(scene);
}

static void maps(void) {
    dermis_scene* scene = scene_of("[grid]\nwidth = 2\nheight = 1\n[output]\nprobes = [[0, 0], [1, 0]]\n");
    dermis_result* result = NULL;
    const double pressure[] = {1, 3}, moduli[] = {1.54, 3.08}, heights[] = {0, 1}, bad[] = {1, NAN};
    const double *values = NULL, *other = NULL;
    size_t count = 0;
    CHECK(dermis_scene_set_map(scene, "load.path", pressure, 2) == DERMIS_OK);
    CHECK(dermis_scene_set_map(scene, "material.modulus", moduli, 2) == DERMIS_OK);
    CHECK(dermis_scene_set_map(scene, "surface.path", heights, 2) == DERMIS_OK);
    CHECK(dermis_scene_set(scene, "surface", "{ kind = \"flat\" }") == DERMIS_OK);
    CHECK(dermis_scene_set(scene, "time.step", "0.02") == DERMIS_OK); /* maps stay */
    REFUSED(dermis_scene_set_map(scene, "load.path", pressure, 3), "load.path = 3 cells; allowed: width*height = 2");
    REFUSED(dermis_scene_set_map(scene, "load.path", bad, 2), "load.path = nan in cell [1, 0]");
    REFUSED(dermis_scene_set_map(scene, "load.map", pressure, 2), "key = \"load.map\"; allowed: surface.path");
    REFUSED(dermis_scene_set_map(scene, "load.path", NULL, 2), "values = (null)");
    REFUSED(dermis_scene_set_map(scene, NULL, pressure, 2), "key = (null)");
    REFUSED(dermis_scene_set_map(NULL, "load.path", pressure, 2), "scene = (null)");
    REFUSED(dermis_scene_set(scene, "grid.width", "3"),
            "array of shape (1, 2); allowed: shape (height, width) = (1, 3)");
    CHECK(dermis_run(scene, NULL, &result) == DERMIS_OK);
    CHECK(dermis_result_get_probe(result, DERMIS_STRAIN, 0, &values, &count) == DERMIS_OK && count == 500);
    CHECK(dermis_result_get_probe(result, DERMIS_STRAIN, 1, &other, &count) == DERMIS_OK);
    CHECK(near(values[1], (1 - exp(-0.0308)) / 1.54) && near(other[1], 3 * (1 - exp(-0.0616)) / 3.08));
    dermis_result_destroy(result);

    CHECK(dermis_scene_set(scene, "material.modulus", "1.54") == DERMIS_OK); /* in place of the map */
    CHECK(dermis_run(scene, NULL, &result) == DERMIS_OK);
    CHECK(dermis_result_get_probe(result, DERMIS_STRAIN, 1, &other, &count) == DERMIS_OK);
    CHECK(near(other[1], 3 * (1 - exp(-0.0308)) / 1.54));
    dermis_result_destroy(result);
    dermis_scene_destroy(scene);
}

static const char run_text[] = "[grid]\nwidth = 4\nheight = 3\n[time]\nduration = 1\n[output]\nprobes = [[1, 2]]\n"
                               "traces = [\"strain\", \"fa1\"]\nfields = [{ at = 0.5, what = [\"sa1\"] }]\n";

static void runs(void) {
    dermis_scene* scene = scene_of(run_text);
    dermis_result* result = NULL;
    dermis_report report = {.size = sizeof report};
    const double *times = NULL, *values = NULL;
    size_t count = 0, sites = 1;
    REFUSED(dermis_run(NULL, NULL, &result), "scene = (null)");
    REFUSED(dermis_run(scene, NULL, NULL), "result = (null)");
    CHECK(dermis_run(scene, NULL, &result) == DERMIS_OK);
    dermis_scene_destroy(scene);
    CHECK(dermis_result_get_times(result, &times, &count) == DERMIS_OK && count == 100 && times[99] == 99 * 0.01);
    CHECK(dermis_result_get_trace(result, DERMIS_FA1, DERMIS_MEAN, &values, &count) == DERMIS_OK && count == 100);
    CHECK(values[0] == 0 && values[1] > 0);
    CHECK(dermis_result_get_trace(result, DERMIS_STRAIN, DERMIS_MAX, &values, &count) == DERMIS_OK && count == 100);
    CHECK(dermis_result_get_probe(result, DERMIS_FA1, 0, &values, &count) == DERMIS_OK && count == 100);
    CHECK(dermis_result_get_field(result, DERMIS_SA1, 0.5, &values, &count) == DERMIS_OK && count == CELLS);
    CHECK(dermis_result_get_responses(result, &values, &count, &sites) == DERMIS_OK);
    CHECK(values == NULL && sites == 0 && count == 100);
    CHECK(dermis_result_get_report(result, &report) == DERMIS_OK);
    CHECK(report.strain.value > 0 && report.retardation_time_count == 1 && report.sign_changed == 0);
    CHECK(near(report.retardation_times[0].value, 1 / 1.54));

    REFUSED(dermis_result_get_trace(result, DERMIS_SA1, DERMIS_MEAN, &values, &count), "output.traces has no \"sa1\"");
    CHECK(values == NULL && count == 0);
    REFUSED(dermis_result_get_trace(result, 13, DERMIS_MEAN, &values, &count), "quantity = 13; allowed: DERMIS_STRAIN");
    REFUSED(dermis_result_get_trace(result, DERMIS_INDENTATION, DERMIS_MEAN, &values, &count), "indentation");
    REFUSED(dermis_result_get_trace(result, DERMIS_FA1, 3, &values, &count), "column = 3; allowed: DERMIS_MEAN (0)");
    REFUSED(dermis_result_get_trace(result, DERMIS_FA1, DERMIS_MEAN, NULL, &count), "values = (null)");
    REFUSED(dermis_result_get_trace(NULL, DERMIS_FA1, DERMIS_MEAN, &values, &count), "result = (null)");
    REFUSED(dermis_result_get_probe(result, DERMIS_FA1, 1, &values, &count), "probe = 1; allowed: less than 1");
    REFUSED(dermis_result_get_field(result, DERMIS_SA1, 0.4, &values, &count), "at of sa1 = 0.4; allowed: 0.5");
    REFUSED(dermis_result_get_field(result, DERMIS_FA2, 0.5, &values, &count), "asks for no field of it");
    REFUSED(dermis_result_get_field(result, DERMIS_SA1, NAN, &values, &count), "at of sa1 = nan");
    REFUSED(dermis_result_get_times(result, NULL, &count), "values = (null)");
    REFUSED(dermis_result_get_times(result, &times, NULL), "count = (null)");
    REFUSED(dermis_result_get_responses(result, &values, &count, NULL), "sites = (null)");
    CHECK(isnan(report.fine_load.value)); /* without a spacing */
    report.size = offsetof(dermis_report, fine_load);
    report.fine_load.value = 7;
    CHECK(dermis_result_get_report(result, &report) == DERMIS_OK && report.fine_load.value == 7); /* not touched */
    report.size = 0;
    REFUSED(dermis_result_get_report(result, &report), "report->size = 0; allowed: ");
    REFUSED(dermis_result_get_report(NULL, &report), "result = (null)");
    dermis_result_destroy(result);
    dermis_result_destroy(NULL);
}

static void sites(void) {
    dermis_scene* scene = scene_of(pad);
    dermis_result* result = NULL;
    const double* values = NULL;
    dermis_report report = {.size = sizeof report};
    size_t times = 0, sites = 0;
    CHECK(dermis_scene_set(scene, "grid", "{ width = 40, height = 40, spacing = 1e-4 }") == DERMIS_BAD_INPUT);
    dermis_scene_destroy(scene);
    scene = scene_of("preset = \"fingertip\"\n[sites]\nseed = 3\n[load]\nintensity = 1e4\n[time]\nduration = 0.1\n");
    REFUSED(dermis_scene_set(scene, "receptors.depth", "thumb"), "receptors.depth = 'thumb'; allowed: \"fingertip\"");
    CHECK(dermis_scene_set(scene, "receptors.depth", "fingertip") == DERMIS_OK);
    CHECK(dermis_run(scene, NULL, &result) == DERMIS_OK);
    CHECK(dermis_result_get_responses(result, &values, &times, &sites) == DERMIS_OK);
    CHECK(values != NULL && times == 10 && sites == 245);
    CHECK(dermis_result_get_report(result, &report) == DERMIS_OK && report.fine_load.greatest == 1);
    CHECK(report.fine_load.value > 0 && report.fine_load.value < 1);
    dermis_result_destroy(result);
    dermis_scene_destroy(scene);
}

/* A press of all pads with one step. */
static dermis_status press(dermis_skin* skin, const float* pressure, size_t cells, double dt) {
    return dermis_skin_press(skin, pressure, cells, &dt, 1, NULL);
}

static void presses(void) {
    dermis_skin* skin = skin_of(pad);
    float pressure[CELLS];
    const float *fa1 = NULL, *again = NULL;
    float first[CELLS];
    size_t count = 0, bytes = 0;
    void* state;
    dermis_report report = {.size = sizeof report};
    for (int i = 0; i < CELLS; ++i) pressure[i] = (float)i;
    CHECK(dermis_skin_get_response(skin, DERMIS_FA1, &fa1, &count) == DERMIS_OK && count == CELLS && fa1[5] == 0);
    CHECK(press(skin, pressure, CELLS, 0.01) == DERMIS_OK);
    CHECK(fa1[5] != 0);
    CHECK(dermis_skin_get_state_size(skin, &bytes, NULL) == DERMIS_OK && bytes > 0);
    state = malloc(bytes);
    CHECK(state != NULL && dermis_skin_save(skin, state, bytes, NULL) == DERMIS_OK);
    CHECK(press(skin, pressure, CELLS, 0.01) == DERMIS_OK);
    memcpy(first, fa1, sizeof first);

    /* every refusal leaves the skin as it was */
    REFUSED(press(skin, pressure, CELLS - 1, 0.01), "pressure = 11 cells; allowed: width*height = 12");
    REFUSED(press(skin, NULL, CELLS, 0.01), "pressure = (null)");
    REFUSED(press(skin, pressure, CELLS, -1), "dt = -1");
    REFUSED(press(NULL, pressure, CELLS, 0.01), "skin = (null)");
    REFUSED(dermis_skin_save(skin, state, bytes - 1, NULL), "state = ");
    REFUSED(dermis_skin_save(skin, NULL, bytes, NULL), "state = (null)");
    REFUSED(dermis_skin_load(skin, state, 7, NULL), "state = 7 bytes");
    REFUSED(dermis_skin_load(skin, NULL, bytes, NULL), "state = (null)");
    REFUSED(dermis_skin_load(NULL, state, bytes, NULL), "skin = (null)");
    REFUSED(dermis_skin_get_response(skin, DERMIS_DEFORMATION, &again, &count), "response = \"deformation\"");
    REFUSED(dermis_skin_get_response(skin, 99, &again, &count), "quantity = 99");
    REFUSED(dermis_skin_get_response(skin, DERMIS_FA1, NULL, &count), "values = (null)");
    REFUSED(dermis_skin_get_response(skin, DERMIS_FA1, &again, NULL), "count = (null)");
    REFUSED(dermis_skin_get_response(NULL, DERMIS_FA1, &again, &count), "skin = (null)");
    REFUSED(dermis_skin_get_state_size(skin, NULL, NULL), "bytes = (null)");
    REFUSED(dermis_skin_get_state_size(NULL, &count, NULL), "skin = (null)");
    REFUSED(dermis_skin_save(NULL, state, bytes, NULL), "skin = (null)");
    CHECK(memcmp(first, fa1, sizeof first) == 0);

    CHECK(dermis_skin_load(skin, state, bytes, NULL) == DERMIS_OK);
    CHECK(press(skin, pressure, CELLS, 0.01) == DERMIS_OK);
    CHECK(memcmp(first, fa1, sizeof first) == 0); /* the same once more */
    CHECK(dermis_skin_get_response(skin, DERMIS_FA1, &again, &count) == DERMIS_OK && again == fa1);
    CHECK(dermis_skin_get_report(skin, 0, &report) == DERMIS_OK && report.strain.value > 0);
    CHECK(dermis_skin_reset(skin, NULL) == DERMIS_OK && fa1[5] == 0);
    REFUSED(dermis_skin_reset(NULL, NULL), "skin = (null)");
    REFUSED(dermis_skin_get_report(NULL, 0, &report), "skin = (null)");
    report.size = 1;
    REFUSED(dermis_skin_get_report(skin, 0, &report), "report->size = 1");
    REFUSED(dermis_skin_get_report(skin, 0, NULL), "report = (null)");
    free(state);
    dermis_skin_destroy(skin);
    dermis_skin_destroy(NULL);
}

static void materials(void) {
    dermis_skin* skin = skin_of(pad);
    dermis_scene* scene = scene_of(pad);
    dermis_report after = {.size = sizeof after};
    CHECK(dermis_scene_set(scene, "material.modulus", "50") == DERMIS_OK);
    CHECK(dermis_skin_set_material(skin, scene, NULL) == DERMIS_OK);
    CHECK(dermis_scene_set(scene, "material",
                           "{ elements = [{ modulus = 1, viscosity = 1 }, { modulus = 2, viscosity = 1 }] }") ==
          DERMIS_OK);
    REFUSED(dermis_skin_set_material(skin, scene, NULL), "material.elements = 2 and no spring; allowed: 1");
    REFUSED(dermis_skin_set_material(skin, NULL, NULL), "scene = (null)");
    REFUSED(dermis_skin_set_material(NULL, scene, NULL), "skin = (null)");
    CHECK(dermis_skin_get_report(skin, 0, &after) == DERMIS_OK && after.retardation_times[0].value == 1.0 / 50);
    dermis_skin_destroy(skin);
    dermis_scene_destroy(scene);
}

static void options(void) {
    dermis_scene* scene = scene_of(pad);
    dermis_skin* skin = NULL;
    const float* values = NULL;
    size_t count = 0;
    dermis_skin_options o = {.size = sizeof o, .count = 1};
    CHECK(dermis_skin_create(on, scene, &o, &skin) == DERMIS_OK);
    CHECK(dermis_skin_get_response(skin, DERMIS_FA2, &values, &count) == DERMIS_OK); /* all four */
    dermis_skin_destroy(skin);
    o.responses = DERMIS_BIT(DERMIS_SA1) | DERMIS_BIT(DERMIS_FA1);
    o.precision = DERMIS_F32_COMPENSATED;
    CHECK(dermis_skin_create(on, scene, &o, &skin) == DERMIS_OK);
    CHECK(dermis_skin_get_response(skin, DERMIS_SA1, &values, &count) == DERMIS_OK);
    REFUSED(dermis_skin_get_response(skin, DERMIS_FA2, &values, &count), "response = \"fa2\"");
    CHECK(values == NULL && count == 0);
    dermis_skin_destroy(skin);

    o.precision = 9;
    REFUSED(dermis_skin_create(on, scene, &o, &skin), "options->precision = 9");
    o.precision = DERMIS_F32;
    o.responses = DERMIS_BIT(DERMIS_STRAIN);
    REFUSED(dermis_skin_create(on, scene, &o, &skin), "options->responses = 1; allowed: bits of sa1, sa2, fa1, fa2");
    o.responses = 0;
    o.count = INT32_MAX;
    REFUSED(dermis_skin_create(on, scene, &o, &skin), "options->count = ");
    o.count = 1048576;
    CHECK(dermis_scene_set(scene, "grid.width", "1024") == DERMIS_OK);
    REFUSED(dermis_skin_create(on, scene, &o, &skin), "count = 1048576; allowed: count*width*height up to");
    o.count = 1;
    o.materials = 2;
    REFUSED(dermis_skin_create(on, scene, &o, &skin), "options->materials = 2; allowed: 0, 1");
    o.materials = 0;
    o.hold = 2;
    REFUSED(dermis_skin_create(on, scene, &o, &skin),
            "options->hold = 2; allowed: DERMIS_LINEAR (0), DERMIS_PARABOLIC (1)");
    o.hold = DERMIS_LINEAR;
    o.control = 2;
    REFUSED(dermis_skin_create(on, scene, &o, &skin),
            "options->control = 2; allowed: DERMIS_PRESSURE (0), DERMIS_DEPTH (1)");
    o.size = 0;
    REFUSED(dermis_skin_create(on, scene, &o, &skin), "options->size = 0; allowed: ");
    CHECK(skin == NULL);
    o.size = sizeof o;
    o.control = DERMIS_DEPTH;
    CHECK(dermis_scene_set(scene, "grid.width", "4") == DERMIS_OK);
    CHECK(dermis_skin_create(on, scene, &o, &skin) == DERMIS_OK);
    REFUSED(dermis_skin_set_material(skin, scene, NULL), "material = (given)");
    dermis_skin_destroy(skin);
    REFUSED(dermis_skin_create(NULL, NULL, NULL, &skin), "scene = (null)");
    REFUSED(dermis_skin_create(on, scene, NULL, NULL), "skin = (null)");
    dermis_scene_destroy(scene);
}

static void spikes_of_a_run(void) {
    dermis_scene* scene =
        scene_of("[[afferents]]\ntype = \"fa1\"\ncells = [[75, 75], [70, 75]]\ngains = [[20, 0]]\n"
                 "[load]\nintensity = 5\n[time]\nstep = 0.001\nduration = 0.2\n[output]\nextremes = false\n");
    dermis_result* result = NULL;
    const dermis_fired_spike* fired = NULL;
    const double* values = NULL;
    size_t count = 0;
    CHECK(dermis_run(scene, NULL, &result) == DERMIS_OK);
    dermis_scene_destroy(scene);
    CHECK(dermis_result_get_spikes(result, &fired, &count) == DERMIS_OK && count > 1);
    for (size_t i = 0; i < count; ++i) {
        CHECK(fired[i].time > 0 && fired[i].time <= 0.2 && fired[i].afferent >= 0 && fired[i].afferent < 2);
        CHECK(i == 0 || fired[i].time >= fired[i - 1].time);
    }
    REFUSED(dermis_result_get_trace(result, DERMIS_SA1, DERMIS_MAX, &values, &count),
            "column = 2; allowed: DERMIS_MEAN (0), without output.extremes");
    REFUSED(dermis_result_get_spikes(result, NULL, &count), "spikes = (null)");
    REFUSED(dermis_result_get_spikes(result, &fired, NULL), "count = (null)");
    REFUSED(dermis_result_get_spikes(NULL, &fired, &count), "result = (null)");
    dermis_result_destroy(result);
}

static void spikes(void) {
    dermis_skin* skin = skin_of(pad);
    const float pressure[CELLS] = {1};
    const dermis_spike one = {0, 0, 0, 1}, *fired = &one;
    size_t count = 1;
    CHECK(dermis_skin_get_spikes(skin, &fired, &count) == DERMIS_OK && count == 0);
    count = 1;
    CHECK(press(skin, pressure, CELLS, 0.01) == DERMIS_OK);
    CHECK(dermis_skin_get_spikes(skin, &fired, &count) == DERMIS_OK && count == 0); /* the scene has no afferents */
    REFUSED(dermis_skin_get_spikes(skin, NULL, &count), "spikes = (null)");
    fired = &one;
    REFUSED(dermis_skin_get_spikes(skin, &fired, NULL), "count = (null)");
    CHECK(fired == NULL);
    fired = &one;
    count = 1;
    REFUSED(dermis_skin_get_spikes(NULL, &fired, &count), "skin = (null)");
    CHECK(fired == NULL && count == 0);
    dermis_skin_destroy(skin);
    skin =
        skin_of("[grid]\nwidth = 4\nheight = 3\n[[afferents]]\ntype = \"sa1\"\ncells = [[0, 0]]\ngains = [[1e3, 0]]\n");
    CHECK(press(skin, pressure, CELLS, 0.2) == DERMIS_OK);
    CHECK(dermis_skin_get_spikes(skin, &fired, &count) == DERMIS_OK && count > 0 && fired->share > 0);
    dermis_skin_destroy(skin);
}

/* Three pads with materials of their own. */
static dermis_skin* batch(void) {
    dermis_scene* scene = scene_of(pad);
    dermis_skin* skin = NULL;
    const dermis_skin_options o = {.size = sizeof o, .count = 3, .materials = 1};
    CHECK(dermis_skin_create(on, scene, &o, &skin) == DERMIS_OK);
    dermis_scene_destroy(scene);
    return skin;
}

/* The first device's answers are those of the second one, bit for bit. */
static void batches(int device) {
    static float answers[3 * CELLS];
    dermis_skin* skin = batch();
    const int32_t numbers[] = {2, 0}, twice[] = {1, 1};
    const dermis_pads two = {numbers, 2}, none = {NULL, 0};
    const double dt[] = {0.01, 0.02, 0.03};
    float pressure[3 * CELLS], first[3 * CELLS];
    const float *sa1 = NULL, *strain = NULL;
    const int32_t* cells = NULL;
    size_t count = 0, all = 0, some = 0;
    void* state;
    dermis_report report = {.size = sizeof report};
    for (int i = 0; i < 3 * CELLS; ++i) pressure[i] = (float)(1 + i);
    CHECK(dermis_skin_get_response(skin, DERMIS_SA1, &sa1, &count) == DERMIS_OK && count == 3 * CELLS);
    CHECK(dermis_skin_press(skin, pressure, 2 * CELLS, dt, 2, &two) == DERMIS_OK);
    CHECK(sa1[0] != 0 && sa1[CELLS] == 0 && sa1[2 * CELLS] != 0); /* pad 1 is as it was */
    CHECK(dermis_skin_press(skin, pressure, 3 * CELLS, dt, 3, NULL) == DERMIS_OK && sa1[CELLS] != 0);
    CHECK(dermis_skin_get_state_size(skin, &all, NULL) == DERMIS_OK);
    CHECK(dermis_skin_get_state_size(skin, &some, &two) == DERMIS_OK && some < all);
    state = malloc(some);
    CHECK(state != NULL && dermis_skin_save(skin, state, some, &two) == DERMIS_OK);
    CHECK(dermis_skin_press(skin, pressure, 2 * CELLS, dt, 1, &two) == DERMIS_OK);
    memcpy(first, sa1, sizeof first);
    if (device == 0) memcpy(answers, sa1, sizeof answers);
    CHECK(memcmp(answers, sa1, sizeof answers) == 0);

    CHECK(dermis_skin_load(skin, state, some, &two) == DERMIS_OK);
    CHECK(dermis_skin_press_frames(skin, pressure, 1, 2 * CELLS, dt[0], &two) == DERMIS_OK);
    CHECK(memcmp(first, sa1, sizeof first) == 0); /* a press is a press of one frame */
    CHECK(dermis_skin_get_cells(skin, &cells, &count) == DERMIS_OK && count == CELLS && cells[CELLS - 1] == CELLS - 1);
    CHECK(dermis_skin_load(skin, state, some, &two) == DERMIS_OK);
    CHECK(dermis_skin_press_cells(skin, pressure, 2 * count, dt[0], &two) == DERMIS_OK);
    CHECK(memcmp(first, sa1, sizeof first) == 0); /* without sites all cells are listed */
    REFUSED(dermis_skin_press_cells(skin, pressure, count, dt[0], &two), "pressure = 12 cells; allowed: 2 pads of");

    /* every refusal leaves the skin as it was, and an empty list changes nothing */
    REFUSED(dermis_skin_press(skin, pressure, 3 * CELLS, dt, 1, &two), "pressure = 36 cells; allowed: 2 pads of");
    REFUSED(dermis_skin_press(skin, pressure, 3 * CELLS, dt, 0, NULL), "dt = 0 steps; allowed: 3");
    REFUSED(dermis_skin_press_frames(skin, pressure, 0, 2 * CELLS, dt[0], &two),
            "count = 0; allowed: at least 1 frame");
    REFUSED(dermis_skin_press_frames(skin, NULL, 1, 2 * CELLS, dt[0], &two), "frames = (null)");
    REFUSED(dermis_skin_press(skin, pressure, 2 * CELLS, NULL, 2, &two), "dt = (null)");
    REFUSED(dermis_skin_press(skin, pressure, 2 * CELLS, dt, 1, &(dermis_pads){NULL, 2}), "pads->numbers = (null)");
    REFUSED(dermis_skin_press(skin, pressure, 2 * CELLS, dt, 1, &(dermis_pads){twice, 2}),
            "pads = 1 at position 1; allowed: 0..2, each at most once");
    REFUSED(dermis_skin_reset(skin, &(dermis_pads){twice, 2}), "pads = 1 at position 1");
    REFUSED(dermis_skin_get_state_size(skin, &all, &(dermis_pads){twice, 2}), "pads = 1");
    CHECK(all == 0);
    REFUSED(dermis_skin_save(skin, state, some, NULL), "state = ");
    REFUSED(dermis_skin_load(skin, state, some, NULL), "number of pads 2");
    REFUSED(dermis_skin_get_report(skin, 3, &report), "pad = 3; allowed: 0..2");
    CHECK(dermis_skin_press(skin, NULL, 0, dt, 1, &none) == DERMIS_OK);
    CHECK(dermis_skin_press(skin, NULL, 0, NULL, 0, &none) == DERMIS_OK);
    CHECK(dermis_skin_reset(skin, &none) == DERMIS_OK);
    CHECK(memcmp(first, sa1, sizeof first) == 0);

    CHECK(dermis_skin_load(skin, state, some, &two) == DERMIS_OK);
    CHECK(dermis_skin_press(skin, pressure, 2 * CELLS, dt, 1, &two) == DERMIS_OK);
    CHECK(memcmp(first, sa1, sizeof first) == 0); /* the same once more */
    CHECK(dermis_skin_reset(skin, &two) == DERMIS_OK);
    CHECK(dermis_skin_get_response(skin, DERMIS_STRAIN, &strain, &count) == DERMIS_OK && count == 3 * CELLS);
    CHECK(strain[0] == 0 && strain[CELLS] != 0 && strain[2 * CELLS] == 0);
    CHECK(dermis_skin_get_response(skin, DERMIS_INDENTATION, &strain, &count) == DERMIS_OK && count == 3 * CELLS);
    CHECK(dermis_skin_get_report(skin, 0, &report) == DERMIS_OK && report.strain.value == 0);
    CHECK(dermis_skin_get_report(skin, 1, &report) == DERMIS_OK && report.strain.value > 0);
    free(state);
    dermis_skin_destroy(skin);
}

static void materials_of_pads(void) {
    dermis_skin *skin = batch(), *shared = NULL;
    dermis_scene* scene = scene_of(pad);
    const int32_t second = 1;
    const dermis_pads one = {&second, 1};
    double moduli[CELLS];
    dermis_report report = {.size = sizeof report};
    dermis_skin_options o = {.size = sizeof o, .count = 3};
    CHECK(dermis_skin_create(on, scene, &o, &shared) == DERMIS_OK);
    CHECK(dermis_scene_set(scene, "material.modulus", "50") == DERMIS_OK);
    CHECK(dermis_skin_set_material(skin, scene, &one) == DERMIS_OK);
    CHECK(dermis_skin_get_report(skin, 0, &report) == DERMIS_OK && report.retardation_times[0].value == 1.0 / 2);
    CHECK(dermis_skin_get_report(skin, 1, &report) == DERMIS_OK && report.retardation_times[0].value == 1.0 / 50);
    REFUSED(dermis_skin_set_material(shared, scene, &one), "pads = 1 of 3; allowed: all");
    CHECK(dermis_skin_set_material(shared, scene, NULL) == DERMIS_OK);
    CHECK(dermis_skin_get_report(shared, 2, &report) == DERMIS_OK && report.retardation_times[0].value == 1.0 / 50);

    for (int i = 0; i < CELLS; ++i) moduli[i] = 1 + i;
    CHECK(dermis_scene_set_map(scene, "material.modulus", moduli, CELLS) == DERMIS_OK);
    REFUSED(dermis_skin_set_material(skin, scene, &one), "material = (a map); allowed: numbers");
    dermis_skin_destroy(shared);
    o.materials = 1;
    REFUSED(dermis_skin_create(on, scene, &o, &shared), "options->materials = 1; allowed: 0, where the scene's");
    o.materials = 0;
    CHECK(dermis_skin_create(on, scene, &o, &shared) == DERMIS_OK);
    REFUSED(dermis_skin_set_material(shared, scene, NULL), "the skin has a material of maps");
    dermis_skin_destroy(shared);
    dermis_skin_destroy(skin);
    dermis_scene_destroy(scene);
}

int main(void) {
    versions_and_errors();
    devices();
    scenes();
    files();
    maps();
    runs();
    sites();
    for (int device = 0; device < 2; ++device) {
        if (device == 1) CHECK(dermis_device_open("vulkan", &on) == DERMIS_OK);
        presses();
        materials();
        options();
        spikes();
        spikes_of_a_run();
        batches(device);
        materials_of_pads();
    }
    dermis_device_close(on);
    puts("passed");
    return 0;
}
