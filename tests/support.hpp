// SPDX-License-Identifier: MIT
#pragma once

#include "host/core/press/vulkan_device.hpp"
#include "host/core/simd/isa.hpp"
#include "host/lab/schedule/schedule.hpp"
#include "tests/expected.hpp"
#include "tests/maps.hpp"
#include "tests/samples.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace test {

using namespace dermis;

// Whether this is the night, in which a suite does all it can: `./run night` sets DERMIS_NIGHT. A submission does a
// part.
bool night();

// A file or folder for this process alone, below the system's folder for temporary ones; the test makes and removes it.
std::filesystem::path temporary(const std::string& name);

// tests/data/<name>
std::string data(const std::string& name);
using Columns = std::map<std::string, std::vector<double>>;
Columns read_csv(const std::string& path);
std::vector<double> read_map(const std::string& name); // 150 x 150

// What a .npy file begins with: shape as "(2, 3)".
std::string npy_header(const std::string& descr, const std::string& shape, const std::string& order = "False");

// The CPU path with the loops of the nth instruction set that this processor has; the last ones are plain loops.
Device cpu_with(int threads, uint64_t n);
inline size_t plain_loops() { return simd::isas().size() - 1; }

// Every number of a result but its impulses.
std::vector<double> numbers_of(const Result&);

// Made ready for a march of which every map is read.
model::PreparedRun everything(const Scene&);

// The state of all pads as bytes.
using Bytes = std::vector<unsigned char>;
Bytes saved(const Skin&, const Pads& = {});

// A Vulkan device with synchronization validation on; when it goes out of scope every message it gave is a failure.
// Fails, never skips, where there is no device. The variable DERMIS_TEST_DEVICE names another one than "vulkan".
class Validated {
  public:
    Validated();
    explicit Validated(const vulkan::Loader&, vulkan::InstanceOptions = {});
    ~Validated();
    Device device() const { return *device_; }
    const std::vector<std::string>& messages() const { return *messages_; }
    void forgive() { messages_->clear(); } // the canary's own

  private:
    std::shared_ptr<std::vector<std::string>> messages_;
    std::unique_ptr<Device> device_;
};

// Greatest |a - b| over greatest |b|.
double difference(const std::vector<double>& a, const std::vector<double>& b);

// The message of the Error that `call` throws; fails the test where it throws none, or one of another code.
template <class Call> std::string refusal(Error::Code code, Call&& call) {
    try {
        call();
    } catch (const Error& e) {
        CHECK(int(e.code()) == int(code));
        return e.what();
    }
    FAIL_CHECK("accepted");
    return "";
}

// Checks that `call` is refused as bad input, in a message with these words.
template <class Call> void refuses(Call&& call, const std::string& words) {
    const std::string why = refusal(Error::Code::bad_input, call);
    CHECK_MESSAGE(why.find(words) != std::string::npos, why);
}

} // namespace test
