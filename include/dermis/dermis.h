// SPDX-License-Identifier: MIT
// dermis in C99: pressure on skin in, mechanoreceptor responses out. It is dermis.hpp without C++, and that header says
// what the model and each number mean. Maps are row-major, row 0 first: index = y*width + x.
//
//     dermis_scene* scene = NULL;
//     dermis_skin* skin = NULL;
//     const double dt = 0.001;
//     const float* fa1;
//     size_t count;
//     if (dermis_scene_from_file("pad.toml", &scene) || dermis_skin_create(NULL, scene, NULL, &skin) ||
//         dermis_skin_press(skin, pressure, width * height, &dt, 1, NULL) ||
//         dermis_skin_get_response(skin, DERMIS_FA1, &fa1, &count))
//         fputs(dermis_last_error(), stderr);
//     dermis_skin_destroy(skin);
//     dermis_scene_destroy(scene);
//
// Rules for every function:
// - It returns DERMIS_OK or another status. dermis_last_error() then names the argument, its value and what is allowed.
//   A call that returns DERMIS_BAD_INPUT has changed nothing, except that pointers and numbers that it should have
//   given are NULL or 0. No C++ exception leaves a function.
// - Pointers must not be NULL unless the function's comment says so. Texts end with a 0 and are UTF-8.
// - Use of a handle after its destroy or close is undefined, and is not detected.
// - One thread at a time may use a handle; all runs and skins on one Vulkan device count as one. Threads may share a
//   scene that none of them changes.
// - A handle keeps what it needs: a device, a scene or a result may be destroyed before what was made with it.
// - Memory that a function gives access to belongs to its handle.
// - Enumerators keep their numbers for ever. A struct begins with its size, which the caller sets to its sizeof, so
//   that later versions can append members. A struct without a size never changes.
#pragma once

#include <dermis/export.hpp>
#include <dermis/version.hpp>

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef int32_t dermis_status;
enum {
    DERMIS_OK = 0,
    DERMIS_BAD_INPUT = 1,     // an argument or a parameter of a scene is not allowed
    DERMIS_NO_DEVICE = 2,     // no device can be used: no loader, no driver, or a device that is refused
    DERMIS_DEVICE_FAILED = 3, // a device failed while working
    DERMIS_IO = 4,            // a file could not be written
    DERMIS_NO_MEMORY = 5,     // memory could not be allocated; what existed before is unchanged
    DERMIS_INTERNAL = 6       // anything else, which is an error in dermis
};

typedef int32_t dermis_quantity;
enum {
    DERMIS_STRAIN = 0,
    DERMIS_SA1 = 1,
    DERMIS_SA2 = 2,
    DERMIS_FA1 = 3,
    DERMIS_FA2 = 4,
    DERMIS_CURVATURE = 5,
    DERMIS_DEFORMATION = 6,
    DERMIS_INDENTATION = 7, // only a skin gives it, and the next five only one with shear
    DERMIS_SHEAR_X = 8,
    DERMIS_SHEAR_Y = 9,
    DERMIS_STRETCH_X = 10,
    DERMIS_STRETCH_Y = 11,
    DERMIS_STRETCH_XY = 12
};
// A set of quantities is the bitwise or of their bits: DERMIS_BIT(DERMIS_SA1) | DERMIS_BIT(DERMIS_FA1).
#define DERMIS_BIT(quantity) ((uint32_t)1 << (quantity))

typedef struct dermis_device dermis_device;
typedef struct dermis_scene dermis_scene;
typedef struct dermis_result dermis_result;
typedef struct dermis_skin dermis_skin;

// The version of the library that runs, such as "0.1.0". DERMIS_VERSION is the version of the headers.
DERMIS_API const char* dermis_version(void);

// The message of the last call on this thread that did not return DERMIS_OK; "" before there is one. Calls that succeed
// do not change it. The text is valid until the next call that fails on this thread. It is the only state outside the
// handles.
DERMIS_API const char* dermis_last_error(void);

// ---- Devices. Where a function takes a device, NULL is the CPU path with one thread per core.

// which: "auto", "cpu", "vulkan", a number, or a part of a Vulkan device's name or uuid; see Device::open in
// dermis.hpp.
DERMIS_API dermis_status dermis_device_open(const char* which, dermis_device** device);
// The CPU path. threads: 0 (one per core that the process may use), 1 (only the calling thread) .. 1024.
DERMIS_API dermis_status dermis_device_open_cpu(int32_t threads, dermis_device** device);
DERMIS_API void dermis_device_close(dermis_device* device); // NULL: nothing happens

