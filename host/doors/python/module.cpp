// SPDX-License-Identifier: MIT
// The module dermis._core. The package around it is in host/doors/python/dermis.
#include "host/doors/python/module.hpp"

#include "host/core/base/opening.hpp"

#include <chrono>
#include <thread>

namespace dermis::python {

namespace {

constexpr const char* codes[] = {"bad_input", "no_device", "device", "io", "no_memory"}; // by Error::Code

// A str, even of bytes that are no UTF-8, as a path may have them.
nb::object str_of(string_view text) {
    nb::object str = nb::steal(PyUnicode_DecodeUTF8(text.data(), Py_ssize_t(text.size()), "backslashreplace"));
    if (!str.is_valid()) nb::raise_python_error();
    return str;
}

// Raises MemoryError, dermis.InputError or dermis.Error in place of a dermis::Error, and MemoryError where this module
// itself had no memory. Other exceptions are nanobind's to translate.
void translate(const std::exception_ptr& thrown, void*) {
    try {
        std::rethrow_exception(thrown);
    } catch (const Error& e) {
        if (e.code() == Error::Code::no_memory) return PyErr_SetString(PyExc_MemoryError, e.what());
        const bool is_input = e.code() == Error::Code::bad_input;
        const nb::object type = nb::module_::import_("dermis._error").attr(is_input ? "InputError" : "Error");
        const nb::tuple arguments = nb::make_tuple(codes[size_t(e.code())], str_of(e.parameter()), str_of(e.what()));
        PyErr_SetObject(type.ptr(), arguments.ptr());
    } catch (const std::bad_alloc&) {
        PyErr_SetString(PyExc_MemoryError, "out of memory: what a call takes or returns could not be allocated");
    }
}

// Calls a method, and returns None where that raises an Exception.
template <class... Arguments> nb::object result_of(const nb::object& method, Arguments&&... arguments) {
    try {
        return method(std::forward<Arguments>(arguments)...);
    } catch (const nb::python_error& e) {
        if (!e.matches(PyExc_Exception)) throw;
        return nb::none();
    }
}

// What an object says why it gives no array, as a tensor of torch that requires a gradient does; empty: nothing.
std::string reason_of(nb::handle argument) try {
    if (nb::hasattr(argument, "__dlpack__")) argument.attr("__dlpack__")();
    return {};
} catch (const nb::python_error& e) {
    if (!e.matches(PyExc_Exception)) throw;
    return nb::str(e.value()).c_str();
}

// Returns what __dlpack__ gives, or None. Arrays older than DLPack 1 do not know the keyword, by which others say
// whether they can be written to.
nb::object capsule_of(nb::handle argument) {
    const nb::object method = argument.attr("__dlpack__");
    const nb::object capsule = result_of(method, nb::arg("max_version") = nb::make_tuple(1, 1));
    return capsule.is_none() ? result_of(method) : capsule;
}

// Puts a function into a scope that calls `function`. Where that raises a TypeError it calls `refuse` with the error,
// the arguments by name and the others, which may raise what says more. signature, doc: how it stands in help.
void answer(const nb::object& scope, const char* signature, const char* doc, bool is_method, const nb::object& function,
            const nb::object& refuse) {
    const auto call = [function, refuse](const nb::args& given, const nb::kwargs& named) {
        PyObject* result = PyObject_Call(function.ptr(), given.ptr(), named.ptr());
        if (result) return nb::steal(result);
        nb::python_error error;
        if (error.matches(PyExc_TypeError)) refuse(error.value(), named, *given);
        throw error;
    };
    const nb::scope in(scope);
    if (is_method) nb::cpp_function_def(call, in, nb::sig(signature), doc, nb::is_method());
    else nb::cpp_function_def(call, in, nb::sig(signature), doc);
}

// value: Ellipsis where it is not given.
void refuse(string_view parameter, nb::handle value, string_view allowed) {
    const std::string described = value.is(nb::ellipsis()) ? "(not given)" : description_of(value);
    scene::refuse(std::string(parameter), described, std::string(allowed));
}

unsigned long main_thread = 0; // of the interpreter

} // namespace

// Up to Python 3.13 an interpreter that ends unwinds threads that come back to it, and no destructor may be unwound. So
// such a thread waits here for the end of the process.
void Computing::come_back() noexcept {
    if (lock_) lock_.unlock();
    try {
        PyEval_RestoreThread(state_);
    } catch (...) {
        for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
    }
}

std::function<void(double)> Computing::progress(nb::handle progress) {
    using Clock = std::chrono::steady_clock;
    return [this, progress, last = Clock::time_point()](double done) mutable {
        if (done < 1 && Clock::now() - last < std::chrono::milliseconds(50)) return; // a run may call far more often
        come_back();
        struct LeavingAgain {
            Computing& computing;
            ~LeavingAgain() {
                computing.state_ = PyEval_SaveThread();
                if (computing.lock_.mutex()) computing.lock_.lock();
            }
        } leaving_again{*this};
        if (PyErr_CheckSignals() != 0) nb::raise_python_error();
        if (!progress.is_none()) progress(done);
        last = Clock::now();
    };
}

void let_signals_act(double) {
    using Clock = std::chrono::steady_clock;
    static Clock::time_point last;                          // of the main thread
    if (PyThread_get_thread_ident() != main_thread) return; // which another may wait for at the end of the process
    if (Clock::now() - last < std::chrono::milliseconds(50)) return;
    const nb::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) nb::raise_python_error();
    last = Clock::now();
}

