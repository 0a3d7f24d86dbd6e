// SPDX-License-Identifier: MIT
// dermis::vulkan::SkinProgram: presses recorded into a host's command buffer, and the check of its device.
#include "host/core/embedding/skin_program.hpp"

#include "dermis/touch.hpp"
#include "host/core/base/float_environment.hpp"
#include "host/core/base/memory.hpp"
#include "host/core/base/refusal.hpp"
#include "host/core/embedding/check.hpp"
#include "host/core/embedding/handles.hpp"
#include "host/core/vulkan/recorder.hpp"

#include <cmath>
#include <cstring>
#include <span>

namespace dermis::vulkan {
namespace {

using scene::refuse;

constexpr int presses = SampleStream::presses;

// The offsets in the buffer range of a check: constants, two states, three pressures, a response for each press, and
// the count of pressures that were not finite, and scratch memory.
struct CheckLayout {
    VkDeviceSize constants = 0, state[2], pressure[presses + 1], response[presses], invalid = 0, scratch = 0, end = 0;

    explicit CheckLayout(const MemoryNeeds& n) {
        constants = append(n.constants);
        for (VkDeviceSize& at : state) at = append(n.state);
        for (VkDeviceSize& at : pressure) at = append(n.pressure);
        for (VkDeviceSize& at : response) at = append(n.response);
        invalid = append(n.invalid);
        scratch = append(n.scratch);
    }

  private:
    VkDeviceSize append(const Memory& m) {
        const VkDeviceSize at = end;
        end = (at + m.bytes + 255) / 256 * 256; // the greatest minStorageBufferOffsetAlignment that Vulkan allows
        return at;
    }
};

// Presses a sample skin with the program's own pipelines; two cells of the last pressure are not finite.
class DeviceCheck {
  public:
    DeviceCheck(Pipelines& pipelines, const model::StreamedSkin& like)
        : sample_(like), recorder_(pipelines, model::StreamedSkin(sample_.skin()), presses),
          layout_(recorder_.needs()) {}

    bool bound() const { return bound_; }

    // The needs of the range, with its initial bytes.
    Memory memory() const {
        Memory m = recorder_.needs().constants;
        m.initial.resize(layout_.end, 0);
        m.bytes = layout_.end;
        std::vector<std::vector<float>> pressures = sample_.pressures();
        const auto [first, second] = sample_.read_cells();
        pressures.back()[first] = NAN, pressures.back()[second] = -INFINITY;
        for (size_t i = 0; i <= presses; ++i)
            std::memcpy(m.initial.data() + layout_.pressure[i], pressures[i].data(),
                        pressures[i].size() * sizeof(float));
        return m;
    }

    void bind(const VkDescriptorBufferInfo& range) {
        const MemoryNeeds& n = recorder_.needs();
        const auto range_at = [&](VkDeviceSize at, const Memory& m) {
            return VkDescriptorBufferInfo{range.buffer, range.offset + at, m.bytes};
        };
        const CheckLayout& l = layout_;
        for (int i = 0; i < presses; ++i)
            recorder_.bind(size_t(i), {.constants = range_at(l.constants, n.constants),
                                       .state_from = range_at(l.state[i % 2], n.state),
                                       .state_to = range_at(l.state[1 - i % 2], n.state),
                                       .pressure_from = range_at(l.pressure[i], n.pressure),
                                       .pressure_to = range_at(l.pressure[i + 1], n.pressure),
                                       .response = range_at(l.response[i], n.response),
                                       .invalid = range_at(l.invalid, n.invalid),
                                       .scratch = range_at(l.scratch, n.scratch)});
        bound_ = true;
    }

    void record(VkCommandBuffer commands, const VolkDeviceTable& vk) const noexcept {
        PressTable table;
        const size_t pads = size_t(sample_.skin().pads);
        double before[] = {0, 0};
        for (int i = 0; i < presses; ++i) {
            const Recorder::Press press{{.count = pads}, sample_.steps(i, before)};
            (void)recorder_.fill(table, press); // true: a sample's coefficients fit float
            recorder_.record(commands, size_t(i), press, table);
            press.dt.taken(press.pads);
            constexpr VkPipelineStageFlags compute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
            if (i + 1 < presses)
                barrier(vk, commands, {compute, VK_ACCESS_SHADER_WRITE_BIT},
                        {compute, VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT});
        }
    }

