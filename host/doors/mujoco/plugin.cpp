// SPDX-License-Identifier: MIT
// Skin in a MuJoCo model, without code: a sensor plugin, "dermis.skin". The sites of all sensors that name one instance
// are the pads of one dermis::Skin. Contacts of a site's body press its pad, at each step; the skin's state is in
// mjData, so that a rollback by mj_setState is one of the skin too. host/examples/SIMULATOR.md lists the keys.
#include "host/doors/mujoco/config.hpp"

#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <set>

namespace dermis::mujoco {
namespace {

// A table of shapes of what touches pads, and the geoms that are in it.
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

// A sensor's pad.
struct Pad {
    int site, body, out; // out: in mjData::sensordata
};

std::string name_of(const mjModel* m, int type, int number) {
    const char* name = mj_id2name(m, type, number);
    return name && *name ? '"' + std::string(name) + '"' : "number " + std::to_string(number);
}

// The sensors of an instance, in the model's order. length: the numbers of each.
std::vector<Pad> pads_of(const mjModel* m, int instance, int length) {
    std::vector<Pad> pads;
    for (int s = 0; s < m->nsensor; ++s) {
        if (m->sensor_type[s] != mjSENS_PLUGIN || m->sensor_plugin[s] != instance) continue;
        if (m->sensor_objtype[s] != mjOBJ_SITE) refuse("objtype", "(another)", "site: a pad is on a site");
        const int site = m->sensor_objid[s], body = m->site_bodyid[site];
        if (m->body_geomnum[body] == 0)
            refuse("objname", name_of(m, mjOBJ_SITE, site), "a site on a body that has a geom itself");
        const double first = m->sensor_adr[s];
        if (m->sensor_dim[s] != length || first < 0 || first + length > double(m->nsensordata))
            refuse("sensor", name_of(m, mjOBJ_SENSOR, s) + " with " + std::to_string(m->sensor_dim[s]) + " numbers",
                   std::to_string(length) + " inside sensordata: the keys, or the scene, have changed");
        pads.push_back({site, body, m->sensor_adr[s]});
    }
    return pads;
}

// How far the face of a box goes on beyond the border of each pad that lies on one, m: along x down and up, then along
// y.
std::vector<std::array<double, 4>> faces_of(const mjModel* m, const Config& config, const std::vector<Pad>& pads) {
    std::vector<std::array<double, 4>> found;
    const double half[] = {0.5 * config.scene.grid.width * *config.scene.grid.spacing,
                           0.5 * config.scene.grid.height * *config.scene.grid.spacing};
    for (const Pad& pad : pads)
        for (int g = m->body_geomadr[pad.body]; g < m->body_geomadr[pad.body] + m->body_geomnum[pad.body]; ++g) {
            mjtNum turn[4], to[4], between[3], place[3], axes[9];
            mju_negQuat(to, m->geom_quat + 4 * g);
            mju_sub3(between, m->site_pos + 3 * pad.site, m->geom_pos + 3 * g);
            mju_rotVecQuat(place, between, to); // the site's in the frame of the box
            mju_mulQuat(turn, to, m->site_quat + 4 * pad.site);
            mju_quat2Mat(axes, turn);
            const mjtNum* size = m->geom_size + 3 * g;
            const auto along = [&](int axis) { // which axis of the box it is along, or -1
                for (int k = 0; k < 3; ++k)
                    if (std::abs(axes[3 * k + axis]) > 1 - 1e-6) return k;
                return -1;
            };
            const int x = along(0), y = along(1), z = along(2);
            if (m->geom_type[g] != mjGEOM_BOX || x < 0 || y < 0 || z < 0) continue;
            if (std::abs(place[z] * axes[3 * z + 2] - size[z]) > 1e-3 * size[z]) continue;
            const double at_x = place[x] * axes[3 * x], at_y = place[y] * axes[3 * y + 1];
            found.push_back({size[x] + at_x - half[0], size[x] - at_x - half[0], size[y] + at_y - half[1],
                             size[y] - at_y - half[1]});
        }
    return found;
}

class Instance {
  public:
    Instance(const mjModel* m, int instance)
        : config_(m, instance), pads_(pads_of(m, instance, config_.sensor_numbers)), skin_(config_.skin()),
          touch_(config_.shape(), config_.options.count, config_.reach, config_.options.shear,
                 config_.source_on(faces_of(m, config_, pads_))),
          held_(size_t(Config::state_numbers(skin_))) {
        if (pads_.size() != size_t(config_.options.count))
            refuse("pads", std::to_string(config_.options.count),
                   std::to_string(pads_.size()) + ", the sensors of this instance");
        if (size_t(m->plugin_statenum[instance]) != held_.size())
            refuse("scene", "(another one)", "the one that the model was read with: the skin's state has another size");
    }

