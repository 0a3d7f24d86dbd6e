// SPDX-License-Identifier: MIT
// labels: threads command long
// Every allocation of the library fails, one after another, and from each one on: an error says so, never
// std::bad_alloc, and what comes next is as if nothing had happened.
#include "dermis/dermis.h"
#include "dermis/touch.hpp"
#include "host/core/base/pool.hpp"
#include "host/core/embedding/backend.hpp"
#include "host/core/press/device.hpp"
#include "host/doors/c/handles.hpp"
#include "tests/allocations.hpp"
#include "tests/command.hpp"
#include "tests/embedding_host.hpp"
#include "tests/shim.hpp"
#include "tests/support.hpp"

#include <atomic>
#include <cstdlib>
#include <regex>

using namespace test;

namespace {

using Numbers = std::vector<double>;

struct Figures {
    int failures = 0, errors = 0, without_words = 0;
} figures;

// Calls, and keeps what that throws.
template <class Work> std::exception_ptr thrown_by(Work&& work) noexcept {
    try {
        work();
    } catch (...) {
        return std::current_exception();
    }
    return nullptr;
}

std::string message_of(const std::exception_ptr& thrown) {
    if (!thrown) return "";
    try {
        std::rethrow_exception(thrown);
    } catch (const Error& e) {
        CHECK(e.code() == Error::Code::no_memory);
        return e.what();
    } catch (dermis_status status) {
        CHECK(status == DERMIS_NO_MEMORY);
        return dermis_last_error();
    } catch (const std::exception& e) {
        return std::string("not an Error: ") + e.what();
    }
}

// What a work throws when an allocation fails after so many others, if any fails.
struct Struck {
    bool struck = false;
    std::exception_ptr thrown;
};
template <class Work> Struck struck_after(long before, bool sticky, Work&& work) {
    FailingAllocation failing(before, sticky);
    std::exception_ptr thrown = thrown_by(work);
    return {failing.struck(), std::move(thrown)};
}

// Counts a failure and checks what came of it. Returns whether it was an error.
bool judge(const std::exception_ptr& thrown, bool sticky) {
    ++figures.failures;
    if (!thrown) return false;
    ++figures.errors;
    const std::string message = message_of(thrown);
    figures.without_words += message.find(": ") == std::string::npos;
    const bool in_c = message.find(" could not be allocated") != std::string::npos;
    CHECK_MESSAGE((in_c || message.find(sticky ? "out of memory" : "out of memory: ") != std::string::npos), message);
    return true;
}

// One of so many allocations fails; at_night: at night.
long stride_of(long at_night) { return night() ? at_night : 5 * at_night; }

// Fails each allocation of a work in turn, until there is none left to fail. The work itself allocates nothing outside
// the library: the numbers have room. at_night: as stride_of() has it. vulkan: whether the work uses a Vulkan
// device: for each device and each new pipeline exit() notes a function, in a list that grows by a block for 32.
template <class Work> void starve(const char* name, Work&& work, long at_night = 1, bool vulkan = false) {
    long calls = 0, grown = 0;
    const long stride = stride_of(at_night);
    Numbers right, got;
    got.reserve(100000);
    work(got);
    right = got;
    for (const bool sticky : {false, true})
        for (long before = 0;; before += stride) {
            INFO(std::string(name));
            CAPTURE(sticky);
            CAPTURE(before);
            got.clear();
            const long left = allocations_left();
            auto [struck, thrown] = struck_after(before, sticky, [&] { work(got); });
            ++calls;
            if (struck && judge(thrown, sticky)) {
                thrown = nullptr;
                grown += allocations_left() > left; // less where a driver has freed some of its own
                CHECK((vulkan || grown == 0));
                got.clear();
                work(got);
            }
            CHECK(got == right);
            if (!struck) {
                if (thrown) std::rethrow_exception(thrown);
                break;
            }
        }
    CHECK(grown <= (vulkan ? calls / 8 + 1 : 0));
}

void append(Numbers& all, const Result& r) {
    for (const Trace& t : r.traces) {
        for (const auto* column : {&t.mean, &t.min, &t.max}) all.insert(all.end(), column->begin(), column->end());
        for (const auto& probe : t.probes) all.insert(all.end(), probe.begin(), probe.end());
    }
    all.insert(all.end(), r.responses.begin(), r.responses.end());
    for (const Impulse& i : r.impulses) all.insert(all.end(), {i.time, i.mean, i.min, i.max});
    for (const Field& f : r.fields) all.insert(all.end(), f.values.begin(), f.values.end());
}

const std::string text = "[grid]\nwidth = 13\nheight = 9\n[surface]\nkind = \"wave\"\n[time]\nduration = 0.05\n"
                         "[output]\nprobes = [[3, 4]]\nfields = [{ at = 0.05, what = [\"sa1\", \"curvature\"] }]\n";

Scene scene_of(Model model) {
    Scene s = Scene::from_string(text);
    s.model = model;
    if (model == Model::sites || model == Model::moments) s.output.fields.clear();
    if (model == Model::sites) {
        s.output.traces.clear();
        s.output.probes.clear();
        s.sites = {{Quantity::sa1, {3, 4}}, {Quantity::fa2, {12, 8}}};
    }
    return s;
}

void append(Numbers& all, const Skin& skin, Quantity q) {
    const Skin::Response r = skin.response(q);
    all.insert(all.end(), r.begin(), r.end());
}

// A skin, or a batch of them, is pressed by this.
struct Pressing {
    SkinDescription description = small_scene(12, 8);
    SkinOptions options;
    Material softer = description.material;
    std::vector<float> pressures;
    std::vector<double> steps;
    mutable std::vector<char> state;

