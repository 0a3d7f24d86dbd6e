// SPDX-License-Identifier: MIT
// The states of pads as bytes. A header is followed by parts, each with its name and its length, so that a skin with
// more to remember adds a part and the version stays. Version 2, which had no parts, is read too.
#pragma once

#include "host/core/base/finite.hpp"
#include "host/core/base/hash.hpp"
#include "host/core/base/refusal.hpp"
#include "host/core/press/stage.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace dermis {

// Where the numbers of a state are: those of the pressed cells, and the parts of the other stages, null if a stage has
// none. Byte: char or const char.
template <class Byte> struct StateParts {
    model::StateMemory<Byte> cells;
    Byte *steps = nullptr, *fibres = nullptr, *shear = nullptr;
    operator StateParts<const Byte>() const { return {cells, steps, fibres, shear}; }
};

class SavedState {
  public:
    SavedState(const model::StreamedSkin& skin, const Stage& steps, const Stage& fibres, const Stage& shear) {
        const model::StateLayout layout = state_layout_of(skin);
        const model::StateShape state = skin.variant().state();
        shape_ = {.width = uint32_t(skin.skin.width()),
                  .height = uint32_t(skin.skin.height()),
                  .cells = uint32_t(layout.cells),
                  .elements = uint32_t(state.elements),
                  .spring = state.spring,
                  .compensated = state.compensated,
                  .integral = state.integral,
                  .rate = state.rate,
                  .sites = hash_of(skin.skin.description.sites)};
        of_pad_[steps_part] = steps.state_bytes();
        of_pad_[strains_part] = layout.cells * layout.planes * sizeof(float);
        of_pad_[pressure_part] = layout.pressure * sizeof(float);
        of_pad_[fibres_part] = fibres.state_bytes();
        of_pad_[shear_part] = shear.state_bytes();
    }

    // The bytes of so many pads.
    size_t bytes(size_t pads) const {
        size_t all = sizeof(Header);
        for (int part = 0; part < part_count; ++part)
            if (has(part)) all += sizeof(PartHeader) + bytes_of(Part(part), pads);
        return all;
    }
    // Writes all but the numbers of so many pads. Returns where the numbers go. Throws Error::bad_input where `bytes`
    // is another number than bytes(pads).
    StateParts<char> write(void* state, size_t given, size_t pads) const {
        if (!state || given != bytes(pads)) refuse_bytes(state, given, bytes(pads));
        Header header{.magic = {}, .version = version, .pads = uint32_t(pads)};
        std::memcpy(header.magic, magic, sizeof header.magic);
        char* to = static_cast<char*>(state);
        std::memcpy(to, &header, sizeof header);
        to += sizeof header;
        char* parts[part_count]{};
        for (int part = 0; part < part_count; ++part) {
            if (!has(part)) continue;
            PartHeader head{.name = {}, .bytes = bytes_of(Part(part), pads)};
            std::memcpy(head.name, part_names[part], std::strlen(part_names[part]));
            std::memcpy(to, &head, sizeof head);
            parts[part] = to + sizeof head;
            to = parts[part] + head.bytes;
        }
        std::memcpy(parts[shape_part], &shape_, sizeof shape_);
        return all_of(parts);
    }
    // Returns where the numbers of so many pads are. Throws Error::bad_input naming the first thing in which the state
    // differs from the skin's, and where a number is not finite.
    StateParts<const char> read(const void* state, size_t given, size_t pads) const {
        const char* const from = static_cast<const char*>(state);
        if (!state || given < sizeof(Header)) refuse_bytes(state, given, bytes(pads));
        const auto header = copied<Header>(from);
        if (std::memcmp(header.magic, magic, sizeof header.magic) != 0)
            scene::refuse("state", "(other bytes)", "what Skin::save has written");
        if (header.version != version && header.version != version_without_parts)
            scene::refuse("state", "(version " + std::to_string(header.version) + ")", "version 2 or 3");
        need_same("number of pads", header.pads, uint32_t(pads));
        const size_t strains = of_pad_[strains_part], pressure = of_pad_[pressure_part];
        const size_t numbers = pads * (strains + pressure);
        if (header.version == version_without_parts) { // the header, the shape, and pad by pad strains and pressure
            constexpr size_t before = sizeof(Header) + sizeof(Shape);
            if (given >= before) check(copied<Shape>(from + sizeof(Header)));
            need_same("parabolic hold", false, has(steps_part));
            need_same("afferents", false, has(fibres_part));
            need_same("shear", false, has(shear_part));
            if (given != before + numbers) refuse_bytes(state, given, before + numbers);
            need_finite(from + before, numbers);
            return {.cells = {from + before, from + before + strains, strains + pressure, strains + pressure}};
        }
        const char* parts[part_count]{};
        if (!find_parts(from + sizeof header, given - sizeof header, pads, parts))
            refuse_bytes(state, given, bytes(pads));
        for (size_t i = 0; has(steps_part) && i < pads; ++i)
            if (const double step = copied<double>(parts[steps_part] + i * sizeof(double));
                !(step >= 0 && finite(step)))
                scene::refuse("state", "(a step of " + std::to_string(step) + " s)", "finite numbers >= 0");
        for (const Part part : {strains_part, pressure_part, fibres_part, shear_part})
            if (has(part)) need_finite(parts[part], bytes_of(part, pads));
        return all_of(parts);
    }

  private:
    static constexpr char magic[] = "dermisst";
    static constexpr uint32_t version = 3, version_without_parts = 2;

