// The last error of a thread, and the version.
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <new>
#include <stdexcept>

#include "base/version.h"
#include "c/call.h"

namespace raygraph::c {

namespace {

// The text of a failure for which there was no memory is a constant.
struct LastError {
    std::string text;
    const char* shown = "";
    int32_t vkResult = 0;
};
thread_local LastError t_last;

RgResult Keep(RgResult result, const char* text, int32_t vkResult = 0) noexcept {
    t_last.vkResult = vkResult;
    try {
        t_last.text = text;
        t_last.shown = t_last.text.c_str();
    } catch (...) {
        t_last.shown = "host memory is exhausted";
    }
    return result;
}

RgResult ResultOf(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::Usage:
            return RG_ERROR_USAGE;
        case ErrorKind::BadInput:
            return RG_ERROR_BAD_INPUT;
        case ErrorKind::Io:
            return RG_ERROR_IO;
        case ErrorKind::NoDevice:
            return RG_ERROR_NO_DEVICE;
        case ErrorKind::OutOfMemory:
            return RG_ERROR_OUT_OF_MEMORY;
        case ErrorKind::DeviceLost:
            return RG_ERROR_DEVICE_LOST;
        case ErrorKind::Vulkan:
            return RG_ERROR_VULKAN;
    }
    return RG_ERROR_INTERNAL;
}

}  // namespace

RgResult KeepError() noexcept {
    try {
        throw;
    } catch (const Error& error) {
        return Keep(ResultOf(error.Kind()), error.what(), error.Result());
    } catch (const Stopped&) {
        return Keep(RG_ERROR_STOPPED, "a callback has ended the call before there was a result");
    } catch (const std::bad_alloc&) {
        return Keep(RG_ERROR_OUT_OF_MEMORY, "host memory is exhausted");
    } catch (const std::length_error&) {
        return Keep(RG_ERROR_OUT_OF_MEMORY, "more memory was asked for than a process can have");
    } catch (const std::filesystem::filesystem_error& error) {
        return Keep(RG_ERROR_IO, error.what());
    } catch (const std::exception& error) {
        return Keep(RG_ERROR_INTERNAL, error.what());
    } catch (...) {
        return Keep(RG_ERROR_INTERNAL, "an exception of unknown type");
    }
}

char* CopyOf(const std::string& text) {
    auto* copy = static_cast<char*>(std::malloc(text.size() + 1));
    if (copy == nullptr) throw std::bad_alloc();
    std::memcpy(copy, text.c_str(), text.size() + 1);
    return copy;
}

}  // namespace raygraph::c

static_assert(RG_VERSION_MAJOR == RAYGRAPH_VERSION_MAJOR && RG_VERSION_MINOR == RAYGRAPH_VERSION_MINOR &&
              RG_VERSION_PATCH == RAYGRAPH_VERSION_PATCH);

const char* rg_last_error(void) {
    return raygraph::c::t_last.shown;
}

int32_t rg_last_vk_result(void) {
    return raygraph::c::t_last.vkResult;
}

const char* rg_version(void) {
    static const std::string text =
        raygraph::Text("{}.{}.{}", RAYGRAPH_VERSION_MAJOR, RAYGRAPH_VERSION_MINOR, RAYGRAPH_VERSION_PATCH);
    return text.c_str();
}

void rg_text_free(char* text) {
    std::free(text);
}