typedef struct dermis_device_info {
    size_t size;         // sizeof(dermis_device_info)
    const char* name;    // "cpu", or what the driver calls the device
    const char* kind;    // "cpu path", "discrete GPU", "integrated GPU", "virtual GPU", "software", "other"
    const char* driver;  // name and version; "" for the CPU path
    const char* refused; // the reason why no Vulkan device is used, if "auto" found none; else ""
    int32_t vulkan;      // 1 for a Vulkan device, 0 for the CPU path
    int32_t exact;       // 1 if a self-test gave the bits of the CPU path, and for the CPU path, else 0
    const char* uuid;    // by which devices of one name differ; "" for the CPU path and for Vulkan 1.0
} dermis_device_info;
// The texts are valid until the device is closed.
DERMIS_API dermis_status dermis_device_get_info(const dermis_device* device, dermis_device_info* info);

// ---- Scenes. host/lab/scenes/README.md lists the keys of a scene and their ranges.

// path: a TOML file of at most 64 MiB, which is read once. Paths in it are relative to its folder.
DERMIS_API dermis_status dermis_scene_from_file(const char* path, dermis_scene** scene);
// text: the content of such a file; "" is a valid scene. folder: where relative paths start; NULL: the working
// directory.
DERMIS_API dermis_status dermis_scene_from_string(const char* text, const char* folder, dermis_scene** scene);
// The fingertip of the preset, as dermis::fingertip(), with the default load.
DERMIS_API dermis_status dermis_scene_fingertip(dermis_scene** scene);
// Replaces one key, as in ("time.step", "0.001"). value: one line of TOML; what is not TOML is taken as a string. The
// scene must be valid before and after. Keys that depend on each other are therefore set together, as a table:
// ("time", "{ step = 0.5, duration = 20 }") replaces all keys of that table. Or they stand in the text from the start.
// The files that the scene names are read again.
DERMIS_API dermis_status dermis_scene_set(dermis_scene* scene, const char* key, const char* value);
// Gives a map in memory in place of a .npy file. key: "surface.path" or "load.path", which also sets surface.kind or
// load.kind to "file"; "material.modulus" or "material.viscosity". values: count = width*height finite numbers, row 0
// first, in the unit of the key; copied.
DERMIS_API dermis_status dermis_scene_set_map(dermis_scene* scene, const char* key, const double* values, size_t count);
// The grid's cells, 1..16384 each.
DERMIS_API dermis_status dermis_scene_get_size(const dermis_scene* scene, int32_t* width, int32_t* height);
DERMIS_API void dermis_scene_destroy(dermis_scene* scene); // NULL: nothing happens

// ---- Reports: whether the numbers of a result or a skin are plausible for skin.

// A figure, and the range in which it is plausible. NaN: not known.
typedef struct dermis_figure {
    double value, least, greatest;
} dermis_figure;

typedef struct dermis_report {
    size_t size;                        // sizeof(dermis_report)
    dermis_figure strain;               // greatest |eps|: indentation over thickness
    dermis_figure indentation;          // m: thickness*strain
    dermis_figure gain;                 // greatest |l*C|, above 1 responses can change sign
    dermis_figure cells_per_ridge;      // infinite where the surface has no ridge period
    dermis_figure retardation_times[8]; // s: one per element in series, else the least and the greatest of all cells
    uint32_t retardation_time_count;    // 0..8
    uint32_t sign_changed;              // bits of responses with the wrong sign in some cell: 1 + l*C < 0 there
    dermis_figure vibration;            // Hz, where frames lose a tenth of a vibration: 0.178 over the time between two
                                        // frames; of a load known by frames. A size of 304 has no such member.
    dermis_figure fine_load;            // see Report in description.hpp. A size of 328 has no such member.
} dermis_report;

// ---- Runs.

// Runs a scene. device may be NULL.
DERMIS_API dermis_status dermis_run(const dermis_scene* scene, const dermis_device* device, dermis_result** result);

// The pointers below are valid until the result is destroyed.

// The output times in s, ascending.
DERMIS_API dermis_status dermis_result_get_times(const dermis_result* result, const double** times, size_t* count);

