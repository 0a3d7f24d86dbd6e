/* SPDX-License-Identifier: MIT */
/* Contacts as a C program adds them to a pad's pressures: what they add up to, and every misuse that can be seen. */
#include "check.h"

#define CELLS 12 /* of the pad, 4 x 3 */

static void contacts(void) {
    float pressure[CELLS] = {0}, before[CELLS];
    dermis_contact_pad on = {.size = sizeof on, .width = 4, .height = 3, .spacing = 1e-3, .pressure = pressure};
    dermis_contact some[] = {{.x = 2e-3, .y = 1.5e-3, .force = 0.01, .radius = 2e-3}, {.x = 1, .force = 0.5}};
    dermis_contact_report report = {.size = sizeof report};
    char text[400] = "-";
    CHECK(dermis_add_contacts(&on, some, 2, &report) == DERMIS_OK);
    CHECK(near(report.asked, 0.51) && near(report.placed + report.outside, 0.51) && report.beside == 1);
    CHECK(report.cells > 4 && report.below_cell == 0 && report.plausible == 0 && report.greatest > pressure[0]);
    CHECK(dermis_contact_report_get_doubts(&report, text, sizeof text) == DERMIS_OK);
    CHECK(strstr(text, "0.02 of the force presses the pad, 0.98 is outside: 1 beside, else over the border.") == text);
    memcpy(before, pressure, sizeof before);

    /* every refusal leaves pressures and report as they were */
    some[1].radius = -1;
    REFUSED(dermis_add_contacts(&on, some, 2, &report), "contacts[1].radius = -1; allowed: 0..1e6");
    REFUSED(dermis_add_contacts(&on, NULL, 2, &report), "contacts = (null)");
    REFUSED(dermis_add_contacts(&on, some, 1, NULL), "report = (null)");
    REFUSED(dermis_add_contacts(NULL, some, 1, &report), "pad = (null)");
    on.size = 1;
    REFUSED(dermis_add_contacts(&on, some, 1, &report), "pad->size = 1");
    on.size = sizeof on;
    CHECK(memcmp(before, pressure, sizeof before) == 0 && near(report.asked, 0.51));
    CHECK(dermis_add_contacts(&on, NULL, 0, &report) == DERMIS_OK && report.asked == 0 && report.plausible == 1);
    CHECK(dermis_contact_report_get_doubts(&report, text, 1) == DERMIS_OK && strcmp(text, "") == 0);
    report.size = 0;
    REFUSED(dermis_add_contacts(&on, some, 1, &report), "report->size = 0");
    report.size = sizeof report;

    some[0].force = 10;
    some[0].radius = 1e-6;
    CHECK(dermis_add_contacts(&on, some, 1, &report) == DERMIS_OK && report.below_cell == 1 && report.plausible == 0);
    REFUSED(dermis_contact_report_get_doubts(&report, text, 10), "size = 10; allowed: ");
    REFUSED(dermis_contact_report_get_doubts(&report, NULL, 10), "text = (null)");
    REFUSED(dermis_contact_report_get_doubts(NULL, text, sizeof text), "report = (null)");
    CHECK(strcmp(text, "") == 0);
    report.below_cell = report.beside = report.too_far = report.turned_away = INT32_MAX; /* the longest text */
    report.placed = report.outside = report.sideways = 0.01 * report.asked;
    report.greatest = 1.23456789e+38;
    CHECK(dermis_contact_report_get_doubts(&report, text, sizeof text) == DERMIS_OK);
    CHECK(strstr(text, "2147483647 patches press") != NULL && strstr(text, "1.23456789e+38 Pa") != NULL);
    CHECK(strstr(text, "0.97 is lost to rounding") != NULL && strstr(text, "2147483647 turned away") != NULL);
}

