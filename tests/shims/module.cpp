// SPDX-License-Identifier: MIT
// Rewrites SPIR-V: float arithmetic as some device may execute it.
#include "tests/shims/shims.hpp"

#include "host/core/simd/model.hpp"

#include <bit>
#include <map>
#include <optional>

namespace shims {
namespace {

enum Operation : uint32_t {
    op_ext_inst_import = 11,
    op_ext_inst = 12,
    op_memory_model = 14,
    op_capability = 17,
    op_type_float = 22,
    op_type_vector = 23,
    op_constant = 43,
    op_constant_composite = 44,
    op_function = 54,
    op_decorate = 71,
    op_f_convert = 115,
    op_f_add = 129,
    op_f_sub = 131,
    op_f_mul = 133
};
constexpr uint32_t header_words = 5, bound_at = 3, spec_id = 1, no_contraction = 42, capability_float64 = 10,
                   glsl_fma = 50;

using Words = std::vector<uint32_t>;

uint32_t first_word(uint32_t operation, size_t words) { return uint32_t(words) << 16 | operation; }

// Calls each(operation, words of the instruction).
template <class Each> void for_each(const uint32_t* code, size_t words, Each each) {
    for (size_t at = header_words; at < words; at += code[at] >> 16)
        each(code[at] & 0xffff, Words(code + at, code + at + (code[at] >> 16)));
}

// A module whose functions get another arithmetic. Declarations that it needs are put before the first function.
class Rewriting {
  public:
    Rewriting(const uint32_t* code, size_t words) : out_(code, code + header_words) {
        for_each(code, words, [&](uint32_t operation, const Words& w) {
            if (operation == op_ext_inst_import) functions_ = w[1];
            if (operation == op_type_float && w[2] == 32) lanes_[w[1]] = {w[1], 1};
            if (operation == op_type_vector && lanes_.count(w[2])) lanes_[w[1]] = {w[2], w[3]};
            if (operation == op_f_mul) products_[w[2]] = {w[3], w[4]};
        });
        bool declared = false;
        for_each(code, words, [&](uint32_t operation, const Words& w) {
            if (operation == op_memory_model) begin();
            if (operation == op_function && !declared) declare(), declared = true;
            const bool loses = operation == op_decorate && w[2] == no_contraction && is(Kind::contracting);
            if (!loses && !(is(Kind::metal) ? guarded(operation, w) : contracted(operation, w))) put(w);
        });
    }
    Words result() && { return std::move(out_); }

  private:
    struct Type {
        uint32_t component, lanes;
    };

    uint32_t fresh() { return out_[bound_at]++; }
    void put(const Words& w) { out_.insert(out_.end(), w.begin(), w.end()); }
    // Writes an instruction with a result and returns that.
    uint32_t make(uint32_t operation, uint32_t type, const Words& operands, std::optional<uint32_t> result = {}) {
        const uint32_t id = result ? *result : fresh();
        put({first_word(operation, operands.size() + 3), type, id});
        put(operands);
        return id;
    }

    // Declares what must stand before the memory model.
    void begin() {
        if (is(Kind::contracting)) {
            // A module begins with its capabilities.
            const Words capability = {first_word(op_capability, 2), capability_float64};
            out_.insert(out_.begin() + header_words, capability.begin(), capability.end());
        } else if (functions_ == 0) {
            functions_ = fresh();
            put({first_word(op_ext_inst_import, 6), functions_, 0x4c534c47, 0x6474732e, 0x3035342e, 0}); // GLSL.std.450
        }
    }

    void declare() {
        uint32_t component64 = 0;
        if (is(Kind::contracting)) {
            component64 = fresh();
            put({first_word(op_type_float, 3), component64, 64});
        }
        for (const auto& [id, type] : lanes_)
            if (is(Kind::contracting)) {
                if (type.lanes == 1) {
                    wide_[id] = component64;
                    continue;
                }
                wide_[id] = fresh();
                put({first_word(op_type_vector, 4), wide_[id], component64, type.lanes});
            } else {
                for (const float value : {0.0f, 1.0f, -1.0f}) {
                    const uint32_t scalar = make(op_constant, type.component, {std::bit_cast<uint32_t>(value)});
                    constants_[{id, value}] =
                        type.lanes == 1 ? scalar : make(op_constant_composite, id, Words(type.lanes, scalar));
                }
            }
    }

    // Writes arithmetic as SPIRV-Cross guards it for Metal. Returns false where there is none.
    bool guarded(uint32_t operation, const Words& w) {
        if (operation != op_f_add && operation != op_f_sub && operation != op_f_mul) return false;
        const uint32_t type = w[1], id = w[2], l = w[3], r = w[4];
        const auto fma = [&](uint32_t a, uint32_t b, uint32_t c) {
            make(op_ext_inst, type, {functions_, glsl_fma, a, b, c}, id);
        };
        if (operation == op_f_mul) fma(l, r, constants_.at({type, 0.0f}));
        else if (operation == op_f_add) fma(constants_.at({type, 1.0f}), l, r);
        else fma(constants_.at({type, -1.0f}), r, l);
        return true;
    }

    // Computes a sum with a product in double, where a product of floats is exact, and rounds at the end. Returns false
    // where there is none.
    bool contracted(uint32_t operation, const Words& w) {
        if (operation != op_f_add && operation != op_f_sub) return false;
        const bool first = products_.count(w[3]) > 0;
        if (!first && !products_.count(w[4])) return false;
        const auto [a, b] = products_.at(w[first ? 3 : 4]);
        const uint32_t type = w[1], wide = wide_.at(type);
        const auto widened = [&](uint32_t x) { return make(op_f_convert, wide, {x}); };
        const uint32_t wide_a = widened(a), wide_b = widened(b), other = widened(w[first ? 4 : 3]),
                       product = make(op_f_mul, wide, {wide_a, wide_b}),
                       sum = make(operation, wide, first ? Words{product, other} : Words{other, product});
        make(op_f_convert, type, {sum}, w[2]);
        return true;
    }

    Words out_;
    uint32_t functions_ = 0;                                     // the import of GLSL.std.450
    std::map<uint32_t, Type> lanes_;                             // float types
    std::map<uint32_t, std::pair<uint32_t, uint32_t>> products_; // the factors of each
    std::map<uint32_t, uint32_t> wide_;                          // the double type of a float type
    std::map<std::pair<uint32_t, float>, uint32_t> constants_;   // of a type, a value in every lane
};

} // namespace

std::vector<uint32_t> change(const uint32_t* code, size_t words) {
    if (!is(Kind::contracting) && !is(Kind::metal)) return {code, code + words};
    return Rewriting(code, words).result();
}

bool has_variable_groups(const uint32_t* code, size_t words) {
    bool found = false;
    for_each(code, words, [&](uint32_t operation, const Words& w) {
        found |= operation == op_decorate && w[2] == spec_id && w[3] == VARIANT_GROUP_X;
    });
    return found;
}

} // namespace shims