typedef int32_t dermis_column;
enum {
    DERMIS_MEAN = 0, // over all cells
    DERMIS_MIN = 1,  // min and max: with output.extremes, which is the default
    DERMIS_MAX = 2
};
// One number per output time of a quantity of output.traces, in its unit. DERMIS_BAD_INPUT for a quantity or a probe
// that the scene does not ask for, and for min and max without output.extremes.
DERMIS_API dermis_status dermis_result_get_trace(const dermis_result* result, dermis_quantity quantity,
                                                 dermis_column column, const double** values, size_t* count);
// The same in one cell. probe: its index in output.probes, from 0 on.
DERMIS_API dermis_status dermis_result_get_probe(const dermis_result* result, dermis_quantity quantity, size_t probe,
                                                 const double** values, size_t* count);
// A field of output.fields: width*height numbers. at: the very time that the scene gives, s.
DERMIS_API dermis_status dermis_result_get_field(const dermis_result* result, dermis_quantity quantity, double at,
                                                 const double** values, size_t* count);
// The responses of the scene's sites: values[time*sites + site]. Without sites *sites is 0 and *values NULL.
DERMIS_API dermis_status dermis_result_get_responses(const dermis_result* result, const double** values, size_t* times,
                                                     size_t* sites);
// A spike of a run: an afferent, a nerve fibre of the skin, fires at a time, s. The scene's are numbered from 0 on.
typedef struct dermis_fired_spike {
    double time;
    int32_t afferent;
} dermis_fired_spike;
// The spikes of the scene's afferents by time, then by number. count: 0 where there are none; *spikes may then be NULL.
DERMIS_API dermis_status dermis_result_get_spikes(const dermis_result* result, const dermis_fired_spike** spikes,
                                                  size_t* count);
DERMIS_API dermis_status dermis_result_get_report(const dermis_result* result, dermis_report* report);
DERMIS_API void dermis_result_destroy(dermis_result* result); // NULL: nothing happens

// ---- Skins, pressed frame by frame, one or many at once. Presses allocate nothing, except the first press with a step
// for each pad, the first parabolic press of pads whose previous steps had different lengths, and presses with
// sa2_stretch or afferents.

typedef int32_t dermis_precision;
enum {
    DERMIS_DEFAULT_PRECISION = 0, // compensated if SA2 is asked for as a plain integral, else f32
    DERMIS_F32 = 1,
    DERMIS_F32_COMPENSATED = 2
};

// How the pressure runs from one frame to the next: along a line, or along a parabola; see Hold in description.hpp.
typedef int32_t dermis_hold;
enum { DERMIS_LINEAR = 0, DERMIS_PARABOLIC = 1 };

// What a skin is pressed by: the pressure of each cell, Pa, or its depth, m. Its strain is then depth/thickness, and 0
// where a depth would pull, whatever the depths of its neighbours. materials and dermis_skin_set_material are
// refused then.
typedef int32_t dermis_control;
enum { DERMIS_PRESSURE = 0, DERMIS_DEPTH = 1 };

typedef struct dermis_skin_options {
    size_t size;                // sizeof(dermis_skin_options)
    int32_t count;              // pads that are pressed together, 1..1048576; count*width*height at most 2147483647
    uint32_t responses;         // bits of sa1, sa2, fa1 and fa2; 0: all four. Ignored if the scene has sites
    dermis_precision precision; // one of the three above
    int32_t materials;          // 1: a material for each pad, at first the scene's, without maps; 0: one for all
    dermis_hold hold;           // one of the two above; a size of 24 has no such member: the pressure runs linearly
    dermis_control control;     // one of the two above; a size of 24 has no such member: a pressure
    int32_t shear;       // 1: presses take tractions too, by dermis_skin_press_tractions or a touch; 0: they do not.
                         // A size of 24 or 32 has no such member: 0. 1 is refused with sites, maps of the
                         // material, DERMIS_DEPTH and published edges
    int32_t sa2_stretch; // 1: sa2 answers to the stretch of the surface in place of the strain; needs shear; or 0
    double stretch_direction[2]; // of sa2_stretch, x and y; {0, 0}: all round
} dermis_skin_options;

// The pads of a skin that a call is about: their numbers, from 0 on, in any order, each at most once. Pressures, steps
// and states stand in this order. Where a function takes such a list, NULL means all pads, from 0 on; a list with a
// count of 0 means no pad.
typedef struct dermis_pads {
    const int32_t* numbers; // NULL is allowed if count is 0
    size_t count;
} dermis_pads;

