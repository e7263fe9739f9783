// Implements `raygraph verify`.
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <system_error>
#include <thread>

#include "base/files.h"
#include "base/os.h"
#include "base/text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_setup.h"
#include "editor/cli/outputs.h"
#include "editor/cli/report.h"
#include "editor/cli/run_command.h"
#include "editor/cli/verify_report.h"
#include "editor/cli/verify_suite.h"
#include "editor/session/settings/as_input.h"
#include "editor/session/settings/light_settings.h"
#include "renderer/image/exr.h"

namespace raygraph::cli {

namespace {

// Is what an accepted difference is of (Verify::Key).
constexpr const char* kAttributeReference = "raygraph.reference";

// Returns the command that explains the reference, but for the pixel, from any folder.
std::string ExplainCommandFor(const VerifyCase& one, const PictureSettings& settings, uint64_t samples) {
    const auto absolute = [](const std::filesystem::path& path) {
        return os::ForShell(std::filesystem::absolute(path).lexically_normal().string());
    };
    std::string command = "raygraph explain " + absolute(one.scene);
    if (!one.root.empty()) command += " --root " + absolute(one.root);
    if (!one.environment.empty()) command += " --env " + absolute(one.environment);
    SettingTexts texts = one.given;
    // The light is not divided into groups there, and pixels are those of the whole picture
    for (const char* name : {"light-group", "crop", "view"}) texts.erase(name);
    texts["size"] = ToText(settings.size);
    if (settings.paths.seed == 0) texts["seed"] = std::to_string(kReferenceSeed);
    for (const auto& [name, text] : texts) command += " --" + name + " " + os::ForShell(text);
    return command + Text(" --spp {}", samples);
}

// RunFolder owns a temporary folder, which it removes with all that is in it. Its path is "" where none can
// be made.
class RunFolder {
  public:
    RunFolder() {
        std::random_device random;
        std::error_code error;
        const std::filesystem::path path = std::filesystem::temp_directory_path(error) /
                                           Text("raygraph-verify-{:08x}{:08x}", random(), random());
        if (error || !std::filesystem::create_directory(path, error)) return;
        m_path = path;
        std::filesystem::permissions(path, std::filesystem::perms::owner_all, error);
    }
    ~RunFolder() {
        std::error_code error;
        if (!m_path.empty()) std::filesystem::remove_all(m_path, error);
    }
    RunFolder(const RunFolder&) = delete;
    RunFolder& operator=(const RunFolder&) = delete;

    const std::filesystem::path& Path() const { return m_path; }

  private:
    std::filesystem::path m_path;
};

// Returns whether cases have the same reference, but for the size of their pictures.
bool IsSameReference(const VerifyCase& a, const VerifyCase& b) {
    return a.scene == b.scene && a.root == b.root && a.environment == b.environment && a.given == b.given;
}

class VerifyRun {
  public:
    VerifyRun(const VerifyArguments& arguments, Console& console, rhi::Device& device)
        : m_arguments(arguments), m_console(console), m_device(device), m_log(console.log.ForLibraries()) {}

    // Returns the results for the pictures of each case, in their order. Cases that were not begun when the
    // program was asked to end have none.
    std::vector<std::vector<VerifiedPicture>> CheckAll(const std::vector<VerifyCase>& cases) {
        // Without a cache, cases share their references by a folder of this run
        const std::filesystem::path cache = m_arguments.isCached ? CacheFolder() : std::filesystem::path();
        std::optional<RunFolder> shared;
        std::vector<std::filesystem::path> folders(cases.size());
        for (size_t i = 0; i < cases.size(); ++i) {
            const auto isSame = [&](const VerifyCase& other) { return IsSameReference(other, cases[i]); };
            if (!cache.empty()) {
                folders[i] = cache / "references";
            } else if (std::ranges::count_if(cases, isSame) > 1) {
                if (!shared) shared.emplace();
                folders[i] = shared->Path();
            }
        }
        std::vector<std::vector<VerifiedPicture>> results(cases.size());
        std::atomic<size_t> next = 0;
        const auto work = [&] {
            for (size_t i = next++; i < cases.size() && !os::IsStopRequested(); i = next++)
                results[i] = Check(cases[i], folders[i]);
        };
        std::vector<std::jthread> others;
        for (size_t i = 1; i < std::min<size_t>(m_arguments.jobs, cases.size()); ++i)
            others.emplace_back(work);
        work();
        others.clear();  // joins them
        return results;
    }

    // Returns the first code of what could not be judged.
    ExitCode Failure() const { return m_failure; }

