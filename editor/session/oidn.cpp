#include "editor/session/oidn.h"

#include <memory>

#include "base/os.h"
#include "base/printable.h"
#include "base/text.h"

namespace raygraph::session {

namespace {

// These are from the documented C API, whose handles are pointers and whose enumerations are ints.
using Handle = void*;
constexpr int kDeviceCpu = 1;  // a GPU could not read the memory of this process everywhere
constexpr int kFormatFloat3 = 3;

[[noreturn]] void Fail(std::string_view why) {
    throw MakeError(ErrorKind::BadInput, "Open Image Denoise: {}", why);
}

void* OpenOidn() {
    std::string why;
    for (const char* name :
         {"libOpenImageDenoise.so.2", "libOpenImageDenoise.so.1", "libOpenImageDenoise.so"}) {
        std::string whyNot;
        if (void* library = os::OpenLibrary(name, whyNot)) return library;
        if (why.empty()) why = whyNot;
    }
    Fail(Text("{}; install it (openimagedenoise.org), or name its folder in LD_LIBRARY_PATH", why));
}

struct Function {
    void* address;
    template <typename Type>
    operator Type*() const {  // NOLINT: it is assigned to a pointer that has the type
        return reinterpret_cast<Type*>(address);
    }
};

struct Oidn {
    void* library = OpenOidn();
    Handle (*newDevice)(int type) = Find("oidnNewDevice");
    void (*commitDevice)(Handle device) = Find("oidnCommitDevice");
    int (*getDeviceError)(Handle device, const char** message) = Find("oidnGetDeviceError");
    void (*releaseDevice)(Handle device) = Find("oidnReleaseDevice");
    Handle (*newFilter)(Handle device, const char* type) = Find("oidnNewFilter");
    void (*setSharedFilterImage)(Handle filter, const char* name, void* data, int format, size_t width,
                                 size_t height, size_t byteOffset, size_t bytePixelStride,
                                 size_t byteRowStride) = Find("oidnSetSharedFilterImage");
    // Version 1 has only the second name
    void (*setFilterBool)(Handle filter, const char* name, bool value) = Find("oidnSetFilterBool",
                                                                              "oidnSetFilter1b");
    void (*commitFilter)(Handle filter) = Find("oidnCommitFilter");
    void (*executeFilter)(Handle filter) = Find("oidnExecuteFilter");
    void (*releaseFilter)(Handle filter) = Find("oidnReleaseFilter");

    Function Find(const char* name, const char* otherName = nullptr) const {
        if (void* address = os::FunctionOf(library, name)) return {address};
        if (otherName != nullptr) return Find(otherName);
        Fail(Text("the library has no function {}", name));
    }

    // The library keeps the first error of a device, or of the thread without one, until it is asked.
    void RequireSuccess(Handle device, Handle made) const {
        const char* message = nullptr;
        const int error = getDeviceError(device, &message);
        if (error == 0 && made) return;
        Fail(Text("the library says: {}",
                  message ? Printable(message, 1024) : Text("error {}, without a message", error)));
    }
};

}  // namespace

Texels DenoiseByOidn(const RenderFile& render) {
    const Oidn oidn;
    using Owner = std::unique_ptr<void, void (*)(Handle)>;
    const Owner device(oidn.newDevice(kDeviceCpu), oidn.releaseDevice);
    if (device) oidn.commitDevice(device.get());
    oidn.RequireSuccess(device.get(), device.get());
    const Owner filter(oidn.newFilter(device.get(), "RT"), oidn.releaseFilter);
    oidn.RequireSuccess(device.get(), filter.get());

    const DenoisingPlanes& planes = render.denoising;
    const bool hasPlanes = !planes.albedo.empty();
    Texels denoised = render.radiance;
    const auto setImage = [&](const char* name, const Texels& texels) {
        // The library writes only to "output", whose texels are not const
        oidn.setSharedFilterImage(filter.get(), name, const_cast<float*>(texels.data()), kFormatFloat3,
                                  render.size.width, render.size.height, 0, 4 * sizeof(float), 0);
    };
    setImage("color", render.radiance);
    setImage("albedo", hasPlanes ? planes.albedo : render.albedo);
    setImage("normal", hasPlanes ? planes.normal : render.normal);
    setImage("output", denoised);
    oidn.setFilterBool(filter.get(), "hdr", true);
    if (hasPlanes) oidn.setFilterBool(filter.get(), "cleanAux", true);
    oidn.commitFilter(filter.get());
    oidn.executeFilter(filter.get());
    oidn.RequireSuccess(device.get(), filter.get());
    return denoised;
}

}  // namespace raygraph::session
