// SPDX-License-Identifier: MIT
// The data of `dermis fit`: a byte of options, then a CSV file.
#include "host/lab/scenes/curve_file.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dermis;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (!size) return 0;
    scene::CurveOptions options;
    if (data[0] & 1) options.kind = data[0] & 2 ? "creep" : "relaxation";
    if (data[0] & 4) options.stress = 2.0;
    if (data[0] & 8) options.residual = "absolute";
    if (data[0] & 16) options.strain = 0.1;
    scene::Curves curves;
    if (!fuzz::taken([&] { curves = scene::read_curves({fuzz::file_of(data + 1, size - 1)}, options); })) return 0;
    const scene::Curve& curve = curves.list.at(0);
    fuzz::need(!curve.times.empty() && curve.times.size() == curve.values.size(), "a curve without points");
    fuzz::need(curve.strains.size() == curve.times.size(), "another number of strains");
    return 0;
}
