// SPDX-License-Identifier: MIT
// Sum, minimum and maximum over a tile of TILE_CELLS columns of one row, by a fixed tree: cell i joins cell i + reach,
// reach = 32, 16 .. 1; cells beyond the row's end add 0. The host joins tiles in double, in order. The bits therefore do
// not depend on workgroups, row windows or threads, and a constant map sums without error.
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