    struct Header {
        char magic[8];
        uint32_t version, pads;
    };
    struct PartHeader {
        char name[8]; // zeros behind it
        uint64_t bytes;
    };
    static constexpr const char* part_names[] = {"shape", "steps", "strains", "pressure", "fibres", "shear"};

    // FNV-1a of the sites that read cells.
    static uint32_t hash_of(const std::vector<Site>& sites) {
        uint32_t hash = fnv1a_32;
        for (const Site& site : sites)
            for (const int n : {int(site.type), site.cell.x, site.cell.y})
                for (int i = 0; i < 4; ++i) hash = fnv1a(hash, static_cast<unsigned char>(uint32_t(n) >> (8 * i)));
        return sites.empty() ? 0 : hash;
    }

    [[noreturn]] static void refuse_bytes(const void* state, size_t bytes, size_t allowed) {
        scene::refuse("state", state ? std::to_string(bytes) + " bytes" : "(null)", std::to_string(allowed) + " bytes");
    }

    static void need_same(const char* what, uint32_t is, uint32_t allowed) {
        if (is != allowed)
            scene::refuse("state", "(" + std::string(what) + " " + std::to_string(is) + ")",
                          std::string(what) + " " + std::to_string(allowed) + ", as the skin has");
    }

    // Copies an object of bytes at any address.
    template <class T> static T copied(const char* from) {
        T object;
        std::memcpy(&object, from, sizeof object);
        return object;
    }

    static void need_finite(const char* floats, size_t bytes) {
        uint32_t joined = 0; // no early exit, so that the loop vectorises
        for (size_t i = 0; i < bytes; i += sizeof(float)) joined |= not_finite(copied<uint32_t>(floats + i));
        if (any_not_finite(joined)) scene::refuse("state", "(a number that is not finite)", "finite numbers");
    }

    // What a state is of; in version 3 a part of it.
    struct Shape {
        uint32_t width, height, cells, elements, spring, compensated, integral, rate, sites;
    };
    enum Part { shape_part, steps_part, strains_part, pressure_part, fibres_part, shear_part, part_count };

    template <class Byte> StateParts<Byte> all_of(Byte* const (&parts)[part_count]) const {
        return {.cells = {parts[strains_part], parts[pressure_part], of_pad_[strains_part], of_pad_[pressure_part]},
                .steps = parts[steps_part],
                .fibres = parts[fibres_part],
                .shear = parts[shear_part]};
    }
    size_t bytes_of(Part part, size_t pads) const { return part == shape_part ? sizeof shape_ : pads * of_pad_[part]; }
    // Finds the parts in `left` bytes of version 3, and checks the shape. Returns whether every part is there, and
    // whole, and nothing behind them.
    bool find_parts(const char* at, size_t left, size_t pads, const char* (&parts)[part_count]) const {
        const char* const end = at + left;
        while (size_t(end - at) >= sizeof(PartHeader)) {
            const auto head = copied<PartHeader>(at);
            const std::string name(head.name, strnlen(head.name, sizeof head.name));
            const auto known = std::ranges::find(part_names, name) - std::begin(part_names);
            if (known == part_count || parts[known] || (known > pressure_part && !has(int(known))))
                scene::refuse("state", "(part \"" + name + "\")", "the parts " + part_list() + ", each once");
            if (known == steps_part || known == strains_part)
                need_same("parabolic hold", parts[steps_part] || known == steps_part, has(steps_part));
            at += sizeof head;
            if (head.bytes > size_t(end - at)) return false;
            parts[known] = at;
            if (known == shape_part && head.bytes == sizeof(Shape)) check(copied<Shape>(at));
            if (head.bytes != bytes_of(Part(known), pads))
                scene::refuse("state", "(part \"" + name + "\" of " + std::to_string(head.bytes) + " bytes)",
                              std::to_string(bytes_of(Part(known), pads)) + " bytes");
            at += head.bytes;
        }
        if (at == end && !parts[fibres_part]) need_same("afferents", 0, has(fibres_part));
        if (at == end && !parts[shear_part]) need_same("shear", 0, has(shear_part));
        for (int part = 0; part < part_count; ++part)
            if (has(part) != (parts[part] != nullptr)) return false;
        return at == end;
    }
    // The names of the parts that the skin's states have: "shape, strains and pressure".
    std::string part_list() const {
        std::vector<std::string> names;
        for (int part = 0; part < part_count; ++part)
            if (has(part)) names.push_back(part_names[part]);
        std::string text = names.front();
        for (size_t i = 1; i < names.size(); ++i) text += (i + 1 == names.size() ? " and " : ", ") + names[i];
        return text;
    }
    // Throws Error::bad_input naming the first thing in which the shape of a saved state differs from the skin's.
    void check(const Shape& saved) const {
        need_same("width", saved.width, shape_.width);
        need_same("height", saved.height, shape_.height);
        need_same("sites of hash", saved.sites, shape_.sites);
        need_same("number of cells", saved.cells, shape_.cells);
        need_same("number of elements", saved.elements, shape_.elements);
        need_same("number of springs", saved.spring, shape_.spring);
        need_same("compensated sums", saved.compensated, shape_.compensated);
        need_same("integral for sa2", saved.integral, shape_.integral);
        need_same("rate of a spring for fa2", saved.rate, shape_.rate);
    }

    bool has(int part) const { return part == shape_part || of_pad_[part] > 0; }

    Shape shape_;
    size_t of_pad_[part_count]{}; // bytes of a pad in each part but the shape
};

} // namespace dermis
