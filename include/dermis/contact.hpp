// SPDX-License-Identifier: MIT
// Contacts to pressure: forces at contact points, depths or taxels, as a simulator has them, become the pressure on
// each cell of a skin. This header is the manual. A pressure has the same bits everywhere, in every rounding mode of
// the caller.
//
//     std::vector<float> pressure(80 * 64);                                 // all 0
//     const dermis::contact::Pad pad{80, 64, 2.5e-4, pressure.data()};      // 20 mm x 16 mm
//     const std::vector<dermis::contact::Contact> contacts = {{0.01, 0.008, 0.5, 0.003}}; // 0.5 N on a radius of 3 mm
//     const dermis::contact::ContactReport report = dermis::contact::add_contacts(pad, contacts);
//     if (!report.plausible()) std::fputs(report.doubts().c_str(), stderr);
//     skin.press(pressure, dt);
//
// The pad's frame is right-handed. Its origin is the outer corner of cell (0, 0), x runs along a row, y from row to
// row, z out of the skin; seen from outside y is a quarter turn counter-clockwise from x. Cells are squares: the centre
// of cell (x, y) is ((x + 0.5)*spacing, (y + 0.5)*spacing), so that mirror edges mirror at the pad's border. A pad on a
// round body such as a fingertip has radii: then x and y are lengths along the body's surface. The frame stays flat:
// its plane z = 0 touches the surface at the pad's middle.
//
// Pressure is added to what the buffer holds: fill it with 0 before a frame. The sum of the pressures added, times
// spacing^2, is ContactReport::placed, to 1e-6 of the force that the buffer then holds; only pressures below 1e-38 Pa
// may be lost.
//
// The functions add_.. allocate nothing. Functions throw Error::bad_input with the argument's name, value and allowed
// range, and check all of their input before they write anything. Lengths are at most 1e6 m, so that nothing overflows.
#pragma once

#include <dermis/description.hpp>

#include <array>
#include <cstddef>

namespace dermis::contact {

// Numbers in the caller's memory, one behind the other: floats or doubles. Null: none.
class Reals {
  public:
    Reals(std::nullptr_t = nullptr) {}
    Reals(const float* first) : first_(first), single_(true) {}
    Reals(const double* first) : first_(first) {}
    explicit operator bool() const { return first_ != nullptr; }
    // Returns call(first), with the first number's address by its type.
    template <class Call> auto visit(const Call& call) const {
        return single_ ? call(static_cast<const float*>(first_)) : call(static_cast<const double*>(first_));
    }
    double operator[](std::size_t i) const {
        return visit([i](const auto* first) { return double(first[i]); });
    }

