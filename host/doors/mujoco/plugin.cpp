// SPDX-License-Identifier: MIT
// Skin in a MuJoCo model, without code: a sensor plugin, "dermis.skin". The sites of all sensors that name one instance
// are the pads of one dermis::Skin. Contacts of a site's body press its pad, at each step; the skin's state is in
// mjData, so that a rollback by mj_setState is one of the skin too. host/examples/SIMULATOR.md lists the keys.
#include "dermis/dermis.hpp"
#include "dermis/touch.hpp"

#include <mujoco/mujoco.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <sstream>

namespace {

namespace contact = dermis::contact;
using dermis::Quantity;

constexpr const char* keys[] = {"scene", "size", "spacing", "pads",   "radius",   "reach",
                                "patch", "ball", "modulus", "output", "responses"};

[[noreturn]] void refuse(const std::string& key, const std::string& value, const std::string& allowed) {
    throw std::invalid_argument(key + " = " + value + "; allowed: " + allowed);
}

// What an instance's keys say. A key that is not given, or empty, has its default.
class Config {
  public:
    Config(const mjModel* m, int instance) : m_(m), instance_(instance) {
        options.count = whole("pads", numbers("pads", {1}, 1, 1)[0]);
        radii = numbers("radius", {0}, 1, 2);
        if (radii.size() == 1) radii.push_back(radii[0]);
        reach = numbers("reach", {1e-3}, 1, 1)[0];
        patch = numbers("patch", {0}, 1, 1)[0];
        ball = numbers("ball", {radii[0]}, 1, 1)[0];
        modulus = numbers("modulus", {1e5}, 1, 1)[0];
        if (patch == 0 && !(ball > 0)) refuse("ball", dermis_text(ball), "above 0 m where patch and radius are 0");
        read_scene();
        read_responses();
        const std::string output = text("output", "field");
        if (output != "field" && output != "mean") refuse("output", output, "field, mean");
        fields = output == "field";
    }

    contact::Pad shape() const {
        return {.width = scene.grid.width,
                .height = scene.grid.height,
                .spacing = *scene.grid.spacing,
                .radius_x = radii[0],
                .radius_y = radii[1]};
    }
    size_t cells() const { return size_t(scene.grid.width) * size_t(scene.grid.height); }
    dermis::Skin skin() const { return {dermis::Device::cpu(1), scene, options}; }

    dermis::SkinDescription scene;
    dermis::SkinOptions options;
    std::vector<Quantity> read; // what the sensors give, in this order
    std::vector<double> radii;
    double reach, patch, ball, modulus;
    bool fields;

  private:
    static std::string dermis_text(double x) {
        char digits[32];
        std::snprintf(digits, sizeof digits, "%.9g", x);
        return digits;
    }
    std::string text(const char* key, const char* otherwise) const {
        const char* value = mj_getPluginConfig(m_, instance_, key);
        return value && *value ? value : otherwise;
    }
    std::vector<double> numbers(const char* key, std::vector<double> otherwise, size_t least, size_t most) const {
        const std::string value = text(key, "");
        if (value.empty()) return otherwise;
        std::istringstream words(value);
        std::vector<double> found;
        for (double x; words >> x;) found.push_back(x);
        if (!words.eof() || found.size() < least || found.size() > most)
            refuse(key, value,
                   most == 1 ? "a number" : std::to_string(least) + " or " + std::to_string(most) + " numbers");
        return found;
    }
    // What is no whole number, or beyond what a skin takes, is refused here.
    static int whole(const char* key, double number) {
        if (!(number >= 0 && number <= 1048576 && number == std::floor(number)))
            refuse(key, dermis_text(number), "whole numbers up to 1048576");
        return int(number);
    }
    void read_scene() {
        const std::string path = text("scene", "");
        if (path.empty()) {
            const std::vector<double> size = numbers("size", {24, 24}, 2, 2);
            static_cast<dermis::SkinDescription&>(scene) = dermis::fingertip();
            dermis::Surface flat;
            flat.kind = dermis::Surface::Kind::flat;
            flat.relief = scene.surface.relief;
            scene.surface = flat;
            scene.grid = {whole("size", size[0]), whole("size", size[1]), numbers("spacing", {5e-4}, 1, 1)[0]};
            return;
        }
        for (const char* key : {"size", "spacing"})
            if (!text(key, "").empty()) refuse(key, text(key, ""), "none beside a scene, which has a grid");
        const dermis::Scene whole = dermis::Scene::from_file(path);
        if (!whole.grid.spacing) refuse("scene", path, "a scene with grid.spacing, in metres");
        if (!whole.sites.empty()) refuse("scene", path, "a scene without sites");
        scene = whole;
    }
    void read_responses() {
        options.responses.clear();
        std::istringstream names(text("responses", "sa1 fa1"));
        for (std::string named; names >> named;) {
            bool known = false;
            for (Quantity q : {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2, Quantity::shear_x,
                               Quantity::shear_y, Quantity::stretch_x, Quantity::stretch_y, Quantity::stretch_xy}) {
                if (named != dermis::name(q)) continue;
                known = true;
                read.push_back(q);
                if (q >= Quantity::shear_x) options.shear = true;
                else options.responses.push_back(q);
            }
            if (!known)
                refuse("responses", named, "sa1, sa2, fa1, fa2, shear_x, shear_y, stretch_x, stretch_y, stretch_xy");
        }
        if (read.empty()) refuse("responses", "(none)", "at least one");
        if (options.responses.empty()) options.responses = {Quantity::sa1};
    }