    bool passed(const unsigned char* bytes) const {
        std::vector<std::vector<float>> pressures = sample_.pressures();
        for (size_t at : sample_.read_cells()) pressures.back()[at] = 0;
        const std::vector<std::vector<float>> expected = sample_.expected(pressures);
        std::vector<float> response(sample_.layout().all);
        bool same = true;
        for (size_t i = 0; i < presses; ++i) {
            std::memcpy(response.data(), bytes + layout_.response[i], response.size() * sizeof(float));
            same &= sample_.same(response.data(), expected[i].data());
        }
        uint32_t invalid = 0;
        std::memcpy(&invalid, bytes + layout_.invalid, sizeof invalid);
        return same && invalid == sample_.read_cells().size();
    }

  private:
    const SampleStream sample_;
    Recorder recorder_;
    const CheckLayout layout_;
    bool bound_ = false;
};

} // namespace

struct SkinProgram::Impl {
    Impl(const Handles& h, model::StreamedSkin&& skin, uint32_t most)
        : own_device(checked(h)), own_pipelines(std::in_place, *own_device), pipelines(*own_pipelines),
          recorder(pipelines, std::move(skin), most), max_bindings(most), needs(recorder.needs()),
          labels(labels_of(h)) {
        check.emplace(pipelines, recorder.skin());
        needs.check = check->memory();
    }
    // Uses the pipelines of a context, and has no check.
    Impl(Pipelines& shared, const Handles& h, model::StreamedSkin&& skin, uint32_t most)
        : pipelines(shared), recorder(pipelines, std::move(skin), most), max_bindings(most), needs(recorder.needs()),
          labels(labels_of(h)) {}

    bool batch() const { return recorder.skin().pads > 1; }

    bool ascend(const Pads& pads) const noexcept {
        for (size_t i = 0; !pads.all && i < pads.count; ++i) {
            const int least = i == 0 ? 0 : pads.numbers[i - 1] + 1;
            if (pads.numbers[i] < least || pads.numbers[i] >= recorder.skin().pads) return false;
        }
        return true;
    }