bool is_row(nb::handle h) {
    const bool is = PySequence_Check(h.ptr()) && PySequence_Size(h.ptr()) >= 0; // an array of no axes has no length
    PyErr_Clear();
    return is && !PyUnicode_Check(h.ptr()) && !is_masked(h);
}

nb::object readable(nb::handle argument, bool to_write) {
    if (is_masked(argument)) return nb::none();
    const bool has_buffer = PyObject_CheckBuffer(argument.ptr()),
               has_dlpack = !(to_write && has_buffer) && nb::hasattr(argument, "__dlpack__");
    if (has_dlpack)
        if (nb::object capsule = capsule_of(argument); PyCapsule_CheckExact(capsule.ptr())) return capsule;
    if (!has_buffer) return has_dlpack ? nb::none() : nb::borrow(argument);
    nb::object view = nb::steal(PyMemoryView_FromObject(argument.ptr()));
    if (view.is_valid()) return view;
    PyErr_Clear();
    return nb::none();
}

std::optional<AnyArray> array_in(nb::handle argument) {
    AnyArray array;
    if (!nb::try_cast(readable(argument), array, false)) return {};
    return array;
}

std::string type_of(const nb::dlpack::dtype& dtype) {
    constexpr const char* names[] = {"int", "uint", "float", "other", "bfloat", "complex", "bool"}; // by DLPack's code
    const std::string name = names[dtype.code < std::size(names) ? dtype.code : 3];
    return name == "bool" ? name : name + std::to_string(dtype.bits);
}

std::string shape_text(const std::vector<size_t>& shape) {
    std::string text;
    for (size_t n : shape) text += (text.empty() ? "" : ", ") + std::to_string(n);
    return "(" + text + (shape.size() == 1 ? ",)" : ")");
}

// Whether an array says that it is in the memory of another device, which need not give it.
bool is_elsewhere(nb::handle argument) {
    if (nb::hasattr(argument, "__cuda_array_interface__")) return true;
    if (!nb::hasattr(argument, "__dlpack_device__")) return false;
    const nb::object device = result_of(argument.attr("__dlpack_device__"));
    int type = nb::device::cpu::value;
    return PyTuple_Check(device.ptr()) && nb::try_cast(device[0], type) && type != nb::device::cpu::value;
}

std::string description_of(nb::handle argument) {
    if (is_elsewhere(argument)) return "array on another device (.cpu() or its like copies it)";
    if (is_masked(argument)) return "masked array (.filled(..) has no mask)";
    nb::ndarray<nb::ro> array;
    if (!nb::try_cast(readable(argument), array, false)) {
        const std::string reason = reason_of(argument);
        if (!reason.empty()) return nb::type_name(argument.type()).c_str() + (" that cannot be read: " + reason);
        const nb::str text = nb::repr(argument);
        const nb::object bytes = nb::steal(PyUnicode_AsEncodedString(text.ptr(), "utf-8", "backslashreplace"));
        if (!bytes.is_valid()) nb::raise_python_error();
        return beginning_of(nb::borrow<nb::bytes>(bytes).c_str(), 60);
    }
    std::vector<size_t> shape;
    for (size_t i = 0; i < array.ndim(); ++i) shape.push_back(array.shape(i));
    const std::string where = array.device_type() == nb::device::cpu::value ? "" : " on another device";
    return (is_dense(array) ? "" : "strided ") + type_of(array.dtype()) + " array of shape " + shape_text(shape) +
           where;
}

} // namespace dermis::python

NB_MODULE(_core, m) {
    using namespace dermis::python;
    m.doc() = "The compiled part of dermis. Use the package dermis, which has all of it.";
    m.attr("version") = dermis::version();
    m.attr("commit") = dermis::commit();
    nanobind::set_leak_warnings(false); // a daemon thread keeps what it holds when the interpreter ends
    nanobind::register_exception_translator(translate);
    main_thread =
        nanobind::cast<unsigned long>(nanobind::module_::import_("threading").attr("main_thread")().attr("ident"));
    nanobind::module_::import_("atexit").attr("register")(nanobind::cpp_function([] {
        const nanobind::gil_scoped_release others_go_on;
        dermis::Opening::end();
    }));
    bind_device(m);
    bind_report(m);
    bind_afferents(m);
    bind_scene(m);
    bind_result(m);
    bind_skin(m);
    bind_fit(m);
    bind_contact(m);
    bind_touch(m);
    m.def("memory_at_hand", memory_at_hand, nb::arg("root"));
    m.def("answer", answer, nb::arg("scope"), nb::arg("signature"), nb::arg("doc"), nb::arg("is_method"),
          nb::arg("function"), nb::arg("refuse"));
    m.def("refuse", refuse, nb::arg("parameter"), nb::arg("value").none(), nb::arg("allowed"),
          nb::sig("def refuse(parameter: str, value: object, allowed: str) -> typing.NoReturn"));
}
