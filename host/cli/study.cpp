#include "host/cli/study.hpp"
namespace dermis::cli { int study(const Path&) { return 1; } }