  private:
    const void* first_ = nullptr;
    bool single_ = false;
};

// The pressure from which on a report is doubtful, Pa. Touch and grasp press skin with 1e3 to 1e5 Pa. More than 1 MPa
// comes from a force on too few cells (1 N on one cell of 0.25 mm is 16 MPa) or of a wrong unit.
inline constexpr double doubtful_pressure = 1e6;

// A grid of cells, and the caller's pressures in Pa: pressure[y*pitch + x] is the pressure of cell (x, y).
struct Pad {
    int width = 0, height = 0; // cells, 1..16384
    double spacing = 0;        // m between cells, 1e-9..1e6
    float* pressure = nullptr; // not null; the caller sees to it that the floats are finite
    std::size_t pitch = 0;     // floats from row to row, width..2^40; 0: width
    bool tiled = false;        // whether pads lie side by side and share patches: the part of a patch beyond the border
                               // then belongs to the neighbours, and counts in no member of this pad's report
    // m, the radii of the surface along x and along y at the pad's middle; 0: straight in that direction. At least
    // width*spacing/(2*pi) and height*spacing/(2*pi), with which the pad goes once round the body; at most 1e6. With
    // equal radii the body is a ball, and a place has the length and the bearing of the shortest way to it from the
    // middle. With other radii it is the surface that an arc of radius_x sweeps about an axis along x, radius_y below
    // the middle. Only contacts in the world depend on radii.
    double radius_x = 0, radius_y = 0;
    // Pa, finite, laid out as the pressure: the tractions along x and along y, to which contacts in the world add the
    // part of their force along the surface. Null: that part is reported alone.
    float *shear_x = nullptr, *shear_y = nullptr;
    // Whether the body ends where the pad ends, as a flat finger does: the cells that a patch covers then carry the
    // part of it beyond the border too. Not together with tiled.
    bool keep = false;
};

// What became of the forces. asked = placed + outside + sideways, up to rounding of less than 1e-6 of the force that
// the buffer then holds.
struct DERMIS_API ContactReport {
    double asked = 0;    // N: sum of the forces given
    double placed = 0;   // N: the part that presses cells, measured by what the buffer's floats gained
    double outside = 0;  // N: the part that presses no cell: beside the pad, too far from it, turned away, or given by
                         // depths that nowhere press
    double sideways = 0; // N: of forces F at an angle to the surface's normal, the sum of F*(1 - cos), which is F less
                         // its component into the pad. The force along the surface, F*sin, is `shear`
    std::array<double, 2> shear = {0, 0}; // N: of contacts in the world that press the pad, the sum of their forces
                                          // along its x and y
    double greatest = 0; // Pa: greatest pressure of the cells that were pressed, with what they held before
    int cells = 0;       // cells that are pressed now and held 0 before
    int below_cell = 0;  // patches that press a single cell; its pressure is force/spacing^2, whatever the radius
    int beside = 0;      // contacts and taxels with a force that are wholly beside the pad
    int too_far = 0;     // contacts with a force farther from the pad's surface than `reach`
    int turned_away = 0; // contacts whose force does not push into the pad
    double level = 0; // m: the depth from which add_depths() with a stiffness, or images in report(pad), press; else 0
    // Of a Touch whose contacts name bodies with shapes:
    int by_body = 0;       // bodies that press by their shape
    int by_patch = 0;      // contacts of a body that is below no cell: they press by their patch
    int tilted = 0;        // bodies whose centre of pressure cannot be their contacts': these lie on a border
    double centre_off = 0; // m: the greatest distance between the two
    int clipped = 0;       // of DepthImages without gaps: images whose force wants to press cells that have no depth

