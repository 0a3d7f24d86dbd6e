// SPDX-License-Identifier: MIT
#include "bench/opencl.hpp"

#ifdef DERMIS_BENCH_OPENCL

#include "bench/native.hpp"
#include "host/core/model/laplacian.hpp"

#include "press_cl.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

namespace bench {
namespace {

void check(cl_int status, const char* call) {
    if (status != CL_SUCCESS) throw std::runtime_error(std::string(call) + " failed: " + std::to_string(status));
}

// Calls that return an object write their status into their last argument, which is read after them.
template <class Object> Object made(Object object, const cl_int& status, const char* call) {
    check(status, call);
    return object;
}

template <class Info, class Object> std::string text_of(Info info, Object object, cl_uint name) {
    size_t bytes = 0;
    info(object, name, 0, nullptr, &bytes);
    std::string text(bytes, '\0');
    info(object, name, bytes, text.data(), nullptr);
    return text.c_str();
}

// Null if there is no PoCL, or if it has no CPU.
cl_device_id pocl_device() {
    cl_platform_id platforms[16];
    cl_uint count = 0;
    if (clGetPlatformIDs(16, platforms, &count) != CL_SUCCESS) return nullptr;
    for (cl_uint i = 0; i < std::min(count, 16u); ++i) {
        cl_device_id device;
        if (text_of(clGetPlatformInfo, platforms[i], CL_PLATFORM_NAME) == "Portable Computing Language" &&
            clGetDeviceIDs(platforms[i], CL_DEVICE_TYPE_CPU, 1, &device, nullptr) == CL_SUCCESS)
            return device;
    }
    return nullptr;
}

class PoclFrames final : public OpenclFrames {
  public:
    PoclFrames(const FrameScene&, cl_device_id, bool past_caches);
    ~PoclFrames() override;
    void press(int frames) override;
    std::array<const float*, 4> responses() override;
    std::string driver_version() const override { return text_of(clGetDeviceInfo, device_, CL_DRIVER_VERSION); }

  private:
    enum { rest, strain0, strain1, integral, responses_, frames_ = responses_ + 4, buffers = frames_ + 4 };
    void compile(bool past_caches);
    template <class T> void set(cl_uint argument, const T& value) {
        check(clSetKernelArg(kernel_, argument, sizeof value, &value), "clSetKernelArg");
    }

    const FrameScene& scene_;
    cl_device_id device_;
    cl_context context_ = nullptr;
    cl_command_queue queue_ = nullptr;
    cl_program program_ = nullptr;
    cl_kernel kernel_ = nullptr;
    std::vector<Floats> maps_; // of all but the frames
    std::vector<cl_mem> memory_;
    size_t frame_ = 0;
};

PoclFrames::PoclFrames(const FrameScene& scene, cl_device_id device, bool past_caches)
    : scene_(scene), device_(device) {
    cl_int status;
    context_ = made(clCreateContext(nullptr, 1, &device_, nullptr, nullptr, &status), status, "clCreateContext");
    queue_ = made(clCreateCommandQueue(context_, device_, 0, &status), status, "clCreateCommandQueue");
    compile(past_caches);
    const std::vector<float> rest_map = dermis::model::padded_rest_curvature<float>(scene.skin());
    for (int i = 0; i < buffers; ++i) {
        float* map;
        if (i < frames_) {
            map = maps_.emplace_back(scene.cells()).data();
            if (i == rest) std::copy(rest_map.begin(), rest_map.end(), map);
            else std::fill_n(map, scene.cells(), 0.0f);
        } else map = scene.frames[size_t(i - frames_)].data();
        cl_mem memory = clCreateBuffer(context_, CL_MEM_USE_HOST_PTR, scene.cells() * sizeof(float), map, &status);
        memory_.push_back(made(memory, status, "clCreateBuffer"));
    }
    const dermis::scene::Element& material = scene.skin().materials[0];
    set(0, native::exact_step<float>(material.modulus, material.viscosity, scene.dt));
    set(1, scene.skin().width());
    set(2, scene.skin().height());
    set(3, scene.skin().pitch);
    set(4, memory_[rest]);
    set(9, memory_[integral]);
    for (cl_uint r = 0; r < 4; ++r) set(10 + r, memory_[responses_ + r]);
}

PoclFrames::~PoclFrames() {
    for (cl_mem memory : memory_) clReleaseMemObject(memory);
    clReleaseKernel(kernel_);
    clReleaseProgram(program_);
    clReleaseCommandQueue(queue_);
    clReleaseContext(context_);
}

void PoclFrames::compile(bool past_caches) {
    cl_int status;
    const char* source = press_cl;
    program_ =
        made(clCreateProgramWithSource(context_, 1, &source, nullptr, &status), status, "clCreateProgramWithSource");
    const std::string options =
        std::string("-cl-std=CL1.2 -cl-fast-relaxed-math") + (past_caches ? " -DPAST_CACHES" : "");
    if (clBuildProgram(program_, 1, &device_, options.c_str(), nullptr, nullptr) != CL_SUCCESS) {
        std::string log(65536, '\0');
        size_t bytes = 0;
        clGetProgramBuildInfo(program_, device_, CL_PROGRAM_BUILD_LOG, log.size(), log.data(), &bytes);
        throw std::runtime_error("bench/press.cl: " + log.substr(0, bytes));
    }
    kernel_ = made(clCreateKernel(program_, "press", &status), status, "clCreateKernel");
}

void PoclFrames::press(int count) {
    const size_t across = size_t(scene_.skin().width()) / 16, all[2] = {across, size_t(scene_.skin().height())};
    const size_t group[2] = {across % 32 ? 1 : 32u, 1};
    for (int i = 0; i < count; ++i, ++frame_) {
        set(5, memory_[frames_ + frame_ % 4]);
        set(6, memory_[frames_ + (frame_ + 1) % 4]);
        set(7, memory_[strain0 + frame_ % 2]);
        set(8, memory_[strain1 - frame_ % 2]);
        check(clEnqueueNDRangeKernel(queue_, kernel_, 2, nullptr, all, group, 0, nullptr, nullptr),
              "clEnqueueNDRangeKernel");
    }
    check(clFinish(queue_), "clFinish");
}

std::array<const float*, 4> PoclFrames::responses() {
    std::array<const float*, 4> maps;
    for (size_t r = 0; r < 4; ++r) { // mapped, the host's memory has what the device wrote
        cl_int status;
        void* mapped = clEnqueueMapBuffer(queue_, memory_[responses_ + r], CL_TRUE, CL_MAP_READ, 0,
                                          scene_.cells() * sizeof(float), 0, nullptr, nullptr, &status);
        check(status, "clEnqueueMapBuffer");
        maps[r] = static_cast<const float*>(mapped);
        check(clEnqueueUnmapMemObject(queue_, memory_[responses_ + r], mapped, 0, nullptr, nullptr),
              "clEnqueueUnmapMemObject");
    }
    check(clFinish(queue_), "clFinish");
    return maps;
}

} // namespace

std::unique_ptr<OpenclFrames> OpenclFrames::make(const FrameScene& scene, bool past_caches) {
    const cl_device_id device = pocl_device();
    return device ? std::make_unique<PoclFrames>(scene, device, past_caches) : nullptr;
}

} // namespace bench

#else

namespace bench {

std::unique_ptr<OpenclFrames> OpenclFrames::make(const FrameScene&, bool) { return nullptr; }

} // namespace bench

#endif
