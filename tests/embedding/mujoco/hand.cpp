// SPDX-License-Identifier: MIT
// Five round fingertips in MuJoCo, from version 2.2 on: hand hand.xml
//
// A hand grasps a ball and lifts it, as in hand.py; its skin feels the contacts of all fingers by one call a step.
// Exits with 1 if less than 0.95 of the force into the pads presses them.
#include <dermis/dermis.hpp>
#include <dermis/touch.hpp>

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

namespace contact = dermis::contact;

constexpr int tips = 5, side = 80;                             // pads of 20 mm x 20 mm
constexpr double spacing = 2.5e-4, radius = 8e-3, step = 1e-3; // m, m, s
constexpr double ball = 6e-3, modulus = 1e5;                   // the ball's radius and the tip's together, m; Pa

dermis::Skin skin_of_tips() {
    dermis::SkinDescription d = dermis::fingertip();
    d.grid = {.width = side, .height = side, .spacing = spacing};
    d.receptors.depth = dermis::fingertip_depths();
    dermis::SkinOptions options{.count = tips, .shear = true};
    return {dermis::Device::cpu(), d, options};
}

// The contacts of the fingertips in one step: which pads they press, and places and forces.
struct Table {
    std::vector<int32_t> pad;
    std::vector<double> rows;

    // pads: of each geom; -1: it has none.
    Table(const mjModel* m, const mjData* d, const std::vector<int>& pads) {
        for (int i = 0; i < 2 * d->ncon; ++i) {
            const mjContact& c = d->contact[i / 2];
            const int geom = i % 2 ? c.geom2 : c.geom1;
            if (pads[size_t(geom)] < 0) continue;
            mjtNum own[6], force[3], place[3];
            mj_contactForce(m, d, i / 2, own);
            mju_mulMatTVec(force, c.frame, own, 3, 3); // in the world, on the second geom
            if (i % 2 == 0) mju_scl3(force, force, -1);
            pad.push_back(pads[size_t(geom)]);
            mju_addScl3(place, c.pos, c.frame, (i % 2 == 0 ? -0.5 : 0.5) * c.dist); // on this geom's surface
            rows.insert(rows.end(), place, place + 3);
            rows.insert(rows.end(), force, force + 3);
        }
    }
    contact::Contacts contacts() const {
        return {.count = pad.size(),
                .pad = pad.data(),
                .position = rows.data(),
                .force = rows.data() + 3,
                .ball = &ball,
                .modulus = modulus,
                .position_step = 6,
                .force_step = 6,
                .ball_step = 0};
    }
};

int main(int argc, char** argv) try {
    char why[1000] = "which file?";
    mjModel* const m = argc > 1 ? mj_loadXML(argv[1], nullptr, why, sizeof why) : nullptr;
    if (!m) throw std::runtime_error(why);
    mjData* const d = mj_makeData(m);
    std::vector<int> pads(size_t(m->ngeom), -1);
    for (int k = 0; k < tips; ++k) pads[size_t(mj_name2id(m, mjOBJ_GEOM, ("tip" + std::to_string(k)).c_str()))] = k;

    dermis::Skin skin = skin_of_tips();
    contact::Touch touch({.width = side, .height = side, .spacing = spacing, .radius_x = radius, .radius_y = radius},
                         tips, 1e-3, true);
    double into = 0, placed = 0, shear = 0;
    for (int n = 0; n < 1000; ++n) {
        d->ctrl[0] = std::clamp((n * step - 0.5) / 0.3, 0.0, 1.0) * 0.04; // lift by 40 mm
        std::fill_n(d->ctrl + 1, tips, std::clamp((n * step - 0.15) / 0.2, 0.0, 1.0) * 0.12);
        mj_step(m, d);
        const Table table(m, d, pads);
        // The model's sites are the pads, in this order.
        const contact::ContactReport& r =
            touch.add({.position = d->site_xpos, .rotation = d->site_xmat}, table.contacts());
        skin.press(touch, step);
        if (n >= 350) into += r.asked - r.sideways, placed += r.placed;
    }
    for (const float gamma : skin.response(dermis::Quantity::shear_x)) shear = std::max(shear, double(std::abs(gamma)));
    const double up = d->qpos[2];
    std::printf(
        "%.1f%% of the force into the pads presses them; the ball hangs at %.0f mm, the greatest shear is %.2f\n",
        100 * placed / into, 1e3 * up, shear);
    mj_deleteData(d);
    mj_deleteModel(m);
    return placed < 0.95 * into || up < 0.06 || shear < 0.02;
} catch (const std::exception& e) {
    return std::fprintf(stderr, "%s\n", e.what()), 1;
}
