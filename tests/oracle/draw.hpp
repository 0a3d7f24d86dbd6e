// SPDX-License-Identifier: MIT
// Random numbers that are the same for the same seed everywhere: made of the bits of the generator alone.
#pragma once

#include <cmath>
#include <random>

namespace oracle {

class Draw {
  public:
    explicit Draw(unsigned seed) : random_(seed) {}

  protected:
    int below(int n) { return int(random_() % unsigned(n)); }
    bool one_in(int n) { return below(n) == 0; }
    double real(double low, double high) { return low + (high - low) * (random_() * 0x1p-32); }
    double decades(double low, double high) { return std::pow(10, real(low, high)); }

    std::mt19937 random_;
};

} // namespace oracle
