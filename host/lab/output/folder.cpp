// SPDX-License-Identifier: MIT
#include "host/lab/output/folder.hpp"

#include "dermis/dermis.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#ifndef O_BINARY
#define O_BINARY 0 // only Windows has files that are text
#endif

namespace dermis::output {
namespace {

[[noreturn]] void failed(const Path& path, const char* what) {
    throw Error(
        Error::Code::io, "",
        fmt::format("{}: cannot be {} ({})", path.empty() ? "\"\"" : path.string(), what, std::strerror(errno)));
}

// A handler may run at any instruction and in any thread, so it takes no lock. It stores its signal and then tries to
// set `held`. If it can, nobody changes the list any more; if not, whoever has set `held` sees the signal afterwards.
std::atomic_flag held;
std::atomic<int> arrived = 0;
Leftover* newest = nullptr; // changes while signals are held

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

constexpr std::string_view before_number = ".dermis-", after_number = ".part";

// Returns whether all of it could be written.
bool write(int file, const std::string& content) {
    for (size_t done = 0; done < content.size();) {
        const ssize_t n = ::write(file, content.data() + done, content.size() - done);
        if (n < 0 && errno != EINTR) return false;
        if (n > 0) done += size_t(n);
    }
    return true;
}

bool is_part(const std::string& name) {
    const size_t at = name.rfind(before_number);
    if (at == name.npos || !name.ends_with(after_number)) return false;
    const size_t first = at + before_number.size(), last = name.size() - after_number.size();
    return first < last && name.find_first_not_of("0123456789", first) == last;
}

} // namespace

// Calls only functions that are safe in a handler.
void remove_leftovers() noexcept {
    for (const Leftover* l = newest; l; l = l->older_)
        if (::unlink(l->path_.c_str()) != 0) ::rmdir(l->path_.c_str());
}

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
    for (int signal = 1; signal < NSIG; ++signal) {
        struct sigaction action = {};
        if (std::ranges::count(none_ended, signal) || ::sigaction(signal, nullptr, &action) != 0) continue;
        if ((action.sa_flags & SA_SIGINFO) || action.sa_handler != SIG_DFL) continue;
        action.sa_handler = dermis_on_signal;
        // A fault comes again when the handler returns, and ends the process then even where signals are held.
        action.sa_flags = SA_RESTART | (std::ranges::count(faults, signal) ? SA_RESETHAND : 0);
        ::sigaction(signal, &action, nullptr);
    }
}

Folder::Folder(const Path& path) : path_(path) {
    // A process whose run failed may remove the folder between any two of these calls, but not time and again.
    bool locked = false;
    for (int tries = 0; tries < 100 && !locked; ++tries) {
        make(path);
        locked = lock();
    }
    if (!locked) failed(path, "created");
    remove_parts();
}

Folder::~Folder() {
    made_.clear();
    ::close(file_);
}

void Folder::make(const Path& path) {
    std::error_code none;
    if (std::filesystem::exists(path, none)) return;
    const Path above = path.parent_path();
    if (!above.empty() && above != path) make(above);
    const HeldSignals signals;
    if (::mkdir(path.c_str(), 0777) == 0) made_.emplace_front(path.string(), signals);
    else if (errno != EEXIST) failed(path, "created");
}

// Returns false where the folder is gone.
bool Folder::lock() {
    file_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file_ < 0 && errno == ENOENT) return false;
    if (file_ < 0) failed(path_, "created");
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        ::close(file_);
        throw Error(Error::Code::io, "",
                    fmt::format("{}: another dermis writes into this folder; allowed: another --out, or this one when "
                                "that has ended",
                                path_.string()));
    }
    struct stat locked = {}, named = {};
    if (::fstat(file_, &locked) == 0 && ::stat(path_.c_str(), &named) == 0 && locked.st_dev == named.st_dev &&
        locked.st_ino == named.st_ino)
        return true;
    ::close(file_);
    errno = ENOENT;
    return false;
}

void Folder::remove_parts() const {
    std::error_code error;
    for (std::filesystem::directory_iterator i(path_, error), end; !error && i != end; i.increment(error))
        if (is_part(i->path().filename().string())) ::unlink(i->path().c_str());
}

PartFile::PartFile(const Path& path, const std::string& content) : path_(path) {
    const int file = created();
    const bool written = write(file, content) && (::fsync(file) == 0 || errno == EINVAL); // which cannot be synced
    if (::close(file) != 0 || !written) failed(path_, "written");
}

// If a name is taken, by a file that a process of the same number left or by another file of this one, the next
// number is tried.
int PartFile::created() {
    for (long number = ::getpid();; ++number) {
        std::string name = fmt::format("{}{}{}{}", path_.string(), before_number, number, after_number);
        const HeldSignals signals;
        const int file = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC | O_BINARY, 0644);
        if (file >= 0) {
            leftover_.emplace(std::move(name), signals);
            return file;
        }
        if (errno != EEXIST) failed(path_, "created");
    }
}

void PartFile::publish(const HeldSignals&) {
    if (::rename(leftover_->path().c_str(), path_.c_str()) != 0) failed(path_, "written");
}

void write_file(const Path& path, const std::string& content) {
    PartFile part(path, content);
    const HeldSignals signals;
    part.publish(signals);
}

} // namespace dermis::output
