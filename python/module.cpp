// The Python module raygraph._core: errors, messages and devices. The package around it is raygraph/.
#include <algorithm>
#include <cstdlib>
#include <mutex>

#include "base/version.h"
#include "editor/session/settings/picture_settings.h"
#include "python/bindings.h"

namespace raygraph::python {

namespace {

struct Message {
    LogLevel level;
    std::string category, text;
};

struct MessageQueue {
    std::mutex lock;
    std::vector<Message> messages;
};

// It outlives every device, also those that the interpreter frees at its end.
MessageQueue& Queue() {
    static MessageQueue& queue = *new MessageQueue;
    return queue;
}

// Returns the level of Python's logging.
int LevelOf(LogLevel level) {
    switch (level) {
        case LogLevel::Debug:
            return 10;
        case LogLevel::Info:
            return 20;
        case LogLevel::Warning:
            return 30;
        default:
            return 40;
    }
}

constexpr std::array kErrorKinds{"usage",         "bad_input",   "io",    "no_device",
                                 "out_of_memory", "device_lost", "vulkan"};

// The class raygraph.Error; kept for as long as the process lives.
PyObject* g_error = nullptr;

void RaiseError(const Error& error, std::string text) {
    const py::object type = py::reinterpret_borrow<py::object>(g_error);
    py::object raised = type(text);
    raised.attr("kind") = kErrorKinds.at(static_cast<size_t>(error.Kind()));
    PyErr_SetObject(g_error, raised.ptr());
}

// The name of a setting as Python's keyword: "max_depth: ..." for "max-depth: ...", and "max_depth 4: ...".
std::string WithKeyword(std::string text) {
    const size_t end = std::min(text.find_first_of(": "), text.size());
    const std::string name = text.substr(0, end);
    if (name == "aov") return "aovs" + text.substr(end);
    if (name == "time") return "seconds" + text.substr(end);
    std::replace(text.begin(), text.begin() + static_cast<ptrdiff_t>(end), '-', '_');
    return text;
}

void BindErrors(py::module_& module) {
    g_error = PyErr_NewExceptionWithDoc(
        "raygraph.Error",
        "A failure of the library, in one line. `kind` is one of usage, bad_input, io, no_device, "
        "out_of_memory, device_lost and vulkan.",
        nullptr, nullptr);
    module.attr("Error") = py::reinterpret_borrow<py::object>(g_error);
    py::register_exception_translator([](std::exception_ptr pointer) {
        try {
            if (pointer) std::rethrow_exception(pointer);
        } catch (const session::SettingError& error) {
            RaiseError(error, WithKeyword(error.what()));
        } catch (const Error& error) {
            RaiseError(error, error.what());
        } catch (const py::cast_error&) {
            PyErr_SetString(PyExc_TypeError, "a value has a type that cannot be converted");
        }
    });
}

// Opens a device as the program does: "" is RAYGRAPH_DEVICE, else the most suitable one.
DevicePtr OpenDevice(std::string select, bool validation) {
    const char* variable = std::getenv("RAYGRAPH_DEVICE");
    if (select.empty() && variable != nullptr) select = variable;
    return WithoutGil([&] {
        return DevicePtr(
            rhi::Device::Create({.select = select, .validation = validation, .log = LogToPython()}));
    });
}

// Null until it is needed, and at the interpreter's end again.
DevicePtr& DefaultDevice() {
    static DevicePtr& device = *new DevicePtr;
    return device;
}

// Ends what the interpreter's end would pull the ground from: what is left behind may still be in the driver,
// whose statics go. But where Ctrl-C ends the interpreter, a signal ends the process, and they stay.
void End() {
    const py::module_ sys = py::module_::import("sys");
    const bool isKilled = !py::hasattr(sys, "ps1") && py::hasattr(sys, "last_type") &&
                          sys.attr("last_type").ptr() == PyExc_KeyboardInterrupt;
    // Ctrl-C ends the wait, and the process
    const py::module_ signals = py::module_::import("signal");
    py::object before = py::none();
    try {
        before = signals.attr("signal")(signals.attr("SIGINT"), signals.attr("SIG_DFL"));
    } catch (const py::error_already_set&) {
        // Only the main thread sets signals
    }
    WithoutGil([&] {
        DefaultDevice().reset();
        if (!isKilled) session::WaitForAbandonedWork();
        return 0;
    });
    if (!before.is_none()) signals.attr("signal")(signals.attr("SIGINT"), before);  // none: not Python's
}

void BindDevices(py::module_& module) {
    py::class_<rhi::Device, DevicePtr>(
        module, "Device",
        "A Vulkan device. `select` is an index or a part of a name; \"\": RAYGRAPH_DEVICE, else the most "
        "suitable one. With `validation` the validation layers check every call, and their messages are "
        "counted.")
        .def(py::init(&OpenDevice), py::arg("select") = "", py::kw_only(), py::arg("validation") = false)
        .def_property_readonly("name", [](const rhi::Device& device) { return device.Info().name; })
        .def_property_readonly("driver", [](const rhi::Device& device) { return device.Info().driver; })
        .def_property_readonly("kind",
                               [](const rhi::Device& device) { return rhi::Name(device.Info().type); })
        .def_property_readonly("validation_messages", &rhi::Device::ValidationMessageCount)
        .def("__repr__",
             [](const rhi::Device& device) { return "<raygraph.Device '" + device.Info().name + "'>"; });
    module.def(
        "devices",
        [] {
            py::list list;
            for (const rhi::DeviceReport& report : WithoutGil([] { return rhi::Device::Enumerate(); })) {
                py::dict entry;
                entry["index"] = report.index;
                entry["name"] = report.name;
                entry["driver"] = report.driver;
                entry["kind"] = rhi::Name(report.type);
                py::list refusals;
                for (const std::string& refusal : report.refusals) refusals.append(refusal);
                entry["refusals"] = refusals;
                list.append(entry);
            }
            return list;
        },
        "Returns every Vulkan device of the machine as a dictionary: index, name, driver, kind, and the "
        "reasons for which it cannot be used as `refusals`.");
    module.def(
        "set_default_device", [](const DevicePtr& device) { DefaultDevice() = device; },
        "Sets the device of calls that name none; None: it is opened again when it is needed.");
    py::module_::import("atexit").attr("register")(py::cpp_function(&End));
}

}  // namespace

Log LogToPython() {
    return Log([](const LogMessage& message) {
        const std::scoped_lock lock(Queue().lock);
        Queue().messages.push_back({message.level, std::string(message.category), std::string(message.text)});
    });
}

void SendMessages() noexcept {
    std::vector<Message> messages;
    {
        const std::scoped_lock lock(Queue().lock);
        messages.swap(Queue().messages);
    }
    if (messages.empty()) return;
    try {
        const py::error_scope pending;  // of the call
        const py::object logging = py::module_::import("logging");
        for (const Message& message : messages)
            logging.attr("getLogger")("raygraph." + message.category)
                .attr("log")(LevelOf(message.level), "%s",
                             py::bytes(message.text).attr("decode")("utf-8", "replace"));
    } catch (py::error_already_set& error) {
        error.discard_as_unraisable("raygraph: a message");
    }
}

DevicePtr DeviceOrDefault(const DevicePtr& device) {
    if (device) return device;
    if (!DefaultDevice()) {
        // Another thread may open one meanwhile: the first stays.
        const DevicePtr opened = OpenDevice("", false);
        if (!DefaultDevice()) DefaultDevice() = opened;
    }
    return DefaultDevice();
}

}  // namespace raygraph::python

PYBIND11_MODULE(_core, module) {
    using namespace raygraph::python;
    module.attr("__version__") = RAYGRAPH_VERSION;
    BindErrors(module);
    BindDevices(module);
    BindScene(module);
    BindPictures(module);
    BindPasses(module);
    BindAnalysis(module);
}