    // Whether at least half of the force asked is placed, at most a tenth is outside, and at most 0.001 is lost to
    // rounding beside what the buffer held. Force is lost, for example, where a round body has a pad without radii,
    // where a position is in mm or a sign is wrong, and in a buffer that was not filled with 0.
    bool keeps_force() const;
    // Whether the force is kept, no patch is below one cell, no image clipped, and no pressure above doubtful_pressure.
    bool plausible() const { return keeps_force() && below_cell == 0 && clipped == 0 && greatest <= doubtful_pressure; }
    std::string doubts() const; // human-readable reasons; empty if plausible
};
using Report [[deprecated("use dermis::contact::ContactReport")]] = ContactReport;

// A force on a round patch with the pressure of an elastic contact after Hertz, p0*sqrt(1 - r^2/radius^2) at the centre
// of each cell; p0 is such that the cells of the whole patch carry the force. If the radius is 1.5 to 8 cells, a cell
// has the mean of the profile at 16 places in the cell instead, from a radius of 4 cells on at 4 places. A mean widens
// the patch, so that the profile's radius is smaller to make up for it. From a radius of two cells on, the patch's
// middle is right to 0.02 of a cell and its second moment to 3 %, wherever in a cell the middle lies. A patch that
// covers no cell's centre presses the nearest cell: give a radius of two cells or more.
//
// The pad's border does not change a patch's pressures. The part of a patch beyond it does not press this pad and
// counts as ContactReport::outside. Pads side by side, each with Pad::tiled set, share a patch between them. For a
// patch that overhangs and has a radius of more than 128 cells the share is right to 1e-4. A pad is [0, width*spacing)
// x [0, height*spacing), so that a place on a common border belongs to one pad.
struct Contact {
    double x = 0, y = 0; // m, in the pad's frame
    double force = 0;    // N, >= 0, into the pad
    double radius = 0;   // m, >= 0
    double area = 0;     // m^2, >= 0: pi*radius^2 in place of radius; one of them is 0
};

// Adds contacts, one after another; where patches overlap, pressures add up.
DERMIS_API ContactReport add_contacts(const Pad&, const Contact* contacts, std::size_t count);
inline ContactReport add_contacts(const Pad& pad, const std::vector<Contact>& contacts) {
    return add_contacts(pad, contacts.data(), contacts.size());
}

// The radius in m of the patch of a rigid ball on an elastic plane, after Hertz: (3*force*ball/(4*modulus))^(1/3).
// force: N, >= 0; ball: its radius, m, > 0; modulus: plane-strain modulus E/(1 - nu^2), Pa, > 0; where the volume
// stays the same, nu = 0.5, it is 4/3 of E.
DERMIS_API double hertz_radius(double force, double ball, double modulus);

// The vertical stress over the modulus at a depth below the middle of a flat, round punch that is pressed into an
// elastic half-space (Sneddon 1946): what an afferent feels below a probe. The parameters of afferent_model() were
// fitted to such strains.
// indentation: m, of the punch; depth: m below the surface, >= 0; radius: m, > 0; poisson: 0..0.5.
DERMIS_API double strain_below_punch(double indentation, double depth, double radius, double poisson = 0.4);

// Where a pad is: its frame in the world. rotation is row-major, and its columns are the axes of the pad in the world,
// so that world = position + rotation*local. Rotations are right to 1e-3.
struct DERMIS_API Pose {
    std::array<double, 3> position = {0, 0, 0}; // m, the outer corner of cell (0, 0)
    std::array<double, 9> rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};

    // As in MuJoCo's site_xpos and site_xmat, or geom_xpos and geom_xmat.
    static Pose from_matrix(Reals position, Reals rotation);
    // quaternion: w, x, y, z, of a length of 1e-150..1e150.
    static Pose from_quaternion(Reals position, Reals quaternion);
    // This frame, moved from the middle of the pad, where simulators have it, to the outer corner of cell (0, 0).
    Pose from_middle(const Pad&) const;
};

// A contact in the world. direction: where the force pushes the pad; its length is ignored, and 0 means straight into
// the pad. Of a force at an angle to the surface only the component against the surface's normal presses: against the
// pad's z, or on a round pad against the normal at the contact's place. A contact on a rim of the pad's body, or a
// direction with the wrong sign, has no such component: it presses nothing and counts in ContactReport::turned_away.
struct WorldContact {
    std::array<double, 3> position = {0, 0, 0};  // m
    double force = 0;                            // N, >= 0
    double radius = 0, area = 0;                 // as in Contact
    std::array<double, 3> direction = {0, 0, 0}; // -1e6..1e6; shorter than 1e-250: as 0
};

// Adds contacts in the world. Each is projected onto the pad's surface along its normal, if it is at most `reach`
// metres from the surface, on either side. reach: m, >= 0, below the pad's radii.
DERMIS_API ContactReport add_contacts(const Pad&, const Pose&, double reach, const WorldContact* contacts,
                                      std::size_t count);
inline ContactReport add_contacts(const Pad& pad, const Pose& pose, double reach,
                                  const std::vector<WorldContact>& contacts) {
    return add_contacts(pad, pose, reach, contacts.data(), contacts.size());
}

