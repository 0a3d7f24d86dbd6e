// SPDX-License-Identifier: MIT
#include "host/c/handles.hpp"

#include "dermis/contact.hpp"

#include <cstring>

using namespace dermis::c;
namespace contact = dermis::contact;

namespace {

// Adds to a pad, and fills the caller's report. contact.hpp has exceptions of its own, which are all refusals.
template <class Add> void add(const dermis_contact_pad* pad, dermis_contact_report* report, Add&& add) {
    need_size(pad, "pad");
    need_size(report, "report");
    try {
        const contact::Report r = add(contact::Pad{.width = pad->width,
                                                   .height = pad->height,
                                                   .spacing = pad->spacing,
                                                   .pressure = pad->pressure,
                                                   .pitch = pad->pitch});
        *report = {.size = sizeof *report,
                   .asked = r.asked,
                   .placed = r.placed,
                   .outside = r.outside,
                   .greatest = r.greatest,
                   .level = r.level,
                   .cells = r.cells,
                   .below_cell = r.below_cell,
                   .beside = r.beside,
                   .plausible = r.plausible()};
    } catch (const std::invalid_argument& refused) {
        throw dermis::Error(dermis::Error::Code::bad_input, "", refused.what());
    }
}

} // namespace

dermis_status dermis_contact_report_get_doubts(const dermis_contact_report* report, char* text, size_t size) {
    return guarded([&] {
        need_pointer(text, "text");
        need_size(report, "report");
        contact::Report own;
        own.below_cell = report->below_cell;
        own.greatest = report->greatest;
        const std::string doubts = own.doubts();
        if (size <= doubts.size())
            dermis::scene::refuse("size", std::to_string(size), std::to_string(doubts.size() + 1) + " bytes or more");
        std::memcpy(text, doubts.c_str(), doubts.size() + 1);
    });
}

dermis_status dermis_add_contacts(const dermis_contact_pad* pad, const dermis_contact* contacts, size_t count,
                                  dermis_contact_report* report) {
    return guarded([&] {
        if (count > 0) need_pointer(contacts, "contacts");
        add(pad, report, [&](const contact::Pad& on) {
            contact::detail::check(on);
            return contact::detail::add_each(on, count, [&](size_t i) {
                const dermis_contact& c = contacts[i];
                return contact::Contact{.x = c.x, .y = c.y, .force = c.force, .radius = c.radius, .area = c.area};
            });
        });
    });
}

dermis_status dermis_add_depths(const dermis_contact_pad* pad, const dermis_depths* depths,
                                dermis_contact_report* report) {
    return guarded([&] {
        need_size(depths, "depths");
        const contact::Depths d{
            .depth = depths->depth, .force = depths->force, .stiffness = depths->stiffness, .pitch = depths->pitch};
        add(pad, report, [&](const contact::Pad& on) { return contact::add_depths(on, d); });
    });
}

dermis_status dermis_add_taxels(const dermis_contact_pad* pad, const dermis_taxels* taxels,
                                dermis_contact_report* report) {
    return guarded([&] {
        need_size(taxels, "taxels");
        using Unit = contact::Taxels::Unit;
        if (taxels->unit != DERMIS_NEWTON && taxels->unit != DERMIS_PASCAL)
            dermis::scene::refuse("taxels->unit", std::to_string(taxels->unit), "DERMIS_NEWTON (0), DERMIS_PASCAL (1)");
        const contact::Taxels t{.unit = taxels->unit == DERMIS_NEWTON ? Unit::newton : Unit::pascal,
                                .values = taxels->values,
                                .columns = taxels->columns,
                                .rows = taxels->rows,
                                .width = taxels->width,
                                .height = taxels->height,
                                .x = taxels->x,
                                .y = taxels->y,
                                .column_step = taxels->column_step ? taxels->column_step : 1,
                                .row_step = taxels->row_step};
        add(pad, report, [&](const contact::Pad& on) { return contact::add_taxels(on, t); });
    });
}
