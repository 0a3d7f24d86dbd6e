// SPDX-License-Identifier: MIT
// Sum, minimum and maximum over a tile of TILE_CELLS columns of one row, by a fixed tree: cell i joins cell i + reach,
// reach = 32, 16 .. 1; cells beyond the row's end add 0. The tiles of a map, row by row, are joined 64 at a time by the
// same tree, as sums in two parts, and so are their joins, until one is left. The bits therefore do not depend on
// workgroups, row windows or threads, and a constant map sums without error.
struct Summary {
    real sum, low, high;
};

inline Summary summary_of(real x) {
    Summary s;
    s.sum = x;
    s.low = x;
    s.high = x;
    return s;
}

inline Summary join(Summary a, Summary b) {
    precise real sum = a.sum + b.sum;
    Summary s;
    s.sum = sum;
    s.low = mix(a.low, b.low, lessThan(b.low, a.low));
    s.high = mix(a.high, b.high, lessThan(a.high, b.high));
    return s;
}

// A sum in two parts: the second holds what rounding took from the first (Knuth's two-sum).
struct LongSum {
    real sum, rest;
};

// The sum of a tile divided by 2^28, so that the sum of any grid's tiles stays in range. The division is exact: what is
// stored is 0 or at least 2^-64.
inline LongSum long_sum(real of_tile) {
    LongSum s;
    precise real sum = of_tile * real(1.0 / 268435456.0);
    s.sum = sum;
    s.rest = real(0.0);
    return s;
}

inline LongSum joined(LongSum a, LongSum b) {
    precise real sum = a.sum + b.sum;
    precise real of_b = sum - a.sum;
    precise real of_a = sum - of_b;
    precise real lost = (a.sum - of_a) + (b.sum - of_b);
    precise real rest = (a.rest + b.rest) + lost;
    LongSum s;
    s.sum = sum;
    s.rest = rest;
    return s;
}
