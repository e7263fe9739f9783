#include "editor/cli/difference_report.h"

#include <nlohmann/json.hpp>

#include "base/text.h"

namespace raygraph::cli {

namespace {

using Json = nlohmann::ordered_json;

// Returns picture / reference - 1 by channel; null where the reference is black.
Json EnergyOf(const session::PictureDifference& difference) {
    Json energy = Json::array();
    for (size_t c = 0; c < 3; ++c) {
        const double reference = difference.meanOfReference[c];
        energy.push_back(reference > 0.0 ? Json(difference.mean[c] / reference - 1.0) : Json());
    }
    return energy;
}

}  // namespace

std::string DescribeDifference(const session::PictureDifference& difference) {
    std::string text = Text("relMSE  {:.4g}", difference.relMse);
    if (difference.z) text += Text("; noise alone gives {:.4g}", difference.relMseOfNoise);
    text += Text("\nFLIP    {:.4f}\nSSIM    {:.4f}\nenergy ", difference.flip, difference.ssim);
    for (size_t c = 0; c < 3; ++c) {
        const double reference = difference.meanOfReference[c], mean = difference.mean[c];
        text += Text("{} {} ", c == 0 ? "" : ",", "RGB"[c]);
        text += reference > 0.0 ? Text("{:+.2f} %", 100.0 * (mean / reference - 1.0))
                                : Text("{:.3g} against 0", mean);
    }
    text += '\n';
    if (difference.z) {
        text += Text("z       {:.2f} rms, {:.2f} % beyond 3; of the mean: R {:+.1f}, G {:+.1f}, B {:+.1f}",
                     difference.z->rms, 100.0 * difference.z->beyondThree, difference.z->ofMean[0],
                     difference.z->ofMean[1], difference.z->ofMean[2]);
        if (difference.z->differsWithoutNoise > 0)
            text += Text("; {} where there is no noise",
                         Counted(difference.z->differsWithoutNoise, "difference"));
        text += difference.z->isOfBoth ? "\n" : "; the noise of one picture alone is known\n";
    }
    return text;
}

Json DifferenceJson(const session::PictureDifference& difference) {
    Json json{{"relmse", difference.relMse},   {"relmse_of_noise", difference.relMseOfNoise},
              {"flip", difference.flip},       {"ssim", difference.ssim},
              {"mean", difference.mean},       {"reference_mean", difference.meanOfReference},
              {"energy", EnergyOf(difference)}};
    json["z"] = difference.z ? Json{{"rms", difference.z->rms},
                                    {"beyond_three", difference.z->beyondThree},
                                    {"of_mean", difference.z->ofMean},
                                    {"differs_without_noise", difference.z->differsWithoutNoise},
                                    {"of_both", difference.z->isOfBoth}}
                             : Json();
    return json;
}

std::string CompareJson(const session::Picture& reference, const session::Picture& picture,
                        const session::PictureDifference& difference) {
    Json json{{"schema", 1},
              {"reference", reference.name},
              {"picture", picture.name},
              {"width", picture.size.width},
              {"height", picture.size.height}};
    json.update(DifferenceJson(difference));
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace raygraph::cli