/* Two pads side by side share a patch, and a pad keeps all of it. A program of the first version knows no `tiled`. */
static void tiled_pads(void) {
    float left[CELLS] = {0}, right[CELLS] = {0};
    dermis_contact_pad on = {.size = sizeof on, .width = 4, .height = 3, .spacing = 1e-3, .pressure = left};
    dermis_contact shared = {.x = 4e-3, .y = 1.5e-3, .force = 0.02, .radius = 1.4e-3};
    dermis_contact_report first = {.size = sizeof first}, second = {.size = sizeof second};
    on.tiled = 1;
    CHECK(dermis_add_contacts(&on, &shared, 1, &first) == DERMIS_OK && first.plausible == 1 && first.outside == 0);
    on.pressure = right;
    shared.x = 0;
    CHECK(dermis_add_contacts(&on, &shared, 1, &second) == DERMIS_OK && second.plausible == 1);
    CHECK(near(first.asked + second.asked, 0.02) && near(first.placed + second.placed, 0.02));
    on.size = offsetof(dermis_contact_pad, tiled);
    CHECK(dermis_add_contacts(&on, &shared, 1, &second) == DERMIS_OK && second.plausible == 0);
    CHECK(near(second.asked, 0.02) && near(second.outside, 0.02 - second.placed));
    on.size = sizeof on;
    on.tiled = 2;
    REFUSED(dermis_add_contacts(&on, &shared, 1, &second), "pad->tiled = 2; allowed: 0, 1");
    on.tiled = 0;
    on.keep = 1;
    CHECK(dermis_add_contacts(&on, &shared, 1, &second) == DERMIS_OK && near(second.placed, 0.02));
    on.keep = 2;
    REFUSED(dermis_add_contacts(&on, &shared, 1, &second), "pad->keep = 2; allowed: 0, 1");
}

/* A contact on the side of a ball presses the pad that has the ball's radii. A program of the second version knows
 * none. */
