#include "renderer/graph/pass_harness.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/text.h"

namespace raygraph::testing {

namespace {

enum class Component : uint8_t { Unorm8, Unorm16, Half, Float, Uint32 };

struct Layout {
    uint32_t channelCount = 0;
    Component component = Component::Float;
    bool isBgra = false;
};

Layout LayoutOf(rhi::Format format) {
    using rhi::Format;
    switch (format) {
        case Format::R8Unorm:
            return {1, Component::Unorm8};
        case Format::Rg8Unorm:
            return {2, Component::Unorm8};
        case Format::Rgba8Unorm:
        case Format::Rgba8Srgb:
            return {4, Component::Unorm8};
        case Format::Bgra8Unorm:
        case Format::Bgra8Srgb:
            return {4, Component::Unorm8, true};
        case Format::Rgba16Unorm:
            return {4, Component::Unorm16};
        case Format::R16Float:
            return {1, Component::Half};
        case Format::Rgba16Float:
            return {4, Component::Half};
        case Format::R32Uint:
            return {1, Component::Uint32};
        case Format::Rg32Uint:
            return {2, Component::Uint32};
        case Format::Rgba32Uint:
            return {4, Component::Uint32};
        case Format::R32Float:
        case Format::D32Float:
            return {1, Component::Float};
        case Format::Rg32Float:
            return {2, Component::Float};
        case Format::Rgba32Float:
            return {4, Component::Float};
        default:  // blocks, which no pass writes
            break;
    }
    return {};
}

// Decodes IEEE 754 binary16.
float FromHalf(uint16_t half) {
    const uint32_t exponent = (half >> 10) & 0x1fu;
    const auto mantissa = static_cast<float>(half & 0x3ffu);
    const float sign = (half & 0x8000u) != 0 ? -1.0f : 1.0f;
    if (exponent == 31) return mantissa == 0.0f ? sign * INFINITY : NAN;
    if (exponent == 0) return sign * std::ldexp(mantissa, -24);
    return sign * std::ldexp(1024.0f + mantissa, static_cast<int>(exponent) - 25);
}

// Rounds to nearest even; values that are too large become infinite.
uint16_t ToHalf(float value) {
    const uint16_t sign = std::signbit(value) ? 0x8000u : 0u;
    const float size = std::fabs(value);
    if (std::isnan(value)) return 0x7e00u;
    if (size >= 65520.0f) return static_cast<uint16_t>(sign | 0x7c00u);
    int exponent = 0;
    std::frexp(size, &exponent);
    const int scale = std::max(exponent - 1, -14);
    const auto mantissa = static_cast<uint32_t>(std::nearbyint(std::ldexp(size, 10 - scale)));
    // A mantissa that rounds up to 2048 carries into the exponent.
    const uint32_t base = size == 0.0f || mantissa < 1024 ? 0u : static_cast<uint32_t>(scale + 14) << 10;
    return static_cast<uint16_t>(sign | (base + mantissa));
}

template <typename T>
T Load(const std::byte* from) {
    T value;
    std::memcpy(&value, from, sizeof value);
    return value;
}

template <typename T>
void Store(std::byte* to, T value) {
    std::memcpy(to, &value, sizeof value);
}

float DecodeComponent(const std::byte* from, Component component) {
    switch (component) {
        case Component::Unorm8:
            return static_cast<float>(Load<uint8_t>(from)) / 255.0f;
        case Component::Unorm16:
            return static_cast<float>(Load<uint16_t>(from)) / 65535.0f;
        case Component::Half:
            return FromHalf(Load<uint16_t>(from));
        case Component::Float:
            return Load<float>(from);
        case Component::Uint32:
            return static_cast<float>(Load<uint32_t>(from));
    }
    return 0.0f;
}

void EncodeComponent(std::byte* to, Component component, float value) {
    // Not a number is 0.
    const auto scaled = [&](float most) {
        return value > 0.0f ? std::min(std::round(value * most), most) : 0.0f;
    };
    switch (component) {
        case Component::Unorm8:
            Store(to, static_cast<uint8_t>(scaled(255.0f)));
            break;
        case Component::Unorm16:
            Store(to, static_cast<uint16_t>(scaled(65535.0f)));
            break;
        case Component::Half:
            Store(to, ToHalf(value));
            break;
        case Component::Float:
            Store(to, value);
            break;
        case Component::Uint32:
            Store(to, !(value > 0.0f)          ? 0u
                      : value >= 4294967296.0f ? 0xffffffffu
                                               : static_cast<uint32_t>(value));
            break;
    }
}

std::string SizeText(Extent2D extent, rhi::Format format) {
    return Text("{}x{} {}", extent.width, extent.height, rhi::Name(format));
}

// Returns the position of channel c in a texel: BGRA formats keep red third.
uint32_t Place(const Layout& layout, uint32_t c) {
    return layout.isBgra && c < 3 ? 2 - c : c;
}

}  // namespace

std::span<const float> Texels::At(uint32_t x, uint32_t y) const {
    if (x >= extent.width || y >= extent.height)
        throw MakeError(ErrorKind::Usage, "Texels::At({}, {}): there are {}x{}", x, y, extent.width,
                        extent.height);
    return std::span(values).subspan((size_t{y} * extent.width + x) * channelCount, channelCount);
}

uint32_t ChannelCount(rhi::Format format) {
    return LayoutOf(format).channelCount;
}

Texels DecodeTexels(std::span<const std::byte> bytes, Extent2D extent, rhi::Format format) {
    const Layout layout = LayoutOf(format);
    const size_t texelCount = size_t{extent.width} * extent.height;
    const size_t texelBytes = rhi::TexelBytes(format);
    if (bytes.size() != texelCount * texelBytes)
        throw MakeError(ErrorKind::Usage, "DecodeTexels: {} bytes for {}", bytes.size(),
                        SizeText(extent, format));
    Texels texels{.extent = extent, .channelCount = layout.channelCount, .values = {}};
    texels.values.reserve(texelCount * layout.channelCount);
    const size_t componentBytes = layout.channelCount == 0 ? 0 : texelBytes / layout.channelCount;
    for (size_t texel = 0; texel < texelCount; ++texel)
        for (uint32_t c = 0; c < layout.channelCount; ++c)
            texels.values.push_back(DecodeComponent(
                bytes.data() + texel * texelBytes + Place(layout, c) * componentBytes, layout.component));
    return texels;
}

std::vector<std::byte> EncodeTexels(std::span<const float> values, Extent2D extent, rhi::Format format) {
    const Layout layout = LayoutOf(format);
    const size_t texelCount = size_t{extent.width} * extent.height;
    const size_t texelBytes = rhi::TexelBytes(format);
    const bool isOneTexel = values.size() == layout.channelCount;
    if (layout.channelCount == 0 || (!isOneTexel && values.size() != texelCount * layout.channelCount))
        throw MakeError(ErrorKind::Usage, "EncodeTexels: {} values for {}, which has {}", values.size(),
                        SizeText(extent, format), texelCount * layout.channelCount);
    std::vector<std::byte> bytes(texelCount * texelBytes);
    const size_t componentBytes = texelBytes / layout.channelCount;
    for (size_t texel = 0; texel < texelCount; ++texel)
        for (uint32_t c = 0; c < layout.channelCount; ++c)
            EncodeComponent(bytes.data() + texel * texelBytes + Place(layout, c) * componentBytes,
                            layout.component, values[(isOneTexel ? 0 : texel * layout.channelCount) + c]);
    return bytes;
}

PassHarness::PassHarness(rhi::Device& device, const RendererDesc& desc) : m_renderer(device, desc) {}

TextureId PassHarness::Texture(std::string_view name, Extent2D extent, rhi::Format format,
                               std::span<const float> values) {
    return Texture(name, {.extent = extent, .format = format}, values);
}

TextureId PassHarness::Texture(std::string_view name, const GraphTextureDesc& desc,
                               std::span<const float> values) {
    struct Piece {
        uint32_t level = 0, layer = 0;
        size_t offset = 0;
    };
    // A multiple of every texel's size, and of 4 as copies require.
    constexpr size_t kAlignment = 16;
    TextureId texture = m_renderer.CreateTexture(name, desc);
    std::vector<Piece> pieces;
    std::vector<std::byte> bytes;
    const bool isOneTexel = values.size() == ChannelCount(desc.format);
    std::span<const float> rest = values;
    for (uint32_t layer = 0; layer < desc.layers; ++layer)
        for (uint32_t level = 0; level < desc.levels; ++level) {
            const Extent2D extent = rhi::MipExtent(desc.extent, level);
            const bool isLast = layer + 1 == desc.layers && level + 1 == desc.levels;
            // The last subresource takes all that is left; EncodeTexels reports a wrong number.
            size_t count = size_t{extent.width} * extent.height * ChannelCount(desc.format);
            if (isOneTexel || isLast || count > rest.size()) count = rest.size();
            const std::vector<std::byte> piece = EncodeTexels(rest.first(count), extent, desc.format);
            if (!isOneTexel) rest = rest.subspan(count);
            bytes.resize((bytes.size() + kAlignment - 1) / kAlignment * kAlignment);
            pieces.push_back({level, layer, bytes.size()});
            bytes.insert(bytes.end(), piece.begin(), piece.end());
        }
    const BufferId staging = Buffer(std::string(name) + " texels", bytes);
    m_renderer.AddPass(
        "Fill " + std::string(name), PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(staging);
            texture = pass.CopiesTo(texture);
        },
        [staging, texture, pieces](CommandList& commands, const PassResources& resources) {
            for (const Piece& piece : pieces)
                commands.CopyToTexture(resources.Buffer(staging), piece.offset, resources.Texture(texture),
                                       piece.level, piece.layer);
        });
    return texture;
}