// Makes a skin at rest with a scene's grid, surface, material, curvature, receptors, sites and afferents: one pad,
// or a batch of pads. Each pad has its own edges and its own state, and its bits are the bits of a skin alone. device
// may be NULL. options may be NULL: one pad with all four responses.
DERMIS_API dermis_status dermis_skin_create(const dermis_device* device, const dermis_scene* scene,
                                            const dermis_skin_options* options, dermis_skin** skin);
// pressure: cells = width*height finite floats for each pad that is pressed, Pa, row 0 first; positive pressure pushes.
// Under DERMIS_DEPTH they are depths, m. The floats are copied. They are the pressure at the end of a step of dt
// seconds; over the step the pressure runs from the pad's previous press, or from 0, as hold says. The other pads stay
// as they are. dt: finite, >= 0; 0 is a pause. steps: the number of dt, 1 for all pads that are pressed or one for
// each. pressure and dt may be NULL if the list of pads is empty.
DERMIS_API dermis_status dermis_skin_press(dermis_skin* skin, const float* pressure, size_t cells, const double* dt,
                                           size_t steps, const dermis_pads* pads);
// The same for a skin with shear, with one step for all pads. traction: Pa, as many numbers along x as there are
// pressures, and in their order, then as many along y.
DERMIS_API dermis_status dermis_skin_press_tractions(dermis_skin* skin, const float* pressure, const float* traction,
                                                     size_t cells, double dt, const dermis_pads* pads);
// The same as `count` presses of dt seconds each, to the bit; the responses of the last frame alone are computed.
// frames: one after another, each of `cells` numbers as above. count: >= 1. All frames are checked before one is
// pressed. Frames of no pad do what one does.
DERMIS_API dermis_status dermis_skin_press_frames(dermis_skin* skin, const float* frames, size_t count, size_t cells,
                                                  double dt, const dermis_pads* pads);
// The cells of a pad whose pressure the skin needs, as y*width + x, ascending. If the scene has sites, and neither a
// depth nor a stress that SA1 follows, they are the cells that the stencils of the sites read; otherwise they are all
// cells. The memory stays the same until the skin is destroyed.
DERMIS_API dermis_status dermis_skin_get_cells(dermis_skin* skin, const int32_t** cells, size_t* count);
// The same as dermis_skin_press, to the bit, with the pressures of these cells alone. numbers: as many as there are
// cells, times the pads pressed.
DERMIS_API dermis_status dermis_skin_press_cells(dermis_skin* skin, const float* pressure, size_t numbers, double dt,
                                                 const dermis_pads* pads);
// The response sa1, sa2, fa1 or fa2 at the end of each pad's last press, 0 before the first: pad by pad from 0 on,
// width*height floats, row 0 first, or, if the scene has sites, one per site of that class in the order given. count:
// the floats of all pads. Strain, indentation (m) and curvature (1/m) are computed from the state by this call, for
// every cell or every site. The memory stays the same until the skin is destroyed. DERMIS_BAD_INPUT for a response that
// the skin was made without.
DERMIS_API dermis_status dermis_skin_get_response(const dermis_skin* skin, dermis_quantity quantity,
                                                  const float** values, size_t* count);
// A spike of a press: an afferent of a pad fires at `share` of the step, 0 < share <= 1, that is (1 - share)*dt
// seconds before the step ends.
typedef struct dermis_spike {
    int32_t pad;
    int32_t afferent; // its number, in the order of the scene, from 0 on
    int32_t frame;    // of dermis_skin_press_frames, from 0 on; of one frame 0
    float share;
} dermis_spike;
// The spikes of the last call that pressed, by frame, then pad by pad in the order pressed, then by afferent, then by
// time. count: 0 where the scene has no afferents, and before the first press; *spikes may then be NULL. The memory is
// valid until the next call that presses, or until the skin is destroyed. With afferents a press whose step is longer
// than all before it may allocate, and a dt above 65536 times an afferent's refractory time or its shortest time
// constant is refused.
DERMIS_API dermis_status dermis_skin_get_spikes(const dermis_skin* skin, const dermis_spike** spikes, size_t* count);
DERMIS_API dermis_status dermis_skin_reset(dermis_skin* skin, const dermis_pads* pads); // back to skins at rest

