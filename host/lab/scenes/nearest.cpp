// SPDX-License-Identifier: MIT
#include "host/lab/scenes/units.hpp"

#include <algorithm>
#include <cctype>

namespace dermis::scene {
namespace {

// Returns the optimal string alignment distance, without regard to case.
size_t edits(const std::string& a, const std::string& b) {
    const auto same = [](char x, char y) {
        return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
    };
    std::vector<size_t> before_last, last(b.size() + 1), now(b.size() + 1); // distances of three prefixes of a
    for (size_t j = 0; j <= b.size(); ++j) last[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        now[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + !same(a[i - 1], b[j - 1])});
            if (i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1]))
                now[j] = std::min(now[j], before_last[j - 2] + 1);
        }
        before_last = last;
        std::swap(last, now);
    }
    return last[b.size()];
}

} // namespace

std::string nearest(const std::string& word, const std::vector<std::string>& known) {
    std::string best;
    size_t least = std::max<size_t>(1, word.size() / 3) + 1;
    for (const std::string& candidate : known) {
        const size_t longer = std::max(word.size(), candidate.size()),
                     shorter = std::min(word.size(), candidate.size());
        if (longer - shorter >= least || shorter < 2) continue; // further away than the best by length alone
        const size_t distance = edits(word, candidate);
        if (distance < least) least = distance, best = candidate;
    }
    return best;
}

std::string suggestion(const std::string& word, const std::vector<std::string>& known) {
    const std::string meant = nearest(word, known);
    return meant.empty() ? "" : "; did you mean " + meant + "?";
}

} // namespace dermis::scene