    Device device;

    explicit Pressing(int count, const Device& d = Device::cpu(1)) : device(d) {
        options.count = count;
        if (count > 1) options.materials.resize(size_t(count), description.material);
        softer.modulus = 0.5;
        pressures = frames_of(description, 0, size_t(count));
        steps.resize(size_t(count), 0.2);
        state.resize(Skin(device, description, options).state_bytes());
    }
    void operator()(Numbers& all) const {
        Skin skin(device, description, options);
        skin.press(pressures, 0.1);
        append(all, skin, Quantity::fa2);
        skin.save(state.data(), state.size());
        skin.reset();
        skin.load(state.data(), state.size());
        skin.set_material(softer);
        skin.press(pressures, steps);
        for (Quantity q : {Quantity::sa1, Quantity::strain, Quantity::curvature}) append(all, skin, q);
        all.push_back(skin.report(options.count - 1).gain.value);
    }
};

// The same in C, where a status is thrown by the test.
void need(dermis_status status) {
    if (status != DERMIS_OK) throw status;
}
void in_c(Numbers& all) {
    struct Handles {
        dermis_device* device = nullptr;
        dermis_scene* scene = nullptr;
        dermis_result* result = nullptr;
        dermis_skin* skin = nullptr;
        ~Handles() {
            dermis_skin_destroy(skin);
            dermis_result_destroy(result);
            dermis_scene_destroy(scene);
            dermis_device_close(device);
        }
    } h;
    need(dermis_device_open_cpu(1, &h.device));
    need(dermis_scene_from_string(text.c_str(), nullptr, &h.scene));
    need(dermis_scene_set(h.scene, "material.modulus", "2"));
    need(dermis_run(h.scene, h.device, &h.result));
    need(dermis_skin_create(h.device, h.scene, nullptr, &h.skin));
    const float pressure[13 * 9] = {1, 2, 3};
    const double dt = 0.1;
    need(dermis_skin_press(h.skin, pressure, std::size(pressure), &dt, 1, nullptr));
    const float* values = nullptr;
    size_t count = 0;
    need(dermis_skin_get_response(h.skin, DERMIS_FA1, &values, &count));
    all.insert(all.end(), values, values + count);
}

// A terminal's command with an allocation that fails; before: how many succeed, with "+" where all later ones fail.
Outcome starved(const Folder& folder, const std::string& arguments, const std::string& before) {
    return command(folder, arguments,
                   "LD_PRELOAD=\"" DERMIS_FAILING_ALLOCATION "${LD_PRELOAD:+:$LD_PRELOAD}\" DERMIS_ALLOCATION=" +
                       before + " DERMIS_ALLOCATIONS_FILE=" + (folder / "count").string());
}

// The names and contents of all files in a folder, but for what tells the time.
std::map<std::string, std::string> files_in(const std::filesystem::path& folder) {
    std::map<std::string, std::string> files;
    if (std::filesystem::exists(folder))
        for (const auto& entry : std::filesystem::directory_iterator(folder))
            files[entry.path().filename()] = entry.path().filename() == "summary.json" ? "" : slurp(entry.path());
    return files;
}

} // namespace