  private:
    // Returns the results for the pictures of a case. What cannot be judged has its error, which is printed,
    // and does not keep the others from their verdicts. Threads: any, each with cases of its own.
    std::vector<VerifiedPicture> Check(const VerifyCase& one, const std::filesystem::path& references) {
        std::vector<VerifiedPicture> verified;
        for (const std::filesystem::path& path : one.pictures) {
            verified.push_back(
                {.scene = one.scene.string(), .picture = {.name = path.string()}, .result = {}});
            Try(verified.back(), [&](VerifiedPicture& picture) {
                Transfer transfer = one.transfer;
                // Code values of a .png with normals are (n + 1) / 2
                if (one.given.contains("view") && one.given.at("view") == Name(View::Normals))
                    transfer = {.curve = TransferCurve::Linear};
                picture.picture = ReadPicture(path, transfer, m_log);
            });
        }
        const auto readable = std::ranges::find(verified, "", &VerifiedPicture::error);
        if (readable == verified.end()) return verified;
        std::string why;
        const ExitCode code = Guarded([&](const char* text) { why = text; },
                                      [&] {
                                          CheckOn(one, references, readable->picture.size, verified);
                                          return ExitCode::Done;
                                      });
        if (code == ExitCode::Done) return verified;
        Fail(code, why);
        for (VerifiedPicture& picture : verified)
            if (picture.error.empty() && picture.result.referenceSamples == 0) picture.error = why;
        return verified;
    }

    void Fail(ExitCode code, const std::string& why) {
        m_console.progress.Clear();
        const std::scoped_lock lock(m_printing);
        if (m_failure == ExitCode::Done) m_failure = code;
        m_console.log.Fail(why.c_str());
    }

    // Does `judge` to a picture without an error. Bad input is an error of the picture, all others are of the
    // case.
    template <typename Judge>
    void Try(VerifiedPicture& picture, Judge&& judge) {
        if (!picture.error.empty()) return;
        try {
            judge(picture);
        } catch (const Error& error) {
            if (error.Kind() != ErrorKind::BadInput) throw;
            picture.error = error.what();
            Fail(ExitCode::BadInput, picture.error);
        }
    }

    void CheckOn(const VerifyCase& one, const std::filesystem::path& references, Extent2D size,
                 std::vector<VerifiedPicture>& verified) {
        PictureSettings settings = SettingsFrom(one.given);
        if (!one.given.contains("size")) settings.size = size;
        SceneInput input = Load(one, settings);
        RequireMapFor(one.given, input, ChooseLight(input, settings), "--env or --light studio");
        VerifyDesc desc{.settings = settings,
                        .tolerance = one.tolerance,
                        .maxSamples = one.maxSamples,
                        .cache = references,
                        .exposureEv = one.transfer.exposureEv,
                        .isStopRequested = os::IsStopRequested,
                        .log = m_log};
        if (m_console.progress.IsOn())
            desc.progress = [&](const ProgressState& state) {
                m_console.progress.ShowSamples("reference of " + one.scene.filename().string(), state);
            };
        Verify verify(m_device, std::move(input), std::move(desc));
        CheckOptions options{.regions = one.regions, .pictureSamples = one.pictureSamples};
        if (!one.mask.empty()) options.mask = ReadPicture(one.mask, {}, m_log);
        for (VerifiedPicture& each : verified)
            Try(each, [&](VerifiedPicture& picture) {
                const std::filesystem::path stored = AcceptedFile(one, picture.picture.name);
                options.accepted = ReadAccepted(stored, verify.Key());
                if (!options.accepted.radiance.empty()) picture.accepted = stored.string();
                picture.result = verify.Check(picture.picture, options);
                picture.picture = verify.AsJudged(picture.picture);
                if (settings.view == View::PathTraced) {
                    picture.explain = ExplainCommandFor(one, settings, picture.result.referenceSamples);
                    picture.originX = RenderedPart(settings).x;
                    picture.originY = RenderedPart(settings).y;
                }
                if (!picture.result.verdict.isRight && m_arguments.isUpdating) {
                    StoreAccepted(stored, WithoutNonFinite(picture.picture), verify);
                    picture.isAccepted = true;
                }
                if (!m_arguments.html.empty()) {
                    Renderer renderer(m_device);
                    picture.shown =
                        ShowPictures(renderer, verify.Reference(), WithoutNonFinite(picture.picture),
                                     picture.result.verdict, one.transfer.exposureEv);
                }
                m_console.progress.Clear();
                const std::scoped_lock lock(m_printing);
                if (!m_arguments.isQuiet) PrintLine(DescribeVerdict(picture));
            });
    }

