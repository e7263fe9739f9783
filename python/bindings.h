// The sources of the Python module share this; it is for python/ alone. Threads: with the GIL held, unless a
// comment says otherwise.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/log.h"
#include "editor/session/binding/edited_scene.h"
#include "editor/session/binding/interruptible.h"
#include "rhi/device.h"

namespace raygraph::python {

namespace py = pybind11;

using Scene = session::EditedScene;  // renders take copies

// Messages of the library wait here until a call into the module returns or a render asks Python whether to
// go on, and then go to Python's `logging` as those of the logger "raygraph". So none of the library's
// threads ever waits for the GIL under a lock.
Log LogToPython();
void SendMessages() noexcept;

// Calls `run` without the GIL, so that other Python threads go on, and sends the messages of the call.
template <typename Run>
auto WithoutGil(Run&& run) {
    struct Sender {
        ~Sender() { SendMessages(); }
    } sender;
    const py::gil_scoped_release released;
    return std::forward<Run>(run)();
}

// Asks Python during a call whether a signal has come, as Ctrl-C. What a question raises ends the call, and
// is raised after it. Each question takes the GIL, which its thread does not hold.
class Listener {
  public:
    template <typename Question>
    void Ask(Question&& question) {
        if (m_raised) return;
        const py::gil_scoped_acquire acquired;
        SendMessages();
        try {
            question();
        } catch (...) {
            m_raised = std::current_exception();
        }
    }
    bool IsStopRequested() {
        // Often enough for a person, and rarely enough not to wait for other Python threads all the time.
        constexpr auto kInterval = std::chrono::milliseconds(20);
        const auto now = std::chrono::steady_clock::now();
        if (now - m_asked > kInterval) {
            m_asked = now;
            Ask([] {
                if (PyErr_CheckSignals() != 0) throw py::error_already_set();
            });
        }
        return m_raised != nullptr;
    }
    // Returns the result of `run`, which returns none where it was stopped. Throws what was raised instead.
    template <typename Run>
    auto ResultOf(Run&& run) {
        decltype(run()) result;
        try {
            result = WithoutGil(std::forward<Run>(run));
        } catch (...) {
            Raise();
            throw;
        }
        Raise();
        return std::move(*result);
    }

  private:
    void Raise() const {
        if (m_raised) std::rethrow_exception(m_raised);
    }

    std::chrono::steady_clock::time_point m_asked;
    std::exception_ptr m_raised;
};

// Runs `work(caller)`, which uses nothing of Python, until a signal comes (session::RunInterruptibly).
template <typename Work>
auto Interruptibly(Work work) {
    Listener listener;
    return listener.ResultOf([&] {
        return session::RunInterruptibly(std::move(work), [&] { return listener.IsStopRequested(); });
    });
}

// A device, or none: the default one, which the first call that needs it opens.
using DevicePtr = std::shared_ptr<rhi::Device>;
DevicePtr DeviceOrDefault(const DevicePtr& device);

// Returns an array of numpy over memory that `owner` keeps, without a copy. Strides are in values.
template <typename T, typename Owner>
py::array ViewOf(const std::shared_ptr<Owner>& owner, const T* data, const std::vector<py::ssize_t>& shape,
                 std::vector<py::ssize_t> strides) {
    for (py::ssize_t& stride : strides) stride *= static_cast<py::ssize_t>(sizeof(T));
    const py::capsule keeper(new std::shared_ptr<Owner>(owner),
                             [](void* pointer) { delete static_cast<std::shared_ptr<Owner>*>(pointer); });
    return py::array(py::dtype::of<T>(), shape, strides, data, keeper);
}

void BindScene(py::module_& module);
void BindPictures(py::module_& module);
void BindPasses(py::module_& module);
void BindAnalysis(py::module_& module);

}  // namespace raygraph::python
