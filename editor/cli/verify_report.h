// The report of `verify`: for people in a few lines, and as JSON, schema 1.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "editor/session/verify/verdict_text.h"
#include "editor/session/verify/verify.h"

namespace raygraph::cli {

// Holds PNGs that a page shows, sRGB; the map of FLIP and the difference in stops in false colors.
struct ReportPictures {
    std::vector<std::byte> picture, reference, flip, stops;
};

// Is the result for one picture.
struct VerifiedPicture {
    std::string scene;
    session::Picture picture;
    session::VerifyResult result;
    std::string error = {};     // why it is not judged: there is no result; "": it is
    ReportPictures shown = {};  // for VerifyHtml; empty: not made
    bool isAccepted = false;    // its difference has been stored as accepted
    // The file of the accepted difference with which it was compared; "": none.
    std::string accepted = {};
    // The command that explains a pixel of the reference, but for its --pixel; "": none does. Its pixels
    // begin at `origin`.
    std::string explain = {};
    uint32_t originX = 0, originY = 0;
};

// Returns a line with the verdict, and one for each check that failed.
std::string DescribeVerdict(const VerifiedPicture& verified);
std::string VerifyJson(const std::vector<VerifiedPicture>& pictures);

// Returns the tiles that are beyond their bounds most, worst first, at most 8.
std::vector<session::VerdictTile> WorstTiles(const session::Verdict& verdict);
// Returns the command that explains a pixel of the reference, for a shell; "": none does.
std::string ExplainCommandOf(const VerifiedPicture& verified, const session::VerdictPixel& pixel);
// Makes the pictures of a page.
ReportPictures ShowPictures(Renderer& renderer, const session::Picture& reference,
                            const session::Picture& picture, const session::Verdict& verdict,
                            float exposureEv);
// Returns a page that needs no other file (verify_html.cpp).
std::string VerifyHtml(const std::vector<VerifiedPicture>& pictures);

}  // namespace raygraph::cli
