// SPDX-License-Identifier: MIT
#include "host/doors/python/skin_arguments.hpp"

#include <algorithm>

namespace dermis::python {

std::vector<size_t> shape_of(const SkinWithShapes& s, const PadNumbers& pads) {
    std::vector<size_t> shape = pads.shape();
    shape.push_back(size_t(s.scene.grid.height));
    shape.push_back(size_t(s.scene.grid.width));
    return shape;
}

std::vector<size_t> shape_of(const SkinWithShapes& s, const Skin::Response& response) {
    if (s.scene.sites.empty()) return shape_of(s, {nb::none(), s.leading});
    std::vector<size_t> shape(s.leading.begin(), s.leading.end());
    shape.push_back(response.size / size_t(s.skin->count()));
    return shape;
}

std::vector<double> steps_in(const SkinWithShapes& s, nb::handle dt, const PadNumbers& pads) {
    std::vector<size_t> axes = shape_of(s, pads), given;
    axes.resize(axes.size() - 2);
    const std::string allowed = "seconds, or an array of them, one for each pad, of shape " + shape_text(axes);
    nb::object row = nb::borrow(dt);
    if (nb::hasattr(dt, "ravel") && !is_masked(dt)) {
        row = dt.attr("ravel")();
        given = nb::cast<std::vector<size_t>>(dt.attr("shape"));
    }
    if (!is_row(row) || (given.size() > 1 && given != axes)) scene::refuse("dt", description_of(dt), allowed);
    return items_of<double>(row, "dt", allowed.c_str());
}

AnyArray pressure_in(const SkinWithShapes& s, nb::handle argument, const PadNumbers& pads, const char* parameter,
                     const std::string& first) {
    std::vector<size_t> shape = shape_of(s, pads);
    std::string allowed = shape_text(shape);
    size_t size = 1;
    for (size_t n : shape) size *= n;
    std::optional<AnyArray> array = array_in(argument);
    const bool floats = array && array->dtype() == nb::dtype<float>();
    if (!first.empty()) {
        shape.insert(shape.begin(), first == "2" ? 2 : floats && array->ndim() > 0 ? array->shape(0) : 1);
        allowed = "(" + first + ", " + allowed.substr(1);
    }
    if (!floats || !is_dense(*array) || !(has_shape(*array, shape) || (first.empty() && has_shape(*array, {size}))))
        scene::refuse(parameter, description_of(argument), "float32 array in C order, of shape " + allowed + " in Pa");
    return std::move(*array);
}

std::vector<Quantity> responses_of(const SkinWithShapes& s) {
    if (s.scene.sites.empty()) return s.options.responses;
    std::vector<Quantity> classes;
    for (const Site& site : s.scene.sites)
        if (std::find(classes.begin(), classes.end(), site.type) == classes.end()) classes.push_back(site.type);
    return classes;
}

Skin::Response response_of(const SkinWithShapes& s, nb::handle named, const std::vector<Quantity>& these) {
    string_view asked;
    nb::try_cast(named, asked);
    std::string allowed;
    for (Quantity q : these) {
        if (asked == name(q)) {
            const Computing computing(s.in_use.get());
            return s.skin->response(q);
        }
        allowed += (allowed.empty() ? "\"" : ", \"") + std::string(name(q)) + "\"";
    }
    scene::refuse("response", description_of(named), allowed);
}

void refuse_output(nb::handle argument, nb::dlpack::dtype type, const std::vector<size_t>& shape) {
    const std::optional<AnyArray> array = array_in(argument);
    const bool read_only = array && array->dtype() == type && is_dense(*array) && has_shape(*array, shape);
    scene::refuse("out", (read_only ? "read-only " : "") + description_of(argument),
                  type_of(type) + " array in C order that can be written, of shape " + shape_text(shape));
}

Outputs outputs_in(const SkinWithShapes& s, nb::handle out) {
    Outputs outputs;
    if (out.is_none()) return outputs;
    if (!PyDict_Check(out.ptr()))
        scene::refuse("out", description_of(out), "a dict of arrays by the names of responses");
    for (const auto& [named, argument] : nb::borrow<nb::dict>(out)) {
        const Skin::Response response = response_of(s, named, responses_of(s));
        const Output<float> array = output_in<float>(argument, shape_of(s, response));
        const auto shares = [&](const Output<float>& before) {
            return std::less()(before.data(), array.data() + array.size()) &&
                   std::less()(array.data(), before.data() + before.size());
        };
        if (std::ranges::any_of(outputs, shares, [](const auto& before) { return before.second; }))
            scene::refuse("out", description_of(argument) + " twice", "an array for each response");
        outputs.emplace_back(response, array);
    }
    return outputs;
}

void fill(const Outputs& outputs) {
    for (const auto& [response, to] : outputs) std::copy_n(response.data, response.size, to.data());
}

} // namespace dermis::python
