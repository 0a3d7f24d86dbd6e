// SPDX-License-Identifier: MIT
#include "tests/oracle/scene_files.hpp"

#include "host/lab/run/maps.hpp"

#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace oracle {

using namespace dermis;

namespace {

std::string text(double v) {
    char digits[40];
    std::snprintf(digits, sizeof digits, "%.17g", v);
    const std::string s = digits;
    return s.find_first_of(".en") == std::string::npos ? s + ".0" : s;
}

std::string text(Cell c) { return "[" + std::to_string(c.x) + ", " + std::to_string(c.y) + "]"; }
std::string text(Quantity q) { return std::string("\"") + name(q) + "\""; }

std::string text(const FieldRequest&);

template <class Values> std::string list_of(const Values& values) {
    std::string all;
    for (const auto& v : values) all += (all.empty() ? "" : ", ") + text(v);
    return "[" + all + "]";
}

std::string text(const FieldRequest& f) { return "{ at = " + text(f.at) + ", what = " + list_of(f.what) + " }"; }

std::string shape_of(const Grid& grid) { return std::to_string(grid.height) + ", " + std::to_string(grid.width); }

void write_npy(const std::filesystem::path& path, const std::string& shape,
               const std::vector<std::vector<double>>& maps) {
    std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + shape + "), }";
    header.resize(118, ' ');
    header.back() = '\n';
    std::ofstream out(path, std::ios::binary);
    out << std::string("\x93NUMPY\x01\x00\x76\x00", 10) << header;
    for (const std::vector<double>& map : maps)
        out.write(reinterpret_cast<const char*>(map.data()), std::streamsize(map.size() * sizeof(double)));
    if (!out) throw std::runtime_error(path.string() + ": cannot be written");
}

// The keys of one scene, table by table.
class Writer {
  public:
    Writer(const Case& c, const std::filesystem::path& folder) : case_(c), s_(c.scene), folder_(folder) {}

    std::string keys() {
        if (s_.tolerance) key("tolerance", *s_.tolerance);
        if (s_.method != Method::exact) word("method", name(s_.method));
        if (s_.allow_unstable) out_ << "allow_unstable = true\n";
        if (s_.model) word("model", name(*s_.model));
        if (s_.precision) word("precision", name(*s_.precision));
        out_ << "[grid]\nwidth = " << s_.grid.width << "\nheight = " << s_.grid.height << "\n";
        if (s_.grid.spacing) key("spacing", *s_.grid.spacing);
        out_ << "[surface]\nkind = \"file\"\n";
        map("path", s_.surface.map, "surface.npy");
        if (s_.surface.relief) key("relief", *s_.surface.relief);
        material();
        load();
        out_ << "[time]\n";
        key("step", s_.time.step);
        key("duration", s_.time.duration);
        curvature();
        receptors();
        if (!s_.sites.empty()) sites();
        out_ << "[output]\ntraces = " << list_of(s_.output.traces) << "\n";
        if (!s_.output.probes.empty()) out_ << "probes = " << list_of(s_.output.probes) << "\n";
        if (!s_.output.fields.empty()) out_ << "fields = " << list_of(s_.output.fields) << "\n";
        if (!s_.output.extremes) out_ << "extremes = false\n";
        return out_.str();
    }

  private:
    void key(const char* name, double value) { out_ << name << " = " << text(value) << "\n"; }
    void word(const char* name, const char* value) { out_ << name << " = \"" << value << "\"\n"; }

    // The value of a key: a number, or the name of a map's file.
    std::string value(double number, const Map& map, const std::string& file) {
        if (map.empty()) return text(number);
        write_map(map, file);
        return "\"" + file + "\"";
    }
    void map(const char* name, const Map& map, const char* file) {
        out_ << name << " = " << value(0, map, file) << "\n";
    }
    void write_map(const Map& map, const std::string& file) {
        write_npy(folder_ / file, shape_of(s_.grid), {map.values()});
    }

    void material() {
        const Material& m = s_.material;
        out_ << "[material]\n";
        std::string elements;
        for (size_t i = 0; i < m.elements.size(); ++i) {
            const KelvinVoigt& e = m.elements[i];
            const std::string number = std::to_string(i) + ".npy";
            elements += (i ? ", " : "") + ("{ modulus = " + value(e.modulus, e.modulus_map, "modulus" + number)) +
                        ", viscosity = " + value(e.viscosity, e.viscosity_map, "viscosity" + number) + " }";
        }
        if (!elements.empty()) out_ << "elements = [" << elements << "]\n";
        if (m.spring) key("spring", *m.spring);
        if (m.dashpot) key("dashpot", *m.dashpot);
        if (m.modulus) out_ << "modulus = " << value(*m.modulus, m.modulus_map, "modulus.npy") << "\n";
        if (m.viscosity) out_ << "viscosity = " << value(*m.viscosity, m.viscosity_map, "viscosity.npy") << "\n";
        if (m.thickness) key("thickness", *m.thickness);
        if (m.curvature_length) key("curvature_length", *m.curvature_length);
    }

    void load() {
        out_ << (s_.more_loads.empty() ? "[load]\n" : "[[load]]\n");
        const bool framed = s_.load.kind == Load::Kind::sequence;
        word("kind", framed ? "sequence" : "file");
        key("intensity", s_.load.intensity);
        if (s_.load.control == Control::depth) word("control", "depth");
        if (framed) {
            word("path", "frames.npy");
            key("interval", *s_.load.interval);
            if (s_.load.hold == Hold::parabolic) word("hold", "parabolic");
            write_frames(folder_ / "frames.npy", s_.grid, case_.frames);
            return;
        }
        map("path", s_.load.map, "load.npy");
        envelope(s_.load.envelope);
        for (size_t i = 0; i < s_.more_loads.size(); ++i) {
            word("[[load]]\nkind", "file");
            key("intensity", s_.more_loads[i].intensity);
            map("path", s_.more_loads[i].map, ("load" + std::to_string(i + 1) + ".npy").c_str());
            envelope(s_.more_loads[i].envelope);
        }
    }