// A rigid body in the world, as physics engines have it.
struct Body {
    // sphere: size[0] is its radius. capsule: a cylinder along z between two half balls; radius and half its length.
    // box: half its length along x, y and z. plane: all below z = 0 of its frame; no sizes. cylinder: along z; radius
    // and half its length. ellipsoid: half its length along x, y and z. hull: a convex solid, given by its faces.
    enum class Kind { sphere, capsule, box, plane, cylinder, ellipsoid, hull } kind = Kind::sphere;
    std::array<double, 3> size = {0, 0, 0}; // m, above 0, at most 1e6; numbers that a kind does not use are 0
    Pose pose;                              // of the body's middle; of a plane any point of it
    // Of a hull, four numbers for each face: its outward normal n, of length 1 to 1e-3, and the offset m up to which
    // n*place <= m inside, m; both in the body's frame. The caller's memory; null of other kinds.
    const double* faces = nullptr;
    std::size_t face_count = 0; // 4..65536
};

// Writes to each cell how deep a body reaches below the pad's surface, along the surface's normal there, m: what
// DepthMap::depth takes. A gap is negative; where the body is neither above nor below a cell the depth is -1e6. What is
// deeper than a radius of the pad, or higher above it, counts as if it were not there. depth: the caller's array,
// depth[y*pitch + x]. pitch: floats from row to row, width..2^40; 0: width. The pad's pressure is not touched.
DERMIS_API void fill_depths(const Pad&, const Pose&, const Body&, float* depth, std::size_t pitch = 0);

// The stiffness, Pa per m, of an elastic foundation on which a ball presses a patch with the radius of Hertz's:
// 16*modulus/(3*pi*radius). Arguments as in hertz_radius(); force > 0.
DERMIS_API double foundation_stiffness(double force, double ball, double modulus);
// The stiffness, Pa per m, of a skin that is held long: the modulus at which its material comes to rest, over the
// thickness. On such a foundation the skin takes the shape of what presses it. 0 where the material flows, has moduli
// by cells, or no thickness.
DERMIS_API double skin_stiffness(const Material&);

// How deep something sinks into each cell, and the force with which it does: an elastic foundation. A negative depth is
// a gap.
struct DepthMap {
    Reals depth;           // m, -1e6..1e6; depth[y*pitch + x] is the depth of cell (x, y)
    double force = 0;      // N, >= 0
    double stiffness = 0;  // Pa per m, 0 or 1e-6..1e30
    std::size_t pitch = 0; // numbers from row to row, width..2^40; 0: width
};
using Depths [[deprecated("use dermis::contact::DepthMap")]] = DepthMap;

// Adds a force. Without a stiffness, pressure is in proportion to depth, where depth > 0. With a stiffness it is
// stiffness*(depth - level), where depth > level; the level is the one at which the pressures sum to the force. It is
// negative where the body has to sink in deeper than the depths say; gaps smaller than -level are then pressed too.
DERMIS_API ContactReport add_depths(const Pad&, const DepthMap&);

// The readings of a sensor array: rectangles side by side, each under an even pressure.
struct TaxelReadings {
    enum class Unit { newton, pascal } unit = Unit::newton;
    Reals values;              // >= 0, pascals at most 3.4e38; of column i in row j values[i*column_step + j*row_step]
    int columns = 0, rows = 0; // 1..16384; columns follow each other along x, rows along y
    double width = 0, height = 0; // m, of one taxel along x and y, 1e-9..1e6
    double x = 0, y = 0;          // m, outer corner of the first taxel in the pad's frame
    // Numbers from column to column, >= 1, and from row to row; row_step 0: columns. Values that are stored column by
    // column have column_step = rows and row_step = 1.
    std::size_t column_step = 1, row_step = 0;
};
using Taxels [[deprecated("use dermis::contact::TaxelReadings")]] = TaxelReadings;

// Adds each taxel's force to the cells below it in proportion to the area that cell and taxel share; either of the two
// may be the finer one. Force beyond the border counts as ContactReport::outside.
DERMIS_API ContactReport add_taxels(const Pad&, const TaxelReadings&);

} // namespace dermis::contact
