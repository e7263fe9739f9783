// A stand-in for Open Image Denoise, of version OIDN_VERSION. It checks in which order and with what it is
// called, and returns a sum from which each input can be told. RAYGRAPH_FAIL names a step that fails.
#include <cstdlib>
#include <map>
#include <string>

#if OIDN_VERSION == 1
#define oidnSetFilterBool oidnSetFilter1b
#endif

namespace {

struct Device {
    bool isCommitted = false;
};

struct Filter {
    std::map<std::string, float*> images;
    std::map<std::string, bool> flags;
    bool isCommitted = false;
};

std::string error;

void Require(bool holds, const char* what) {
    if (!holds && error.empty()) error = std::string("not so: ") + what;
}

bool Fails(const std::string& step) {
    const char* failing = std::getenv("RAYGRAPH_FAIL");
    if (failing && failing == step) error = "no " + step;
    return !error.empty();
}

}  // namespace

extern "C" {

Device* oidnNewDevice(int type) {
    Require(type == 1, "a CPU is asked for");
    return Fails("device") ? nullptr : new Device;
}

void oidnCommitDevice(Device* device) {
    device->isCommitted = true;
}

int oidnGetDeviceError(Device*, const char** message) {
    *message = error.empty() ? nullptr : error.c_str();
    return error.empty() ? 0 : 1;
}

void oidnReleaseDevice(Device* device) {
    delete device;
}

Filter* oidnNewFilter(Device* device, const char* type) {
    Require(device->isCommitted && type == std::string("RT"), "the device is committed, the filter is RT");
    return Fails("filter") ? nullptr : new Filter;
}

void oidnSetSharedFilterImage(Filter* filter, const char* name, void* data, int format, size_t width,
                              size_t height, size_t byteOffset, size_t bytePixelStride,
                              size_t byteRowStride) {
    Require(format == 3 && width == 9 && height == 7, "images have three floats and the size of the render");
    Require(byteOffset == 0 && bytePixelStride == 16 && byteRowStride == 0, "pixels are 16 bytes apart");
    filter->images[name] = static_cast<float*>(data);
    filter->isCommitted = false;
}

void oidnSetFilterBool(Filter* filter, const char* name, bool value) {
    filter->flags[name] = value;
    filter->isCommitted = false;
}

void oidnCommitFilter(Filter* filter) {
    filter->isCommitted = true;
}

void oidnExecuteFilter(Filter* filter) {
    Require(filter->isCommitted && filter->flags["hdr"], "the filter is committed after all is set");
    Require(filter->images.size() == 4, "there are four images");
    if (Fails("execute")) return;
    const float clean = filter->flags["cleanAux"] ? 8.0f : 0.0f;
    for (size_t i = 0; i < 9 * 7 * 4; ++i)
        if (i % 4 != 3)
            filter->images["output"][i] = filter->images["color"][i] + 2.0f * filter->images["albedo"][i] +
                                          4.0f * filter->images["normal"][i] + clean;
}

void oidnReleaseFilter(Filter* filter) {
    delete filter;
}

}  // extern "C"