BufferId PassHarness::Buffer(std::string_view name, std::span<const std::byte> bytes) {
    const BufferId staging = m_renderer.CreateBuffer(
        std::string(name) + " bytes", {.size = bytes.size(), .memory = rhi::MemoryKind::Upload});
    BufferId buffer = m_renderer.CreateBuffer(name, {.size = bytes.size()});
    m_renderer.AddPass(
        "Fill " + std::string(name), PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(staging);
            buffer = pass.CopiesTo(buffer);
        },
        [staging, buffer, data = std::vector<std::byte>(bytes.begin(), bytes.end())](
            CommandList& commands, const PassResources& resources) {
            const rhi::Buffer& source = resources.Buffer(staging);
            std::copy(data.begin(), data.end(), source.Mapped().begin());
            commands.CopyBuffer(source, 0, resources.Buffer(buffer), 0, data.size());
        });
    return buffer;
}

Texels PassHarness::Run(const std::function<TextureId(PassHarness&)>& declare) {
    m_renderer.BeginFrame();
    const Readback readback = m_renderer.ReadBack(declare(*this));
    m_renderer.Execute();
    readback.Wait();
    return DecodeTexels(readback.Bytes(), readback.Extent(), readback.Format());
}

std::vector<Texels> PassHarness::RunAll(const std::function<TextureId(PassHarness&)>& declare) {
    m_renderer.BeginFrame();
    const TextureId texture = declare(*this);
    const GraphTextureDesc desc = m_renderer.Desc(texture);
    std::vector<Readback> readbacks;
    for (uint32_t layer = 0; layer < desc.layers; ++layer)
        for (uint32_t level = 0; level < desc.levels; ++level)
            readbacks.push_back(m_renderer.ReadBack(texture, level, layer));
    m_renderer.Execute();
    std::vector<Texels> all;
    for (const Readback& readback : readbacks) {
        readback.Wait();
        all.push_back(DecodeTexels(readback.Bytes(), readback.Extent(), readback.Format()));
    }
    return all;
}

std::vector<std::byte> PassHarness::RunBytes(const std::function<BufferId(PassHarness&)>& declare) {
    m_renderer.BeginFrame();
    const Readback readback = m_renderer.ReadBack(declare(*this));
    m_renderer.Execute();
    readback.Wait();
    const std::span<const std::byte> bytes = readback.Bytes();
    return {bytes.begin(), bytes.end()};
}

}  // namespace raygraph::testing
