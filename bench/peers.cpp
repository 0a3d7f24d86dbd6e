// SPDX-License-Identifier: MIT
#include "bench/peers.hpp"

#include <csignal>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>

namespace bench {

Peers::Peers(const std::string& command) {
    if (command.empty()) return;
    int down[2], up[2];
    if (pipe(down) != 0 || pipe(up) != 0) throw std::runtime_error("the peers: no pipe");
    std::signal(SIGPIPE, SIG_IGN); // a peer that has ended is an error of reading
    process_ = fork();
    if (process_ == 0) {
        dup2(down[0], STDIN_FILENO);
        dup2(up[1], STDOUT_FILENO);
        for (int end : {down[0], down[1], up[0], up[1]}) close(end);
        execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
        _exit(127);
    }
    close(down[0]);
    close(up[1]);
    to_ = fdopen(down[1], "w");
    from_ = fdopen(up[0], "r");
}

Peers::~Peers() {
    if (!process_) return;
    std::fclose(to_); // the process ends where there are no more questions
    std::fclose(from_);
    waitpid(process_, nullptr, 0);
}

void Peers::tell(const std::string& line) {
    std::fputs((line + "\n").c_str(), to_);
    std::fflush(to_);
}

std::string Peers::answer() {
    char line[512];
    if (!std::fgets(line, sizeof line, from_))
        throw std::runtime_error("the peers have ended; their message stands above");
    return line;
}

std::vector<Peers::Peer> Peers::prepare(const std::string& work) {
    std::vector<Peer> peers;
    if (!process_) return peers;
    tell("prepare " + work);
    for (;;) {
        std::istringstream words(answer());
        std::string word;
        words >> word;
        if (word == "ready") return peers;
        Peer& peer = peers.emplace_back();
        words >> peer.name;
        if (word != "peer") continue; // is missing
        words >> peer.method >> peer.version >> peer.threads >> peer.steps;
        for (double error; words >> error;) peer.errors.push_back(error);
    }
}

double Peers::seconds(const Peer& peer, int count) {
    tell(fmt::format("run {} {} {}", peer.name, peer.method, count));
    return std::strtod(answer().c_str(), nullptr);
}

} // namespace bench
