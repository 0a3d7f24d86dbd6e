// SPDX-License-Identifier: MIT
// Skins pressed frame by frame, one or many at once. Part of dermis.hpp.
#pragma once

#include <dermis/afferents.hpp>
#include <dermis/device.hpp>

#include <functional>

namespace dermis {

namespace contact {
class Touch; // touch.hpp
}

// Options of a Skin.
struct SkinOptions {
    // The responses that each cell gives: sa1, sa2, fa1, fa2, each at most once. Ignored if the description has sites:
    // each site then gives the response of its class, and no other cell gives any.
    std::vector<Quantity> responses = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    // f32 or f32_compensated. Default: compensated if SA2 is asked for as a plain integral, which grows for ever.
    std::optional<Precision> precision;
    // The number of pads: skins of this description that are pressed together. Each pad has its own edges and its own
    // state, and its bits are the bits of a Skin with one pad. 1..1048576; count*width*height at most 2147483647.
    int count = 1;
    // A material for each pad, `count` of them, in place of the description's. Only moduli, viscosities, elements,
    // spring and dashpot count, as numbers, not maps. Every pad must have the same number of elements and springs, and
    // dashpots in the same places. Empty: all pads have the description's material.
    std::vector<Material> materials;
    // How the pressure runs from frame to frame; a SkinProgram takes linear alone. Under parabolic hold a skin keeps
    // one more number for each cell, the pressure of the frame before, and a step depends on the length of the one
    // before.
    Hold hold = Hold::linear;
    // depth: where a press is given pressures it takes the depth of each cell, m (without Grid::spacing in units of the
    // thickness), from which the strain follows whatever the material: depth/thickness, and 0 where a depth would pull.
    // The depths of neighbours do not matter. Needs a thickness > 0; refuses `materials`, set_material() and FA2 as
    // Fa2::point. A SkinProgram takes pressure alone.
    Control control = Control::pressure;
    // The afferents of each pad, nerve fibres of the skin. Under control = depth they follow the strain. A SkinProgram
    // has none. They read the state after each press: on a Vulkan device a press then waits and downloads the state.
    std::vector<Afferents> afferents;
    // Whether presses take tractions beside pressures. They strain the same chain of elements with a third of its
    // moduli and viscosities, because the skin's volume stays the same. No pressure changes a shear, and no shear a
    // response, except SA2 with sa2_stretch. Refuses sites, maps of the material, control = depth and edges =
    // published. A SkinProgram has no shear.
    bool shear = false;
    // Given: SA2 answers to the stretch of the surface along this direction (x, y), of any length but 0, in place of
    // the strain; (0, 0): to the sum of stretch_x and stretch_y. Receptors::sa2_adaptation holds for it, and between
    // frames the stretch runs linearly. Needs shear, and sa2 among the responses. On a Vulkan device each press then
    // waits and downloads the shear. Where sa2 is the only response, sa1 is one too.
    std::optional<std::array<double, 2>> sa2_stretch;
    // Called on the thread that presses, while many frames are copied, between frames and between blocks of steps of
    // afferents, each of which takes less than a second; with the fraction of the frames that is done, 0..1. A short
    // press does not call it. What it throws ends the press: the pads then have the state after the last whole frame,
    // spikes() has the spikes up to it (none within the first frame, those of the last press before it begins), and
    // responses are those of a frame only after the next press. If afferents take several blocks, the press saves the
    // state first, which allocates. It may press other skins; this one then refuses presses, changes and saves.
    std::function<void(double)> progress;
};

// The pads of a Skin that a call is about: their numbers, from 0 on, in any order, each at most once. Pressures, steps
// and states stand in this order. By default all pads, from 0 on. A number that the Skin has not, or that occurs twice,
// throws Error::bad_input.
struct Pads {
    Pads() = default;
    // Explicit, so that a braced {0, 1} is not taken for a pointer and a count.
    explicit Pads(const int* list, size_t n) : numbers(list), count(n), all(false) {}
    Pads(const std::vector<int>& v) : Pads(v.data(), v.size()) {}
    const int* numbers = nullptr;
    size_t count = 0;
    bool all = true;
};

// A skin pressed frame by frame, or a batch of pads: each press gives it the pressure at the end of a time step.
// Presses allocate nothing, except the first press with a step for each pad, the first parabolic press of pads whose
// previous steps had different lengths, press_frames() of more frames than before, and presses of afferents over a
// longer time than before. A press that throws Error::bad_input or Error::no_memory leaves the skin unchanged. Only one
// thread at a time may use a skin; all skins on one Vulkan device count as one.
//
// Responses at a depth (Receptors::depth) differ from the sums over all cells by at most 1e-3 of the greatest |signal|
// in the pad, times 1 + |l*C|; if the weights of those sums add up to more than 1, as a displacement's may, times what
// they add up to. They have the same bits on the CPU and on every device. A skin with a depth, or whose SA1 follows the
// stress, computes all cells, whether or not the description has sites.
class DERMIS_API Skin {
  public:
    // On Device::cpu(1) the calling thread works alone. On a Vulkan device up to one thread per core copies the
    // pressures of a large skin. The default of receptors.fa2 is step_mean. Throws Error::bad_input; Error::no_device
    // if the device has other bits than the CPU path and was not asked for by name or number; Error::device.
    Skin(const Device&, const SkinDescription&, const SkinOptions& = {});
    ~Skin();
    Skin(Skin&&) noexcept;
    Skin& operator=(Skin&&) noexcept;