    // own: see PressKernel::record(); if it is null, nothing is thrown.
    Recorded record(VkCommandBuffer commands, Binding binding, const Recorder::Press& press, const Timestamps& stamps,
                    Recording* own = nullptr) const {
        for (size_t i = 0; i < (press.dt.each ? press.pads.count : 1); ++i)
            if (!finite(press.dt[i]) || press.dt[i] < 0) return {"dt is not a finite number >= 0"};
        PressTable table;
        if (!recorder.fill(table, press)) return {"dt: a coefficient of the step is beyond 3.4e38"};
        const VolkDeviceTable& vk = device.calls;
        VkDebugUtilsLabelEXT label{VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT};
        label.pLabelName = "dermis press";
        if (labels.begin) labels.begin(commands, &label);
        if (stamps.pool) vk.vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, stamps.pool, stamps.first);
        recorder.record(commands, binding.set, press, table, own);
        if (stamps.pool)
            vk.vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, stamps.pool, stamps.first + 1);
        if (labels.begin) labels.end(commands);
        return {};
    }

    void check_range(const char* name, const VkDescriptorBufferInfo& b, const Memory& m) const {
        const std::string parameter = name;
        if (!b.buffer)
            refuse(parameter + ".buffer", "null", "a buffer of at least " + std::to_string(m.bytes) + " bytes");
        if (b.offset % m.alignment != 0)
            refuse(parameter + ".offset", std::to_string(b.offset),
                   "a multiple of minStorageBufferOffsetAlignment = " + std::to_string(m.alignment));
        if (b.range < m.bytes) // VK_WHOLE_SIZE is the greatest number
            refuse(parameter + ".range", std::to_string(b.range), "at least " + std::to_string(m.bytes) + " bytes");
        VkMemoryRequirements there{};
        device.calls.vkGetBufferMemoryRequirements(device.device, b.buffer, &there);
        const VkDeviceSize range = b.range == VK_WHOLE_SIZE ? m.bytes : b.range;
        if (b.offset > there.size || range > there.size - b.offset)
            refuse(parameter, std::to_string(b.offset) + " + " + std::to_string(range) + " bytes",
                   "within the buffer, which has at most " + std::to_string(there.size));
    }

    // Throws where a range that a press writes overlaps another one.
    void check_apart(const Buffers& b) const {
        struct Named {
            const char* name;
            const VkDescriptorBufferInfo& info;
            const Memory& needs;
            bool written;
        };
        const Named all[] = {{"constants", b.constants, needs.constants, recorder.writes_constants()},
                             {"state_from", b.state_from, needs.state, false},
                             {"state_to", b.state_to, needs.state, true},
                             {"pressure_from", b.pressure_from, needs.pressure, false},
                             {"pressure_to", b.pressure_to, needs.pressure, false},
                             {"response", b.response, needs.response, true},
                             {"invalid", b.invalid, needs.invalid, true},
                             {"scratch", b.scratch, needs.scratch, true}};
        const std::span used(all, std::size(all) - (needs.scratch.bytes == 0));
        for (const Named& one : used) check_range(one.name, one.info, one.needs);
        for (const Named& one : used)
            for (const Named& other : used)
                if (&one != &other && one.written && one.info.buffer == other.info.buffer &&
                    one.info.offset < other.info.offset + other.needs.bytes &&
                    other.info.offset < one.info.offset + one.needs.bytes)
                    refuse(one.name, "in the same memory as " + std::string(other.name),
                           "memory of its own, because a press writes it");
    }

    // scene::guarded() in the words of what the program needs.
    template <class Call> decltype(auto) guarded(Call&& call) const {
        const auto words = [this] {
            return "a program of " + std::to_string(recorder.skin().pads) + " pads and up to " +
                   std::to_string(max_bindings) + " bindings, whose constants have " +
                   scene::bytes_text(double(needs.constants.bytes));
        };
        return scene::guarded(words, call);
    }

    std::optional<DeviceTable> own_device;
    std::optional<Pipelines> own_pipelines;
    Pipelines& pipelines;
    const DeviceTable& device = pipelines.device();
    std::optional<DeviceCheck> check;
    Recorder recorder;
    uint32_t max_bindings, bindings = 0;
    MemoryNeeds needs;
    Labels labels;
};

// Makes a program for a skin that the library has prepared.
struct Internal {
    // of: the arguments of a constructor of Impl.
    template <class... Of> static SkinProgram make(Of&&... of) {
        const DefaultFloats guard;
        SkinProgram program;
        program.impl_ = std::make_unique<SkinProgram::Impl>(std::forward<Of>(of)...);
        return program;
    }
    static SkinProgram::Impl& impl_of(const SkinProgram& program) { return *program.impl_; }
};

SkinProgram program_of(Context& context, const model::StreamedSkin& skin, uint32_t max_bindings) {
    return Internal::make(context.pipelines(), context.handles(), model::StreamedSkin(skin), max_bindings);
}

Recorded record_press(const SkinProgram& program, Recording& own, Binding binding, const model::PadList& pads,
                      const model::StepLengths& dt, bool answers) {
    return Internal::impl_of(program).record(own.commands(), binding, {pads, dt, answers}, {}, &own);
}

double work_of_press(const SkinProgram& program) { return Internal::impl_of(program).recorder.work_of_pad(); }

void set_elements(SkinProgram& program, const model::PadList& pads, const std::vector<model::Element>& elements) {
    Internal::impl_of(program).recorder.set_elements(pads, elements);
}