// The state as bytes, the same on every device. A skin can load it into the same number of pads if it has the grid,
// sites, numbers of elements and springs, precision, hold, number of afferents and shear of the skin that saved it,
// and gives SA2 and FA2 where that skin did. bytes: what dermis_skin_get_state_size gives for this number of pads; for
// dermis_skin_load also the bytes of a state of the older version 2. dermis_skin_load refuses a number that is not
// finite, and a number of an afferent that no press makes.
DERMIS_API dermis_status dermis_skin_get_state_size(const dermis_skin* skin, size_t* bytes, const dermis_pads* pads);
DERMIS_API dermis_status dermis_skin_save(const dermis_skin* skin, void* state, size_t bytes, const dermis_pads* pads);
DERMIS_API dermis_status dermis_skin_load(dermis_skin* skin, const void* state, size_t bytes, const dermis_pads* pads);

// Gives pads the moduli and viscosities of a scene's material from the next press on. The scene must have the same
// number of elements, springs and dashpots as the skin, and no maps of them; everything else in it is ignored. Strains
// are kept. A list of pads is allowed only with materials. A skin with maps of the material refuses this call: make
// a new skin, and give it the state by dermis_skin_load.
DERMIS_API dermis_status dermis_skin_set_material(dermis_skin* skin, const dermis_scene* scene,
                                                  const dermis_pads* pads);

// pad: 0..count-1. The call takes up to as long as making the skin.
DERMIS_API dermis_status dermis_skin_get_report(const dermis_skin* skin, int32_t pad, dermis_report* report);
DERMIS_API void dermis_skin_destroy(dermis_skin* skin); // NULL: nothing happens

// ---- Contacts: forces, depths or taxels become the pressure on a pad's cells. contact.hpp says how, and has the
// frame: the origin is the outer corner of cell (0, 0), x runs along a row, y from row to row, and the centre of cell
// (x, y) is ((x + 0.5)*spacing, (y + 0.5)*spacing). Pressure is added to what the buffer holds: fill it with 0 before a
// frame. Lengths are at most 1e6 m, and a force on one cell at most 3.4e38 Pa. Functions that add allocate nothing.

// A grid of cells, and the caller's pressures: pressure[y*pitch + x] is the pressure of cell (x, y).
typedef struct dermis_contact_pad {
    size_t size;           // sizeof(dermis_contact_pad)
    int32_t width, height; // cells, 1..16384
    double spacing;        // m between cells, 1e-9..1e6
    float* pressure;       // Pa, finite
    size_t pitch;          // floats from row to row, width..2^40; 0: width
    int32_t tiled;         // 1: pads lie side by side and share patches: the part of a patch beyond the border then
                           // belongs to the neighbours, and counts in no member of this pad's report. Else 0, also for
                           // a program that gives a size without this member and the next ones
    double radius_x, radius_y; // m, of the surface along x and y at the pad's middle; 0: straight. At least
                               // width*spacing/(2*pi) and height*spacing/(2*pi), at most 1e6
    float *shear_x, *shear_y; // Pa, finite, laid out as the pressure: the tractions along x and y, to which contacts in
                              // the world add the part of their force along the surface. NULL: none
    int32_t keep; // 1: the body ends where the pad ends, as a flat finger does: the cells that a patch covers carry the
                  // part of it beyond the border too. 0 beside tiled
} dermis_contact_pad;

// What became of the forces. asked = placed + outside + sideways, up to rounding of less than 1e-6 of the force that
// the buffer then holds.
typedef struct dermis_contact_report {
    size_t size;         // sizeof(dermis_contact_report)
    double asked;        // N: sum of the forces given
    double placed;       // N: the part that presses cells, measured by what the buffer's floats gained
    double outside;      // N: the part that presses no cell: beside the pad, too far, turned away, or no depth > 0
    double greatest;     // Pa: greatest pressure of the cells that were pressed, with what they held before
    double level;        // m: of dermis_add_depths with a stiffness, else 0; see contact.hpp
    int32_t cells;       // cells that are pressed now and held 0 before
    int32_t below_cell;  // patches that press a single cell; its pressure is force/spacing^2, whatever the radius
    int32_t beside;      // contacts and taxels with a force that are wholly beside the pad
    int32_t plausible;   // 1 if below_cell is 0, greatest at most 1e6 Pa, at least 0.5 of asked is placed, at most 0.1
                         // of it is outside and 0.001 of it lost to rounding; else 0
    double sideways;     // N: of forces at an angle to the pad, the force less its component into the pad
    int32_t too_far;     // contacts in the world with a force farther from the pad's surface than reach
    int32_t turned_away; // contacts in the world whose force does not push into the pad
    double shear_x, shear_y; // N: of contacts in the world that press the pad, the sum of their forces along its x and
                             // y. A program that gives the size without these two and what follows gets the others
    // Of dermis_touch_add_shapes; contact.hpp says more:
    int32_t by_body;   // bodies that press by their shapes
    int32_t by_patch;  // contacts of a body that is below no cell: they press by their patch
    int32_t tilted;    // bodies whose centre of pressure cannot be their contacts'
    double centre_off; // m: the greatest distance between the two
    int32_t clipped;   // of dermis_touch_add_depths: images whose force wants to press cells that have no depth
} dermis_contact_report;
// Writes the sentences that say why a report is not plausible, or "". text: size bytes, 400 are enough for all.
DERMIS_API dermis_status dermis_contact_report_get_doubts(const dermis_contact_report* report, char* text, size_t size);

