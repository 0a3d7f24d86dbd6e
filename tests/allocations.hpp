// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace test {

// How often operator new has been called in this process, by any thread; always 0 in a sanitizer's build.
size_t allocations();

// While it lives, an allocation of this thread fails: by operator new, malloc or what C has beside it. Those of other
// threads, and of a driver that this one has called, never fail; in a sanitizer's build none does.
class FailingAllocation {
  public:
    FailingAllocation(long before, bool sticky); // so many succeed before; sticky: all later ones fail too
    ~FailingAllocation();
    FailingAllocation(const FailingAllocation&) = delete;
    FailingAllocation& operator=(const FailingAllocation&) = delete;
    bool struck() const { return struck_; }
    bool strikes(); // counts an allocation

  private:
    long before_;
    bool sticky_, struck_ = false;
};

// Whether allocations can be made to fail here.
bool allocations_fail();

// The allocations of this thread that have not been freed, but those of drivers.
long allocations_left();

// While it lives, what this thread allocates is a driver's.
class InDriver {
  public:
    InDriver();
    ~InDriver();
    InDriver(const InDriver&) = delete;
    InDriver& operator=(const InDriver&) = delete;

  private:
    bool before_;
};

} // namespace test
