// Call is what every function of the C interface runs in: no exception leaves it, and pointers and structs of
// the host are checked. For c/ alone. Threads: any.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "base/text.h"
#include "c/raygraph.h"

namespace raygraph::c {

// Thrown by a call that a callback of the host has ended without a result.
struct Stopped {};

// Keeps the exception that is being handled as the last error of the thread, and returns its result.
RgResult KeepError() noexcept;

class Call {
  public:
    explicit Call(const char* function) : m_function(function) {}

    template <typename T>
    T& Required(T* pointer, const char* what) const {
        if (pointer == nullptr) throw MakeError(ErrorKind::Usage, "{}: {} is NULL", m_function, what);
        return *pointer;
    }
    const char* RequiredText(const char* text, const char* what) const { return &Required(text, what); }

    // Returns the struct with zeros for fields that the host's version of it does not have.
    template <typename Struct>
    Struct Read(const Struct* given, const char* what) const {
        static_assert(std::is_trivially_copyable_v<Struct>);
        const uint32_t size = Required(given, what).struct_size;
        RequireSize(size, what);
        const auto* bytes = reinterpret_cast<const std::byte*>(given);
        for (uint32_t i = sizeof(Struct); i < size; ++i)
            if (bytes[i] != std::byte{})
                throw MakeError(ErrorKind::Usage, "{}: {} has fields that this library does not know",
                                m_function, what);
        Struct read{};
        std::memcpy(&read, given, std::min<size_t>(size, sizeof(Struct)));
        return read;
    }
    template <typename Struct>
    Struct ReadOr(const Struct* given, const char* what) const {
        return given == nullptr ? Struct{} : Read(given, what);
    }
    // Fills the struct of the host as far as its version goes.
    template <typename Struct>
    void Write(Struct* to, const char* what, Struct value) const {
        static_assert(std::is_trivially_copyable_v<Struct>);
        const uint32_t size = Required(to, what).struct_size;
        RequireSize(size, what);
        value.struct_size = size;
        auto* bytes = reinterpret_cast<std::byte*>(to);
        std::memcpy(bytes, &value, std::min<size_t>(size, sizeof(Struct)));
        if (size > sizeof(Struct)) std::memset(bytes + sizeof(Struct), 0, size - sizeof(Struct));
    }

    [[noreturn]] void Refuse(const std::string& why) const {
        throw Error(ErrorKind::Usage, std::string(m_function) + ": " + why);
    }

  private:
    void RequireSize(uint32_t size, const char* what) const {
        if (size < 2 * sizeof(uint32_t))
            throw MakeError(ErrorKind::Usage, "{}: struct_size of {} is {}, not the sizeof of its type",
                            m_function, what, size);
    }

    const char* m_function;
};

// Runs `run(call)` as the function of this name.
template <typename Run>
RgResult Guarded(const char* function, Run&& run) noexcept {
    try {
        run(Call(function));
        return RG_OK;
    } catch (...) {
        return KeepError();
    }
}

inline std::string TextOr(const char* text, const char* other = "") {
    return text == nullptr ? other : text;
}

// Returns a copy for rg_text_free.
char* CopyOf(const std::string& text);

inline Log LogOf(const RgLog& log) {
    if (log.callback == nullptr) return {};
    const auto least =
        log.least == RG_LOG_DEFAULT ? LogLevel::Info : static_cast<LogLevel>(std::min(log.least, 5u) - 1);
    return Log(
        [log](const LogMessage& message) {
            log.callback(log.user, static_cast<RgLogLevel>(message.level) + 1,
                         std::string(message.category).c_str(), std::string(message.text).c_str());
        },
        least);
}

}  // namespace raygraph::c
