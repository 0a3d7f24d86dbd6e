// SPDX-License-Identifier: MIT
// A finger in MuJoCo, from version 2.2 on: finger finger.xml
//
// A pad of 8 mm x 6 mm is pressed on a ridged plate at 1 kHz, held, slid and lifted. Prints what is checked, with
// numbers, and exits with 1 if something fails. host/examples/SIMULATOR.md explains it; finger.py does the same in
// Python, and checks what the finger feels.
#include <dermis/contact.hpp>
#include <dermis/dermis.hpp>

#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

namespace contact = dermis::contact;
using dermis::Quantity;
using std::numbers::pi;

constexpr double step = 1e-3;                  // s
constexpr double period = 1e-3, relief = 2e-5; // m: from crest to crest of the plate, and from valley to crest
constexpr int width = 80, height = 60, cells = width * height;
constexpr double spacing = 1e-4;  // m
constexpr double stiffness = 1e8; // Pa per m of sinking: a modulus of 1e5 Pa over a thickness of 1 mm
constexpr Quantity classes[] = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};

// Commands of the slider: times in s, places in m. The pad meets the plate on its way down, and leaves it on its way
// up.
constexpr int knots = 6;
using Way = std::array<double, knots>;
constexpr Way times = {0, 0.15, 0.45, 0.85, 0.90, 0.98};
constexpr Way along = {0, 0, 0, 0.016, 0.016, 0.016};
constexpr Way up = {0, -1.5e-3, -1.5e-3, -1.5e-3, -1.5e-3, 0};
constexpr int frames = 1050;

// A skin with the material of a fingertip. Its own ridges run as the plate's do.
dermis::SkinDescription skin_of_a_fingertip() {
    dermis::SkinDescription skin = dermis::fingertip();
    skin.grid = {.width = width, .height = height, .spacing = spacing};
    skin.surface.kind = dermis::Surface::Kind::wave;
    skin.surface.ridge_period = 1e-3;
    return skin;
}

// Returns how high the plate is at x, in m: its crests are those of the model.
double plate_height(double x) { return relief / 2 * (1 + std::cos(2 * pi * x / period)); }

double command(const Way& way, double time) {
    if (time <= times.front()) return way.front();
    for (int i = 1; i < knots; ++i)
        if (time <= times[i]) return std::lerp(way[i - 1], way[i], (time - times[i - 1]) / (times[i] - times[i - 1]));
    return way.back();
}

struct Delete {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
    void operator()(mjData* data) const { mj_deleteData(data); }
};
using Model = std::unique_ptr<mjModel, Delete>;
using Data = std::unique_ptr<mjData, Delete>;

// A finger with a simulation of its own, which writes the pressure on its skin.
class Finger {
  public:
    Finger(const mjModel* model, float* pressure)
        : model_(model), data_(mj_makeData(model)),
          depth_(cells), pad_{.width = width, .height = height, .spacing = spacing, .pressure = pressure},
          up_(model->jnt_dofadr[id(mjOBJ_JOINT, "up")]), site_(id(mjOBJ_SITE, "skin")), geom_(id(mjOBJ_GEOM, "pad")) {}

    // Advances by one step, and turns the contact into pressure.
    contact::ContactReport advance() {
        const double now = double(std::lround(data_->time / step)) * step;
        data_->ctrl[0] = command(along, now);
        data_->ctrl[1] = command(up, now);
        mj_step(model_, data_.get());
        // The site's frame and the contacts both belong to the start of this step; qpos already is that of its end.
        const contact::Pose middle =
            contact::Pose::from_matrix(data_->site_xpos + 3 * site_, data_->site_xmat + 9 * site_);
        const contact::Pose corner = middle.from_middle(pad_);
        // This pad looks straight down and its x is that of the world. What is above its plane has sunk in.
        for (int i = 0; i < cells; ++i)
            depth_[i] = float(plate_height(corner.position[0] + (i % width + 0.5) * spacing) - corner.position[2]);
        std::fill_n(pad_.pressure, cells, 0.0f);
        return contact::add_depths(pad_, {.depth = depth_.data(), .force = force(), .stiffness = stiffness});
    }

    // The force into the pad, added contact by contact, in N.
    double force() const {
        double total = 0;
        for (int i = 0; i < data_->ncon; ++i) {
            const mjContact& touch = data_->contact[i];
            mjtNum force[6], world[3];
            mj_contactForce(model_, data_.get(), i, force);
            mju_mulMatTVec(world, touch.frame, force, 3, 3);      // the frame's axes are rows
            total += touch.geom2 == geom_ ? world[2] : -world[2]; // it acts on geom2
        }
        return total;
    }

    double held_up() const { return data_->qfrc_constraint[up_]; } // N: the solver's force in the slider's equation