namespace {

model::StreamedSkin streamed(const SkinDescription& d, uint32_t max_bindings, const SkinOptions& options) {
    const DefaultFloats guard;
    scene::need(max_bindings >= 1 && max_bindings <= 65536, "max_bindings", max_bindings, "1..65536");
    if (options.hold != Hold::linear) refuse("hold", "parabolic", "linear in a SkinProgram; a Skin has both");
    if (options.control != Control::pressure) refuse("control", "depth", "pressure in a SkinProgram; a Skin has both");
    if (scene::follows_stress(d.receptors))
        refuse("receptors.follow", "\"stress\"", "\"strain\" in a SkinProgram; a Skin has both");
    if (options.shear) refuse("shear", "true", "false in a SkinProgram; a Skin has shear");
    if (options.sa2_stretch) refuse("sa2_stretch", "(given)", "none in a SkinProgram; a Skin has shear");
    if (!options.afferents.empty())
        refuse("afferents", std::to_string(options.afferents.size()) + " kinds",
               "none in a SkinProgram; a Skin has them");
    return model::streamed_skin(d, options);
}

} // namespace

SkinProgram::SkinProgram() = default;
SkinProgram::SkinProgram(const Handles& handles, const SkinDescription& description, uint32_t max_bindings,
                         const SkinOptions& options)
    : SkinProgram(scene::guarded(
          [&] { return scene::needs_of(description, options); },
          [&] { return Internal::make(handles, streamed(description, max_bindings, options), max_bindings); })) {}
SkinProgram::~SkinProgram() = default;
SkinProgram::SkinProgram(SkinProgram&&) noexcept = default;
SkinProgram& SkinProgram::operator=(SkinProgram&&) noexcept = default;

const MemoryNeeds& SkinProgram::memory() const noexcept { return impl_->needs; }

int SkinProgram::pitch() const noexcept { return impl_->recorder.skin().skin.pitch; }

SkinProgram::Range SkinProgram::range(Quantity q) const noexcept {
    if (!scene::is_receptor_class(q)) return {};
    const model::ResponseLayout::Range& r = impl_->recorder.layout().of[size_t(q)];
    return {r.first, r.count};
}

Access SkinProgram::first_access() const noexcept {
    Access a{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};
    if (impl_->recorder.copies()) {
        a.stages |= VK_PIPELINE_STAGE_TRANSFER_BIT;
        a.access |= VK_ACCESS_TRANSFER_WRITE_BIT;
    }
    if (impl_->recorder.writes_constants()) { // a batch always does, and copies besides
        a.stages |= VK_PIPELINE_STAGE_TRANSFER_BIT;
        a.access |= VK_ACCESS_TRANSFER_WRITE_BIT;
        if (impl_->batch()) a.access |= VK_ACCESS_TRANSFER_READ_BIT;
    }
    return a;
}

Access SkinProgram::last_access() const noexcept {
    Access a{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT};
    if (impl_->batch() || impl_->recorder.copies()) {
        a.stages |= VK_PIPELINE_STAGE_TRANSFER_BIT;
        a.access |= VK_ACCESS_TRANSFER_WRITE_BIT;
    }
    return a;
}

Binding SkinProgram::bind(const Buffers& b) {
    return impl_->guarded([&] {
        Impl& impl = *impl_;
        impl.check_apart(b);
        if (impl.bindings == impl.max_bindings)
            refuse("max_bindings", std::to_string(impl.max_bindings), "as many as are bound, and this is one more");
        Binding binding;
        binding.program = impl_.get();
        binding.set = impl.bindings;
        impl.recorder.bind(binding.set, b);
        ++impl.bindings;
        return binding;
    });
}

Recorded SkinProgram::record_press(VkCommandBuffer commands, Binding binding, double dt, const Timestamps& stamps,
                                   Answers answers) const noexcept {
    if (binding.program != impl_.get()) return {"the binding is not this program's"};
    return impl_->record(commands, binding,
                         {{.count = size_t(impl_->recorder.skin().pads)}, {&dt}, answers == Answers::all}, stamps);
}

Recorded SkinProgram::record_press(VkCommandBuffer commands, Binding binding, const Pads& pads, const double* dt,
                                   size_t steps, const Timestamps& stamps, Answers answers) const noexcept {
    const Impl& impl = *impl_;
    const size_t count = pads.all ? size_t(impl.recorder.skin().pads) : pads.count;
    if (binding.program != &impl) return {"the binding is not this program's"};
    if (!impl.batch()) return {"pads: the program is of a single skin"};
    if (!impl.ascend(pads)) return {"pads: the numbers do not ascend from 0 on below the count of pads"};
    if (steps != 1 && steps != count) return {"steps: neither one nor as many as pads"};
    return impl.record(commands, binding,
                       {{.ids = pads.all ? nullptr : pads.numbers, .count = count},
                        {.dt = dt, .each = steps != 1},
                        answers == Answers::all},
                       stamps);
}