// A force on a round patch, with the pressure of an elastic contact after Hertz. Give a radius of two cells or more.
typedef struct dermis_contact {
    double x, y;   // m, -1e6..1e6
    double force;  // N, finite, >= 0, into the pad
    double radius; // m, 0..1e6
    double area;   // m^2, 0..1e12: pi*radius^2 in place of radius; one of them is 0
} dermis_contact;
// contacts: count of them, or NULL if count is 0. Pressures add up where patches overlap.
DERMIS_API dermis_status dermis_add_contacts(const dermis_contact_pad* pad, const dermis_contact* contacts,
                                             size_t count, dermis_contact_report* report);

// A pose says where a pad is: world = position + rotation*local. The pad's z points out of the skin.
typedef struct dermis_pose {
    double position[3]; // m, -1e6..1e6: the outer corner of cell (0, 0)
    double rotation[9]; // row-major, right to 1e-3; its columns are the pad's axes in the world
} dermis_pose;
// quaternion: w, x, y, z, of a length of 1e-150..1e150.
DERMIS_API dermis_status dermis_pose_from_quaternion(const double* position, const double* quaternion,
                                                     dermis_pose* pose);
// Moves a pose from the middle of the pad, where simulators have it, to the outer corner of cell (0, 0).
DERMIS_API dermis_status dermis_pose_from_middle(dermis_pose* pose, const dermis_contact_pad* pad);

// A contact in the world. Of a force at an angle to the surface only the component against its normal presses.
typedef struct dermis_world_contact {
    double position[3];  // m, -1e6..1e6
    double direction[3]; // -1e6..1e6: where the force pushes the pad; its length is ignored; 0: straight into the pad
    double force;        // N, finite, >= 0
    double radius, area; // as in dermis_contact
} dermis_world_contact;
// Projects each contact onto the pad's surface and adds it, if it is at most reach metres from the surface, on either
// side. reach: m, >= 0, below the pad's radii. contacts: count of them, or NULL if count is 0.
DERMIS_API dermis_status dermis_add_contacts_world(const dermis_contact_pad* pad, const dermis_pose* pose, double reach,
                                                   const dermis_world_contact* contacts, size_t count,
                                                   dermis_contact_report* report);

typedef int32_t dermis_body_kind;
enum {
    DERMIS_SPHERE = 0,
    DERMIS_CAPSULE = 1,
    DERMIS_BOX = 2,
    DERMIS_PLANE = 3,
    DERMIS_CYLINDER = 4,
    DERMIS_ELLIPSOID = 5,
    DERMIS_HULL = 6 // of dermis_shapes alone
};
// A rigid body in the world. sphere: extent[0] is its radius. capsule: a cylinder along z between two half balls;
// radius and half its length. box: half its length along x, y and z. plane: all below z = 0 of its frame. cylinder:
// along z; radius and half its length. ellipsoid: half its length along x, y and z.
typedef struct dermis_body {
    size_t size;           // sizeof(dermis_body)
    dermis_body_kind kind; // one of the first six above
    double extent[3];      // m, above 0, at most 1e6; numbers that a kind does not use are 0
    dermis_pose pose;      // of the body's middle; of a plane any point of it
} dermis_body;
// Writes to each cell how deep a body reaches below the pad's surface, along its normal there, m, as dermis_depths
// takes it. A gap is negative, and -1e6 where no part of the body is above or below the cell. depth: the caller's
// array, depth[y*pitch + x]. pitch: floats from row to row, width..2^40; 0: width. The pad's pressure is not touched.
DERMIS_API dermis_status dermis_fill_depths(const dermis_contact_pad* pad, const dermis_pose* pose,
                                            const dermis_body* body, float* depth, size_t pitch);

