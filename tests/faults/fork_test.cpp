// SPDX-License-Identifier: MIT
// A forked child and what its parent has made: an error, never a number that is wrong or a wait that does not end.
#include "host/core/press/device.hpp"
#include "tests/support.hpp"

#include <functional>
#include <sys/wait.h>
#include <unistd.h>

using namespace test;

namespace {

constexpr unsigned long_enough = 120; // s; a child that hangs is ended, which fails the test

// Returns what waitpid() says of a child that does this, 0 where it returned true.
int status_of_child(const std::function<bool()>& deed) {
    const pid_t child = fork();
    if (child == 0) {
        alarm(long_enough);
        bool done = false;
        try {
            done = deed();
        } catch (...) {
        }
        _exit(done ? 0 : 1);
    }
    int status = -1;
    waitpid(child, &status, 0);
    return status;
}

// Whether a call is refused because another process has opened what it uses.
bool refused(const std::function<void()>& call) {
    try {
        call();
    } catch (const Error& e) {
        return e.code() == Error::Code::device &&
               std::string(e.what()).find(" opened by another process") != std::string::npos;
    }
    return false;
}

Scene marching() {
    Scene s = small_scene(64, 32);
    s.model = Model::march;
    s.precision = Precision::f32;
    return s;
}

SkinDescription large() { return small_scene(512, 256); } // worth two threads

std::vector<float> answer(const Device& device, const SkinDescription& d, int count) {
    SkinOptions options{.count = count};
    Skin skin(device, d, options);
    const std::vector<float> one = frame(d, 1);
    std::vector<float> all;
    for (int i = 0; i < count; ++i) all.insert(all.end(), one.begin(), one.end());
    skin.press(all, 0.1);
    return answers(skin, Quantity::fa1);
}

} // namespace

TEST_CASE("a forked child that uses its parent's threads or Vulkan device gets an error, and ends what it has") {
    const SkinDescription d = large(), pad = small_scene(64, 32);
    for (const char* name : {"cpu", "vulkan"}) {
        CAPTURE(name);
        const bool vulkan = std::string(name) == "vulkan";
        auto device = std::make_unique<Device>(vulkan ? Device::open("vulkan") : Device::cpu(2));
        SkinOptions options{.count = 64};
        auto skin = std::make_unique<Skin>(*device, d);
        auto batch = std::make_unique<Skin>(*device, pad, options);
        const std::vector<float> one = frame(d, 1), many(64 * 64 * 32, 1.0f);
        skin->press(one, 0.1);
        batch->press(many, 0.1);
        std::vector<char> state(skin->state_bytes());
        skin->save(state.data(), state.size());
        CHECK(status_of_child([&] {
                  bool all = refused([&] { skin->press(one, 0.1); }) && refused([&] { skin->press(one, 0.1); }) &&
                             refused([&] { batch->press(many, 0.1); });
                  if (vulkan)
                      all = all && refused([&] { skin->response(Quantity::sa1); }) &&
                            refused([&] { skin->response(Quantity::strain); }) && refused([&] { skin->reset(); }) &&
                            refused([&] { skin->load(state.data(), state.size()); }) &&
                            refused([&] { Skin(*device, pad); }) && refused([&] { run(marching(), *device); });
                  skin.reset();
                  batch.reset();
                  device.reset();
                  return all;
              }) == 0);
        // Nothing of that is seen by the parent.
        Skin twin(Device::cpu(1), d);
        for (int i : {1, 2}) twin.press(frame(d, i), 0.1);
        skin->press(frame(d, 2), 0.1);
        const Skin::Response a = skin->response(Quantity::fa2), b = twin.response(Quantity::fa2);
        CHECK(std::equal(a.begin(), a.end(), b.begin(), b.end()));
    }
}

TEST_CASE("a forked child makes skins and devices of the CPU, and presses skins of one thread: the same bits") {
    const SkinDescription d = large(), pad = small_scene(64, 32);
    const std::vector<float> right = answer(Device::cpu(1), d, 1), batch = answer(Device::cpu(1), pad, 64);
    const Device used = Device::cpu(2), one = Device::cpu(1), vulkan = Device::open("vulkan");
    for (const Device* device : {&used, &one, &vulkan}) CHECK(answer(*device, d, 1) == right);
    Skin alone(one, d);
    CHECK(status_of_child([&] {
              alone.press(frame(d, 1), 0.1);
              return answers(alone, Quantity::fa1) == right;
          }) == 0);
    for (const bool open : {false, true})
        CHECK(status_of_child([&] {
                  const Device own = open ? Device::cpu(2) : used;
                  return answer(own, d, 1) == right && answer(own, pad, 64) == batch;
              }) == 0);
}

TEST_CASE("a forked child of a process that has used Vulkan opens no Vulkan device: an error, and auto is the CPU") {
    const SkinDescription d = large();
    const Device vulkan = Device::open("vulkan");
    const std::vector<float> right = answer(vulkan, d, 1);
    CHECK(status_of_child([&] {
              const auto says = [](const std::string& why) {
                  return why.find("a Vulkan driver was opened by another process") != std::string::npos;
              };
              for (const char* name : {"vulkan", "0"})
                  if (!says(refusal(Error::Code::no_device, [&] { Device::open(name); }))) return false;
              const Device own = Device::open("auto");
              return !own.info().vulkan && says(own.info().refused) && answer(own, d, 1) == right;
          }) == 0);
    CHECK(answer(vulkan, d, 1) == right);
}
