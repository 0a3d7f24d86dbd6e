// SPDX-License-Identifier: MIT
// What exit() does with devices that are open: skins that are static, cached or held by a thread may outlive the
// driver, whose own static objects exit() destroys.
#pragma once

#include <string>

namespace dermis::vulkan {

class Context;

// A use of a driver. While it lives, exit() in another thread waits. It is false if it is not allowed or the process is
// ending: the driver must then not be called, and all its objects are left to it.
class Use {
  public:
    explicit Use(bool allowed = true) noexcept;
    explicit Use(const std::string& device); // throws Error::device, naming the device, if the process is ending
    ~Use();
    Use& operator=(Use&&) = delete; // and no copies
    explicit operator bool() const { return entered_; }

  private:
    bool entered_;
};

// From now on exit() ends all uses before it destroys the static objects that there are now. Drivers make more of them
// when they first run what they have compiled: then this is called again. Returns false if memory runs out.
bool end_before_drivers() noexcept;

// The contexts with submissions that exit() waits for.
void add_open(const Context*);
void remove_open(const Context*);

} // namespace dermis::vulkan
