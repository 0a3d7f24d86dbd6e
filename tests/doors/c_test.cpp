// SPDX-License-Identifier: MIT
// labels: threads
// The C interface beside C++: the numbers of runs, and no allocation. That its presses have the same bits is what the
// suite `ways` says; how it is used from C: tests/doors/c.
#include "host/doors/c/handles.hpp"
#include "tests/allocations.hpp"
#include "tests/support.hpp"

#include <cstring>
#include <new>
#include <thread>

using namespace test;

namespace {

const char pad[] = "[grid]\nwidth = 25\nheight = 20\n[surface]\nkind = \"wave\"\nnoise = 0\n[material]\nmodulus = 2\n"
                   "[receptors]\nfa2 = \"step-mean\"\n[time]\nduration = 1\n[output]\nprobes = [[3, 4]]\n"
                   "fields = [{ at = 0.5, what = [\"fa1\"] }]\n";

struct Destroy {
    void operator()(dermis_device* d) const { dermis_device_close(d); }
    void operator()(dermis_scene* s) const { dermis_scene_destroy(s); }
    void operator()(dermis_result* r) const { dermis_result_destroy(r); }
    void operator()(dermis_skin* s) const { dermis_skin_destroy(s); }
};
template <class Handle> using Owned = std::unique_ptr<Handle, Destroy>;

// The handle that a call makes.
template <class Handle, class Call> Owned<Handle> made(Call&& call) {
    Handle* handle = nullptr;
    const dermis_status status = call(&handle);
    REQUIRE_MESSAGE(status == DERMIS_OK, dermis_last_error());
    return Owned<Handle>(handle);
}

Owned<dermis_scene> c_scene() {
    return made<dermis_scene>([](auto s) { return dermis_scene_from_string(pad, nullptr, s); });
}

// Whether a response in C has the bits of that in C++.
bool same_response(const dermis_skin* in_c, const Skin& skin, Quantity q) {
    const Skin::Response expected = skin.response(q);
    const float* values = nullptr;
    size_t count = 0;
    CHECK(dermis_skin_get_response(in_c, int(q), &values, &count) == DERMIS_OK);
    REQUIRE(count == expected.size);
    return std::memcmp(values, expected.data, count * sizeof(float)) == 0;
}

} // namespace

TEST_CASE("a run in C has the numbers of the run in C++") {
    const Owned<dermis_scene> scene = c_scene();
    const auto result = made<dermis_result>([&](auto r) { return dermis_run(scene.get(), nullptr, r); });
    const Scene own = Scene::from_string(pad);
    const Result r = run(own);
    const double* values = nullptr;
    size_t count = 0;
    const auto same = [&](const std::vector<double>& expected) {
        return count == expected.size() && std::memcmp(values, expected.data(), count * sizeof(double)) == 0;
    };
    CHECK(dermis_result_get_times(result.get(), &values, &count) == DERMIS_OK);
    CHECK(same(r.time));
    for (Quantity q : own.output.traces) {
        const Trace& trace = r.trace(q);
        for (auto [column, expected] :
             {std::pair{DERMIS_MEAN, &trace.mean}, {DERMIS_MIN, &trace.min}, {DERMIS_MAX, &trace.max}}) {
            CHECK(dermis_result_get_trace(result.get(), int(q), column, &values, &count) == DERMIS_OK);
            CHECK(same(*expected));
        }
        CHECK(dermis_result_get_probe(result.get(), int(q), 0, &values, &count) == DERMIS_OK);
        CHECK(same(trace.probes[0]));
    }
    CHECK(dermis_result_get_field(result.get(), DERMIS_FA1, 0.5, &values, &count) == DERMIS_OK);
    CHECK(same(r.fields[0].values));
    const Report expected = report(own, r);
    dermis_report actual{};
    actual.size = sizeof actual;
    CHECK(dermis_result_get_report(result.get(), &actual) == DERMIS_OK);
    CHECK(actual.strain.value == expected.strain.value);
    CHECK(actual.gain.value == expected.gain.value);
    CHECK(actual.gain.greatest == expected.gain.greatest);
    CHECK(actual.cells_per_ridge.value == expected.cells_per_ridge.value);
    CHECK(actual.cells_per_ridge.least == expected.cells_per_ridge.least);
    uint32_t changed = 0;
    for (Quantity q : expected.sign_changed) changed |= DERMIS_BIT(int(q));
    CHECK(actual.sign_changed == changed);
    CHECK(changed != 0);
}

