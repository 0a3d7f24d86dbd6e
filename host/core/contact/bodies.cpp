// SPDX-License-Identifier: MIT
// The lines along which depths of bodies are measured.
#include "host/core/contact/bodies.hpp"

#include "host/core/base/float_environment.hpp"

namespace dermis::contact {
void check(const Body& body, const char* list, int number) {
    check(body.pose, list, number);
    const auto name = [&](const char* member) { return member_of(list, member, number); };
    if (int(body.kind) < 0 || int(body.kind) > 6)
        scene::refuse(name("kind"), std::to_string(int(body.kind)),
                      "sphere, capsule, box, plane, cylinder, ellipsoid, hull (0..6)");
    constexpr size_t used[] = {1, 2, 3, 0, 2, 3, 0}; // sizes of each kind
    for (size_t k = 0; k < 3; ++k) {
        const double size = body.size[k];
        const bool asked = k < used[size_t(body.kind)];
        if (asked ? !(size > 0 && size <= greatest_length) : size != 0)
            scene::refuse(name("size") + "[" + std::to_string(k) + "]", shortest(size),
                          asked ? "above 0, at most 1e6" : "0");
    }
    const bool hull = body.kind == Body::Kind::hull;
    if (hull ? body.face_count < 4 || body.face_count > 65536 : body.face_count != 0)
        scene::refuse(name("face_count"), std::to_string(body.face_count),
                      hull ? "4..65536" : "0: only a hull has faces");
    if (hull && !body.faces) scene::refuse(name("faces"), "null", "an address");
    for (size_t f = 0; f < body.face_count; ++f) {
        const double* n = body.faces + 4 * f;
        const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        if (!(std::abs(length - 1) <= 1e-3 && std::abs(n[3]) <= greatest_length))
            scene::refuse(name("faces") + "[" + std::to_string(f) + "]",
                          shortest(n[0]) + ", " + shortest(n[1]) + ", " + shortest(n[2]) + ", " + shortest(n[3]),
                          "a normal of length 1 and an offset of -1e6..1e6 m");
    }
}

Lines::Lines(const Pad& pad, const Pose& from, const Pose& to) : surface_(pad) {
    Vector between;
    for (size_t i = 0; i < 3; ++i) {
        between[i] = from.position[i] - to.position[i];
        for (size_t j = 0; j < 3; ++j)
            for (size_t k = 0; k < 3; ++k) rows_[i][j] += to.rotation[3 * k + i] * from.rotation[3 * k + j];
    }
    const Vector own = turned(to, between);
    const Vector middle = vector({0.5 * pad.width * pad.spacing, 0.5 * pad.height * pad.spacing, 0});
    lines_.flat = pad.radius_x == 0 && pad.radius_y == 0;
    lines_.deepest = greatest_length;
    for (double radius : {pad.radius_x, pad.radius_y})
        if (radius != 0) lines_.deepest = std::min(lines_.deepest, radius);
    const double corner_x = (0.5 - 0.5 * pad.width) * pad.spacing, corner_y = (0.5 - 0.5 * pad.height) * pad.spacing;
    for (size_t k = 0; k < 3; ++k) {
        offset_[k] = middle[k] + own[k];
        lines_.origin[k] = offset_[k] + (rows_[k][0] * corner_x + rows_[k][1] * corner_y);
        lines_.step_x[k] = rows_[k][0] * pad.spacing, lines_.step_y[k] = rows_[k][1] * pad.spacing;
        lines_.down[k] = -rows_[k][2];
    }
}

void Lines::deepen(const Body& body, const double* x, const double* y, int count, double* depth) {
    for (int i = 0; i < count; ++i) {
        if (lines_.flat) {
            lines_.from[0][i] = x[i], lines_.from[1][i] = y[i];
            continue;
        }
        Vector place, normal;
        if (i == 0 || y[i] != y[i - 1]) surface_.row(y[i]);
        surface_.at(x[i], place, normal);
        const Vector own = vector(place), out = vector(normal);
        for (size_t k = 0; k < 3; ++k) lines_.from[k][i] = offset_[k] + own[k], lines_.along[k][i] = -out[k];
    }
    lines_.faces = body.faces, lines_.face_count = body.face_count;
    loops().deepen(int(body.kind), body.size.data(), lines_, {0, 0, count, 1, 0, true}, depth);
}

void Lines::deepen(const Body& body, const Block& b, double* depth) {
    lines_.faces = body.faces, lines_.face_count = body.face_count;
    if (lines_.flat) return loops().deepen(int(body.kind), body.size.data(), lines_, b, depth);
    for (int j = 0; j < b.rows; ++j)
        for (int first = 0; first < b.columns; first += LineRow::most) {
            double x[LineRow::most], y[LineRow::most];
            const int count = std::min(LineRow::most, b.columns - first);
            for (int i = 0; i < count; ++i) x[i] = b.x + first + i, y[i] = b.y + j;
            deepen(body, x, y, count, depth + size_t(j) * b.pitch + size_t(first));
        }
}

void fill_depths(const Pad& pad, const Pose& pose, const Body& body, float* depth, size_t pitch) {
    const DefaultFloats guard;
    check(pad);
    check(pose);
    check(body, "body");
    need_memory("depth", depth != nullptr);
    need_pitch("pitch", pitch, pad.width);
    Lines lines(pad, pose, body.pose);
    std::vector<double> row(size_t(pad.width));
    for (int y = 0; y < pad.height; ++y) {
        std::ranges::fill(row, not_below);
        lines.deepen(body, Block{0, double(y), pad.width, 1, 0}, row.data());
        std::ranges::copy(row, depth + size_t(y) * (pitch ? pitch : size_t(pad.width)));
    }
}

} // namespace dermis::contact
