// The report of `verify` as one page of HTML, with its pictures in it.
#include <algorithm>
#include <span>

#include "base/base64.h"
#include "base/text.h"
#include "editor/cli/verify_report.h"

namespace raygraph::cli {

namespace {

constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>raygraph verify</title><style>
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 1320px }
body { padding: 0 1em; color: #222 }
h2 { margin: 1.5em 0 .3em } .right { color: #176b2c } .wrong { color: #b3261e }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(380px, 1fr)); gap: 12px }
figure { margin: 0 } figcaption { color: #555; margin-top: 2px }
.frame { position: relative } .frame img { width: 100%; display: block; image-rendering: pixelated }
.frame svg { position: absolute; inset: 0; width: 100%; height: 100% }
table { border-collapse: collapse; margin: .6em 0 } td, th { padding: 2px 14px 2px 0; text-align: left }
th { border-bottom: 1px solid #bbb; font-weight: 600 } td.n, th.n { text-align: right }
td.c { font: 13px/1.4 monospace; user-select: all }
.tables { display: flex; flex-wrap: wrap; gap: 0 4em } .best { font-size: 1.15em }
</style></head><body>
)";

std::string Escaped(std::string_view text) {
    std::string escaped;
    for (const char c : Printable(text, 1024)) {
        switch (c) {
            case '&':
                escaped += "&amp;";
                break;
            case '<':
                escaped += "&lt;";
                break;
            case '>':
                escaped += "&gt;";
                break;
            case '"':
                escaped += "&quot;";
                break;
            default:
                escaped += c;
        }
    }
    return escaped;
}

std::string Percent(double share) {
    return Text("{:.2f} %", 100.0 * share);
}

// Makes a table of texts; columns after the first are numbers, but for a last one of commands.
class Table {
  public:
    explicit Table(std::vector<std::string> heads, bool hasCommands = false) : m_hasCommands(hasCommands) {
        Add("th", heads);
    }
    void Row(const std::vector<std::string>& cells) { Add("td", cells); }
    std::string Html() const { return "<table>" + m_rows + "</table>\n"; }

  private:
    void Add(const char* tag, const std::vector<std::string>& cells) {
        m_rows += "<tr>";
        for (size_t i = 0; i < cells.size(); ++i) {
            const bool isCommand = m_hasCommands && i + 1 == cells.size();
            m_rows += Text("<{}{}>{}</{}>", tag,
                           i == 0      ? ""
                           : isCommand ? " class=\"c\""
                                       : " class=\"n\"",
                           Escaped(cells[i]), tag);
        }
        m_rows += "</tr>\n";
    }
    std::string m_rows;
    bool m_hasCommands;
};

std::string Figure(const std::string& caption, const std::vector<std::byte>& png,
                   const std::string& overlay) {
    return "<figure><div class=\"frame\"><img alt=\"" + caption + "\" src=\"data:image/png;base64," +
           EncodeBase64(png) + "\">" + overlay + "</div><figcaption>" + caption + "</figcaption></figure>\n";
}

// Outlines tiles on a picture of that size.
std::string Outlines(const std::vector<session::VerdictTile>& tiles, Extent2D size) {
    std::string svg =
        Text("<svg viewBox=\"0 0 {} {}\" preserveAspectRatio=\"none\">", size.width, size.height);
    for (const session::VerdictTile& tile : tiles)
        svg += Text(
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#ff2d2d\" "
            "stroke-width=\"1.5\" vector-effect=\"non-scaling-stroke\"/>",
            tile.x, tile.y, tile.width, tile.height);
    return svg + "</svg>";
}

std::string Tables(const VerifiedPicture& verified) {
    const session::Verdict& verdict = verified.result.verdict;
    Table checks({"check", "value", "limit", ""});
    for (const session::VerdictCheck& check : verdict.checks) {
        const bool isShare = check.name != "flip" && check.name != "ssim";
        const auto text = [&](double value) { return isShare ? Percent(value) : Text("{:.4f}", value); };
        checks.Row({check.name + (check.where.empty() ? "" : ": " + check.where), text(check.value),
                    (check.name == "ssim" ? "at least " : "") + text(check.limit),
                    check.isPassed ? "passed" : "FAILED"});
    }
    std::string html = checks.Html();
    const session::Diagnosis& diagnosis = verified.result.diagnosis;
    if (!diagnosis.parts.empty()) {
        Table parts({"part of the light", "share", "error of its light", "standard error"});
        for (const session::PartFit& part : diagnosis.parts)
            parts.Row({part.kind + ": " + part.name, Percent(part.share),
                       Text("{:+.1f} %", 100.0 * part.amount), Percent(part.standardError)});
        html += parts.Html();
    }
    if (!diagnosis.objects.empty()) {
        Table objects(
            {"where the difference is", "its share", "share of the pixels", "error of its brightness"});
        // Noise that was subtracted leaves shares below 0 and above 1
        for (const session::ObjectShare& object : diagnosis.objects) {
            if (object.share < 0.005) continue;
            objects.Row({object.kind + " " + object.name, Percent(std::min(object.share, 1.0)),
                         Percent(object.area), Text("{:+.1f} %", 100.0 * object.relativeError)});
        }
        html += objects.Html();
    }
    const std::vector<session::VerdictTile> worst = WorstTiles(verdict);
    if (!worst.empty()) {
        Table tiles({"worst tiles", "error of its brightness", "standard errors", "error / allowed error"});
        for (const session::VerdictTile& tile : worst)
            tiles.Row({Text("{}x{} from {}, {}", tile.width, tile.height, tile.x, tile.y),
                       Text("{:+.1f} %", 100.0 * tile.relativeError), Text("{:+.1f}", tile.z),
                       Text("{:.1f}", tile.excess)});
        html += tiles.Html();
    }
    if (!verdict.worstPixels.empty() && !verdict.isRight) {
        Table pixels({"worst pixels", "reference", "picture", "error / allowed error",
                      "command that explains the reference"},
                     true);
        const auto color = [](const std::array<float, 3>& c) {
            return Text("{:.3g} {:.3g} {:.3g}", c[0], c[1], c[2]);
        };
        for (size_t i = 0; i < std::min<size_t>(verdict.worstPixels.size(), 8); ++i) {
            const session::VerdictPixel& pixel = verdict.worstPixels[i];
            if (pixel.excess <= 1.0) break;  // the worst are first
            pixels.Row({Text("{}, {}", pixel.x, pixel.y), color(pixel.reference), color(pixel.picture),
                        Text("{:.1f}", pixel.excess), ExplainCommandOf(verified, pixel)});
        }
        html += pixels.Html();
    }
    return "<div class=\"tables\">" + html + "</div>\n";
}

std::string Section(const VerifiedPicture& verified) {
    const session::Verdict& verdict = verified.result.verdict;
    std::string html = Text(
        "<h2>{}: <span class=\"{}\">{}</span></h2>\n<p>Against the reference of {}, {} a pixel. The noise "
        "of the picture is {}.{}</p>\n",
        Escaped(verified.picture.name), verdict.isRight ? "right" : "wrong",
        verdict.isRight ? "right" : "not right", Escaped(verified.scene),
        Counted(verified.result.referenceSamples, "sample"), verdict.isNoiseEstimated ? "estimated" : "known",
        verdict.isDecided ? "" : " More samples of the reference could change the verdict.");
    const std::vector<session::Hypothesis>& hypotheses = verified.result.diagnosis.hypotheses;
    if (!hypotheses.empty()) {
        html +=
            "<p class=\"best\">" + Escaped(hypotheses.front().text) +
            Text(". This explains {:.0f} % of the difference.</p>\n", 100.0 * hypotheses.front().explained);
        if (hypotheses.size() > 1) {
            Table others({"other possible cause", "share explained"});
            for (size_t i = 1; i < hypotheses.size(); ++i)
                others.Row({hypotheses[i].text, Text("{:.0f} %", 100.0 * hypotheses[i].explained)});
            html += others.Html();
        }
    }
    const Extent2D size = verified.picture.size;
    const std::string outlines = Outlines(WorstTiles(verdict), size);
    html += "<div class=\"pictures\">\n" + Figure("The picture", verified.shown.picture, outlines) +
            Figure("The reference", verified.shown.reference, "") +
            Figure(Text("FLIP, mean {:.4f}; noise alone would give {:.4f}", verdict.difference.flip,
                        verdict.flipOfNoise),
                   verified.shown.flip, "") +
            Figure("Stops by which the picture is brighter (red) or darker (blue), up to 2",
                   verified.shown.stops, outlines) +
            "</div>\n";
    return html + Tables(verified);
}

}  // namespace

ReportPictures ShowPictures(Renderer& renderer, const session::Picture& reference,
                            const session::Picture& picture, const session::Verdict& verdict,
                            float exposureEv) {
    const Extent2D size = picture.size;
    const auto show = [&](const session::Picture& of) {
        return image::EncodePng(session::ShowRadiance(renderer, of.radiance, size, exposureEv), of.name);
    };
    double luminance = 0.0;
    for (size_t i = 0; i < reference.radiance.size(); i += 4)
        luminance += session::LuminanceOf(&reference.radiance[i]);
    const auto floor = static_cast<float>(0.01 * luminance / double(session::PixelCount(size)) + 1e-12);
    const float white = std::min(reference.white, picture.white);
    return {
        .picture = show(picture),
        .reference = show(reference),
        .flip = image::EncodePng(session::ShowHeat(renderer, verdict.difference.flipMap, size, 1.0f), "flip"),
        .stops = image::EncodePng(
            session::ShowStops(session::StopsBetween(session::CutAt(reference.radiance, white),
                                                     session::CutAt(picture.radiance, white), floor),
                               size, 2.0f),
            "stops")};
}

std::string VerifyHtml(const std::vector<VerifiedPicture>& pictures) {
    std::string html = kHead;
    for (const VerifiedPicture& picture : pictures)
        html += picture.error.empty() ? Section(picture) : "<p>" + Escaped(picture.error) + "</p>\n";
    return html + "</body></html>\n";
}

}  // namespace raygraph::cli