TEST_CASE("an allocation that fails in the library: an error says what needed how much, and nothing is left") {
    if (!allocations_fail()) return;
    for (Model model : {Model::moments, Model::maps, Model::sites, Model::march})
        starve(name(model), [s = scene_of(model)](Numbers& all) { append(all, run(s, Device::cpu(1))); });
    const Folder folder;
    folder.write("sites.csv", "type,x,y\nsa1,3,4\nfa2,11,7\n");
    folder.write("map.npy", npy_header("<f8", "(9, 13)") + std::string(9 * 13 * 8, '\0'));
    const std::string path = folder.write(
        "scene.toml", text + "[load]\nkind = \"file\"\npath = \"map.npy\"\n[sites]\npath = \"sites.csv\"\n");
    const std::vector<std::string> overrides = {"material.modulus=2", "surface.kind=wave"};
    starve("a file", [&](Numbers& all) {
        const Scene s = Scene::from_file(path, overrides);
        all.insert(all.end(),
                   {*s.material.modulus, s.load.intensity, double(s.sites.size()), double(s.load.map.size())});
    });
    for (int count : {1, 3}) starve("a skin", Pressing(count));
    const Scene s = scene_of(Model::maps);
    starve("plan", [&](Numbers& all) { all.push_back(double(plan(s, Device::cpu(1)).candidates.size())); });
    starve("population", [](Numbers& all) { all.push_back(double(population(fingertip().grid).size())); });
    const Relaxation relaxing{.moduli = {1, 2}, .times = {3, 4}, .equilibrium = 5};
    starve("a relaxation", [&](Numbers& all) { all.push_back(relaxation_of(chain_of(relaxing)).moduli[0]); });
}

namespace {

// Skins of three pads with every set of options, and every call that changes a state. Each starts from pads with steps
// of different lengths.
struct Starving {
    bool shear, parabolic, fibres, stretch;
    SkinDescription description;
    SkinOptions options;
    static constexpr size_t pad = 12 * 8;
    std::vector<float> pressure = std::vector<float>(6 * pad, 0.7f), traction = std::vector<float>(12 * pad, 0.2f);
    contact::Touch touch;
    Material softer;