    int count() const; // number of pads

    // pressure: width*height finite floats for each pad that is pressed, Pa, row 0 first; positive pressure pushes.
    // With SkinOptions::control = depth they are depths, m. The floats are copied. They are the pressure at the end of
    // a step of dt seconds; over the step the pressure runs linearly, or as SkinOptions::hold says, from the pad's
    // previous press, or from 0 on a skin at rest. Pads that are not pressed stay as they are. dt: s, >= 0, finite. dt
    // = 0 is a pause: strain is kept, and the next step starts from this pressure, linearly; the change of pressure
    // during the pause appears in no response. The coefficients of the step must also fit a float: about 1e-38 .. 1e19
    // s at viscosities near 1 Pa s. A response beyond 3.4e38 is infinite, and then NaN until reset(). Throws
    // Error::bad_input, which names dt, the size, the pad or the first cell that is not finite, and leaves the skin
    // unchanged; Error::device.
    void press(const float* pressure, size_t cells, double dt, const Pads& = {});
    void press(const std::vector<float>& pressure, double dt, const Pads& pads = {}) {
        press(pressure.data(), pressure.size(), dt, pads);
    }
    // The same, with one step for each pad that is pressed: `steps` of them, in the order of the pads.
    void press(const float* pressure, size_t cells, const double* dt, size_t steps, const Pads& = {});
    void press(const std::vector<float>& pressure, const std::vector<double>& dt, const Pads& pads = {}) {
        press(pressure.data(), pressure.size(), dt.data(), dt.size(), pads);
    }
    // The same with tractions, Pa: of a skin with SkinOptions::shear, which takes no press without them. traction: as
    // many numbers along x as there are pressures, and in their order, then as many along y. A positive traction moves
    // the surface towards greater x or y.
    void press(const float* pressure, const float* traction, size_t cells, double dt, const Pads& = {});
    // Does the same as `count` presses of dt seconds each, to the bit, but computes only the responses after the last
    // frame: for a simulator that steps several times before it reads a response. frames: `count` >= 1 frames, one
    // after another, each of `cells` numbers as press() takes them. All frames are copied and checked before any of
    // them is pressed; the skin keeps the memory of the copy. Frames of no pad do what one does.
    void press_frames(const float* frames, size_t count, size_t cells, double dt, const Pads& = {});
    // The same as press() of all pads with the pressures of a Touch, to the bit, but takes no time for a pad that is at
    // rest and not touched. The Touch has as many pads, of as many cells, of the same spacing if the description gives
    // one in metres, and tractions where the skin has shear. Refuses SkinOptions::control = depth.
    void press(const contact::Touch&, double dt);
    // The cells of a pad whose pressure the skin needs, as y*width + x, ascending. If the description has sites, and
    // the skin does not compute all cells, they are the cells that the stencils of the sites read; otherwise all cells.
    std::vector<int> cells() const;
    // The same as press(), to the bit, with the pressures of cells() alone: `numbers` floats, cells().size() for each
    // pad that is pressed. It takes time for these cells, not for the grid.
    void press_cells(const float* pressure, size_t numbers, double dt, const Pads& = {});

