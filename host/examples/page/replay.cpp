// SPDX-License-Identifier: MIT
// dermis-replay FILE: presses natively what a recording of the page has, and prints its hash.
#include "host/examples/page/session.hpp"

#include <cstdio>
#include <fstream>
#include <iostream>
#include <stdexcept>

namespace {

// The first line of a recording: # dermis page, ridge_period_m=..., modulus_pa=..., shape=..., radius_m=...,
// one_element=...
dermis::web::Settings settings_of(const std::string& line) {
    dermis::web::Settings s;
    int shape = 0, one_element = 0;
    if (std::sscanf(line.c_str(),
                    "# dermis page, ridge_period_m=%lf, modulus_pa=%lf, shape=%d, radius_m=%lf, one_element=%d",
                    &s.ridge_period, &s.modulus, &shape, &s.radius, &one_element) != 5 ||
        shape < 0 || shape > 2)
        throw std::invalid_argument("the first line is \"" + line + "\"; allowed: a recording of the page");
    s.shape = dermis::web::Shape(shape);
    s.one_element = one_element != 0;
    return s;
}

int replay(const char* path) {
    std::ifstream file(path);
    if (!file) throw std::invalid_argument(std::string(path) + " cannot be read");
    std::string line;
    std::getline(file, line);
    dermis::web::Session session(settings_of(line));
    std::getline(file, line); // names of the columns
    while (std::getline(file, line)) {
        double time, x, y, force;
        if (std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,", &time, &x, &y, &force) != 4)
            throw std::invalid_argument("line " + std::to_string(session.steps() + 3) + " is \"" + line +
                                        "\"; allowed: time, x, y, force and more");
        session.step(x, y, force);
    }
    std::printf("%d steps, %zu spikes, hash %016llx\n", session.steps(), session.all_spikes(),
                static_cast<unsigned long long>(session.hash()));
    return 0;
}

} // namespace

int main(int argc, char** argv) try {
    if (argc != 2) throw std::invalid_argument("dermis-replay needs one file: a recording of the page");
    return replay(argv[1]);
} catch (const std::exception& e) {
    std::cerr << "dermis-replay: " << e.what() << "\n";
    return 2;
}