    const mjModel* m_;
    int instance_;
};

// A sensor's pad.
struct Pad {
    int site, body, out; // out: in mjData::sensordata
};

// The sensors of an instance, in the model's order.
std::vector<Pad> pads_of(const mjModel* m, int instance) {
    std::vector<Pad> pads;
    for (int s = 0; s < m->nsensor; ++s) {
        if (m->sensor_type[s] != mjSENS_PLUGIN || m->sensor_plugin[s] != instance) continue;
        if (m->sensor_objtype[s] != mjOBJ_SITE) refuse("objtype", "(another)", "site: a pad is on a site");
        pads.push_back({m->sensor_objid[s], m->site_bodyid[m->sensor_objid[s]], m->sensor_adr[s]});
    }
    return pads;
}

// A state in mjData: the number of the step that wrote it, and the skin's state. 0 is a skin at rest.
double next_number() {
    static std::atomic<int64_t> last = 0;
    return double(++last);
}

class Instance {
  public:
    Instance(const mjModel* m, int instance)
        : config_(m, instance), pads_(pads_of(m, instance)), skin_(config_.skin()),
          touch_(config_.shape(), config_.options.count, config_.reach, config_.options.shear) {
        if (pads_.size() != size_t(config_.options.count))
            refuse("pads", std::to_string(config_.options.count),
                   std::to_string(pads_.size()) + ", the sensors of this instance");
    }

    void rest() {
        skin_.reset();
        holds_ = 0;
    }
    // From the state in mjData, as often as the step is computed.
    void compute(const mjModel* m, mjData* d, const mjtNum* state) {
        if (state[0] != holds_) {
            if (state[0] == 0) skin_.reset();
            else skin_.load(state + 1, skin_.state_bytes());
        }
        holds_ = -1; // a step ahead of the state
        touch_.add(poses(d), contacts(m, d));
        skin_.press(touch_, m->opt.timestep);
        write(d);
    }
    void advance(mjtNum* state) {
        skin_.save(state + 1, skin_.state_bytes());
        state[0] = holds_ = next_number();
    }

  private:
    contact::Poses poses(const mjData* d) {
        places_.clear();
        axes_.clear();
        for (const Pad& p : pads_) {
            places_.insert(places_.end(), d->site_xpos + 3 * p.site, d->site_xpos + 3 * p.site + 3);
            axes_.insert(axes_.end(), d->site_xmat + 9 * p.site, d->site_xmat + 9 * p.site + 9);
        }
        return {.position = places_.data(), .rotation = axes_.data()};
    }
    contact::Contacts contacts(const mjModel* m, const mjData* d) {
        pad_.clear();
        table_.clear();
        for (int k = 0; k < d->ncon; ++k)
            for (int side = 0; side < 2; ++side) add_contact(m, d, k, side);
        const bool hertz = config_.patch == 0;
        return {.count = pad_.size(),
                .pad = pad_.data(),
                .position = table_.data(),
                .force = table_.data() + 3,
                .radius = hertz ? nullptr : &config_.patch,
                .ball = hertz ? &config_.ball : nullptr,
                .modulus = hertz ? config_.modulus : 0,
                .position_step = 6,
                .force_step = 6,
                .radius_step = 0,
                .ball_step = 0};
    }
    // A contact presses the pads on the body of one of its geoms.
    void add_contact(const mjModel* m, const mjData* d, int k, int side) {
        const mjContact& c = d->contact[k];
        if (c.geom[side] < 0) return;
        for (size_t p = 0; p < pads_.size(); ++p) {
            if (m->geom_bodyid[c.geom[side]] != pads_[p].body) continue;
            mjtNum own[6], force[3];
            mj_contactForce(m, d, k, own);
            mju_mulMatTVec(force, c.frame, own, 3, 3);
            if (side == 0) mju_scl3(force, force, -1); // it acts on the second geom
            pad_.push_back(int32_t(p));
            table_.insert(table_.end(), c.pos, c.pos + 3);
            table_.insert(table_.end(), force, force + 3);
        }
    }
    // Writes what is read, each response of a pad behind the one before.
    void write(mjData* d) const {
        const size_t cells = config_.cells(), length = config_.fields ? cells : 1;
        for (size_t r = 0; r < config_.read.size(); ++r) {
            const dermis::Skin::Response all = skin_.response(config_.read[r]);
            for (size_t p = 0; p < pads_.size(); ++p) {
                mjtNum* out = d->sensordata + size_t(pads_[p].out) + r * length;
                const float* values = all.data + p * cells;
                if (config_.fields) std::copy_n(values, cells, out);
                else *out = mean(values, cells);
            }
        }
    }
    // Four sums hide the latency of additions.
    static double mean(const float* values, size_t count) {
        double a = 0, b = 0, c = 0, e = 0;
        size_t i = 0;
        for (; i + 4 <= count; i += 4)
            a += double(values[i]), b += double(values[i + 1]), c += double(values[i + 2]), e += double(values[i + 3]);
        for (; i < count; ++i) a += double(values[i]);
        return ((a + b) + (c + e)) / double(count);
    }

