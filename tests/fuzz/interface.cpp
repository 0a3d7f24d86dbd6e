// SPDX-License-Identifier: MIT
// The C interface: bytes choose calls, their order and their numbers. Pointers lead to memory, or are NULL.
#include "dermis/dermis.h"
#include "tests/fuzz/fuzz.hpp"

#include <algorithm>

#include <fuzzer/FuzzedDataProvider.h>

namespace {

constexpr const char* scenes[] = {
    "grid = { width = 4, height = 3 }", "grid = { width = 1, height = 1 }\nmethod = \"euler\"",
    "[grid]\nwidth = 3\nheight = 2\n[material]\nelements = [{ modulus = 2, viscosity = 1 }]\nspring = 3",
    "preset = \"fingertip\"\ngrid = { width = 5, height = 4 }"};
constexpr int most_cells = 64; // of a grid, so that each call is quick

class Calls {
  public:
    Calls(const uint8_t* data, size_t size) : bytes_(data, size) {}
    ~Calls() {
        dermis_result_destroy(result_);
        dermis_skin_destroy(skin_);
        dermis_scene_destroy(scene_);
    }

    void make() {
        static void (Calls::*const all[])() = {&Calls::scene, &Calls::set,  &Calls::map,    &Calls::skin,
                                               &Calls::press, &Calls::read, &Calls::state,  &Calls::material,
                                               &Calls::run,   &Calls::add,  &Calls::depths, &Calls::taxels};
        for (int i = 0; i < 32 && bytes_.remaining_bytes(); ++i) (this->*bytes_.PickValueInArray(all))();
    }

  private:
    // A call that is refused says why.
    bool done(dermis_status status) {
        if (status != DERMIS_OK) fuzz::need_one_line(dermis_last_error());
        return status == DERMIS_OK;
    }
    int byte() { return bytes_.ConsumeIntegral<uint8_t>(); }
    template <class T> std::vector<T> numbers(size_t most) {
        std::vector<T> all(bytes_.ConsumeIntegralInRange<size_t>(0, most));
        for (T& x : all) x = byte() < 200 ? T(byte()) / 16 : bytes_.ConsumeFloatingPoint<T>();
        return all;
    }
    double number() { return byte() < 200 ? byte() / 64.0 : bytes_.ConsumeFloatingPoint<double>(); }
    bool small() const {
        int32_t width = 0, height = 0;
        return scene_ && dermis_scene_get_size(scene_, &width, &height) == DERMIS_OK && width * height <= most_cells;
    }
    // All pads, or a list of them.
    const dermis_pads* pads() {
        if (byte() < 128) return nullptr;
        list_.resize(size_t(byte() % 5));
        for (int32_t& pad : list_) pad = byte() < 250 ? byte() % 4 : bytes_.ConsumeIntegral<int32_t>();
        pads_ = {list_.data(), list_.size()};
        return &pads_;
    }

