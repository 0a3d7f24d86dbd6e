// SPDX-License-Identifier: MIT
// Mean, minimum and maximum of a map from the summaries of its tiles, by the tree of kernels/reduce.h.
#pragma once

#include "host/core/simd/isa.hpp"

#include <algorithm>
#include <array>

namespace dermis::model {

struct Totals {
    double mean, min, max;
};

// Joins sums, each of up to 64 tiles, in the order in which they are added: 64 at a time, then 64 of the results, and
// so on.
template <class K> class JoinedSums {
  public:
    void add(typename K::LongSum s) {
        for (Level& of : levels_) {
            of.add(s);
            if (of.count < tree) return;
            s = of.joined();
        }
    }

    // The sum of all that were added.
    typename K::LongSum total() {
        size_t last = levels_.size() - 1; // the last level with a sum
        while (last > 0 && levels_[last].count == 0) --last;
        typename K::LongSum s{0, 0};
        for (size_t level = 0; level <= last; ++level) {
            if (level > 0) levels_[level].add(s);
            s = levels_[level].joined();
        }
        return s;
    }

  private:
    static constexpr size_t tree = simd::tiles_joined;
    struct Level {
        typename K::real sum[tree], rest[tree];
        size_t count = 0;

        void add(typename K::LongSum s) {
            sum[count] = s.sum;
            rest[count] = s.rest;
            ++count;
        }
        // Joins the sums and leaves none.
        typename K::LongSum joined() {
            if (count == 1) return count = 0, typename K::LongSum{sum[0], rest[0]};
            std::fill(sum + count, sum + tree, typename K::real(0));
            std::fill(rest + count, rest + tree, typename K::real(0));
            count = 0;
            for (size_t reach = tree / 2; reach > 0; reach /= 2)
                for (size_t i = 0; i < reach; ++i) {
                    const typename K::LongSum s = K::joined({sum[i], rest[i]}, {sum[i + reach], rest[i + reach]});
                    sum[i] = s.sum;
                    rest[i] = s.rest;
                }
            return {sum[0], rest[0]};
        }
    };

    std::array<Level, 4> levels_; // 64^5 is more than the tiles of any grid
};

template <class K>
Totals total_of(const typename K::Summary* tiles, size_t count, size_t cells, const simd::Isa& isa = simd::best()) {
    const simd::Loops<K>& loops = isa.template of<K>();
    JoinedSums<K> sums;
    typename K::real low = tiles[0].low, high = tiles[0].high;
    for (size_t i = 0; i < count; i += simd::tiles_joined) {
        simd::JoinedTiles<K> joined;
        loops.join_tiles(tiles + i, int(std::min(count - i, size_t(simd::tiles_joined))), joined);
        sums.add(joined.sum);
        low = joined.low < low ? joined.low : low;
        high = high < joined.high ? joined.high : high;
    }
    const typename K::LongSum total = sums.total();
    return {(double(total.sum) + double(total.rest)) / double(cells) * 0x1p28, double(low), double(high)};
}

} // namespace dermis::model