// How deep something sinks into each cell, and the force with which it does. A negative depth is a gap.
typedef struct dermis_depths {
    size_t size;        // sizeof(dermis_depths)
    const float* depth; // m, -1e6..1e6; depth[y*pitch + x] is the depth of cell (x, y)
    size_t pitch;       // floats from row to row, width..2^40; 0: width
    double force;       // N, finite, >= 0
    double stiffness;   // Pa per m, 1e-6..1e30, or 0: pressure is in proportion to depth
} dermis_depths;
DERMIS_API dermis_status dermis_add_depths(const dermis_contact_pad* pad, const dermis_depths* depths,
                                           dermis_contact_report* report);

typedef int32_t dermis_taxel_unit;
enum { DERMIS_NEWTON = 0, DERMIS_PASCAL = 1 };
// The readings of a sensor array: rectangles side by side, each under an even pressure.
typedef struct dermis_taxels {
    size_t size;            // sizeof(dermis_taxels)
    const float* values;    // finite, >= 0; column i of row j is values[i*column_step + j*row_step]
    dermis_taxel_unit unit; // of the values
    int32_t columns, rows;  // 1..16384; columns follow each other along x, rows along y
    double width, height;   // m, of one taxel along x and y, 1e-9..1e6
    double x, y;            // m, outer corner of the first taxel, -1e6..1e6
    size_t column_step;     // floats; 0: 1
    size_t row_step;        // floats; 0: columns
} dermis_taxels;
DERMIS_API dermis_status dermis_add_taxels(const dermis_contact_pad* pad, const dermis_taxels* taxels,
                                           dermis_contact_report* report);

// ---- The contacts of a whole batch of pads in one call, from arrays that are read in place. touch.hpp says more.

typedef struct dermis_touch dermis_touch;

// shape: of each pad; its pressure, shear_x and shear_y are NULL and its pitch 0, because a touch has memory of its
// own. count: pads, 1..1048576. reach: m, >= 0, below the pads' radii. shear: 1: tractions are kept too, else 0.
DERMIS_API dermis_status dermis_touch_create(const dermis_contact_pad* shape, int32_t count, double reach,
                                             int32_t shear, dermis_touch** touch);
// The same for bodies with shapes, which press as on an elastic foundation; touch.hpp says more. stiffness: Pa/m,
// 1e-6..1e30. around: NULL, or four numbers, m: the finger's surface beyond the pad's borders x = 0, x = width, y = 0
// and y = height; below 0: so much less.
DERMIS_API dermis_status dermis_touch_create_on(const dermis_contact_pad* shape, int32_t count, double reach,
                                                int32_t shear, double stiffness, const double* around,
                                                dermis_touch** touch);
// Where pads are: the numbers of pad i begin i*step doubles behind the first ones.
typedef struct dermis_poses {
    const double* position; // m, -1e6..1e6: three numbers, the middle of the pad
    const double* rotation; // nine numbers, row-major, right to 1e-3; columns are the pad's axes in the world
    size_t position_step, rotation_step; // usually 3 and 9
} dermis_poses;
// Forces on pads: the numbers of contact i begin i*step behind the first ones; with a step of 0 one number holds for
// all contacts.
typedef struct dermis_contacts {
    size_t size;            // sizeof(dermis_contacts)
    size_t count;           // the other members are ignored where it is 0
    const int32_t* pad;     // which pad the force presses, in any order
    const double* position; // m, in the world, -1e6..1e6: three numbers
    const double* force;    // N, in the world, -1e12..1e12: three numbers, the force on the pad; 0 is no contact
    const double* radius;   // m, of the patch, 0..1e6. NULL: Hertz's, by ball and modulus, if above two cells; else two
    const double* ball;     // m, > 0: 1/(1/R1 + 1/R2) of radii R1 and R2. NULL beside radius
    double modulus;         // Pa, > 0; 0 beside radius
    size_t pad_step, position_step, force_step, radius_step, ball_step; // usually 1, 3, 3, 1, 1
    const int32_t* body;  // of dermis_touch_add_shapes: the body of each contact, 0 or more, or -1. NULL: all -1
    size_t body_step;     // usually 1
    const double* torque; // N m, in the world, -1e12..1e12: three numbers, the moment on the pad about the contact's
                          // place. NULL: none. Shapes press with it; patches do not
    size_t torque_step;   // usually 3
} dermis_contacts;
// Takes away what the last call added, and adds contacts. poses: NULL is allowed if there is no contact. report: of all
// pads: sums, and the greatest pressure.
DERMIS_API dermis_status dermis_touch_add(dermis_touch* touch, const dermis_poses* poses,
                                          const dermis_contacts* contacts, dermis_contact_report* report);
