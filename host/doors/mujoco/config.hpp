// SPDX-License-Identifier: MIT
// The keys of an instance of the plugin. Each is checked here, when a model is read.
#pragma once

#include "dermis/dermis.hpp"
#include "dermis/touch.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstdlib>
#include <iomanip>
#include <optional>
#include <sstream>

namespace dermis::mujoco {

constexpr const char* keys[] = {"scene",  "size",   "spacing", "pads", "radius",  "reach",  "source",   "stiffness",
                                "beyond", "around", "patch",   "ball", "modulus", "output", "responses"};

[[noreturn]] inline void refuse(const std::string& key, const std::string& value, const std::string& allowed) {
    throw std::invalid_argument(key + " = " + value + "; allowed: " + allowed);
}

inline std::string number_text(double number) {
    std::ostringstream text;
    text << std::setprecision(9) << number;
    return text.str();
}

// MuJoCo counts in ints.
inline int counted(const char* key, double count) {
    if (count > INT_MAX) refuse(key, number_text(count) + " numbers of mjData", "at most 2147483647");
    return int(count);
}

// A key that is not given, or empty, has its default.
struct Keys {
    const mjModel* m;
    int instance;

    std::string text(const char* key, const char* otherwise = "") const {
        const char* value = mj_getPluginConfig(m, instance, key);
        return value && *value ? value : otherwise;
    }
    // From `fewest` to as many numbers as `otherwise` has, each from `least` to `most`.
    std::vector<double> numbers(const char* key, size_t fewest, const std::vector<double>& otherwise, double least,
                                double most) const {
        const std::string value = text(key);
        if (value.empty()) return otherwise;
        std::istringstream words(value);
        std::vector<double> found;
        bool whole = true; // whether each word is a number up to its end
        for (std::string word; words >> word;) {
            char* end = nullptr;
            found.push_back(std::strtod(word.c_str(), &end));
            whole = whole && *end == 0;
        }
        if (!whole || found.size() < fewest || found.size() > otherwise.size())
            refuse(key, value,
                   otherwise.size() == 1 ? "a number"
                   : fewest == 1         ? "1 or 2 numbers"
                                         : std::to_string(fewest) + " numbers");
        for (double x : found)
            if (!(x >= least && x <= most)) refuse(key, number_text(x), number_text(least) + ".." + number_text(most));
        return found;
    }
    double number(const char* key, double otherwise, double least, double most) const {
        return numbers(key, 1, {otherwise}, least, most)[0];
    }
    int whole(const char* key, double number) const {
        if (number != std::floor(number)) refuse(key, number_text(number), "whole numbers");
        return int(number);
    }
};

struct Config {
    Config(const mjModel* m, int instance) {
        const Keys given{m, instance};
        options.count = given.whole("pads", given.number("pads", 1, 1, 1048576));
        radii = given.numbers("radius", 1, {0, 0}, 0, 1e6);
        if (radii.size() == 1) radii.push_back(radii[0]);
        reach = given.number("reach", 1e-3, 0, 1e6);
        patch = given.number("patch", 0, 0, 1e6);
        ball = given.number("ball", radii[0], 0, 1e6);
        modulus = given.number("modulus", 1e5, 1e-6, 1e30);
        read_scene(given);
        read_source(given);
        read_responses(given);
        const std::string output = given.text("output", "field");
        if (output != "field" && output != "mean") refuse("output", output, "field, mean");
        fields = output == "field";
        double sum = 0;
        for (const std::optional<Quantity>& each : read) sum += double(length(each));
        sensor_numbers = counted("responses", sum);
    }

    contact::Pad shape() const {
        return {.width = scene.grid.width,
                .height = scene.grid.height,
                .spacing = *scene.grid.spacing,
                .radius_x = radii[0],
                .radius_y = radii[1],
                .keep = keep};
    }
    // The source of pads. faces: how far the boxes on which pads lie go on beyond them. Without the key `around` it is
    // that, if all pads have such a face and the same one; on a round pad it is 8 cells, or what there is up to a
    // quarter turn; else 0.
    contact::Source source_on(const std::vector<std::array<double, 4>>& faces) const {
        contact::Source made = source;
        if (knows_around || !bodies) return made;
        const double spacing = *scene.grid.spacing;
        const int sides[] = {scene.grid.width, scene.grid.height};
        if (radii[0] == 0 && radii[1] == 0) {
            const bool same = faces.size() == size_t(options.count) && std::ranges::all_of(faces, [&](const auto& f) {
                                  return std::ranges::equal(f, faces[0], [&](double a, double b) {
                                      return std::abs(a - b) < 1e-3 * spacing;
                                  });
                              });
            for (size_t k = 0; same && k < 4; ++k)
                made.around[k] = std::clamp(faces[0][k], -sides[k / 2] * spacing, sides[k / 2] * spacing);
            return made;
        }
        for (size_t k = 0; k < 4; ++k)
            made.around[k] = std::clamp(0.5 * (M_PI * radii[k / 2] - sides[k / 2] * spacing), 0.0, 8 * spacing);
        return made;
    }
    Skin skin() const { return {Device::cpu(1), scene, options}; }
    size_t cells() const { return size_t(scene.grid.width) * size_t(scene.grid.height); }
    // The numbers of an output of a pad.
    size_t length(std::optional<Quantity> output) const { return !output ? 2 : fields ? cells() : 1; }
    // The numbers of the state in mjData: whether the skin is not at rest, and its state.
    static int state_numbers(const Skin& skin) {
        return counted("pads", 1 + std::ceil(double(skin.state_bytes()) / sizeof(mjtNum)));
    }