    void scene() {
        dermis_scene_destroy(scene_);
        scene_ = nullptr;
        done(dermis_scene_from_string(bytes_.PickValueInArray(scenes), nullptr, &scene_));
        runs_ = true;
    }
    void set() {
        const std::string key = bytes_.ConsumeRandomLengthString(32), value = bytes_.ConsumeRandomLengthString(64);
        if (!scene_ || key.find("sites") != key.npos || value.find("spacing") != value.npos) return; // may be many
        runs_ &= !done(dermis_scene_set(scene_, key.c_str(), value.c_str())); // it may be long now
    }
    void map() {
        const char* const keys[] = {"surface.path", "load.path", "material.modulus", "material.viscosity", "time.step"};
        const std::vector<double> values = numbers<double>(20);
        done(dermis_scene_set_map(scene_, bytes_.PickValueInArray(keys), values.data(), values.size()));
    }
    void skin() {
        dermis_skin_destroy(skin_);
        skin_ = nullptr;
        if (!small()) return;
        dermis_skin_options options = {sizeof options, byte() % 5, uint32_t(byte()) % 64, byte() % 4, byte() % 3};
        done(dermis_skin_create(device(), scene_, byte() < 64 ? nullptr : &options, &skin_));
    }
    void press() {
        const std::vector<float> pressure = numbers<float>(48);
        const std::vector<double> dt = numbers<double>(4);
        if (dt.size() == 3)
            done(dermis_skin_press_frames(skin_, pressure.data(), 2, pressure.size() / 2, dt[0], pads()));
        else done(dermis_skin_press(skin_, pressure.data(), pressure.size(), dt.data(), dt.size(), pads()));
    }
    void read() {
        const float* values = nullptr;
        size_t count = 0;
        if (done(dermis_skin_get_response(skin_, byte() % 10, &values, &count)))
            for (size_t i = 0; i < count; ++i) sum_ = sum_ + values[i];
        dermis_report report = {};
        report.size = sizeof report;
        done(dermis_skin_get_report(skin_, byte() % 5, &report));
        if (byte() < 64) done(dermis_skin_reset(skin_, pads()));
    }
    void state() {
        const dermis_pads* some = pads();
        size_t size = 0;
        if (!done(dermis_skin_get_state_size(skin_, &size, some))) return;
        std::vector<uint8_t> state(size);
        if (!done(dermis_skin_save(skin_, state.data(), size, some))) return;
        const size_t changed = size_t(byte()) % size;
        state[changed] ^= uint8_t(byte());
        done(dermis_skin_load(skin_, state.data(), size, some));
    }
    void material() { done(dermis_skin_set_material(skin_, scene_, pads())); }
    void run() {
        dermis_result_destroy(result_);
        result_ = nullptr;
        if (!runs_ || !small() || !done(dermis_run(scene_, device(), &result_))) return;
        const double* values = nullptr;
        size_t count = 0;
        if (done(dermis_result_get_trace(result_, byte() % 10, byte() % 4, &values, &count)) && count)
            sum_ = sum_ + values[count - 1];
        done(dermis_result_get_probe(result_, byte() % 10, size_t(byte() % 3), &values, &count));
        done(dermis_result_get_field(result_, byte() % 10, number(), &values, &count));
    }

    // A pad of up to 8 x 8 cells, in a buffer of its size.
    dermis_contact_pad pad() {
        const int width = byte() % 9, height = byte() % 9;
        const size_t pitch = size_t(byte() % 12);
        pressure_.assign(size_t(height) * std::max(pitch, size_t(width)) + 1, 0.0f);
        return {sizeof(dermis_contact_pad), width, height, number(), pressure_.data(), pitch, byte() % 3};
    }
    void reported(dermis_status status, const dermis_contact_report& report) {
        char text[400];
        if (done(status)) done(dermis_contact_report_get_doubts(&report, text, size_t(byte()) + 1));
    }
    void add() {
        const dermis_contact_pad on = pad();
        std::vector<dermis_contact> contacts(size_t(byte() % 4));
        for (dermis_contact& c : contacts) c = {number(), number(), number(), number(), number()};
        dermis_contact_report report = {};
        report.size = sizeof report;
        reported(dermis_add_contacts(&on, contacts.data(), contacts.size(), &report), report);
    }
    void depths() {
        const dermis_contact_pad on = pad();
        std::vector<float> depth = numbers<float>(96);
        const size_t pitch = size_t(byte() % 12);
        depth.resize(size_t(on.height) * std::max(pitch, size_t(on.width)) + 1);
        const dermis_depths given = {sizeof given, depth.data(), pitch, number(), number()};
        dermis_contact_report report = {};
        report.size = sizeof report;
        reported(dermis_add_depths(&on, &given, &report), report);
    }
    void taxels() {
        const dermis_contact_pad on = pad();
        std::vector<float> values = numbers<float>(16);
        dermis_taxels given = {};
        given.size = sizeof given;
        given.unit = byte() % 3;
        given.columns = byte() % 5, given.rows = byte() % 5;
        given.width = number(), given.height = number(), given.x = number(), given.y = number();
        given.column_step = size_t(byte() % 4), given.row_step = size_t(byte() % 8);
        values.resize(64);
        given.values = values.data();
        dermis_contact_report report = {};
        report.size = sizeof report;
        reported(dermis_add_taxels(&on, &given, &report), report);
    }

    static const dermis_device* device() {
        static dermis_device* cpu = [] {
            dermis_device* made = nullptr;
            dermis_device_open_cpu(1, &made);
            return made;
        }();
        return cpu;
    }

    FuzzedDataProvider bytes_;
    dermis_scene* scene_ = nullptr;
    dermis_skin* skin_ = nullptr;
    dermis_result* result_ = nullptr;
    bool runs_ = false;
    std::vector<int32_t> list_;
    dermis_pads pads_ = {};
    std::vector<float> pressure_;
    volatile double sum_ = 0; // so that what is read is read
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    Calls(data, size).make();
    return 0;
}
