#include "renderer/gpu_scene/lights/environment_upload.h"

#include "renderer/gpu_scene/device_limits.h"

namespace raygraph {

namespace {

// `texel` is one texel of the format.
rhi::Texture SolidTexture(rhi::Device& device, rhi::Uploader& uploader, const char* name, rhi::Format format,
                          std::span<const std::byte> texel) {
    rhi::Texture texture = device.CreateTexture({.name = name, .extent = {1, 1}, .format = format});
    uploader.UploadTexture(texture, texel);
    return texture;
}

rhi::Buffer UploadTable(rhi::Device& device, rhi::Uploader& uploader, const EnvironmentTable& table) {
    RequireBindable(device, "entries of the environment's table", table.entries.size(),
                    sizeof(table.entries[0]));
    const std::span<const std::byte> bytes = std::as_bytes(std::span(table.entries));
    rhi::Buffer buffer =
        device.CreateBuffer({.name = "environment table",
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
    const EnvironmentTable table = BuildEnvironmentTable(map);
    result.table = UploadTable(device, uploader, table);
    uploader.UploadTexture(result.map, std::as_bytes(std::span(map.rgba)));
    result.cells = {table.width, table.height};
    result.meanRadiance = table.meanRadiance;
    return result;
}

EnvironmentOnDevice BlankEnvironment(rhi::Device& device, rhi::Uploader& uploader) {
    const glm::vec4 black(0.0f);
    EnvironmentOnDevice result;
    result.map = SolidTexture(device, uploader, "no environment map", rhi::Format::Rgba32Float,
                              std::as_bytes(std::span(&black, 1)));
    result.table = UploadTable(device, uploader, ConstantEnvironmentTable());
    return result;
}

}  // namespace raygraph
