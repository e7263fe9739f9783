// Picture is a finished picture that is compared with another one: this program's or any renderer's, in
// linear radiance. Threads: plain values and functions of files, for any thread.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "base/api.h"
#include "base/log.h"
#include "editor/session/file/render_file.h"
#include "shaders/shared/choice.h"

namespace raygraph::session {

#define RAYGRAPH_TRANSFER_CURVES(X, Of)       \
    X(Of, Srgb, 0, "srgb", "IEC 61966-2-1")   \
    X(Of, Linear, 1, "linear", "not encoded") \
    X(Of, Gamma, 2, "gamma", "a power, as gamma:2.2")
RAYGRAPH_CHOICE(TransferCurve, RAYGRAPH_TRANSFER_CURVES)

// Says how the code values of a picture of integers follow from radiance: code = encode(radiance * 2^EV), cut
// at 1.
struct RAYGRAPH_API Transfer {
    TransferCurve curve = TransferCurve::Srgb;
    float gamma = 2.2f;  // only of Gamma: encode(x) = x^(1 / gamma)
    float exposureEv = 0.0f;

    float Decode(float code) const;  // code in [0, 1]; without the exposure
    float Encode(float linear) const;
    bool operator==(const Transfer&) const = default;
};

// Parses "srgb", "linear" or "gamma:G" with G from 1 to 4. Throws Error{Usage} that quotes the text.
RAYGRAPH_API Transfer ParseTransfer(std::string_view text);
RAYGRAPH_API std::string ToText(const Transfer& transfer);

struct RAYGRAPH_API Picture {
    std::string name;  // for messages
    Extent2D size;
    Texels radiance;  // linear; alpha has no meaning
    // Variance of the radiance as it is, which is the mean of samples; w has no meaning. Empty: not known.
    Texels variance;
    uint64_t samples = 0;  // samples of a pixel; 0: not known
    // Radiance from which on all values look alike, for a picture of integers.
    float white = std::numeric_limits<float>::infinity();
    std::optional<Transfer> transfer;  // of a picture of integers with eight bits; none: of floats

    // Returns the variance that rounding to eight bits adds at this radiance; 0 for a picture of floats.
    float RoundingVariance(float radiance) const;
};

// Reads a .png by the transfer function, and a .hdr or an .exr (scan lines or tiles, R, G and B or Y) as it
// is, or an .exr with Z alone as depth, which is 0 where Z is infinite. A .hdr is divided by its EXPOSURE. An
// .exr with variance.R, G and B of one sample and `samples`, as this program writes, has variance. Throws
// Error{BadInput} that names the file, also if it cannot be read.
RAYGRAPH_API Picture ReadPicture(const std::filesystem::path& path, const Transfer& transfer = {},
                                 const Log& log = {});

// Returns the picture of a render.
RAYGRAPH_API Picture PictureOf(const RenderFile& render, std::string name);

}  // namespace raygraph::session
