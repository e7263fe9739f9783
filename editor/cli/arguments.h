// The command line, parsed and checked as far as it can be without opening a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "editor/cli/aov_request.h"
#include "editor/cli/edit_view.h"
#include "editor/cli/frame_range.h"
#include "editor/cli/outputs.h"
#include "editor/cli/program_log.h"
#include "editor/cli/shard.h"
#include "editor/session/picture_settings.h"
#include "editor/session/render_file.h"
#include "editor/session/tracing_choice.h"
#include "passes/tonemap.h"

namespace raygraph::cli {

using namespace session;  // NOLINT: the program is a command line for it

// Of a .png.
struct WhitePoint {
    std::optional<double> kelvin;  // none: the color of the scene's light
};

struct RenderArguments : OutputArguments {
    static constexpr uint32_t kDefaultSamples = 64;

    std::filesystem::path scene;
    std::vector<OutputFile> outputs;    // empty: see RenderCommand
    SettingTexts given;                 // picture settings, as given
    std::filesystem::path root;         // "": the scene's folder
    std::filesystem::path environment;  // "": none
    std::optional<uint32_t> samples;    // of the picture in all; for a resumed one too
    std::optional<double> seconds;
    std::optional<double> error;  // relative, of the whole picture
    std::optional<uint32_t> sampleOffset;
    std::optional<FrameRange> frames;  // a picture each; outputs and report are then patterns of names
    std::vector<std::string> cameras;  // the same, if there are several; `given` has the first
    std::optional<Shard> shard;  // samples, sampleOffset, frames and names are already those of its part
    std::optional<float> exposureEv;
    std::optional<TonemapOperator> tonemap;
    std::optional<WhitePoint> whitePoint;  // none: that of the display
    std::optional<ExrType> exrType;
    std::optional<AovRequest> aovs;
    std::string device;
    std::string devices;  // several; "": the one
    bool isValidating = false;
    std::filesystem::path report;             // "": none
    std::filesystem::path resume;             // "": from the start
    std::filesystem::path settingsFrom;       // "": none
    std::optional<double> checkpointMinutes;  // between saves; then `resume` need not exist yet
    TracingChoice tracing{};
};

// Why there is nothing to render: a shard beyond the last sample or frame has none; "": there is something.
std::string WhyNothingToRender(const RenderArguments& arguments);

// How a .png shows the picture: as given, else as by default. Without a white point that the scene is needed
// for (DisplayFor).
passes::TonemapSettings DisplayOf(const RenderArguments& arguments);

struct BenchArguments : OutputArguments {
    static constexpr double kDefaultTolerance = 0.05;

    std::filesystem::path scene;
    SettingTexts given;
    std::filesystem::path root;  // "": the scene's folder
    std::filesystem::path environment;
    uint32_t frames = 8;  // timed ones of each kind in a round
    uint32_t rounds = 5;
    uint32_t samplesAtOnce = 0;  // 0: as a render
    bool hasViewport = false;    // times a host's viewport, too
    bool isListingPipelines = false;
    std::string device;
    std::filesystem::path json;       // "": stdout alone
    std::filesystem::path compare;    // results to compare with; "": none
    std::optional<double> tolerance;  // that a cost may rise relative to the stored one
    TracingChoice tracing{};
};

struct InfoArguments : OutputArguments {
    std::filesystem::path scene;  // "": one of the lists
    std::string sceneChoice;
    std::string variant;
    scene::PointsAndLines pointsAndLines;
    std::filesystem::path root;  // "": the scene's folder
    bool isListingDevices = false;
    bool isListingExtensions = false;
    bool isJson = false;
};

struct GraphArguments : OutputArguments {
    std::filesystem::path scene;
    SettingTexts given;
    std::filesystem::path root;  // "": the scene's folder
    bool isDot = false;
    bool isJson = false;
    bool isFirstFrame = false;
    std::string device;
};

struct MergeArguments : OutputArguments {
    std::vector<std::filesystem::path> inputs;
    std::filesystem::path output;
    std::filesystem::path report;  // "": none
};

struct EditArguments : OutputArguments {
    std::filesystem::path scene;           // "": opens empty
    std::string variant;                   // of it; "": none
    std::filesystem::path root;            // "": the folder of each scene
    std::filesystem::path environment;     // "": none
    std::optional<EditView> view;          // none: as it was left
    scene::PointsAndLines pointsAndLines;  // radii of its, and of what is opened later
    SettingTexts given;                    // picture settings, as given
    std::filesystem::path script;          // "": a window
    std::filesystem::path shaders;         // "": none to reload from
    std::string device;
    bool isValidating = false;
};

// As for a render, but for the depth: a few long paths in a bright scene would decide how long a frame takes.
// And scenes are timed in their own light alone: the studio would be another picture than the one of results
// that are stored.
PictureSettings BenchDefaults();

// --help and --version: a text for stdout, and nothing else to do.
struct ShowText {
    std::string text;
};

using Arguments = std::variant<RenderArguments, BenchArguments, InfoArguments, GraphArguments, MergeArguments,
                               EditArguments, ShowText>;

// Error{Usage}, one line naming the option, for everything that is not a command line of this program.
Arguments ParseArguments(int argc, const char* const* argv);

}  // namespace raygraph::cli