static void round_pads(void) {
    float pressure[1600] = {0};
    dermis_contact_pad on = {.size = sizeof on, .width = 40, .height = 40, .spacing = 5e-4, .pressure = pressure};
    const dermis_pose pose = {.rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    dermis_contact_report report = {.size = sizeof report};
    /* at 60 degrees of a ball of 8 mm */
    const dermis_world_contact side = {.position = {10e-3 + 8e-3 * 0.8660254037844386, 10e-3, -4e-3},
                                       .force = 1,
                                       .radius = 1e-3,
                                       .direction = {-0.8660254037844386, 0, -0.5}};
    on.radius_x = on.radius_y = 8e-3;
    CHECK(dermis_add_contacts_world(&on, &pose, 1e-3, &side, 1, &report) == DERMIS_OK);
    CHECK(near(report.placed, 1) && report.plausible == 1);
    REFUSED(dermis_add_contacts_world(&on, &pose, 8e-3, &side, 1, &report), "reach = 0.008; allowed: below the pad's");
    on.size = offsetof(dermis_contact_pad, radius_x);
    CHECK(dermis_add_contacts_world(&on, &pose, 1e-3, &side, 1, &report) == DERMIS_OK && report.too_far == 1);
    on.size = sizeof on;
    CHECK(near(report.outside, 1));
}

/* Contacts of two pads from one table press the skin as its pressures do, and a table that is wrong is refused. */
static void contacts_of_a_batch(void) {
    const dermis_contact_pad shape = {
        .size = sizeof shape, .width = 24, .height = 24, .spacing = 5e-4, .radius_x = 8e-3, .radius_y = 8e-3};
    const double middles[6] = {0, 0, 0, 0.1, 0, 0};
    const double axes[18] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const dermis_poses poses = {.position = middles, .rotation = axes, .position_step = 3, .rotation_step = 9};
    /* the place of a contact, its force and the radius of its patch */
    double table[2][7] = {{0.1, 0, 0, 0.05, 0, -0.2, 1e-3}, {0, 0, 0, 0, 0, 0, 1e-3}};
    const int32_t pads[2] = {1, 0};
    dermis_contacts contacts = {.size = sizeof contacts,
                                .count = 2,
                                .pad = pads,
                                .position = table[0],
                                .force = table[0] + 3,
                                .radius = table[0] + 6,
                                .pad_step = 1,
                                .position_step = 7,
                                .force_step = 7,
                                .radius_step = 7};
    dermis_contact_report report = {.size = sizeof report}, old = {.size = offsetof(dermis_contact_report, shear_x)};
    dermis_touch* touch = NULL;
    const float* pressure = NULL;
    size_t numbers = 0;
    REFUSED(dermis_touch_create(&shape, 0, 1e-3, 0, &touch), "count = 0; allowed: 1..1048576");
    REFUSED(dermis_touch_create(&shape, 2, 1e-3, 2, &touch), "shear = 2; allowed: 0, 1");
    REFUSED(dermis_touch_create(NULL, 2, 1e-3, 0, &touch), "shape = (null)");
    CHECK(dermis_touch_create(&shape, 2, 1e-3, 0, &touch) == DERMIS_OK);
    CHECK(dermis_touch_get_pressure(touch, &pressure, NULL, &numbers) == DERMIS_OK && numbers == 1152);
    CHECK(dermis_touch_add(touch, &poses, &contacts, &report) == DERMIS_OK);
    CHECK(near(report.placed, 0.2) && near(report.shear_x, 0.05) && report.plausible == 1);
    CHECK(pressure[12 * 24 + 12] == 0 && pressure[576 + 12 * 24 + 12] > 0);
    old.shear_x = 7;
    CHECK(dermis_touch_get_report(touch, 1, &old) == DERMIS_OK && near(old.placed, 0.2) && old.shear_x == 7);
    REFUSED(dermis_touch_get_report(touch, 2, &report), "pad = 2; allowed: 0..1");
    contacts.radius = NULL;
    REFUSED(dermis_touch_add(touch, &poses, &contacts, &report), "contacts.ball = null; allowed: an address");
    REFUSED(dermis_touch_add(touch, NULL, &contacts, &report), "poses = (null)");

    dermis_scene* scene = NULL;
    dermis_skin* skin = NULL;
    const dermis_skin_options options = {.size = sizeof options, .count = 2};
    const float* sa1 = NULL;
    size_t count = 0;
    CHECK(dermis_scene_from_string("[grid]\nwidth = 24\nheight = 24\n[surface]\nkind = \"flat\"\n", ".", &scene) ==
          DERMIS_OK);
    CHECK(dermis_skin_create(NULL, scene, &options, &skin) == DERMIS_OK);
    CHECK(dermis_skin_press_touch(skin, touch, 1e-3) == DERMIS_OK);
    CHECK(dermis_skin_get_response(skin, DERMIS_SA1, &sa1, &count) == DERMIS_OK);
    CHECK(count == 1152 && sa1[12 * 24 + 12] == 0 && sa1[576 + 12 * 24 + 12] != 0);
    REFUSED(dermis_skin_press_touch(skin, NULL, 1e-3), "touch = (null)");
    dermis_skin_destroy(skin);
    dermis_scene_destroy(scene);
    dermis_touch_destroy(touch);
    dermis_touch_destroy(NULL);
}

/* A skin with shear takes tractions beside pressures, or the ones of a touch. */
static void shear(void) {
    const dermis_contact_pad shape = {.size = sizeof shape, .width = 8, .height = 6, .spacing = 1e-3};
    const double middle[3] = {0, 0, 0}, axes[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const dermis_poses poses = {.position = middle, .rotation = axes};
    const double place[3] = {0, 0, 0}, force[3] = {0.1, -0.05, -0.3}, radius = 2e-3;
    const int32_t pad = 0;
    const dermis_contacts contacts = {
        .size = sizeof contacts, .count = 1, .pad = &pad, .position = place, .force = force, .radius = &radius};
    dermis_contact_report report = {.size = sizeof report};
    dermis_touch* touch = NULL;
    dermis_scene* scene = NULL;
    dermis_skin *by_touch = NULL, *by_maps = NULL;
    dermis_skin_options options = {.size = sizeof options, .count = 1, .shear = 2};
    const float *pressure = NULL, *traction = NULL, *a = NULL, *b = NULL;
    size_t numbers = 0, count = 0;
    CHECK(dermis_touch_create(&shape, 1, 1e-3, 1, &touch) == DERMIS_OK);
    CHECK(dermis_touch_add(touch, &poses, &contacts, &report) == DERMIS_OK && near(report.shear_y, -0.05));
    CHECK(dermis_touch_get_pressure(touch, &pressure, &traction, &numbers) == DERMIS_OK && numbers == 48 && traction);
    CHECK(dermis_scene_from_string("[grid]\nwidth = 8\nheight = 6\n[surface]\nkind = \"flat\"\n", ".", &scene) ==
          DERMIS_OK);
    REFUSED(dermis_skin_create(NULL, scene, &options, &by_touch), "options->shear = 2; allowed: 0, 1");
    options.shear = 1;
    CHECK(dermis_skin_create(NULL, scene, &options, &by_touch) == DERMIS_OK);
    options.sa2_stretch = 2;
    REFUSED(dermis_skin_create(NULL, scene, &options, &by_maps), "options->sa2_stretch = 2; allowed: 0, 1");
    options.sa2_stretch = 1;
    CHECK(dermis_skin_create(NULL, scene, &options, &by_maps) == DERMIS_OK);
    CHECK(dermis_skin_press_touch(by_touch, touch, 0.1) == DERMIS_OK);
    CHECK(dermis_skin_press_tractions(by_maps, pressure, traction, numbers, 0.1, NULL) == DERMIS_OK);
    REFUSED(dermis_skin_press_tractions(by_maps, pressure, NULL, numbers, 0.1, NULL), "traction = (null)");
    CHECK(dermis_skin_get_response(by_touch, DERMIS_SHEAR_X, &a, &count) == DERMIS_OK);
    CHECK(dermis_skin_get_response(by_maps, DERMIS_SHEAR_X, &b, &count) == DERMIS_OK);
    CHECK(count == 48 && memcmp(a, b, count * sizeof *a) == 0 && a[2 * 8 + 4] > 0);
    CHECK(dermis_skin_get_response(by_maps, DERMIS_SHEAR_Y, &b, &count) == DERMIS_OK && b[2 * 8 + 4] < 0);
    CHECK(dermis_skin_get_response(by_maps, DERMIS_STRETCH_XY, &b, &count) == DERMIS_OK && count == 48);
    CHECK(dermis_skin_get_response(by_maps, DERMIS_SA2, &b, &count) == DERMIS_OK && b[2 * 8 + 1] > 0);
    REFUSED(dermis_skin_get_response(by_maps, 13, &b, &count), "quantity = 13");
    dermis_skin_destroy(by_touch), dermis_skin_destroy(by_maps);
    options.size = offsetof(dermis_skin_options, shear);
    CHECK(dermis_skin_create(NULL, scene, &options, &by_touch) == DERMIS_OK);
    REFUSED(dermis_skin_get_response(by_touch, DERMIS_SHEAR_X, &a, &count), "response = \"shear_x\"");
    dermis_skin_destroy(by_touch);
    dermis_scene_destroy(scene);
    dermis_touch_destroy(touch);
}

static void contacts_of_the_world(void) {
    float pressure[CELLS] = {0}, local[CELLS] = {0};
    const dermis_contact_pad on = {.size = sizeof on, .width = 4, .height = 3, .spacing = 1e-3, .pressure = pressure};
    const dermis_contact_pad alone = {.size = sizeof on, .width = 4, .height = 3, .spacing = 1e-3, .pressure = local};
    /* The pad lies a quarter turn about z in the world: its x is the world's y. */
    const double middle[] = {1, 2, 3}, turn[] = {1, 0, 0, 1}, no_turn[] = {0, 0, 0, 0};
    const dermis_contact same = {.x = 1.5e-3, .y = 1e-3, .force = 0.01, .radius = 1.4e-3};
    dermis_world_contact some[] = {
        {.position = {1 + 0.5e-3, 2 - 0.5e-3, 3}, .direction = {0, 0, -2}, .force = 0.01, .radius = 1.4e-3},
        {.position = {1, 2, 3.1}, .force = 0.02, .radius = 1e-3},
        {.position = {1, 2, 3}, .direction = {0, 0, 1}, .force = 0.04, .radius = 1e-3},
        {.position = {1, 2, 3}, .direction = {1, 0, -1}, .force = 0, .radius = 1e-3},
    };
    dermis_contact_report report = {.size = sizeof report};
    dermis_pose pose;
    CHECK(dermis_pose_from_quaternion(middle, turn, &pose) == DERMIS_OK && pose.position[2] == 3);
    CHECK(near(pose.rotation[1], -1) && near(pose.rotation[3], 1) && fabs(pose.rotation[0]) < 1e-12);
    CHECK(dermis_pose_from_middle(&pose, &on) == DERMIS_OK);
    CHECK(fabs(pose.position[0] - (1 + 1.5e-3)) < 1e-12 && fabs(pose.position[1] - (2 - 2e-3)) < 1e-12);
    CHECK(dermis_add_contacts_world(&on, &pose, 1e-3, some, 4, &report) == DERMIS_OK);
    CHECK(near(report.asked, 0.07) && report.too_far == 1 && report.turned_away == 1 && report.sideways == 0);
    CHECK(near(report.asked, report.placed + report.outside + report.sideways));
    CHECK(dermis_add_contacts(&alone, &same, 1, &report) == DERMIS_OK && report.sideways == 0);
    for (int i = 0; i < CELLS; ++i) CHECK(fabs(pressure[i] - local[i]) <= 1e-3 * fabs(local[i]));
    some[0].direction[0] = 2; /* 45 degrees */
    CHECK(dermis_add_contacts_world(&on, &pose, 1e-3, some, 1, &report) == DERMIS_OK);
    CHECK(near(report.sideways, 0.01 * (1 - sqrt(0.5))));

    memcpy(local, pressure, sizeof local);
    REFUSED(dermis_add_contacts_world(&on, NULL, 1e-3, some, 1, &report), "pose = (null)");
    REFUSED(dermis_add_contacts_world(&on, &pose, 1e-3, NULL, 1, &report), "contacts = (null)");
    REFUSED(dermis_add_contacts_world(NULL, &pose, 1e-3, some, 1, &report), "pad = (null)");
    REFUSED(dermis_add_contacts_world(&on, &pose, 1e-3, some, 1, NULL), "report = (null)");
    CHECK(memcmp(local, pressure, sizeof local) == 0);
    REFUSED(dermis_pose_from_quaternion(middle, no_turn, &pose), "|quaternion|^2 = 0; allowed: 1e-300..1e300");
    REFUSED(dermis_pose_from_quaternion(NULL, turn, &pose), "position = (null)");
    REFUSED(dermis_pose_from_quaternion(middle, NULL, &pose), "quaternion = (null)");
    REFUSED(dermis_pose_from_quaternion(middle, turn, NULL), "pose = (null)");
    REFUSED(dermis_pose_from_middle(NULL, &on), "pose = (null)");
    REFUSED(dermis_pose_from_middle(&pose, NULL), "pad = (null)");
}

/* A ball above the middle of a pad is as deep there as it was put, and a body that is none is refused. */
static void bodies(void) {
    float pressure[12] = {0}, depth[12];
    const dermis_contact_pad on = {.size = sizeof on, .width = 4, .height = 3, .spacing = 1e-3, .pressure = pressure};
    dermis_pose pose = {.rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    dermis_body ball = {.size = sizeof ball, .kind = DERMIS_SPHERE, .extent = {5e-3}, .pose = pose};
    ball.pose.position[2] = 4.9e-3;
    ball.pose.position[0] = 0.5e-3;
    CHECK(dermis_pose_from_middle(&pose, &on) == DERMIS_OK);
    CHECK(dermis_fill_depths(&on, &pose, &ball, depth, 0) == DERMIS_OK && fabs(depth[1 * 4 + 2] - 1e-4) < 1e-9);
    ball.kind = DERMIS_BOX;
    REFUSED(dermis_fill_depths(&on, &pose, &ball, depth, 0), "body.size[1] = 0; allowed: above 0");
    ball.kind = 6;
    REFUSED(dermis_fill_depths(&on, &pose, &ball, depth, 0),
            "body->kind = 6; allowed: DERMIS_SPHERE (0) .. DERMIS_ELLIPSOID");
    REFUSED(dermis_fill_depths(&on, &pose, NULL, depth, 0), "body = (null)");
    REFUSED(dermis_fill_depths(&on, NULL, &ball, depth, 0), "body->kind = 6");
}

static void depths_and_taxels(void) {
    float pressure[CELLS] = {0}, depth[CELLS] = {0}, values[] = {0.1f, 0, 0, 0.3f};
    const dermis_contact_pad on = {.size = sizeof on, .width = 4, .height = 3, .spacing = 1e-3, .pressure = pressure};
    dermis_depths depths = {.size = sizeof depths, .depth = depth, .force = 0.02};
    dermis_taxels taxels = {.size = sizeof taxels, .values = values, .columns = 2, .rows = 2, .width = 2e-3};
    dermis_contact_report report = {.size = sizeof report};
    depth[5] = 1e-3f;
    depth[6] = 3e-3f;
    CHECK(dermis_add_depths(&on, &depths, &report) == DERMIS_OK && near(report.placed, 0.02) && report.cells == 2);
    CHECK(near(pressure[5], 5e3) && near(pressure[6], 15e3) && report.level == 0);
    depths.stiffness = 1e7;
    CHECK(dermis_add_depths(&on, &depths, &report) == DERMIS_OK && near(report.level, 1e-3)); /* 2 mm of one cell */
    depths.stiffness = 0;
    depths.depth = NULL;
    REFUSED(dermis_add_depths(&on, &depths, &report), "depths.depth = null");
    depths.size = 1;
    REFUSED(dermis_add_depths(&on, &depths, &report), "depths->size = 1");
    REFUSED(dermis_add_depths(&on, NULL, &report), "depths = (null)");

    REFUSED(dermis_add_taxels(&on, &taxels, &report), "taxels.height = 0; allowed: 1e-9..1e6");
    taxels.height = 1.5e-3;
    memset(pressure, 0, sizeof pressure);
    CHECK(dermis_add_taxels(&on, &taxels, &report) == DERMIS_OK && near(report.asked, (double)0.1f + (double)0.3f));
    CHECK(near(report.placed, report.asked) && near(pressure[0], 0.1 / 3e-6) && near(pressure[11], 0.3 / 3e-6));
    taxels.unit = DERMIS_PASCAL;
    memset(pressure, 0, sizeof pressure);
    CHECK(dermis_add_taxels(&on, &taxels, &report) == DERMIS_OK && near(pressure[0], 0.1));
    taxels.unit = 2;
    REFUSED(dermis_add_taxels(&on, &taxels, &report), "taxels->unit = 2; allowed: DERMIS_NEWTON (0), DERMIS_P");
    taxels.size = 1;
    REFUSED(dermis_add_taxels(&on, &taxels, &report), "taxels->size = 1");
    REFUSED(dermis_add_taxels(&on, NULL, &report), "taxels = (null)");
}

/* A box finger half on a box: its contacts are on the border, and the whole force is on the half that is below. */
static void bodies_press_by_their_shapes(void) {
    const dermis_contact_pad shape = {.size = sizeof shape, .width = 8, .height = 8, .spacing = 1e-3};
    const double middle[] = {0, 0, 0}, upright[] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, box[] = {4e-3, 8e-3, 1e-2},
                 place[] = {4e-3, 0, 1e-2}, around[] = {0, 0, 0, -2e-3};
    const double points[] = {0, -4e-3, 0, 0, 0, -1, 4e-3, 2e-3, 0, 0, 0, -1};
    const dermis_body_kind kind = DERMIS_BOX;
    const int32_t pads[] = {0, 0}, bodies[] = {3, 3};
    const dermis_poses poses = {.position = middle, .rotation = upright, .position_step = 3, .rotation_step = 9};
    dermis_contacts contacts = {.size = sizeof contacts,
                                .count = 2,
                                .pad = pads,
                                .position = points,
                                .force = points + 3,
                                .pad_step = 1,
                                .position_step = 6,
                                .force_step = 6,
                                .body = bodies,
                                .body_step = 1};
    dermis_shapes shapes = {.size = sizeof shapes,
                            .count = 1,
                            .pad = pads,
                            .body = bodies,
                            .kind = &kind,
                            .extent = box,
                            .position = place,
                            .rotation = upright};
    dermis_contact_report report = {.size = sizeof report};
    dermis_touch* touch = NULL;
    const float* pressure = NULL;
    size_t numbers = 0;
    REFUSED(dermis_touch_create_on(&shape, 1, 1e-3, 0, -1, around, &touch), "source.stiffness = -1; allowed: 1e-6");
    CHECK(dermis_touch_create_on(&shape, 1, 1e-3, 0, 5e7, around, &touch) == DERMIS_OK);
    CHECK(dermis_touch_get_pressure(touch, &pressure, NULL, &numbers) == DERMIS_OK);
    CHECK(dermis_touch_add_shapes(touch, &poses, &contacts, &shapes, &report) == DERMIS_OK);
    CHECK(near(report.placed, 2) && report.by_body == 1 && report.by_patch == 0 && report.tilted == 0);
    CHECK(pressure[3] == 0 && pressure[4] > 0 && pressure[7 * 8 + 7] == 0); /* the last two rows have no finger */
    contacts.size = offsetof(dermis_contacts, body);
    REFUSED(dermis_touch_add_shapes(touch, &poses, &contacts, &shapes, &report), "contacts.ball = null");
    contacts.size = sizeof contacts;
    shapes.kind = NULL;
    REFUSED(dermis_touch_add_shapes(touch, &poses, &contacts, &shapes, &report), "shapes.kind = null");
    shapes.size = 1;
    REFUSED(dermis_touch_add_shapes(touch, &poses, &contacts, &shapes, &report), "shapes->size = 1");

    float depth[64] = {0};
    const double force[] = {0.1, 0, -2};
    for (int i = 0; i < 8; ++i) depth[8 * i + 3] = depth[8 * i + 4] = 1e-3f;
    CHECK(dermis_touch_add_depths(touch, depth, force, 0, &report) == DERMIS_OK);
    CHECK(near(report.placed, 2) && report.clipped == 1 && report.plausible == 0 && near(pressure[3], 2 / 16e-6));
    CHECK(dermis_touch_add_depths(touch, depth, force, 1, &report) == DERMIS_OK);
    CHECK(near(report.placed, 2) && report.clipped == 0 && pressure[0] > 0);
    REFUSED(dermis_touch_add_depths(touch, NULL, force, 1, &report), "images.depth = null");
    REFUSED(dermis_touch_add_depths(touch, depth, force, 2, &report), "gaps = 2");
    dermis_touch_destroy(touch);
}

int main(void) {
    contacts();
    bodies_press_by_their_shapes();
    tiled_pads();
    round_pads();
    contacts_of_a_batch();
    shear();
    contacts_of_the_world();
    bodies();
    depths_and_taxels();
    puts("passed");
    return 0;
}