    const Config config_;
    const std::vector<Pad> pads_;
    dermis::Skin skin_;
    contact::Touch touch_;
    std::vector<double> places_, axes_, table_; // table_: place and force of each contact
    std::vector<int32_t> pad_;
    double holds_ = 0; // the number of the state that the skin has; -1: of none
};

Instance* instance_of(const mjData* d, int i) { return reinterpret_cast<Instance*>(d->plugin_data[i]); }

// Calls; MuJoCo's C takes no exception, so a refusal is MuJoCo's error, once the exception is gone.
template <class Call> int guarded(Call call) {
    static thread_local char why[400];
    try {
        return call();
    } catch (const std::exception& e) {
        std::snprintf(why, sizeof why, "%s", e.what());
    }
    mju_error("dermis.skin: %s", why);
    return 0;
}

// MuJoCo asks before the model has its sensors, so that pads cannot be counted here.
int nstate(const mjModel* m, int instance) {
    return guarded([&] { return 1 + int((Config(m, instance).skin().state_bytes() + 7) / sizeof(mjtNum)); });
}

int nsensordata(const mjModel* m, int instance, int) {
    return guarded([&] {
        const Config c(m, instance);
        return int(c.read.size() * (c.fields ? c.cells() : 1));
    });
}

int init(const mjModel* m, mjData* d, int instance) {
    return guarded([&] {
        d->plugin_data[instance] = reinterpret_cast<uintptr_t>(new Instance(m, instance));
        d->plugin_state[m->plugin_stateadr[instance]] = 0;
        return 0;
    });
}

void destroy(mjData* d, int instance) {
    delete instance_of(d, instance);
    d->plugin_data[instance] = 0;
}

void reset(const mjModel* m, mjtNum* state, void* data, int instance) {
    guarded([&] {
        std::fill_n(state, m->plugin_statenum[instance], 0);
        if (data) static_cast<Instance*>(data)->rest();
        return 0;
    });
}

void compute(const mjModel* m, mjData* d, int instance, int) {
    guarded([&] {
        instance_of(d, instance)->compute(m, d, d->plugin_state + m->plugin_stateadr[instance]);
        return 0;
    });
}

void advance(const mjModel* m, mjData* d, int instance) {
    guarded([&] {
        instance_of(d, instance)->advance(d->plugin_state + m->plugin_stateadr[instance]);
        return 0;
    });
}

} // namespace

__attribute__((constructor)) static void dermis_register() {
    if (mj_version() != mjVERSION_HEADER)
        mju_error("dermis.skin: the plugin was built for MuJoCo %d, and is loaded by %d", mjVERSION_HEADER,
                  mj_version());
    mjpPlugin plugin;
    mjp_defaultPlugin(&plugin);
    plugin.name = "dermis.skin";
    plugin.nattribute = int(std::size(keys)), plugin.attributes = keys;
    plugin.capabilityflags = mjPLUGIN_SENSOR, plugin.needstage = mjSTAGE_ACC;
    plugin.nstate = nstate, plugin.nsensordata = nsensordata;
    plugin.init = init, plugin.destroy = destroy, plugin.reset = reset;
    plugin.compute = compute, plugin.advance = advance;
    mjp_registerPlugin(&plugin);
}
