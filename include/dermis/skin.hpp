// SPDX-License-Identifier: MIT
// Skins pressed frame by frame, one or many at once. Part of dermis.hpp.
#pragma once

#include <dermis/device.hpp>

namespace dermis {

// Options of a Skin.
struct SkinOptions {
    // Fields over all cells to compute: sa1, sa2, fa1, fa2, each at most once. Ignored if the description has sites:
    // the responses are then those of their classes.
    std::vector<Quantity> responses = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    // f32 or f32_compensated. Default: compensated if SA2 is asked for as a plain integral, which grows for ever.
    std::optional<Precision> precision;
    // Pads: skins of this description that are pressed together, each with edges and a state of its own and with the
    // bits of a Skin alone. 1..1048576, count*width*height up to 2147483647.
    int count = 1;
    // The material of each pad in place of the description's: moduli, viscosities, elements, spring and dashpot, in
    // numbers, of as many elements, springs and dashpots in every pad. Empty: all pads have the description's.
    std::vector<Material> materials;
};

// Some pads of a Skin, in this order: numbers from 0 on, each at most once. By default all, from 0 on.
struct Pads {
    Pads() = default;
    explicit Pads(const int* list, size_t n) : numbers(list), count(n), all(false) {} // not of {0, 1}
    Pads(const std::vector<int>& v) : Pads(v.data(), v.size()) {}
    const int* numbers = nullptr;
    size_t count = 0;
    bool all = true;
};

// A skin pressed frame by frame, or a batch of them: each press gives it the pressure at the end of a time step.
// Presses allocate nothing. One thread at a time may use a skin, or the skins on one Vulkan device, which share it.
class DERMIS_API Skin {
  public:
    // On Device::cpu(1) the calling thread works alone. receptors.fa2 is by default step_mean, as for all frames.
    // Throws Error::bad_input; Error::no_device if the device's bits are not the CPU path's and it was not asked for by
    // name or number; Error::device.
    Skin(const Device&, const SkinDescription&, const SkinOptions& = {});
    ~Skin();
    Skin(Skin&&) noexcept;
    Skin& operator=(Skin&&) noexcept;

    int count() const; // of pads

    // pressure: width*height finite floats for each pad that is pressed, Pa, pushing is positive, row 0 first; copied.
    // It is the pressure at the end of a step of dt seconds, over which it runs linearly from that of the pad's
    // previous press, or from 0 on a skin at rest. The other pads stay as they are. dt: finite, >= 0. dt = 0 is a
    // pause: strain is kept, and this pressure is where the next step starts. A change of pressure during a pause
    // appears in no response. dt must also leave the coefficients of the step in float: about 1e-38 .. 1e19 s at
    // viscosities near 1 Pa s. A response beyond 3.4e38 is infinite, and then NaN until reset(). Throws
    // Error::bad_input naming dt, size, pad or the first cell that is not finite, and nothing has happened;
    // Error::device.
    void press(const float* pressure, size_t cells, double dt, const Pads& = {});
    void press(const std::vector<float>& pressure, double dt, const Pads& pads = {}) {
        press(pressure.data(), pressure.size(), dt, pads);
    }
    // The same with a step for each pad that is pressed. The first such press of a batch allocates.
    void press(const float* pressure, size_t cells, const double* dt, size_t steps, const Pads& = {});
    void press(const std::vector<float>& pressure, const std::vector<double>& dt, const Pads& pads = {}) {
        press(pressure.data(), pressure.size(), dt.data(), dt.size(), pads);
    }

    // The response sa1, sa2, fa1 or fa2 at the end of each pad's last press; 0 before the first. data, pad by pad from
    // 0 on: width*height floats, row 0 first, or, if the description has sites, one per site of that class in the order
    // given; the same memory after every press. Throws Error::bad_input if the response was not asked for;
    // Error::device if the device is lost.
    struct Response {
        const float* data;
        size_t size; // of all pads
        const float* begin() const { return data; }
        const float* end() const { return data + size; }
        float operator[](size_t i) const { return data[i]; }
    };
    // Also strain, indentation (thickness*strain, m) and curvature (1/m; of the deformed surface, where gains are
    // 1 + l*C), which are read from the state when this is called: of every cell, or of every site in the order given.
    // A spring's share in the strain is that of the last pressure.
    Response response(Quantity) const;

    void reset(const Pads& = {}); // back to skins at rest

    // The state: strains, integrals and the pressure that the next press starts from, in native byte order. The bytes
    // are the same on the CPU and on Vulkan, and as many pads of any skin take them that has the same grid, sites,
    // number of elements, precision, and SA2 and FA2 asked for: their next presses give the same bits. Responses stay
    // those of the last press until then. load() also takes states that dermis 0.1 saved. save() and load() throw
    // Error::bad_input naming the first thing that differs, and nothing has happened; Error::device.
    size_t state_bytes(const Pads& = {}) const;
    void save(void* state, size_t bytes, const Pads& = {}) const;
    void load(const void* state, size_t bytes, const Pads& = {});

    // Gives pads another material from the next press on, in numbers, of as many elements, springs and dashpots as they
    // have; strains stay. Some pads only where SkinOptions::materials gave each its own. Throws Error::bad_input, also
    // where the material is one of maps, and nothing has happened.
    void set_material(const Material&, const Pads& = {});

    // Returns what the state and the description tell: strain and indentation now (of the cells that sites read),
    // times, ridges, the gain at rest and, of fields on a surface that is no map, now, and which of the last responses
    // changed sign. Takes up to as long as making the skin did.
    Report report(int pad = 0) const;

    struct DERMIS_HIDDEN Impl;

  private:
    std::unique_ptr<Impl> impl_;
};

} // namespace dermis
