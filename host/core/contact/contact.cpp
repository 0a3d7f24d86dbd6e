// SPDX-License-Identifier: MIT
// Checks contacts and adds them to a pad; says in words where their forces went.
#include "dermis/contact.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/contact/landing.hpp"

#include <cstdio>
#include <numbers>

namespace dermis::contact {
namespace {

// Refuses a member of contact i. The names are made only for a message, because they allocate.
void need_member(bool ok, size_t i, const char* member, double value, const char* allowed) {
    if (!ok) scene::refuse("contacts[" + std::to_string(i) + "]" + member, shortest(value), allowed);
}

// Checks the numbers that a Contact and a WorldContact have in common, and returns the force.
template <class AnyContact> double checked_force(const AnyContact& c, size_t i) {
    need_member(c.force >= 0 && finite(c.force), i, ".force", c.force, "a finite number >= 0");
    need_member(c.radius >= 0 && c.radius <= greatest_length, i, ".radius", c.radius, "0..1e6");
    need_member(c.area >= 0 && c.area <= greatest_length * greatest_length, i, ".area", c.area, "0..1e12");
    need_member(c.radius == 0 || c.area == 0, i, ".area", c.area, "0 beside a radius > 0");
    return c.force;
}

// Returns a sentence that says where the force went, in shares of what was asked.
std::string whereabouts(const ContactReport& r) {
    const auto share = [&](double force) {
        char digits[32];
        std::snprintf(digits, sizeof digits, "%.2f", force / r.asked);
        return std::string(digits);
    };
    const double rounded = r.asked - r.placed - r.outside - r.sideways;
    std::string sentence = share(r.placed) + " of the force presses the pad";
    if (r.sideways > 0) sentence += ", " + share(r.sideways) + " is sideways (a round body?)";
    if (std::abs(rounded) > 1e-3 * r.asked) sentence += ", " + share(std::abs(rounded)) + " is lost to rounding";
    if (r.outside > 0) {
        std::string causes;
        const auto count = [&](int patches, const char* cause) {
            if (patches > 0) causes += ", " + std::to_string(patches) + cause;
        };
        count(r.beside, " beside");
        count(r.too_far, " too far");
        count(r.turned_away, " turned away");
        if (r.placed > 0) causes += causes.empty() ? ", over the border" : ", else over the border";
        if (causes.empty()) causes = ", nowhere deeper than 0";
        sentence += ", " + share(r.outside) + " is outside: " + causes.substr(2);
    }
    return sentence + ". ";
}

} // namespace

bool ContactReport::keeps_force() const {
    const double rounded = asked - placed - outside - sideways;
    return outside <= 0.1 * asked && placed >= 0.5 * asked && std::abs(rounded) <= 1e-3 * asked;
}

std::string ContactReport::doubts() const {
    const DefaultFloats guard;
    std::string sentences;
    if (!keeps_force()) sentences += whereabouts(*this);
    if (below_cell > 0)
        sentences += std::to_string(below_cell) + (below_cell == 1 ? " patch presses" : " patches press") +
                     " one cell alone: the pressure is force/spacing^2. ";
    if (greatest > doubtful_pressure)
        sentences += "The greatest pressure is " + shortest(greatest) + " Pa, above " + shortest(doubtful_pressure) +
                     " Pa; touch presses with 1e3 to 1e5 Pa. ";
    if (clipped > 0)
        sentences += std::to_string(clipped) + (clipped == 1 ? " depth image has" : " depth images have") +
                     " too few depths above 0 for the force: cells beside them would be pressed too. ";
    if (!sentences.empty()) sentences += "Are lengths in m, forces in N?";
    return sentences;
}

ContactReport add_each(const Pad& pad, size_t count, const std::function<Contact(size_t)>& contact_at) {
    const DefaultFloats guard;
    check(pad);
    double asked = 0;
    for (size_t i = 0; i < count; ++i) {
        const Contact c = contact_at(i);
        asked += checked_force(c, i);
        need_member(std::abs(c.x) <= greatest_length, i, ".x", c.x, "-1e6..1e6");
        need_member(std::abs(c.y) <= greatest_length, i, ".y", c.y, "-1e6..1e6");
    }
    need_float_pressure(pad, asked);
    return press_each(pad, count, [&](size_t i, ContactReport&) -> std::optional<Landing> {
        const Contact c = contact_at(i);
        if (!(c.force > 0)) return {};
        return Landing{c, c.force};
    });
}

ContactReport add_each(const Pad& pad, const Pose& pose, double reach, size_t count,
                       const std::function<WorldContact(size_t)>& contact_at) {
    const DefaultFloats guard;
    check(pad);
    check(pose);
    check_reach(pad, reach);
    double asked = 0;
    for (size_t i = 0; i < count; ++i) {
        const WorldContact c = contact_at(i);
        asked += checked_force(c, i);
        for (double p : c.position) need_member(std::abs(p) <= greatest_length, i, ".position", p, "-1e6..1e6");
        for (double d : c.direction) need_member(std::abs(d) <= greatest_length, i, ".direction", d, "-1e6..1e6");
    }
    need_float_pressure(pad, asked);
    return press_each(pad, count, [&](size_t i, ContactReport& report) {
        return landing_of(pad, pose, reach, contact_at(i), report);
    });
}

ContactReport add_contacts(const Pad& pad, const Contact* contacts, size_t count) {
    if (count > 0) need_memory("contacts", contacts != nullptr);
    return add_each(pad, count, [contacts](size_t i) { return contacts[i]; });
}

ContactReport add_contacts(const Pad& pad, const Pose& pose, double reach, const WorldContact* contacts, size_t count) {
    if (count > 0) need_memory("contacts", contacts != nullptr);
    return add_each(pad, pose, reach, count, [contacts](size_t i) { return contacts[i]; });
}

double hertz_radius(double force, double ball, double modulus) {
    const DefaultFloats guard;
    scene::need_not_negative("force", force);
    scene::need_positive("ball", ball);
    scene::need_positive("modulus", modulus);
    return std::cbrt(0.75 * force * ball / modulus);
}

double strain_below_punch(double indentation, double depth, double radius, double poisson) {
    const DefaultFloats guard;
    scene::need_finite("indentation", indentation);
    scene::need_not_negative("depth", depth);
    scene::need_positive("radius", radius);
    scene::need(poisson >= 0 && poisson <= 0.5, "poisson", poisson, "0..0.5");
    const double r = std::hypot(depth, radius), flat = radius / r, deep = depth / r;
    return indentation / (std::numbers::pi * radius * (1 - poisson * poisson)) * flat * flat *
           (flat * flat + 3 * deep * deep);
}

double foundation_stiffness(double force, double ball, double modulus) {
    const DefaultFloats guard;
    scene::need_positive("force", force);
    return 16 * modulus / (3 * std::numbers::pi * hertz_radius(force, ball, modulus));
}

double skin_stiffness(const Material& m) {
    double compliance = m.spring ? 1 / *m.spring : 0;
    bool rests = !m.dashpot && m.modulus_map.empty();
    for (const KelvinVoigt& e : m.elements) compliance += 1 / e.modulus, rests = rests && e.modulus_map.empty();
    if (m.elements.empty()) compliance += 1 / m.modulus.value_or(0);
    const double stiffness = 1 / (compliance * m.thickness.value_or(0));
    return rests && finite(stiffness) ? stiffness : 0;
}

Pose Pose::from_matrix(Reals position, Reals rotation) {
    need_memory("position", bool(position));
    need_memory("rotation", bool(rotation));
    Pose pose;
    for (size_t k = 0; k < 3; ++k) pose.position[k] = position[k];
    for (size_t k = 0; k < 9; ++k) pose.rotation[k] = rotation[k];
    return pose;
}

Pose Pose::from_quaternion(Reals position, Reals q) {
    const DefaultFloats guard;
    need_memory("position", bool(position));
    need_memory("quaternion", bool(q));
    const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    need_within("|quaternion|^2", square, 1e-300, 1e300, "1e-300..1e300");
    const double scale = 1 / std::sqrt(square);
    const double w = scale * q[0], x = scale * q[1], y = scale * q[2], z = scale * q[3];
    const double rotation[] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                               2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                               2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    return from_matrix(position, rotation);
}

Pose Pose::from_middle(const Pad& pad) const {
    const DefaultFloats guard;
    const double x = -0.5 * pad.width * pad.spacing, y = -0.5 * pad.height * pad.spacing;
    Pose corner = *this;
    for (size_t k = 0; k < 3; ++k) corner.position[k] += rotation[3 * k] * x + rotation[3 * k + 1] * y;
    return corner;
}

} // namespace dermis::contact