    // From the state in mjData, as often as the step is computed.
    void compute(const mjModel* m, mjData* d, const mjtNum* state) {
        const bool holds = !ahead_ && std::memcmp(held_.data(), state, held_.size() * sizeof(mjtNum)) == 0;
        ahead_ = true;
        if (!holds && state[0] == 0) skin_.reset();
        else if (!holds) skin_.load(state + 1, skin_.state_bytes());
        const contact::Contacts forces = contacts(m, d);
        touch_.add(poses(d), forces, shapes_.columns());
        skin_.press(touch_, m->opt.timestep);
        write(d);
        warn(m, d);
    }
    void advance(mjtNum* state) {
        if (!ahead_) return; // nothing has been computed: sensors are disabled
        skin_.save(state + 1, skin_.state_bytes());
        state[0] = 1;
        std::copy_n(state, held_.size(), held_.data());
        ahead_ = false;
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
    contact::Contacts contacts(const mjModel* m, mjData* d) {
        pad_.clear();
        body_.clear();
        table_.clear();
        shapes_.clear();
        for (int k = 0; k < d->ncon; ++k)
            for (int side = 0; side < 2; ++side) add_contact(m, d, k, side);
        const bool hertz = config_.patch == 0 && config_.ball > 0; // else bodies without a shape press two cells
        return {.count = pad_.size(),
                .pad = pad_.data(),
                .position = table_.data(),
                .force = table_.data() + 3,
                .radius = config_.patch > 0 ? &config_.patch : nullptr,
                .ball = hertz ? &config_.ball : nullptr,
                .modulus = hertz ? config_.modulus : 0,
                .body = body_.data(),
                .torque = table_.data() + 6,
                .position_step = 9,
                .force_step = 9,
                .radius_step = 0,
                .ball_step = 0,
                .torque_step = 9};
    }
    // A contact presses the pads on the body of one of its geoms. Its place is the middle between both surfaces.
    void add_contact(const mjModel* m, mjData* d, int k, int side) {
        const mjContact& c = d->contact[k];
        if (c.geom[side] < 0) return;
        for (size_t p = 0; p < pads_.size(); ++p) {
            if (m->geom_bodyid[c.geom[side]] != pads_[p].body) continue;
            for (int geom : c.geom)
                if (geom >= 0) keep_awake(m, d, m->geom_bodyid[geom]);
            mjtNum own[6], force[6], place[3]; // forces with their moments
            mj_contactForce(m, d, k, own);
            mju_mulMatTVec(force, c.frame, own, 3, 3);
            mju_mulMatTVec(force + 3, c.frame, own + 3, 3, 3);
            if (side == 0) mju_scl(force, force, -1, 6);                           // they act on the second geom
            mju_addScl3(place, c.pos, c.frame, (side == 0 ? -0.5 : 0.5) * c.dist); // on this geom's surface
            pad_.push_back(int32_t(p));
            body_.push_back(config_.bodies ? shapes_.add(m, d, int32_t(p), c.geom[1 - side]) : -1);
            table_.insert(table_.end(), place, place + 3);
            table_.insert(table_.end(), force, force + 6);
        }
    }
    // A body that sleeps has no contacts, so what touches a pad is kept from falling asleep, as if it still moved.
    void keep_awake([[maybe_unused]] const mjModel* m, [[maybe_unused]] mjData* d, [[maybe_unused]] int body) {
#ifdef mjMINAWAKE // MuJoCo from 3.4 on has bodies that sleep
        const int tree = m->body_treeid[body], moving = -(1 + mjMINAWAKE);
        if (tree < 0 || d->tree_asleep[tree] <= moving || d->tree_asleep[tree] >= 0) return;
        d->tree_asleep[tree] = moving;
        if (is_first("awake", body))
            mju_warning("dermis.skin: the body %s does not fall asleep while it touches a pad. This is said once",
                        name_of(m, mjOBJ_BODY, body).c_str());
#endif
    }
    // Whether this is the first time for a body: MuJoCo too says what it warns of once in an mjData.
    bool is_first(const char* what, int body) { return said_.insert({what, body}).second; }
    // Writes what is read, each output of a pad behind the one before.
    void write(mjData* d) const {
        const size_t cells = config_.cells();
        size_t first = 0;
        for (const std::optional<Quantity>& output : config_.read) {
            for (size_t p = 0; p < pads_.size(); ++p) {
                mjtNum* out = d->sensordata + size_t(pads_[p].out) + first;
                const float* values = output ? skin_.response(*output).data + p * cells : nullptr;
                if (!output) out[0] = touch_.report(int(p)).placed, out[1] = touch_.report(int(p)).outside;
                else if (config_.fields) std::copy_n(values, cells, out);
                else
                    *out = std::transform_reduce(values, values + cells, 0.0, std::plus(), [](double x) { return x; }) /
                           double(cells);
            }
            first += config_.length(output);
        }
    }
    // Says that more than a tenth of the force on a body, of which each of its pads was asked for all, presses none.
    void warn(const mjModel* m, const mjData* d) {
        for (int p : touch_.touched()) {
            const contact::ContactReport& r = touch_.report(p);
            const int body = pads_[size_t(p)].body;
            double lost = r.outside > 0.1 * r.asked ? r.asked : 0;
            for (int q : touch_.touched())
                if (lost > 0 && pads_[size_t(q)].body == body)
                    lost -= touch_.report(q).placed + touch_.report(q).sideways;
            if (lost > 0.1 * r.asked && is_first("lost", body))
                mju_warning("dermis.skin: at %.6g s, %.3g of %.3g N on the body %s press none of its pads. At the site "
                            "%s %s This is said once; the output \"force\" has it at each step",
                            d->time, lost, r.asked, name_of(m, mjOBJ_BODY, body).c_str(),
                            name_of(m, mjOBJ_SITE, pads_[size_t(p)].site).c_str(), r.doubts().c_str());
        }
    }

    const Config config_;
    const std::vector<Pad> pads_;
    Skin skin_;
    contact::Touch touch_;
    std::vector<double> places_, axes_, table_; // table_: place, force and moment of each contact
    std::vector<int32_t> pad_, body_;           // of each contact
    Shapes shapes_;
    std::vector<mjtNum> held_; // the state in mjData that the skin had last; all 0: a skin at rest
    bool ahead_ = false;       // whether the skin is a step ahead of it
    std::set<std::pair<std::string, int>> said_;
};

// The instances of all mjData, which has no pointer to them: another process may have pickled it. Never destroyed: a
// program may free mjData when it ends.
struct Living {
    std::mutex in_use;
    std::map<std::pair<const mjData*, int>, std::unique_ptr<Instance>> all;
};
Living& living = *new Living;

Instance& instance_of(const mjModel* m, const mjData* d, int i) {
    const std::lock_guard lock(living.in_use);
    std::unique_ptr<Instance>& found = living.all[{d, i}];
    if (!found) found = std::make_unique<Instance>(m, i);
    return *found;
}

void destroy(mjData* d, int instance) {
    const std::lock_guard lock(living.in_use);
    living.all.erase({d, instance});
}

// Calls; MuJoCo's C takes no exception, so a refusal is MuJoCo's error, once the exception is gone.
template <class Call> auto guarded(Call call) -> decltype(call()) {
    static thread_local char why[400];
    try {
        return call();
    } catch (const std::exception& e) {
        std::snprintf(why, sizeof why, "%s", e.what());
    }
    mju_error("dermis.skin: %s", why);
    return decltype(call())();
}

// MuJoCo asks before the model has its sensors, so that pads cannot be counted here.
int nstate(const mjModel* m, int instance) {
    return guarded([&] { return Config::state_numbers(Config(m, instance).skin()); });
}

int nsensordata(const mjModel* m, int instance, int) {
    return guarded([&] { return Config(m, instance).sensor_numbers; });
}

int init(const mjModel* m, mjData* d, int instance) {
    guarded([&] {
        destroy(d, instance); // that of an mjData that had this address
        instance_of(m, d, instance);
    });
    return 0;
}

void reset(const mjModel* m, mjtNum* state, void*, int instance) {
    std::fill_n(state, m->plugin_statenum[instance], 0);
}

void compute(const mjModel* m, mjData* d, int instance, int) {
    guarded([&] { instance_of(m, d, instance).compute(m, d, d->plugin_state + m->plugin_stateadr[instance]); });
}

void advance(const mjModel* m, mjData* d, int instance) {
    guarded([&] { instance_of(m, d, instance).advance(d->plugin_state + m->plugin_stateadr[instance]); });
}

} // namespace
} // namespace dermis::mujoco

__attribute__((constructor)) static void dermis_register() {
    using namespace dermis::mujoco;
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
