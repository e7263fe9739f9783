#include "renderer/gpu_scene/environment_upload.h"

#include "renderer/gpu_scene/device_limits.h"

namespace raygraph {

namespace {

// `texel` has the format's size.
rhi::Texture SolidTexture(rhi::Device& device, rhi::Uploader& uploader, const char* name, rhi::Format format,
                          std::span<const std::byte> texel) {
    rhi::Texture texture = device.CreateTexture({.name = name, .extent = {1, 1}, .format = format});
    uploader.UploadTexture(texture, texel);
    return texture;
}

rhi::Buffer UploadAlias(rhi::Device& device, rhi::Uploader& uploader, const EnvironmentAlias& alias) {
    RequireBindable(device, "entries of the environment's table", alias.entries.size(),
                    sizeof(alias.entries[0]));
    const std::span<const std::byte> bytes = std::as_bytes(std::span(alias.entries));
    rhi::Buffer buffer =
        device.CreateBuffer({.name = "environment alias",
                             .size = bytes.size(),
                             .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::CopySource |
                                      rhi::BufferUsage::CopyDestination});
    uploader.UploadBuffer(buffer, 0, bytes);
    return buffer;
}

}  // namespace

rhi::Texture WhiteTexture(rhi::Device& device, rhi::Uploader& uploader) {
    const uint32_t white = 0xFFFFFFFFu;
    return SolidTexture(device, uploader, "white", rhi::Format::Rgba8Unorm,
                        std::as_bytes(std::span(&white, 1)));
}

EnvironmentOnDevice UploadEnvironment(rhi::Device& device, rhi::Uploader& uploader,
                                      const image::ImageF& map) {
    EnvironmentOnDevice result;
    result.map = device.CreateTexture(
        {.name = "environment map", .extent = {map.width, map.height}, .format = rhi::Format::Rgba32Float});
    const EnvironmentAlias alias = BuildEnvironmentAlias(map);
    result.alias = UploadAlias(device, uploader, alias);
    uploader.UploadTexture(result.map, std::as_bytes(std::span(map.rgba)));
    result.cells = {alias.width, alias.height};
    result.meanRadiance = alias.meanRadiance;
    return result;
}

EnvironmentOnDevice BlankEnvironment(rhi::Device& device, rhi::Uploader& uploader) {
    const glm::vec4 black(0.0f);
    EnvironmentOnDevice result;
    result.map = SolidTexture(device, uploader, "no environment map", rhi::Format::Rgba32Float,
                              std::as_bytes(std::span(&black, 1)));
    result.alias = UploadAlias(device, uploader, ConstantEnvironmentAlias());
    return result;
}

}  // namespace raygraph
