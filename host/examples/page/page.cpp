// SPDX-License-Identifier: MIT
// The functions that page.js calls. page_begin and page_step return nullptr, or a message that says why they refuse.
#include "host/examples/page/session.hpp"

#include <cstdio>
#include <memory>
#include <string>

namespace {

std::unique_ptr<dermis::web::Session> session;

template <class Call> const char* refusal(Call call) {
    static std::string message;
    try {
        call();
        return nullptr;
    } catch (const std::exception& e) {
        message = e.what();
        return message.c_str();
    }
}

} // namespace

extern "C" {

// A skin at rest. Lengths in m, modulus in Pa; shape: the number of a dermis::web::Shape.
const char* page_begin(double ridge_period, double modulus, int shape, double radius, int one_element) {
    return refusal([&] {
        session = std::make_unique<dermis::web::Session>(dermis::web::Settings{.ridge_period = ridge_period,
                                                                               .modulus = modulus,
                                                                               .shape = dermis::web::Shape(shape),
                                                                               .radius = radius,
                                                                               .one_element = one_element != 0});
    });
}

const char* page_step(double x, double y, double force) {
    return refusal([&] { session->step(x, y, force); });
}

// number: the number of a dermis::Quantity.
const float* page_map(int number) { return session->map(dermis::Quantity(number)); }

// m^2, of the cells that the body presses.
double page_pressed() { return session->pressed(); }

// How many afferents of a kind there are. kind: 0 for SA1, 1 for FA1, 2 for FA2.
int page_fibres(int kind) { return int(session->afferents().at(size_t(kind)).cells.size()); }

// The number of the cell in which an afferent of a kind ends.
int page_ending(int kind, int fibre) {
    const dermis::Cell cell = session->afferents().at(size_t(kind)).cells.at(size_t(fibre));
    return cell.y * dermis::web::Session::width + cell.x;
}

// How many spikes the last step had.
int page_spikes() { return int(session->spikes().size); }

// The number of the afferent that fired spike i of the last step.
int page_spike_fibre(int i) { return session->spikes()[size_t(i)].afferent; }
// The time of spike i of the last step, s after the step's beginning.
double page_spike_time(int i) { return double(session->spikes()[size_t(i)].share) * dermis::web::Session::step_time; }

const char* page_hash() {
    static char text[20];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(session->hash()));
    return text;
}
}
