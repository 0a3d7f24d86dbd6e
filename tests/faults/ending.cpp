// SPDX-License-Identifier: MIT
// Ends as its argument says, with a Vulkan skin that nobody has destroyed before: the suite `ending` looks at how.
#include "dermis/dermis.hpp"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

using namespace dermis;

namespace {

constexpr int width = 64, height = 64;

// The device that a test names, if it names one, because "vulkan" takes none whose bits differ.
Device opened() {
    const char* named = std::getenv("DERMIS_TEST_DEVICE");
    return Device::open(named ? named : "vulkan");
}

struct World {
    std::optional<Device> device;
    std::optional<Skin> skin;

    void open() {
        if (!device) device = opened();
        SkinDescription d;
        d.grid.width = width;
        d.grid.height = height;
        skin.emplace(*device, d);
    }
    void press() { skin->press(std::vector<float>(width * height, 2), 0.01); }
    void read() { (void)skin->response(Quantity::fa1); }
};

World global;
World& local() { // made before its device
    static World world;
    return world;
}
World& late() { // and after
    static const Device device = opened();
    static World world{device, {}};
    return world;
}

std::atomic<int> stage{0};
constexpr int refused = 9; // a stage

// Opens, presses and reads for ever in a thread that nobody joins; returns when it has come to a stage. Ends the
// process with 1 if it cannot come there.
void wait_for_thread(int wanted) {
    std::thread([] {
        try {
            World own;
            stage = 1;
            own.device = opened();
            stage = 2;
            own.open();
            stage = 3;
            for (;; stage = 4) own.press(), own.read();
        } catch (const Error& error) { // the process is ending, or there is no such device
            if (stage < 3) std::fprintf(stderr, "%s\n", error.what());
            if (stage < 3) stage = refused;
            for (;;) pause();
        }
    }).detach();
    while (stage < wanted) std::this_thread::yield();
    if (stage == refused) std::_Exit(1);
}

// Presses at depths, on the CPU path, and reports: once by main() and once more when its static objects are gone.
void press_on_cpu() {
    SkinDescription d = fingertip();
    d.grid = {24, 24, 5e-4};
    d.sites.clear();
    d.receptors.depth = {.sa1 = 3e-4};
    Skin skin(Device::cpu(1), d);
    skin.press(std::vector<float>(24 * 24, 2), 0.01);
    if (!(skin.report().strain.value > 0)) std::_Exit(1);
}

void run_until(double done) {
    Scene scene;
    scene.grid.width = scene.grid.height = 64;
    scene.model = Model::march;
    scene.precision = Precision::f32;
    RunOptions options;
    options.progress = [done](double fraction) {
        if (fraction >= done) std::exit(0);
    };
    run(scene, opened(), options);
}

} // namespace

int main(int, char** arguments) {
    const std::string way = arguments[1];
    World& world = way == "local" ? local() : way == "late" ? late() : global;
    if (way.starts_with("thread")) {
        const int wanted = way.back() - '0';
        wait_for_thread(std::min(wanted, 4));
        if (wanted == 5) std::this_thread::sleep_for(std::chrono::milliseconds(20));
        return 0;
    }
    if (way == "later") {
        std::atexit(press_on_cpu); // runs after the ends of all that is made from here on
        press_on_cpu();
        return 0;
    }
    if (way == "progress") run_until(0.3);
    world.open();
    if (way != "unpressed") world.press();
    if (way == "late" || way == "twice") world.read();
    if (way == "twice") global.device.reset(), global.open(), world.press(); // the first device is held by nothing
    if (way == "forked") {
        const pid_t child = fork();
        // With the parent's skin; on hardware without the handlers of exit() (dermis/device.hpp).
        if (child == 0 && world.device->info().kind != "software") _exit(0);
        if (child == 0) return 0;
        int status = -1;
        waitpid(child, &status, 0);
        return status != 0;
    }
    if (way == "own") { // a child that asks for a device, beside a thread of the parent's
        wait_for_thread(4);
        const pid_t child = fork();
        if (child == 0) {
            bool refused = false;
            try {
                opened();
            } catch (const Error& error) {
                refused = error.code() == Error::Code::no_device;
            }
            static World own{Device::open("auto"), {}};
            own.open(), own.press();
            _exit(own.device->info().vulkan || !refused);
        }
        int status = -1;
        waitpid(child, &status, 0);
        return status != 0;
    }
    if (way == "exit") std::exit(0);
    return 0;
}