Recorded SkinProgram::record_touch(VkCommandBuffer commands, const VkDescriptorBufferInfo& range,
                                   const contact::Touch& touch) const noexcept {
    const model::StreamedSkin& skin = impl_->recorder.skin();
    const contact::Pad& pad = touch.shape();
    if (touch.count() != skin.pads || pad.width != skin.skin.width() || pad.height != skin.skin.height())
        return {"touch: other pads than the program's"};
    if (const std::optional<double> spacing = skin.skin.description.grid.spacing;
        spacing && std::abs(*spacing - pad.spacing) > 1e-6 * pad.spacing)
        return {"touch: pads of another spacing than the program's"};
    if (touch.traction()) return {"touch: tractions; a SkinProgram has no shear"};
    const VkDeviceSize bytes = impl_->needs.pressure.bytes, pitch = VkDeviceSize(skin.skin.pitch);
    if (range.range != VK_WHOLE_SIZE && range.range < bytes) return {"pressure_to: fewer than memory().pressure.bytes"};
    const VolkDeviceTable& vk = impl_->device.calls;
    vk.vkCmdFillBuffer(commands, range.buffer, range.offset, bytes, 0);
    constexpr Access written{VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT};
    barrier(vk, commands, written, written);
    for (const int number : touch.touched()) {
        const contact::Touch::Block b = touch.block(number);
        for (int y = b.y; y < b.y + b.height; ++y) {
            const auto row = size_t(number) * size_t(pad.height) + size_t(y);
            const VkDeviceSize at = (row * pitch + VkDeviceSize(b.x)) * sizeof(float);
            vk.vkCmdUpdateBuffer(commands, range.buffer, range.offset + at, VkDeviceSize(b.width) * sizeof(float),
                                 touch.pressure() + row * size_t(pad.width) + size_t(b.x));
        }
    }
    return {};
}

void SkinProgram::set_material(const Material& material, const Pads& pads) {
    impl_->guarded([&] {
        const DefaultFloats guard;
        Impl& impl = *impl_;
        const model::StreamedSkin& skin = impl.recorder.skin();
        if (!impl.ascend(pads)) refuse("pads", "(numbers)", "ascending numbers of pads");
        const model::PadList list{.ids = pads.all ? nullptr : pads.numbers,
                                  .count = pads.all ? size_t(skin.pads) : pads.count};
        model::need_new_material(skin.skin.uniform(), !skin.elements_of_pad.empty(), list.count, size_t(skin.pads));
        const std::vector<model::Element> elements =
            model::elements_of_pad(skin.skin.description, material, skin.skin.chain, skin.wanted, "material");
        impl.recorder.set_elements(list, elements);
    });
}

void SkinProgram::bind_check(const VkDescriptorBufferInfo& range) {
    impl_->guarded([&] {
        Impl& impl = *impl_;
        impl.check_range("check", range, impl.needs.check);
        if (impl.check->bound()) refuse("check", "bound already", "one binding");
        impl.check->bind(range);
    });
}

bool SkinProgram::record_check(VkCommandBuffer commands) const noexcept {
    const Impl& impl = *impl_;
    if (!impl.check->bound()) return false;
    impl.check->record(commands, impl.device.calls);
    return true;
}

bool SkinProgram::check_passed(const void* bytes, size_t size) const {
    return impl_->guarded([&] {
        const DefaultFloats guard;
        if (!bytes || size < impl_->needs.check.bytes)
            refuse("check", bytes ? std::to_string(size) + " bytes" : "(null)",
                   "memory().check.bytes = " + std::to_string(impl_->needs.check.bytes));
        return impl_->check->passed(static_cast<const unsigned char*>(bytes));
    });
}

} // namespace dermis::vulkan
