#include "editor/session/verify/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "base/files.h"
#include "base/text.h"
#include "editor/session/settings/as_input.h"
#include "editor/session/settings/parse.h"
#include "renderer/image/exr.h"
#include "renderer/image/image.h"
#include "renderer/image/radiance_hdr.h"
#include "shaders/core/color.glsl"

namespace raygraph::session {

float Transfer::Decode(float code) const {
    switch (curve) {
        case TransferCurve::Srgb:
            return shading::SrgbDecode(code);
        case TransferCurve::Linear:
            return code;
        case TransferCurve::Gamma:
            return std::pow(std::max(code, 0.0f), gamma);
    }
    return code;
}

float Transfer::Encode(float linear) const {
    switch (curve) {
        case TransferCurve::Srgb:
            return shading::SrgbEncode(linear);
        case TransferCurve::Linear:
            return linear;
        case TransferCurve::Gamma:
            return std::pow(std::max(linear, 0.0f), 1.0f / gamma);
    }
    return linear;
}

Transfer ParseTransfer(std::string_view text) {
    constexpr std::string_view kGamma = "gamma:";
    if (text.starts_with(kGamma))
        return {.curve = TransferCurve::Gamma,
                .gamma = static_cast<float>(ParseNumber(text.substr(kGamma.size()), 1.0, 4.0))};
    if (text == Name(TransferCurve::Srgb)) return {};
    if (text == Name(TransferCurve::Linear)) return {.curve = TransferCurve::Linear};
    throw MakeError(ErrorKind::Usage, "{} is neither srgb, linear nor gamma:G", Quoted(text));
}

std::string ToText(const Transfer& transfer) {
    std::string text = Name(transfer.curve);
    return transfer.curve == TransferCurve::Gamma ? text + ":" + ToText(transfer.gamma) : text;
}

float Picture::RoundingVariance(float value) const {
    if (!transfer) return 0.0f;
    const float scale = std::exp2(transfer->exposureEv);
    const float code = std::clamp(transfer->Encode(value * scale), 0.0f, 1.0f);
    const float low = transfer->Decode(std::max(code - 0.5f / 255.0f, 0.0f)),
                high = transfer->Decode(std::min(code + 0.5f / 255.0f, 1.0f));
    const float step = (high - low) / scale;
    return step * step / 12.0f;
}

namespace {

Picture FromPng(const std::vector<std::byte>& bytes, const std::filesystem::path& path,
                const Transfer& transfer) {
    const image::Image8 image = image::DecodeImage8(bytes, Printable(path.string(), 1024));
    Picture picture{.size = {image.width, image.height}, .transfer = transfer};
    const float scale = std::exp2(-transfer.exposureEv);
    std::array<float, 256> radianceOf;
    for (size_t code = 0; code < 256; ++code)
        radianceOf[code] = transfer.Decode(static_cast<float>(code) / 255.0f) * scale;
    picture.radiance.resize(image.rgba.size());
    std::ranges::transform(image.rgba, picture.radiance.begin(),
                           [&](uint8_t code) { return radianceOf[code]; });
    // The last step belongs to white, too: it is where rounding and clipping meet.
    picture.white = radianceOf[254];
    return picture;
}

// Adds what an .exr has beside its colors. Outside its data window there is no noise.
void AddVariance(const image::ExrImage& file, Picture& picture) {
    const std::vector<float>* variance[3] = {};
    for (size_t c = 0; c < 3; ++c) {
        variance[c] = file.FloatChannel(std::string("variance.") + "RGB"[c]);
        if (variance[c] == nullptr) return;
    }
    const std::vector<uint32_t>* samples = file.UintChannel("samples");
    if (samples == nullptr || samples->empty()) return;
    Texels all(picture.radiance.size(), 0.0f);
    uint64_t sum = 0;
    for (size_t i = 0; i < samples->size(); ++i) {
        sum += (*samples)[i];
        // The variance of a single sample says nothing
        if ((*samples)[i] < 2) return;
        const int64_t x = int64_t{file.window.x} + int64_t(i % file.width),
                      y = int64_t{file.window.y} + int64_t(i / file.width);
        if (x < 0 || y < 0 || x >= picture.size.width || y >= picture.size.height) continue;
        for (size_t c = 0; c < 3; ++c) {
            const float value = std::max(0.0f, (*variance[c])[i]) / static_cast<float>((*samples)[i]);
            if (!std::isfinite(value)) return;
            all[4 * (size_t(y) * picture.size.width + size_t(x)) + c] = value;
        }
    }
    picture.variance = std::move(all);
    picture.samples = sum / samples->size();
}

// Returns the depth of an .exr that has nothing else; none: it has colors.
std::optional<Texels> DepthAlone(const image::ExrImage& file) {
    const std::vector<float>* depth = file.FloatChannel("Z");
    const auto isColor = [](const image::ExrChannel& channel) {
        return channel.name == "Y" || channel.name == "R" || channel.name.ends_with(".R");
    };
    if (depth == nullptr || std::ranges::any_of(file.channels, isColor)) return std::nullopt;
    Texels texels(4 * depth->size(), 1.0f);
    for (size_t i = 0; i < texels.size(); ++i)
        if (i % 4 != 3) texels[i] = std::isinf((*depth)[i / 4]) ? 0.0f : (*depth)[i / 4];
    return texels;
}

}  // namespace

Picture ReadPicture(const std::filesystem::path& path, const Transfer& transfer, const Log& log) {
    return AsInput([&] {
        const std::vector<std::byte> bytes = ReadFile(path);
        const image::FileFormat format = image::SniffFormat(bytes);
        const std::string name = Printable(path.string(), 1024);
        Picture picture;
        switch (format) {
            case image::FileFormat::Png:
                picture = FromPng(bytes, path, transfer);
                break;
            case image::FileFormat::Hdr: {
                image::Environment read = image::DecodeFloats(bytes, name);
                picture.size = {read.image.width, read.image.height};
                picture.radiance = std::move(read.image.rgba);
                const float exposure = image::HdrExposure(bytes, name);
                if (!(exposure > 0.0f))
                    throw MakeError(ErrorKind::BadInput, "{}: EXPOSURE is not above 0", path);
                for (size_t i = 0; i < picture.radiance.size(); ++i)
                    if (i % 4 != 3) picture.radiance[i] /= exposure;
                break;
            }
            case image::FileFormat::Exr: {
                const image::ExrImage file = image::DecodeExr(bytes, name);
                if (std::optional<Texels> depth = DepthAlone(file)) {
                    picture.size = {file.width, file.height};
                    picture.radiance = std::move(*depth);
                    break;
                }
                image::Environment read = image::DecodeFloats(bytes, name);
                for (const std::string& warning : read.warnings)
                    log.Send(LogLevel::Warning, log_category::kScene, warning);
                picture.size = {read.image.width, read.image.height};
                picture.radiance = std::move(read.image.rgba);
                AddVariance(file, picture);
                break;
            }
            default:
                throw MakeError(ErrorKind::BadInput, "{}: neither a PNG, a Radiance HDR nor an OpenEXR",
                                path);
        }
        picture.name = path.string();
        return picture;
    });
}

Picture PictureOf(const RenderFile& render, std::string name) {
    Picture picture{.name = std::move(name), .size = render.size, .radiance = render.radiance};
    picture.samples = SampleCount(render.samples);
    if (render.variance.empty() || picture.samples < 2) return picture;
    picture.variance = render.variance;
    for (size_t i = 0; i < picture.variance.size(); ++i) {
        const uint64_t samples = render.adaptive ? render.adaptive->counts[i / 4] : picture.samples;
        picture.variance[i] /= static_cast<float>(std::max<uint64_t>(samples, 1));
    }
    return picture;
}

}  // namespace raygraph::session