// What bodies look like, in the world: many shapes of one number are one rigid body. The numbers of shape i begin
// i*step behind the first ones.
typedef struct dermis_shapes {
    size_t size;                  // sizeof(dermis_shapes)
    size_t count;                 // the other members are ignored where it is 0
    const int32_t *pad, *body;    // the pad below which the shape is, and its body, 0 or more
    const dermis_body_kind* kind; // of each shape
    const double* extent;         // m, three numbers, as in dermis_body; of a hull how many faces it has, its first one
                                  // among faces, and 0
    const double *position, *rotation; // three and nine numbers, as of poses: the shape's frame
    const double* faces; // of all hulls, four numbers for each: an outward normal n of length 1, and the offset m up to
                         // which n*place is inside, m; in the hull's frame. NULL where there is no hull
    size_t face_count;   // 0..16777216
    size_t pad_step, body_step, kind_step, extent_step, position_step, rotation_step; // usually 1, 1, 1, 3, 3, 9
} dermis_shapes;
// As dermis_touch_add, and the bodies that contacts name press by their shapes.
DERMIS_API dermis_status dermis_touch_add_shapes(dermis_touch* touch, const dermis_poses* poses,
                                                 const dermis_contacts* contacts, const dermis_shapes* shapes,
                                                 dermis_contact_report* report);
// The same of depth images, one for each pad: depth: m, count*height*width floats; force: N, three numbers for each
// pad, the force on it in its own frame, of which -z presses. gaps: 1: a depth below 0 is a gap; 0: images stop at 0.
DERMIS_API dermis_status dermis_touch_add_depths(dermis_touch* touch, const float* depth, const double* force,
                                                 int32_t gaps, dermis_contact_report* report);
// The report of one pad of the last call. pad: 0..count-1.
DERMIS_API dermis_status dermis_touch_get_report(const dermis_touch* touch, int32_t pad, dermis_contact_report* report);
// Pa: width*height pressures of each pad, row 0 first; numbers: how many. traction may be NULL; it becomes as many
// tractions along x and then along y, or NULL without shear. The memory stays the same.
DERMIS_API dermis_status dermis_touch_get_pressure(const dermis_touch* touch, const float** pressure,
                                                   const float** traction, size_t* numbers);
// Presses all pads of a skin with the pressures of a touch, in no time for a pad that is at rest and not touched. The
// touch has as many pads, of as many cells, and of the same spacing if the scene gives one in metres.
DERMIS_API dermis_status dermis_skin_press_touch(dermis_skin* skin, const dermis_touch* touch, double dt);
DERMIS_API void dermis_touch_destroy(dermis_touch* touch); // NULL: nothing happens

// Old names, until 1.0: a compiler warns of them and names the new ones.
#define DERMIS_OLD(name) __attribute__((deprecated("use " name))) static inline dermis_status
DERMIS_OLD("dermis_pose_from_middle")
dermis_pose_move_from_middle(dermis_pose* pose, const dermis_contact_pad* pad) {
    return dermis_pose_from_middle(pose, pad);
}
DERMIS_OLD("dermis_add_contacts_world")
dermis_add_world_contacts(const dermis_contact_pad* pad, const dermis_pose* pose, double reach,
                          const dermis_world_contact* contacts, size_t count, dermis_contact_report* report) {
    return dermis_add_contacts_world(pad, pose, reach, contacts, count, report);
}
DERMIS_OLD("dermis_skin_press_tractions")
dermis_skin_press_shear(dermis_skin* skin, const float* pressure, const float* traction, size_t cells, double dt,
                        const dermis_pads* pads) {
    return dermis_skin_press_tractions(skin, pressure, traction, cells, dt, pads);
}
#undef DERMIS_OLD

#ifdef __cplusplus
}
#endif
