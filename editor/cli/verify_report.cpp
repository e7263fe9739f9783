#include "editor/cli/verify_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "editor/cli/difference_report.h"

namespace raygraph::cli {

namespace {

using Json = nlohmann::ordered_json;

Json PictureJson(const VerifiedPicture& verified) {
    const session::Verdict& verdict = verified.result.verdict;
    Json json{{"scene", verified.scene},
              {"picture", verified.picture.name},
              {"width", verified.picture.size.width},
              {"height", verified.picture.size.height},
              {"right", verdict.isRight},
              {"accepted_now", verified.isAccepted},
              {"accepted", verified.accepted},
              {"decided", verdict.isDecided},
              {"reference_samples", verified.result.referenceSamples},
              {"new_samples", verified.result.newSamples},
              {"noise", verdict.isNoiseEstimated ? "estimated" : "known"},
              {"picture_samples", verdict.isNoiseEstimated ? Json(verdict.pictureSamples) : Json()}};
    for (const session::VerdictCheck& check : verdict.checks)
        json["checks"].push_back({{"name", check.name},
                                  {"value", check.value},
                                  {"limit", check.limit},
                                  {"where", check.where},
                                  {"passed", check.isPassed}});
    json["difference"] = DifferenceJson(verdict.difference);
    json["difference"]["flip_of_noise"] = verdict.flipOfNoise;
    json["difference"]["ssim_of_noise"] = verdict.ssimOfNoise;
    json["hypotheses"] = Json::array();
    for (const session::Hypothesis& hypothesis : verified.result.diagnosis.hypotheses)
        json["hypotheses"].push_back({{"kind", hypothesis.kind},
                                      {"name", hypothesis.name},
                                      {"text", hypothesis.text},
                                      {"explained", hypothesis.explained},
                                      {"amount", hypothesis.amount}});
    json["projections"] = Json::array();
    for (const session::Projection& projection : verdict.projections) {
        constexpr size_t kMost = 16;
        if (projection.error <= 0.0 || json["projections"].size() == kMost) break;
        json["projections"].push_back({{"kind", projection.kind},
                                       {"name", projection.name},
                                       {"part", projection.part},
                                       {"amount", projection.amount},
                                       {"z", projection.z},
                                       {"error", projection.error}});
    }
    json["parts"] = Json::array();
    for (const session::PartFit& part : verified.result.diagnosis.parts)
        json["parts"].push_back({{"kind", part.kind},
                                 {"name", part.name},
                                 {"share", part.share},
                                 {"amount", part.amount},
                                 {"standard_error", part.standardError}});
    json["objects"] = Json::array();
    for (const session::ObjectShare& object : verified.result.diagnosis.objects)
        json["objects"].push_back({{"kind", object.kind},
                                   {"name", object.name},
                                   {"share", object.share},
                                   {"area", object.area},
                                   {"relative_error", object.relativeError}});
    json["worst_tiles"] = Json::array();
    for (const session::VerdictTile& tile : WorstTiles(verdict))
        json["worst_tiles"].push_back({{"x", tile.x},
                                       {"y", tile.y},
                                       {"width", tile.width},
                                       {"height", tile.height},
                                       {"relative_error", tile.relativeError},
                                       {"z", tile.z},
                                       {"excess", tile.excess}});
    json["worst_pixels"] = Json::array();
    for (const session::VerdictPixel& pixel : verdict.worstPixels)
        json["worst_pixels"].push_back({{"x", pixel.x},
                                        {"y", pixel.y},
                                        {"excess", pixel.excess},
                                        {"reference", pixel.reference},
                                        {"picture", pixel.picture},
                                        {"explain", ExplainCommandOf(verified, pixel)}});
    return json;
}

}  // namespace

std::vector<session::VerdictTile> WorstTiles(const session::Verdict& verdict) {
    std::vector<session::VerdictTile> tiles = verdict.tiles;
    std::erase_if(tiles, [](const session::VerdictTile& tile) { return tile.excess <= 1.0; });
    std::ranges::sort(tiles, std::greater{}, &session::VerdictTile::excess);
    constexpr size_t kMost = 8;
    if (tiles.size() > kMost) tiles.resize(kMost);
    return tiles;
}

std::string ExplainCommandOf(const VerifiedPicture& verified, const session::VerdictPixel& pixel) {
    if (verified.explain.empty()) return {};
    return Text("{} --pixel {},{}", verified.explain, verified.originX + pixel.x, verified.originY + pixel.y);
}

std::string DescribeVerdict(const VerifiedPicture& verified) {
    const std::string found =
        verified.result.verdict.isRight && !verified.accepted.empty()
            ? Text("right, with the accepted difference {}", Printable(verified.accepted, 1024))
        : verified.isAccepted && !verified.result.verdict.isRight ? "not right, accepted now"
                                                                  : "";
    std::string text = session::Describe(verified.result, verified.picture.name, found);
    if (!verified.result.verdict.isDecided) text += " (--spp)";
    return text;
}

std::string VerifyJson(const std::vector<VerifiedPicture>& pictures) {
    Json json{{"schema", 1}};
    json["right"] = std::ranges::all_of(pictures, [](const VerifiedPicture& picture) {
        return picture.error.empty() && picture.result.verdict.isRight;
    });
    json["pictures"] = json["errors"] = Json::array();
    for (const VerifiedPicture& picture : pictures) {
        if (picture.error.empty())
            json["pictures"].push_back(PictureJson(picture));
        else
            json["errors"].push_back(
                {{"scene", picture.scene}, {"picture", picture.picture.name}, {"error", picture.error}});
    }
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace raygraph::cli
