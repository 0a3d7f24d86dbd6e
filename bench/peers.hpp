// SPDX-License-Identifier: MIT
// The peers in Python, bench/peers.py, in a process of their own. It is asked for each measurement, so that its peers
// run in the same rounds as everything else.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include <sys/types.h>

namespace bench {

class Peers {
  public:
    // Starts a command by the shell. If it is empty, there are no peers.
    explicit Peers(const std::string& command);
    ~Peers();
    Peers(const Peers&) = delete;
    Peers& operator=(const Peers&) = delete;

    struct Peer {
        std::string name, method, version; // without a method: not installed
        int threads = 0;
        long long steps = 0;
        std::vector<double> errors; // by the greatest value, from a run before anything is timed
    };
    // Makes those peers ready that do this work, such as "frames 512"; those from before are gone.
    std::vector<Peer> prepare(const std::string& work);
    // Lets a peer that is ready do its work `count` times. Returns its seconds.
    double seconds(const Peer&, int count);

  private:
    void tell(const std::string& line);
    std::string answer();

    FILE *to_ = nullptr, *from_ = nullptr;
    pid_t process_ = 0;
};

} // namespace bench