    explicit Starving(int bits)
        : shear(bits & 1), parabolic(bits & 2), fibres(bits & 4), stretch(bits & 8),
          touch({.width = 12, .height = 8, .spacing = 5e-4}, 3, 1e-3, shear) {
        description = fingertip();
        description.grid = {12, 8, 5e-4};
        description.receptors.sa2_adaptation = 0.5;
        softer = description.material;
        for (auto& e : softer.elements) e.modulus /= 2;
        options.count = 3;
        options.shear = shear;
        if (parabolic) options.hold = Hold::parabolic;
        if (stretch) options.sa2_stretch = {1, 0};
        if (fibres) options.afferents = {{.type = Quantity::fa1, .cells = {{1, 1}, {4, 4}}}};
        const double place[3] = {3e-3, 2e-3, 0}, force[3] = {1e-6, 0, -1e-5}, radius = 1e-3;
        const double origin[3] = {}, axes[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
        const int32_t second = 1;
        touch.add({.position = origin, .rotation = axes, .position_step = 0, .rotation_step = 0},
                  {.count = 1, .pad = &second, .position = place, .force = force, .radius = &radius});
    }
    // The first pads. Nothing here allocates outside the library.
    void press(Skin& skin, double dt, size_t count = 3) const {
        constexpr int numbers[] = {0, 1, 2};
        const Pads list(numbers, count);
        if (shear) skin.press(pressure.data(), traction.data(), count * pad, dt, list);
        else skin.press(pressure.data(), count * pad, dt, list);
    }
    Skin made() const {
        Skin skin(Device::cpu(1), description, options);
        press(skin, 1e-3);
        press(skin, 2e-3, 1);
        return skin;
    }
    void call(int which, Skin& skin) const {
        constexpr double steps[] = {1e-3, 3e-2, 5e-3};
        if (which == 0) press(skin, 2e-2);
        if (which == 1) skin.press(touch, 4e-3);
        if (which == 2) skin.set_material(softer);
        if (which == 3) skin.reset();
        if (which == 4) (void)skin.response(shear ? Quantity::stretch_x : Quantity::curvature);
        if (which == 5 && !shear) skin.press(pressure.data(), 3 * pad, steps, 3);
        if (which == 6 && !shear) skin.press_frames(pressure.data(), 2, 3 * pad, 4e-2);
        if (which == 7 && !shear) skin.press_cells(pressure.data(), 3 * pad, 3e-2);
    }
    static constexpr int calls = 8;
};

} // namespace

TEST_CASE("a call that runs out of memory leaves every byte of a skin's state, and the same call then gives its bits") {
    if (!allocations_fail()) return;
    int failed = 0;
    for (int bits = 0; bits < 16; ++bits) {
        const Starving starving(bits);
        if (starving.stretch && !starving.shear) continue;
        for (int which = 0; which < Starving::calls; ++which) {
            Skin right = starving.made();
            const Bytes before = saved(right);
            starving.call(which, right);
            const Bytes after = saved(right);
            for (long k = 0;; ++k) {
                Skin skin = starving.made();
                const auto [struck, thrown] = struck_after(k, false, [&] { starving.call(which, skin); });
                CAPTURE(bits);
                CAPTURE(which);
                CAPTURE(k);
                if (!struck) break;
                if (!thrown) continue;
                ++failed;
                CHECK(message_of(thrown).find("out of memory: ") == 0);
                CHECK(saved(skin) == before);
                starving.call(which, skin);
                CHECK(saved(skin) == after);
            }
        }
    }
    CHECK(failed > 100);
}

TEST_CASE("an allocation that fails beside a Vulkan driver's own: the same, and the device works on") {
    if (!allocations_fail()) return;
    const vulkan::Loader loader = shimmed();
    starve(
        "a device", [&](Numbers& all) { all.push_back(open_device("0", loader).info().exact); }, 31, true);
    const Device device = open_device("0", loader);
    Scene s = scene_of(Model::march);
    s.precision = Precision::f32;
    starve(
        "a run", [&](Numbers& all) { append(all, run(s, device)); }, 1, true);
    starve("skins", Pressing(3, device), 1, true);
    const vulkan::Handles handles = vulkan::context_of(*device.impl().backend)->handles();
    const Pressing pressing(1);
    const auto program = [&](Numbers& all) {
        const vulkan::SkinProgram made(handles, pressing.description, 1, pressing.options);
        all.push_back(double(made.memory().check.bytes));
    };
    starve("a program", program, 31, true);
    Host host(*vulkan::context_of(*device.impl().backend), pressing.description, 1, pressing.options);
    vulkan::SkinProgram bound(handles, pressing.description, 100, pressing.options);
    starve(
        "a binding", [&](Numbers&) { (void)bound.bind(host.buffers(1)); }, 1, true);
}

TEST_CASE("an allocation that fails under the C interface is the status DERMIS_NO_MEMORY") {
    if (!allocations_fail()) return;
    dermis_scene* none = nullptr; // its message is longer than those to come, which then take no memory
    CHECK(dermis_scene_from_string((std::string(500, 'x') + "=").c_str(), nullptr, &none) == DERMIS_BAD_INPUT);
    starve("C", in_c);
}

TEST_CASE("what one of several threads throws reaches the caller, and the threads go on") {
    simd::Pool pool(3);
    for (int failing = 0; failing < pool.threads(); ++failing) {
        CHECK_THROWS_AS(pool.each([=](int thread) {
            if (thread == failing) throw std::bad_alloc();
        }),
                        std::bad_alloc);
        std::atomic<int> done = 0;
        pool.each([&](int) { ++done; });
        CHECK(done == pool.threads());
    }
}

TEST_CASE("an allocation that fails in the command: one line, status 1, and no file or all of them") {
    if (!allocations_fail()) return;
    const Folder folder;
    const std::string scene = folder.write("scene.toml", text), out = (folder / "out").string();
    int runs = 0, failed = 0;
    for (const auto& [arguments, at_night] :
         {std::pair<std::string, long>{"run " + scene + " --out " + out + " --device cpu", 1},
          {"run " + scene + " --out " + out + " --device cpu --set surface.kind=flat", 7},
          {"run " + scene + " --bogus", 7},
          {"plan " + scene + " --device cpu", 7},
          {"--help", 7}}) {
        std::filesystem::remove_all(out);
        const Outcome clean = starved(folder, arguments, "1000000000");
        const auto files = files_in(out);
        const long count = std::stol(slurp(folder / "count"));
        CAPTURE(arguments);
        CHECK(count > 50);
        const long stride = stride_of(at_night);
        for (const char* sticky : {"", "+"})
            for (long before = 0; before < count; before += stride, ++runs) {
                CAPTURE(before);
                CAPTURE(std::string(sticky));
                std::filesystem::remove_all(out);
                const Outcome o = starved(folder, arguments, std::to_string(before) + sticky);
                if (o.status == clean.status && o.err == clean.err) {
                    CHECK(files_in(out) == files);
                    continue;
                }
                ++failed;
                CHECK(o.status == 1);
                CHECK_MESSAGE(std::regex_match(o.err, std::regex("dermis: [^\n]*out of memory[^\n]*\n")), o.err);
                const auto left = files_in(out); // all where they had been written before
                CHECK((left.empty() || left == files));
            }
    }
    MESSAGE(figures.failures << " allocations failed in the library: " << figures.errors << " errors, "
                             << figures.failures - figures.errors << " absorbed, 0 leaks; " << runs
                             << " in the command: " << failed << " errors, " << runs - failed << " absorbed");
}
