// SPDX-License-Identifier: MIT
// The shapes of what touches pads, from MuJoCo's geoms.
#pragma once

#include "dermis/touch.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace dermis::mujoco {

// A table of shapes, and the geoms that are in it.
class Shapes {
  public:
    void clear() {
        for (auto* numbers : {&pads_, &bodies_, &kinds_, &geoms_}) numbers->clear();
        for (auto* numbers : {&sizes_, &places_, &axes_, &faces_}) numbers->clear();
    }
    // Lists a geom below a pad, unless it is there, and returns the number of its rigid body; -1 for what has no shape
    // here: a height field, a signed distance, a flex, a mesh without a convex hull of 4..65536 faces with normals.
    int32_t add(const mjModel* m, const mjData* d, int32_t pad, int geom) {
        if (geom < 0) return -1;
        const int body = m->body_weldid[m->geom_bodyid[geom]];
        for (size_t i = 0; i < geoms_.size(); ++i)
            if (geoms_[i] == geom && pads_[i] == pad) return body;
        double size[3] = {};
        const int kind = kind_of(m, geom, size);
        if (kind < 0) return -1;
        geoms_.push_back(geom), pads_.push_back(pad), bodies_.push_back(body), kinds_.push_back(kind);
        sizes_.insert(sizes_.end(), size, size + 3);
        places_.insert(places_.end(), d->geom_xpos + 3 * geom, d->geom_xpos + 3 * geom + 3);
        axes_.insert(axes_.end(), d->geom_xmat + 9 * geom, d->geom_xmat + 9 * geom + 9);
        return body;
    }
    contact::Shapes columns() const {
        return {.count = pads_.size(),
                .pad = pads_.data(),
                .body = bodies_.data(),
                .kind = kinds_.data(),
                .size = sizes_.data(),
                .position = places_.data(),
                .rotation = axes_.data(),
                .faces = faces_.data(),
                .face_count = faces_.size() / 4};
    }

  private:
    using Kind = contact::Body::Kind;
    int kind_of(const mjModel* m, int geom, double* size) {
        const mjtNum* own = m->geom_size + 3 * geom;
        const auto sized = [&](Kind kind, int numbers) {
            std::copy_n(own, numbers, size);
            return int(kind);
        };
        switch (m->geom_type[geom]) {
        case mjGEOM_PLANE: return sized(Kind::plane, 0);
        case mjGEOM_SPHERE: return sized(Kind::sphere, 1);
        case mjGEOM_CAPSULE: return sized(Kind::capsule, 2);
        case mjGEOM_ELLIPSOID: return sized(Kind::ellipsoid, 3);
        case mjGEOM_CYLINDER: return sized(Kind::cylinder, 2);
        case mjGEOM_BOX: return sized(Kind::box, 3);
        case mjGEOM_MESH: return add_hull(m, m->geom_dataid[geom], size);
        default: return -1;
        }
    }
    // The polygons of the convex hull that MuJoCo collides.
    int add_hull(const mjModel* m, int mesh, double* size) {
        const int count = mesh < 0 ? 0 : m->mesh_polynum[mesh];
        if (count < 4 || count > 65536 || m->mesh_graphadr[mesh] < 0) return -1;
        size[0] = count, size[1] = double(faces_.size() / 4);
        for (int p = 0; p < count; ++p) {
            const int polygon = m->mesh_polyadr[mesh] + p;
            const mjtNum* normal = m->mesh_polynormal + 3 * polygon;
            const int vertex = m->mesh_polyvert[m->mesh_polyvertadr[polygon]];
            const float* place = m->mesh_vert + 3 * (m->mesh_vertadr[mesh] + vertex);
            const double length = mju_norm3(normal);
            if (!(length > 0)) return faces_.resize(4 * size_t(size[1])), -1;
            double offset = 0;
            for (int k = 0; k < 3; ++k) {
                faces_.push_back(normal[k] / length);
                offset += normal[k] / length * double(place[k]);
            }
            faces_.push_back(offset);
        }
        return int(Kind::hull);
    }

    std::vector<int32_t> pads_, bodies_, kinds_, geoms_;
    std::vector<double> sizes_, places_, axes_, faces_;
};

} // namespace dermis::mujoco
