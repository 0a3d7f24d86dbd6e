// SPDX-License-Identifier: MIT
#include "host/lab/output/leftover.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <iterator>
#include <unistd.h>

namespace dermis::output {
namespace {

// A handler may run at any instruction and in any thread, so it takes no lock. It stores its signal and then tries to
// set `held`. If it can, nobody changes the list any more; if not, whoever has set `held` sees the signal afterwards.
std::atomic_flag held;
std::atomic<int> arrived = 0;
Leftover* newest = nullptr; // changes while signals are held

} // namespace

// Calls only functions that are safe in a handler.
void remove_leftovers() noexcept {
    for (const Leftover* l = newest; l; l = l->older_)
        if (::unlink(l->path_.c_str()) != 0) ::rmdir(l->path_.c_str());
}

namespace {

// `held` stays set: no leftover is made or renamed until the process has ended.
void end_by(int signal) {
    remove_leftovers();
    struct sigaction otherwise = {};
    otherwise.sa_handler = SIG_DFL;
    ::sigaction(signal, &otherwise, nullptr);
    ::kill(::getpid(), signal); // arrives at the end of the handler, if this is one
}

extern "C" void dermis_on_signal(int signal) {
    const int error = errno; // of the code that the signal interrupts
    arrived = signal;
    if (!held.test_and_set()) end_by(signal);
    errno = error;
}

} // namespace

HeldSignals::HeldSignals() {
    while (held.test_and_set()) // a handler in another thread has it until the process ends
        ::usleep(1000);
}

HeldSignals::~HeldSignals() {
    held.clear();
    if (const int signal = arrived; signal && !held.test_and_set()) end_by(signal);
}

Leftover::Leftover(std::string path, const HeldSignals&) : path_(std::move(path)), older_(newest) { newest = this; }

Leftover::~Leftover() {
    const HeldSignals signals;
    if (::unlink(path_.c_str()) != 0) ::rmdir(path_.c_str()); // or it has been renamed, or has files
    Leftover** link = &newest;
    while (*link != this) link = &(*link)->older_;
    *link = older_;
}

void remove_leftovers_on_signals() {
    const int none_ended[] = {SIGKILL, SIGSTOP, SIGCHLD, SIGCONT, SIGURG, SIGWINCH, SIGTSTP, SIGTTIN, SIGTTOU};
    const int faults[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGSYS, SIGABRT};
    const auto is_in = [](const auto& list, int signal) {
        return std::find(std::begin(list), std::end(list), signal) != std::end(list);
    };
    for (int signal = 1; signal <= SIGRTMAX; ++signal) {
        struct sigaction action = {};
        if (is_in(none_ended, signal) || ::sigaction(signal, nullptr, &action) != 0) continue;
        if ((action.sa_flags & SA_SIGINFO) || action.sa_handler != SIG_DFL) continue;
        action.sa_handler = dermis_on_signal;
        // A fault comes again when the handler returns, and ends the process then even where signals are held.
        action.sa_flags = SA_RESTART | (is_in(faults, signal) ? SA_RESETHAND : 0);
        ::sigaction(signal, &action, nullptr);
    }
}

} // namespace dermis::output