    SceneInput Load(const VerifyCase& one, const PictureSettings& settings) {
        InputOptions options = InputOptionsFor(settings);
        options.root = one.root;
        options.environment = one.environment;
        options.log = m_log;
        options.progress = [&](std::string_view stage, float fraction) {
            m_console.progress.ShowLoading(stage, fraction);
        };
        return LoadInput(one.scene, options);
    }

    Picture ReadAccepted(const std::filesystem::path& file, const std::string& key) const {
        std::error_code error;
        if (file.empty() || !std::filesystem::exists(file, error)) return {};
        const image::ExrImage image = AsInput([&] { return image::ReadExr(file); });
        const auto of = image.attributes.find(kAttributeReference);
        if (of == image.attributes.end() || of->second != image::ExrAttribute(key)) {
            if (m_arguments.isUpdating) return {};
            throw MakeError(ErrorKind::BadInput,
                            "{} was accepted for another scene, other settings or another version; --update "
                            "stores it again",
                            file);
        }
        Picture accepted{.name = file.string(), .size = {image.width, image.height}};
        accepted.radiance.assign(4 * PixelCount(accepted.size), 0.0f);
        for (size_t c = 0; c < 3; ++c) {
            const std::vector<float>* channel = image.FloatChannel(std::string(1, "RGB"[c]));
            if (channel == nullptr) throw MakeError(ErrorKind::BadInput, "{}: no R, G and B", file);
            for (size_t i = 0; i < channel->size(); ++i) accepted.radiance[4 * i + c] = (*channel)[i];
        }
        return accepted;
    }

    static void StoreAccepted(const std::filesystem::path& file, const Picture& picture,
                              const Verify& verify) {
        Texels difference = picture.radiance;
        for (size_t i = 0; i < difference.size(); ++i) difference[i] -= verify.Reference().radiance[i];
        const std::span<const float> all(difference);
        const image::ExrPlane planes[] = {{.name = "R", .samples = all, .stride = 4},
                                          {.name = "G", .samples = all.subspan(1), .stride = 4},
                                          {.name = "B", .samples = all.subspan(2), .stride = 4}};
        std::error_code error;
        std::filesystem::create_directories(file.parent_path(), error);
        image::WriteExr(file, picture.size.width, picture.size.height, planes,
                        {{kAttributeReference, verify.Key()}});
    }

    const VerifyArguments& m_arguments;
    Console& m_console;
    rhi::Device& m_device;
    Log m_log;
    std::mutex m_printing;
    ExitCode m_failure = ExitCode::Done;
};

}  // namespace

ExitCode VerifyCommand(const VerifyArguments& arguments, Console& console) {
    const Log log = console.log.ForLibraries();
    CheckWritable(FilesOf(arguments), log);
    const image::ExrThreads threads;
    const std::vector<VerifyCase> cases =
        arguments.suite.empty() ? std::vector{arguments.only} : ReadSuite(arguments.suite);
    RequireDistinctAccepted(cases);
    const std::unique_ptr<rhi::Device> device = OpenDevice({arguments.device, arguments.isValidating}, log);
    os::SignalWatch signals([] { std::_Exit(static_cast<int>(ExitCode::TryAgain)); });
    signals.StartDeferring();
    VerifyRun run(arguments, console, *device);
    std::vector<VerifiedPicture> verified;
    for (std::vector<VerifiedPicture>& result : run.CheckAll(cases))
        std::ranges::move(result, std::back_inserter(verified));
    console.log.RequireValid();
    OutputWriter outputs([&](const auto&, std::string_view why) { console.log.Fail(why); });
    if (!arguments.json.empty())
        outputs.Add(arguments.json, [&] { WriteTextFile(arguments.json, VerifyJson(verified)); });
    if (!arguments.html.empty())
        outputs.Add(arguments.html, [&] { WriteTextFile(arguments.html, VerifyHtml(verified)); });
    outputs.WriteAll();
    if (os::IsStopRequested()) return ExitCode::TryAgain;
    if (run.Failure() != ExitCode::Done) return run.Failure();
    if (outputs.Result() != ExitCode::Done) return outputs.Result();
    const bool areRight = std::ranges::all_of(verified, [](const VerifiedPicture& picture) {
        return picture.result.verdict.isRight || picture.isAccepted;
    });
    return areRight ? ExitCode::Done : ExitCode::Differs;
}

}  // namespace raygraph::cli