    Data save() const { return Data(mj_copyData(nullptr, model_, data_.get())); }
    void load(const Data& kept) { mj_copyData(data_.get(), model_, kept.get()); }

  private:
    int id(mjtObj kind, const char* name) const {
        const int found = mj_name2id(model_, kind, name);
        if (found < 0) throw std::runtime_error(std::string("the model has no ") + name);
        return found;
    }

    const mjModel* model_;
    Data data_;
    std::vector<float> depth_;
    contact::Pad pad_;
    int up_, site_, geom_;
};

// A recording has what one finger did and felt, frame by frame.
struct Recording {
    std::vector<double> held_up;
    std::vector<float> pressure;            // of frames*cells
    std::array<std::vector<float>, 4> felt; // the same, by class
    std::string doubts;
};

Recording record(const mjModel* model) {
    std::vector<float> pressure(cells);
    Finger finger(model, pressure.data());
    dermis::Skin skin(dermis::Device::cpu(1), skin_of_a_fingertip());
    Recording made;
    for (int n = 0; n < frames; ++n) {
        const contact::ContactReport report = finger.advance();
        skin.press(pressure, step);
        made.held_up.push_back(finger.held_up());
        made.pressure.insert(made.pressure.end(), pressure.begin(), pressure.end());
        for (int c = 0; c < 4; ++c) {
            const auto felt = skin.response(classes[c]);
            made.felt[c].insert(made.felt[c].end(), felt.begin(), felt.end());
        }
        if (made.doubts.empty()) made.doubts = report.doubts();
    }
    return made;
}

// Prints a claim with its numbers. Returns whether it holds.
template <class... Numbers> bool told(bool holds, const char* claim, const char* format, Numbers... numbers) {
    std::printf("%s %s: ", holds ? "ok    " : "FAILED", claim);
    std::printf(format, numbers...);
    std::printf("\n");
    return holds;
}

bool force_is_kept(const Recording& made) {
    double off = 0;
    for (int n = 0; n < frames; ++n) {
        const float* pressure = made.pressure.data() + size_t(n) * cells;
        const double integral = std::accumulate(pressure, pressure + cells, 0.0) * spacing * spacing;
        off = std::max(off, std::abs(integral - made.held_up[n]));
    }
    const double most = *std::max_element(made.held_up.begin(), made.held_up.end());
    return told(most > 0.3 && off < 1e-6 * most && made.doubts.empty(),
                "the integral of the pressure is the contact force",
                "up to %.4f N, off by %.1e of it; at most %.2f kPa; %s", most, off / most,
                *std::max_element(made.pressure.begin(), made.pressure.end()) / 1e3,
                made.doubts.empty() ? "no doubts" : made.doubts.c_str());
}

// Returns how many responses have other bits than a recorded frame.
size_t differing(const dermis::Skin& skin, const Recording& made, int n) {
    size_t wrong = 0;
    for (int c = 0; c < 4; ++c) {
        const float *now = skin.response(classes[c]).data, *then = made.felt[c].data() + size_t(n) * cells;
        for (int i = 0; i < cells; ++i) wrong += std::memcmp(now + i, then + i, sizeof(float)) != 0;
    }
    return wrong;
}

// Both states are kept while the pad slides, and taken back later: the same bits follow.
bool rolls_back(const mjModel* model, const Recording& made) {
    constexpr int at = 600, again = 100;
    std::vector<float> pressure(cells);
    Finger finger(model, pressure.data());
    dermis::Skin skin(dermis::Device::cpu(1), skin_of_a_fingertip());
    size_t wrong = 0;
    const auto play = [&](int begin, int end) {
        for (int n = begin; n < end; ++n) {
            finger.advance();
            skin.press(pressure, step);
            wrong += differing(skin, made, n);
        }
    };
    play(0, at);
    const Data moved = finger.save();
    std::vector<char> felt(skin.state_bytes());
    skin.save(felt.data(), felt.size());
    play(at, at + again);
    finger.load(moved);
    skin.load(felt.data(), felt.size());
    play(at, at + again);
    return told(wrong == 0, "a simulator and its skin roll back to the same bits",
                "%d frames again: %zu values differ, of a state of %zu bytes", again, wrong, felt.size());
}

} // namespace

int main(int count, char** arguments) try {
    if (count != 2) throw std::runtime_error("usage: finger finger.xml");
    char error[1000] = "";
    const Model model(mj_loadXML(arguments[1], nullptr, error, sizeof error));
    if (!model) throw std::runtime_error(error);
    std::printf("MuJoCo %s\n", mj_versionString());
    const Recording made = record(model.get());
    bool holds = force_is_kept(made);
    holds &= rolls_back(model.get(), made);
    return !holds;
} catch (const std::exception& e) {
    std::fprintf(stderr, "finger: %s\n", e.what());
    return 1;
}