    // The response sa1, sa2, fa1 or fa2 at the end of each pad's last press; 0 before the first. data, pad by pad from
    // 0 on: width*height floats, row 0 first, or, if the description has sites, one per site of that class in the order
    // given; the same memory after every press. On Vulkan a press waits for and downloads the responses that this call
    // has returned before; where there is none it does not wait, and a later call throws what fails in it. Throws
    // Error::bad_input if the skin was made without the response; Error::device if the device is lost.
    struct Response {
        const float* data;
        size_t size; // of all pads
        const float* begin() const { return data; }
        const float* end() const { return data + size; }
        float operator[](size_t i) const { return data[i]; }
    };
    // Strain, indentation (thickness*strain, m) and curvature (1/m) of the deformed surface, the C of the gain 1 + l*C,
    // can always be asked for. This call computes them from the present state, so that they are asked for again after a
    // press: for every cell, or for every site in the order given. The strain of a spring follows from the last
    // pressure.
    //
    // With SkinOptions::shear there are also shear_x and shear_y, the shear strains gamma of every cell, with the
    // displacement u = thickness*gamma; and the strain of the surface, by central differences under the edges' rule:
    // stretch_x = du_x/dx, stretch_y = du_y/dy, stretch_xy = (du_x/dy + du_y/dx)/2. Along a direction (n_x, n_y) skin
    // is stretched by n_x^2*stretch_x + n_y^2*stretch_y + 2*n_x*n_y*stretch_xy.
    Response response(Quantity) const;

    // The spikes of the last call that pressed, pad by pad in the order pressed, then by afferent, then by time; of
    // press_frames() frame by frame. Empty without SkinOptions::afferents, and before the first press. The same memory
    // until the next call that presses. Spikes of an afferent are at least its refractory time apart. A press whose
    // step is longer than all before it may allocate. press() refuses a dt above 65536 times an afferent's refractory
    // time or its shortest time constant.
    struct Spikes {
        const Spike* data;
        size_t size;
        const Spike* begin() const { return data; }
        const Spike* end() const { return data + size; }
        const Spike& operator[](size_t i) const { return data[i]; }
    };
    Spikes spikes() const;

    void reset(const Pads& = {}); // back to skins at rest

    // The state: strains, integrals and the pressure from which the next press starts, in native byte order; under
    // parabolic hold also the pressure and the step before. The pressures of cells that are not among cells() are 0.
    // The bytes are the same on the CPU and on Vulkan. A skin can load them into the same number of pads if it has the
    // grid, sites, numbers of elements and springs, precision, hold, number of afferents and shear of the skin that
    // saved them, and gives SA2 and FA2 where that skin did; its next presses then give the same bits. Depths may
    // differ: a skin that computes all cells has the states of one without sites. load() also takes states of the older
    // version 2, for skins without parabolic hold, afferents and shear. Until the next press, responses stay what they
    // were. bytes: state_bytes(). save() and load() throw Error::bad_input, which names the first difference, a number
    // that is not finite, or a number of an afferent that no press makes, with its range, and change nothing;
    // Error::device.
    size_t state_bytes(const Pads& = {}) const;
    void save(void* state, size_t bytes, const Pads& = {}) const;
    void load(const void* state, size_t bytes, const Pads& = {});

    // Gives pads another material from the next press on; the strains of elements are kept, and that of a spring
    // follows from the pressure at once. It must have the same number of elements and springs as the old one, and
    // dashpots in the same places. Neither of the two may have maps. A list of pads is allowed only where
    // SkinOptions::materials gave each pad its own. Throws Error::bad_input and changes nothing then.
    void set_material(const Material&, const Pads& = {});

    // Returns what is known of a pad. From its state: the greatest strain and indentation (of cells() alone). From the
    // description: retardation times, cells per ridge and the gain at rest. Without sites, and unless the surface is a
    // map, also the gain now and which of the last responses have changed sign. Takes up to as long as making the skin.
    // pad: 0..count() - 1; Error::bad_input otherwise.
    Report report(int pad = 0) const;

    struct DERMIS_HIDDEN Impl;

  private:
    std::unique_ptr<Impl> impl_;
};

} // namespace dermis
