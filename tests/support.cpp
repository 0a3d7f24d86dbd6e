// SPDX-License-Identifier: MIT
#include "tests/support.hpp"

#include "host/core/cpu/backend.hpp"
#include "host/core/press/device.hpp"
#include "host/lab/scenes/scene.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include <unistd.h>

namespace test {

bool night() { return std::getenv("DERMIS_NIGHT") != nullptr; }

std::filesystem::path temporary(const std::string& name) {
    return std::filesystem::temp_directory_path() / ("dermis_" + std::to_string(getpid()) + "_" + name);
}

std::string data(const std::string& name) { return std::string(DERMIS_TEST_DATA) + "/" + name; }

Columns read_csv(const std::string& path) {
    std::ifstream in(path);
    REQUIRE_MESSAGE(in.good(), path);
    std::string line, cell;
    std::getline(in, line);
    std::vector<std::string> names;
    for (std::istringstream header(line); std::getline(header, cell, ',');) names.push_back(cell);
    Columns columns;
    while (std::getline(in, line)) {
        std::istringstream row(line);
        for (const std::string& name : names) {
            std::getline(row, cell, ',');
            columns[name].push_back(std::strtod(cell.c_str(), nullptr));
        }
    }
    return columns;
}

std::vector<double> read_map(const std::string& name) {
    return scene::read_map(data(name), 150, 150, name).values.values();
}

std::string npy_header(const std::string& descr, const std::string& shape, const std::string& order) {
    std::string header = "{'descr': '" + descr + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }";
    header.resize(118, ' ');
    header.back() = '\n';
    return std::string("\x93NUMPY\x01\x00\x76\x00", 10) + header;
}

Device cpu_with(int threads, uint64_t n) {
    auto impl = std::make_shared<Device::Impl>(Device::cpu(threads).impl());
    impl->backend = std::make_shared<cpu::CpuBackend>(threads, *simd::isas()[n % simd::isas().size()]);
    return Device(std::move(impl));
}

std::vector<double> numbers_of(const Result& r) {
    std::vector<double> all = r.time;
    const auto add = [&](const std::vector<double>& more) { all.insert(all.end(), more.begin(), more.end()); };
    for (const Trace& t : r.traces) {
        for (const auto* column : {&t.mean, &t.min, &t.max}) add(*column);
        for (const auto& column : t.probes) add(column);
    }
    for (const Field& f : r.fields) add(f.values);
    add(r.responses);
    all.push_back(r.stencil_estimate);
    return all;
}

model::PreparedRun everything(const Scene& scene) {
    model::PreparedRun run = model::prepare_run(scene);
    run.schedule.wanted.fill(true);
    run.schedule.keeps_maps = run.schedule.derives = true;
    return run;
}

Bytes saved(const Skin& skin, const Pads& pads) {
    Bytes bytes(skin.state_bytes(pads));
    skin.save(bytes.data(), bytes.size(), pads);
    return bytes;
}

Validated::Validated() : Validated(vulkan::system_loader()) {}

Validated::Validated(const vulkan::Loader& loader, vulkan::InstanceOptions options)
    : messages_(std::make_shared<std::vector<std::string>>()) {
    options.validation = [messages = messages_](const std::string& m) { messages->push_back(m); };
    const char* which = std::getenv("DERMIS_TEST_DEVICE");
    device_ = std::make_unique<Device>(open_device(which ? which : "vulkan", loader, options));
}

Validated::~Validated() {
    device_.reset();
    // The loader says of layers that the environment names that it does.
    for (const std::string& m : *messages_)
        if (m.find("env var 'VK_INSTANCE_LAYERS' defined") == std::string::npos) FAIL_CHECK(m);
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
    REQUIRE(a.size() == b.size());
    double worst = 0, largest = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        worst = std::max(worst, std::isfinite(a[i]) ? std::abs(a[i] - b[i]) : INFINITY);
        largest = std::max(largest, std::abs(b[i]));
    }
    return largest > 0 ? worst / largest : worst;
}

} // namespace test
