// Holds the parsed command line, checked as far as possible without opening a file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "editor/cli/aov_request.h"
#include "editor/cli/edit_view.h"
#include "editor/cli/outputs.h"
#include "editor/cli/picture_list.h"
#include "editor/cli/program_log.h"
#include "editor/session/denoise.h"
#include "editor/session/explain/explain.h"
#include "editor/session/file/render_file.h"
#include "editor/session/settings/picture_settings.h"
#include "editor/session/settings/tracing_choice.h"
#include "editor/session/verify/picture.h"
#include "editor/session/verify/verify.h"
#include "passes/tonemap.h"

namespace raygraph::cli {

using namespace session;  // NOLINT: the program is a command line for it

// Gives the white point of a .png.
struct WhitePoint {
    std::optional<double> kelvin;  // none: the color of the scene's light
};

// Says how a .png shows the picture.
struct DisplayArguments {
    std::optional<float> exposureEv;
    std::optional<TonemapOperator> tonemap;
    std::optional<WhitePoint> whitePoint;  // none: the white point of the display
};

struct RenderArguments : OutputArguments, DisplayArguments {
    // Apply where neither samples, nor a time, nor an error is given: a picture has its samples when its
    // error is that of a clean one, or at the limit. A shard, and a view without an error, has
    // kDefaultSamples.
    static constexpr uint32_t kDefaultSamples = 64;
    static constexpr double kCleanError = 0.02, kDenoisedError = 0.05;
    static constexpr uint32_t kMostSamples = 1024, kMostDenoisedSamples = 256;

    std::filesystem::path scene;
    std::vector<OutputFile> outputs;    // empty: see RenderCommand
    SettingTexts given;                 // picture settings of the command line
    std::filesystem::path root;         // "": the scene's folder
    std::filesystem::path environment;  // "": none
    std::optional<uint32_t> samples;    // total for the picture, resumed samples included
    std::optional<double> seconds;
    std::optional<double> error;  // relative error of the whole picture
    std::optional<uint32_t> sampleOffset;
    std::optional<FrameRange>
        frames;  // renders a picture per frame; outputs and report are name patterns then
    std::vector<std::string> cameras;   // a picture per camera, if there are several; `given` has the first
    std::optional<uint32_t> turntable;  // number of pictures around the scene; `cameras` are theirs
    bool isContactSheet = false;        // all pictures are shown in one
    // With one, `given` hides the environment; none: see BackdropOf.
    std::optional<passes::BackdropSettings> backdrop;
    bool isCutOut = false;       // nothing is to be behind the scene
    std::optional<Shard> shard;  // samples, sampleOffset, frames and names are already the shard's
    std::optional<ExrType> exrType;
    std::optional<AovRequest> aovs;
    // None: if the samples are left to the program, only .png and .jpg are written, and the picture can be.
    std::optional<bool> denoise;
    std::optional<FileDenoiser> denoiser;
    std::string device;
    std::string devices;  // list; "": only `device`
    bool isValidating = false;
    std::filesystem::path report;             // "": none
    std::filesystem::path resume;             // "": starts at the first sample
    std::filesystem::path settingsFrom;       // "": none
    std::optional<double> checkpointMinutes;  // between saves; `resume` need not exist then
    TracingChoice tracing{};

    // Returns whether the command line says when a picture has its samples.
    bool GivesSampling() const { return samples || seconds || error; }
};

// Returns why there is nothing to render: a shard beyond the last sample or frame is empty. "" if there is
// something.
std::string NothingToRenderReason(const RenderArguments& arguments);

// Returns what is behind the scene in a .png of these settings: with a ground, the environment as it is,
// unless the command line says otherwise. None: what the render shows, which is nothing where it is hidden.
std::optional<passes::BackdropSettings> BackdropOf(const RenderArguments& arguments,
                                                   const PictureSettings& settings);

// Returns how a .png shows the picture, with defaults for what is not given. Its white point is not set if it
// depends on the scene (see DisplayFor).
passes::TonemapSettings DisplayOf(const DisplayArguments& arguments);

struct BenchArguments : OutputArguments {
    static constexpr double kDefaultTolerance = 0.05;