    void envelope(const Envelope& e) {
        if (const auto& w = e.window)
            out_ << "window = { start = " << text(w->start) << ", rise = " << text(w->rise)
                 << (w->until ? ", until = " + text(*w->until) : "") << ", fall = " << text(w->fall) << " }\n";
        static const char* const kinds[] = {"step", "ramp", "sine", "pulse", "table"};
        word("envelope", kinds[int(e.kind)]);
        switch (e.kind) {
        case Envelope::Kind::step: key("start", e.start); break;
        case Envelope::Kind::ramp:
            key("start", e.start);
            key("rise", e.rise);
            break;
        case Envelope::Kind::sine:
            key("frequency", e.frequency);
            key("phase", e.phase);
            key("mean", e.mean);
            key("amplitude", e.amplitude);
            break;
        case Envelope::Kind::pulse:
            key("start", e.start);
            key("length", e.length);
            key("period", e.period);
            break;
        case Envelope::Kind::table:
            out_ << "times = " << list_of(e.times) << "\nvalues = " << list_of(e.values) << "\n";
        }
    }

    void curvature() {
        static const char* const stencils[] = {"five-point", "fourth-order", "published"};
        static const char* const edges[] = {"mirror", "periodic", "published"};
        if (!s_.stencil && !s_.edges) return;
        out_ << "[curvature]\n";
        if (s_.stencil) word("stencil", stencils[int(*s_.stencil)]);
        if (s_.edges) word("edges", edges[int(*s_.edges)]);
    }

    void receptors() {
        const Receptors& r = s_.receptors;
        out_ << "[receptors]\nfa2_gains = " << list_of(r.fa2_gains) << "\n";
        if (r.fa2) word("fa2", *r.fa2 == Fa2::point ? "point" : "step-mean");
        if (r.sa2_adaptation) key("sa2_adaptation", *r.sa2_adaptation);
        if (r.kernel == Receptors::Kernel::strain) word("kernel", "strain");
        if (r.poisson) key("poisson", *r.poisson);
        out_ << "[receptors.depth]\n";
        const Depths& d = r.depth;
        for (const auto& [of, depth] : {std::pair{"sa1", d.sa1}, {"sa2", d.sa2}, {"fa1", d.fa1}, {"fa2", d.fa2}})
            if (depth) key(of, *depth);
    }

    void sites() {
        out_ << "[sites]\npath = \"sites.csv\"\n";
        std::ofstream list(folder_ / "sites.csv");
        list << "type,x,y\n";
        for (const Site& site : s_.sites) list << name(site.type) << "," << site.cell.x << "," << site.cell.y << "\n";
    }

    const Case& case_;
    const Scene& s_;
    const std::filesystem::path folder_;
    std::ostringstream out_;
};

// The frames that write_frames has written.
std::vector<std::vector<double>> read_frames(const std::string& path, const Grid& grid) {
    std::ifstream in(path, std::ios::binary);
    unsigned char begin[10] = {}; // the header's length stands in the last two
    in.read(reinterpret_cast<char*>(begin), sizeof begin);
    const size_t header = sizeof begin + begin[8] + 256u * begin[9];
    in.seekg(0, std::ios::end);
    const size_t cells = size_t(grid.width) * size_t(grid.height), frame = cells * sizeof(double);
    std::vector<std::vector<double>> frames((size_t(in.tellg()) - header) / frame, std::vector<double>(cells));
    in.seekg(std::streamoff(header));
    for (std::vector<double>& f : frames) in.read(reinterpret_cast<char*>(f.data()), std::streamsize(frame));
    if (!in) throw std::runtime_error(path + ": not frames of double");
    return frames;
}

} // namespace

void write_frames(const std::filesystem::path& path, const Grid& grid, const std::vector<std::vector<double>>& frames) {
    write_npy(path, std::to_string(frames.size()) + ", " + shape_of(grid), frames);
}

void write_case(const Case& c, const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    const std::string keys = Writer(c, folder).keys();
    std::ofstream(folder / "scene.toml") << keys;
}

Case with_maps(Scene s) {
    const bool sequence = s.load.kind == Load::Kind::sequence;
    const SceneMaps m = maps(s);
    s.surface = {.kind = Surface::Kind::map,
                 .ridges = {},
                 .noise = {},
                 .noise_length = {},
                 .relief = s.grid.spacing ? std::optional<double>(1) : std::nullopt,
                 .map = m.surface,
                 .ridge_period = {}};
    if (sequence) return {s, read_frames(s.load.path, s.grid)};
    s.load.kind = Load::Kind::map;
    s.load.center.reset();
    s.load.radius.reset();
    s.load.intensity = 1;
    s.load.map = m.pressure;
    return {s, {}};
}

Case read_case(const std::filesystem::path& scene) {
    const Scene s = Scene::from_file(scene.string());
    const bool sequence = s.load.kind == Load::Kind::sequence;
    if (s.surface.kind != Surface::Kind::map || (!sequence && s.load.kind != Load::Kind::map)) return with_maps(s);
    return {s, sequence ? read_frames(s.load.path, s.grid) : std::vector<std::vector<double>>()};
}

} // namespace oracle
