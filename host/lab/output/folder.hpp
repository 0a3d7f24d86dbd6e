// SPDX-License-Identifier: MIT
// A folder of results, and files that are in it under their names only when they are whole, also where a signal ends
// the process. Throws Error::io, naming the path.
#pragma once

#include <filesystem>
#include <forward_list>
#include <optional>
#include <string>

namespace dermis::output {

using Path = std::filesystem::path;

// While such an object lives no signal ends the process, except SIGKILL and faults of the process itself. A signal that
// arrives meanwhile ends the process when the object is destroyed. Such objects do not nest.
class HeldSignals {
  public:
    HeldSignals();
    ~HeldSignals();
    HeldSignals(const HeldSignals&) = delete;
};

// The path of a file, or of a folder that is empty, which is removed with this object or where a signal ends the
// process.
class Leftover {
  public:
    // The path is made while the same signals are held, so that it is never another process's.
    Leftover(std::string path, const HeldSignals&);
    ~Leftover();
    Leftover(const Leftover&) = delete;
    const std::string& path() const { return path_; }

  private:
    friend void remove_leftovers() noexcept;
    std::string path_;
    Leftover* older_;
};

// Removes all of them now, before the process ends without destructors.
void remove_leftovers() noexcept;
// Removes leftovers on each signal that would end the process and can be caught; one that is ignored, or handled
// already, stays so.
void remove_leftovers_on_signals();

// A folder, locked against other processes that use this class: the constructor throws if another one has the lock. The
// lock ends with the process, however the process ends. A file system without locks gives none.
class Folder {
  public:
    // Makes the folder and the folders above it, where missing, and removes parts that a killed process left in it.
    explicit Folder(const Path&);
    // Removes the folders that it made, if they are empty.
    ~Folder();
    Folder(const Folder&) = delete;
    const Path& path() const { return path_; }

  private:
    void make(const Path&);
    bool lock();
    void remove_parts() const;

    Path path_;
    std::forward_list<Leftover> made_; // the innermost one first
    int file_ = -1;
};

// A new file under a temporary name beside its own, NAME.dermis-PID.part. It is never a file that exists already, nor
// reached through a link. The part is removed unless it is published.
class PartFile {
  public:
    // Writes the content, to the disk.
    PartFile(const Path&, const std::string& content);
    // Gives the file its own name; a file that has the name is replaced.
    void publish(const HeldSignals&);

  private:
    int created();

    Path path_;
    std::optional<Leftover> leftover_;
};

// Writes one file as a part and publishes it.
void write_file(const Path&, const std::string& content);

} // namespace dermis::output