    std::filesystem::path scene;
    SettingTexts given;
    std::filesystem::path root;  // "": the scene's folder
    std::filesystem::path environment;
    uint32_t frames = 8;  // timed frames of each kind per round
    uint32_t rounds = 5;
    uint32_t batchSize = 0;    // per frame; 0: as many as a render takes
    bool hasViewport = false;  // also times a host's viewport
    bool isListingPipelines = false;
    std::string device;
    std::filesystem::path json;       // "": prints to stdout only
    std::filesystem::path compare;    // stored results to compare with; "": none
    std::optional<double> tolerance;  // allowed relative increase of a cost
    TracingChoice tracing{};
};

struct InfoArguments : OutputArguments {
    std::filesystem::path scene;  // "": an option lists something else
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

struct GraphRunArguments : OutputArguments {
    std::filesystem::path description;
    std::filesystem::path folder;    // of the outputs; "": the working folder
    std::optional<uint32_t> frames;  // none: those of the description
    bool showsPlan = false;
    bool isDot = false;
    bool showsTimes = false;
    std::string device;
    bool isValidating = false;
};

struct ExplainArguments : OutputArguments {
    std::filesystem::path scene;               // or the .exr of a render, of which the noise is explained
    bool hasPixel = false;                     // with a scene only
    bool hasSamples = false;                   // `request` says which samples
    std::filesystem::path noiseMap, groupMap;  // of a render; "": none
    SettingTexts given;
    std::filesystem::path root;          // "": the scene's folder
    std::filesystem::path environment;   // "": none
    std::filesystem::path settingsFrom;  // "": none
    ExplainRequest request;
    bool isJson = false;
    std::string device;
    bool isValidating = false;
    TracingChoice tracing{};
};

struct MergeArguments : OutputArguments {
    std::vector<std::filesystem::path> inputs;
    std::filesystem::path output;
    std::filesystem::path report;  // "": none
};

struct DenoiseArguments : OutputArguments, DisplayArguments {
    std::filesystem::path input;
    std::vector<OutputFile> outputs;  // .png and .exr
    std::optional<FileDenoiser> denoiser;
    std::string device;
    bool isValidating = false;
};

// Says how pictures to compare are read, and shown for FLIP and SSIM.
struct ComparedArguments {
    Transfer transfer;  // of a .png; its exposure is that of the display, too
    std::string device;
    bool isValidating = false;
};

struct CompareArguments : OutputArguments, ComparedArguments {
    std::filesystem::path reference, picture;
    std::vector<OutputFile> outputs;  // .png and .exr
    std::filesystem::path json;       // "": none
};

// Is a scene with its pictures and what they are judged by.
struct VerifyCase {
    std::string name;
    std::filesystem::path scene;
    std::vector<std::filesystem::path> pictures;
    SettingTexts given;
    std::filesystem::path root;         // "": the scene's folder
    std::filesystem::path environment;  // "": none
    Transfer transfer;
    Tolerance tolerance;
    uint32_t maxSamples = 1024;              // of the reference
    std::optional<uint32_t> pictureSamples;  // of pictures without a variance; none: estimated
    std::vector<RegionRule> regions;
    std::filesystem::path mask;      // "": none
    std::filesystem::path accepted;  // folder of accepted differences; "": none
    std::filesystem::path folder;    // of the list, to which names in `accepted` are relative; "": none
};

struct VerifyArguments : OutputArguments, ComparedArguments {
    VerifyCase only;              // of the command line
    std::filesystem::path suite;  // file with the cases, instead; "": none
    uint32_t jobs = 1;            // cases at a time
    bool isCached = true;
    bool isUpdating = false;           // stores the differences of pictures that are not right as accepted
    std::filesystem::path json, html;  // "": none
};

struct EditArguments : OutputArguments, DisplayArguments {
    std::filesystem::path scene;           // "": starts without a scene
    std::string variant;                   // "": no variant
    std::filesystem::path root;            // "": each scene's folder
    std::filesystem::path environment;     // "": none
    std::optional<EditView> view;          // none: the stored view, or by time
    scene::PointsAndLines pointsAndLines;  // radii for this scene and all that are opened later
    SettingTexts given;                    // picture settings of the command line
    std::string backdrop;                  // session::ParseBackdrop; "": that of the stored view
    std::filesystem::path script;          // "": opens a window
    std::filesystem::path shaders;         // "": no hot reload
    std::string device;
    bool isValidating = false;
    bool isListingKeys = false;
};

// Returns the settings of a render, except for the size, that of stored results; for the depth, since a few
// long paths in a bright scene would decide how long a frame takes, and for the light: scenes are timed in
// their own light alone, since the studio would change the picture of stored results.
PictureSettings BenchDefaults();

// Describes a text for stdout (--help, --version), after which the program ends.
struct ShowText {
    std::string text;
};

using Arguments = std::variant<RenderArguments, BenchArguments, InfoArguments, GraphArguments,
                               GraphRunArguments, ExplainArguments, MergeArguments, DenoiseArguments,
                               CompareArguments, VerifyArguments, EditArguments, ShowText>;

// Parses the command line. Throws Error{Usage}, one line that names the option, if it is not valid.
Arguments ParseArguments(int argc, const char* const* argv);

}  // namespace raygraph::cli