TEST_CASE("a press in C allocates nothing, and a skin of a scene presses as one in C++") {
    const auto device = made<dermis_device>([](auto d) { return dermis_device_open_cpu(1, d); });
    const auto in_c =
        made<dermis_skin>([&](auto s) { return dermis_skin_create(device.get(), c_scene().get(), nullptr, s); });
    const Scene scene = Scene::from_string(pad);
    Skin skin(Device::cpu(1), scene);
    for (int i = 0; i < 5; ++i) {
        const std::vector<float> pressure = frame(scene, i);
        skin.press(pressure, 0.01 * i);
        const double dt = 0.01 * i;
        const size_t before = allocations();
        const dermis_status status = dermis_skin_press(in_c.get(), pressure.data(), pressure.size(), &dt, 1, nullptr);
        CHECK(allocations() == before);
        REQUIRE(status == DERMIS_OK);
        for (Quantity q : all_responses) CHECK(same_response(in_c.get(), skin, q));
    }
}

TEST_CASE("contacts in C allocate nothing") {
    std::vector<float> pressure(40 * 30);
    const dermis_contact_pad pad{
        .size = sizeof pad, .width = 40, .height = 30, .spacing = 1e-3, .pressure = pressure.data()};
    const dermis_contact some[] = {{.x = 0.01, .y = 0.02, .force = 0.5, .radius = 3e-3}, {.x = 1, .y = 1, .force = 1}};
    dermis_contact_report report{};
    report.size = sizeof report;
    const size_t before = allocations();
    const dermis_status status = dermis_add_contacts(&pad, some, 2, &report);
    CHECK(allocations() == before);
    CHECK(status == DERMIS_OK);
}

TEST_CASE("a Vulkan device in C tells its uuid, and one that does not exist is named") {
    const auto device = made<dermis_device>([](auto d) { return dermis_device_open("vulkan", d); });
    dermis_device_info info{};
    info.size = sizeof info;
    CHECK(dermis_device_get_info(device.get(), &info) == DERMIS_OK);
    CHECK(info.vulkan == 1);
    CHECK(info.uuid == Device::open("vulkan").info().uuid);
    info = {.size = offsetof(dermis_device_info, uuid)}; // of a program that was compiled before the uuid
    CHECK(dermis_device_get_info(device.get(), &info) == DERMIS_OK);
    CHECK(info.vulkan == 1);
    CHECK(info.uuid == nullptr);
    dermis_device* none = nullptr;
    CHECK(dermis_device_open("no such device", &none) == DERMIS_BAD_INPUT);
    CHECK(none == nullptr);
    CHECK(std::string(dermis_last_error())
              .find("no such device; allowed: auto (a GPU if there is one, else the CPU path), cpu, ") !=
          std::string::npos);
}

TEST_CASE("every exception is a status with a message, and each thread has its own") {
    using c::guarded;
    const auto status = [](Error::Code code) { return guarded([&] { throw Error(code, "", "an error"); }); };
    CHECK(status(Error::Code::bad_input) == DERMIS_BAD_INPUT);
    CHECK(status(Error::Code::no_device) == DERMIS_NO_DEVICE);
    CHECK(status(Error::Code::device) == DERMIS_DEVICE_FAILED);
    CHECK(status(Error::Code::io) == DERMIS_IO);
    CHECK(dermis_last_error() == std::string("an error"));
    std::thread([] {
        CHECK(dermis_last_error() == std::string());
        CHECK(guarded([] { throw std::bad_alloc(); }) == DERMIS_NO_MEMORY);
        CHECK(dermis_last_error() == std::string("memory could not be allocated"));
        CHECK(guarded([] { throw 3; }) == DERMIS_INTERNAL);
    }).join();
    CHECK(dermis_last_error() == std::string("an error"));
    CHECK(guarded([] { throw std::runtime_error("another"); }) == DERMIS_INTERNAL);
    CHECK(dermis_last_error() == std::string("another"));
}
