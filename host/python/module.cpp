// SPDX-License-Identifier: MIT
// The module dermis._core. The package around it is in host/python/dermis.
#include "host/python/module.hpp"

namespace dermis::python {
namespace {

const char* name_of(Error::Code code) {
    switch (code) {
    case Error::Code::bad_input: return "bad_input";
    case Error::Code::no_device: return "no_device";
    case Error::Code::device: return "device";
    case Error::Code::io: return "io";
    case Error::Code::no_memory: return "no_memory";
    }
    return "(no such code)";
}

// Raises MemoryError or dermis.Error in place of a dermis::Error. Other exceptions are nanobind's to translate.
void translate(const std::exception_ptr& thrown, void*) {
    try {
        std::rethrow_exception(thrown);
    } catch (const Error& e) {
        if (e.code() == Error::Code::no_memory) return PyErr_SetString(PyExc_MemoryError, e.what());
        const nb::object type = nb::module_::import_("dermis._error").attr("Error");
        PyErr_SetObject(type.ptr(), nb::make_tuple(name_of(e.code()), e.parameter(), e.what()).ptr());
    }
}

std::string type_of(const nb::dlpack::dtype& dtype) {
    using Code = nb::dlpack::dtype_code;
    const Code code = Code(dtype.code);
    const std::string name = code == Code::Bool      ? "bool"
                             : code == Code::Int     ? "int"
                             : code == Code::UInt    ? "uint"
                             : code == Code::Float   ? "float"
                             : code == Code::Bfloat  ? "bfloat"
                             : code == Code::Complex ? "complex"
                                                     : "other";
    return code == Code::Bool ? name : name + std::to_string(dtype.bits);
}

} // namespace

nb::object with_strides(nb::handle argument) {
    if (!PyObject_CheckBuffer(argument.ptr()) || nb::hasattr(argument, "__dlpack__")) return nb::borrow(argument);
    nb::object view = nb::steal(PyMemoryView_FromObject(argument.ptr()));
    if (view.is_valid()) return view;
    PyErr_Clear();
    return nb::none();
}

std::optional<AnyArray> array_in(nb::handle argument) {
    AnyArray array;
    if (!nb::try_cast(with_strides(argument), array, false)) return {};
    return array;
}

std::string shape_text(const std::vector<size_t>& shape) {
    std::string text;
    for (size_t n : shape) text += (text.empty() ? "" : ", ") + std::to_string(n);
    return "(" + text + (shape.size() == 1 ? ",)" : ")");
}

std::string description_of(nb::handle argument) {
    nb::ndarray<nb::ro> array;
    if (!nb::try_cast(with_strides(argument), array, false)) {
        const std::string text = nb::repr(argument).c_str();
        return text.size() > 60 ? text.substr(0, 60) + ".." : text;
    }
    std::vector<size_t> shape;
    for (size_t i = 0; i < array.ndim(); ++i) shape.push_back(array.shape(i));
    const std::string where = array.device_type() == nb::device::cpu::value ? "" : " on another device";
    return type_of(array.dtype()) + " array of shape " + shape_text(shape) + where;
}

std::vector<Quantity> quantities_named(const std::string& parameter, const std::vector<std::string>& names) {
    std::vector<Quantity> quantities;
    for (const std::string& name : names) quantities.push_back(value_named<Quantity>(parameter, name));
    return quantities;
}

} // namespace dermis::python

NB_MODULE(_core, m) {
    using namespace dermis::python;
    m.doc() = "The compiled part of dermis. Use the package dermis, which has all of it.";
    m.attr("version") = dermis::version();
    m.attr("commit") = dermis::commit();
    nanobind::register_exception_translator(translate);
    bind_device(m);
    bind_report(m);
    bind_scene(m);
    bind_result(m);
    bind_skin(m);
    bind_fit(m);
    bind_contact(m);
}