    SkinDescription scene;
    SkinOptions options;
    std::vector<std::optional<Quantity>> read; // what the sensors give, in this order; empty: the force
    std::vector<double> radii;
    double reach, patch, ball, modulus;
    contact::Source source;
    bool bodies;       // whether bodies press by their shapes
    bool knows_around; // whether `around` is given
    bool keep;         // whether the pad's cells carry the part of a patch beyond its border
    bool fields;
    int sensor_numbers; // of all outputs of a pad

  private:
    void read_scene(const Keys& given) {
        const std::string path = given.text("scene");
        if (path.empty()) {
            const std::vector<double> size = given.numbers("size", 2, {24, 24}, 0, 1048576);
            static_cast<SkinDescription&>(scene) = fingertip();
            scene.surface = {.kind = Surface::Kind::flat, .relief = scene.surface.relief};
            scene.grid = {given.whole("size", size[0]), given.whole("size", size[1]),
                          given.number("spacing", 5e-4, 1e-9, 1e6)};
            return;
        }
        for (const char* key : {"size", "spacing"})
            if (!given.text(key).empty()) refuse(key, given.text(key), "none beside a scene, which has a grid");
        const Scene whole = Scene::from_file(path);
        if (!whole.grid.spacing) refuse("scene", path, "a scene with grid.spacing, in metres");
        if (!whole.sites.empty()) refuse("scene", path, "a scene without sites");
        scene = whole;
    }
    void read_source(const Keys& given) {
        const std::string from = given.text("source", "bodies");
        if (from != "bodies" && from != "contacts") refuse("source", from, "bodies, contacts");
        bodies = from == "bodies";
        const std::string beyond = given.text("beyond", radii[0] == 0 && radii[1] == 0 ? "keep" : "drop");
        if (beyond != "keep" && beyond != "drop") refuse("beyond", beyond, "keep, drop");
        keep = beyond == "keep";
        for (const char* key : {"stiffness", "around"})
            if (!bodies && !given.text(key).empty()) refuse(key, given.text(key), "none beside source = contacts");
        knows_around = !given.text("around").empty();
        std::ranges::copy(given.numbers("around", 4, {0, 0, 0, 0}, -1e6, 1e6), source.around.begin());
        if (!bodies && patch == 0 && ball == 0)
            refuse("ball", "0",
                   "above 0 m, of what presses the pad; in its place patch, of each contact, or radius, of the pad");
        if (!bodies) return;
        source.stiffness = given.number("stiffness", 0, 1e-6, 1e30);
        if (source.stiffness == 0) source.stiffness = contact::skin_stiffness(scene.material);
        if (source.stiffness == 0)
            refuse("stiffness", "(not given)", "Pa/m beside a scene that has none at rest; or source = contacts");
    }
    void read_responses(const Keys& given) {
        options.responses.clear();
        std::istringstream names(given.text("responses", "sa1 fa1"));
        for (std::string named; names >> named;) {
            const std::optional<Quantity> output = output_of(named);
            if (std::ranges::count(read, output)) refuse("responses", named + " twice", "each one once");
            read.push_back(output);
            if (!output) continue;
            if (*output >= Quantity::shear_x) options.shear = true;
            else options.responses.push_back(*output);
        }
        if (read.empty()) refuse("responses", "(none)", "at least one");
        if (options.responses.empty()) options.responses = {Quantity::sa1};
    }
    static std::optional<Quantity> output_of(const std::string& named) {
        if (named == "force") return {};
        std::string allowed;
        for (Quantity q : {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2, Quantity::shear_x,
                           Quantity::shear_y, Quantity::stretch_x, Quantity::stretch_y, Quantity::stretch_xy}) {
            if (named == name(q)) return q;
            allowed += name(q) + std::string(", ");
        }
        refuse("responses", named, allowed + "force");
    }
};

} // namespace dermis::mujoco
