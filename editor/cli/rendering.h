// Runs `render`: RenderJob is its plan, from the command line and a resumed file; Rendering renders the
// pictures of one session and writes their files, also as checkpoints; DescribeRun makes the report.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/log.h"
#include "base/os.h"
#include "base/stopwatch.h"
#include "editor/cli/arguments.h"
#include "editor/cli/console.h"
#include "editor/cli/exit_code.h"
#include "editor/cli/picture_list.h"
#include "editor/cli/report.h"
#include "editor/session/file/resume.h"
#include "editor/session/session.h"
#include "editor/session/settings/scene_input.h"
#include "passes/tonemap.h"
#include "renderer/image/image.h"

namespace raygraph::cli {

// RenderJob is what `render` is to do, from the command line and a resumed file.
struct RenderJob {
    PictureSettings settings;  // settings of the first picture
    AovSet aovs;
    uint32_t firstSample = 0;
    std::optional<uint32_t> samplesWanted;  // total for a picture; none: until the time is up
    std::optional<double> error;            // relative error of the whole picture that ends it before
    bool isDenoised = false;
    std::optional<ResumedRender> resumed;  // for the first picture
};

// Returns the settings of a stored render (--settings-from), for options that are not `given`, or the
// defaults if there is no file. The light is chosen again for another scene, and where the other arguments
// replace it.
PictureSettings StoredSettings(const std::filesystem::path& file, const std::filesystem::path& scene,
                               const std::filesystem::path& environment, const SettingTexts& given,
                               const Log& log);

// Returns how a .png shows a picture of this scene. Throws Error{BadInput} if its white point is that of the
// scene's light, and nothing emits light.
passes::TonemapSettings DisplayFor(const RenderArguments& arguments, const PictureSettings& settings,
                                   const SceneInput& input);

// Plans the job; `arguments` has all its outputs. Throws Error{Usage} for options that exclude each other.
RenderJob PlanJob(const RenderArguments& arguments, const Log& log);

// Returns the render that a picture continues, if one is asked for; with checkpoints it need not exist.
std::optional<ResumedRender> ResumedFor(const RenderArguments& arguments, const PictureName& name,
                                        const Log& log);

// Throws Error{BadInput} that names the first difference if a complete render is not that picture of the job.
// Scene and environment map are compared by the names of their files alone, since they are not loaded for
// this.
void RequireSameRequest(const ResumedRender& complete, const RenderArguments& arguments, const RenderJob& job,
                        const PlannedPicture& picture);

// Serialize the job, without the resumed render, for processes with the same arguments. JobFrom throws
// Error{BadInput} for malformed text.
std::string JobText(const RenderJob& job);
RenderJob JobFrom(const std::string& text);

bool WritesKind(const RenderArguments& arguments, OutputKind kind);

// Rendering renders the pictures of one session, and writes their files, also as checkpoints.
class Rendering {
  public:
    // The arguments must outlive the object. `group` is the session's.
    Rendering(const RenderArguments& arguments, const RenderJob& job, std::span<rhi::Device* const> devices,
              Session& session, os::SignalWatch& signals, Console& console, ProcessGroup* group);

    // Renders the picture that the session has begun until it is complete or the program is asked to end,
    // then writes its files (in a group, the root does): first the resumable .exr, then other pictures, the
    // report, and last devices and pipes. Checkpoints write neither the report nor devices and pipes. A file
    // that cannot be written is logged, does not stop the others, and sets Result(). `giveBack`, for the last
    // picture, destroys the session and its devices: it runs on another thread while the files are written,
    // and has returned when this call does. It is not called with a report, in a group, after ten seconds
    // of rendering or more, or if nothing is written.
    void RenderPicture(const PlannedPicture& picture, const std::function<void()>& giveBack = {});

    // Writes the pictures so far side by side (--contact-sheet); RenderPicture wrote none of them.
    void WriteContactSheet();

    // Returns whether the program was asked to end; the picture may be complete even so.
    bool IsStopped() const { return m_isInterrupted || m_isTerminated; }
    // Returns whether the program has been asked to end by now, in any process. All processes must call it
    // together.
    bool IsStopRequested();
    bool IsIncomplete() const { return m_isIncomplete; }  // concerns the last picture
    bool IsTerminated() const { return m_isTerminated; }  // a signal other than Ctrl-C has ended it
    // Returns whether a render that can be resumed was saved, at the end or as a checkpoint, for any of the
    // pictures, and not destroyed by a later write. If none is asked for (no .exr, or one without sums), any
    // picture counts.
    bool IsSaved() const { return !m_saved.empty(); }
    // Returns Done, or the status of the first output of a picture that could not be written; in a group, the
    // root's.
    ExitCode Result() const { return m_result; }

  private:
    RunSummary Run(const PlannedPicture& picture, uint32_t samplesBefore);
    // Agrees in all processes on whether rendering ends.
    void SynchronizeSignals();
    bool IsSaveDue() const;
    // Writes all files as of now. `summary` describes the run so far; `giveBack` is as in RenderPicture.
    void Write(const PlannedPicture& picture, const RunSummary& summary, uint32_t samplesBefore, bool isEnd,
               const std::function<void()>& giveBack = {});
    // Adds the picture of the session to the contact sheet.
    void AddToSheet(const RunSummary& run, uint32_t samplesBefore);
    void WritePicture(const OutputFile& picture, const RenderFile& render,
                      const std::optional<image::Image8>& display);
    // Logs that a file cannot be written; before the end, once for each reason.
    void LogNotWritten(const std::filesystem::path& file, std::string_view why, bool isEnd);
    // `outcome` is "", or names what was written, for a run that was stopped.
    void Warn(const RunSummary& run, uint32_t samples, uint64_t nonFiniteSamples, const std::string& outcome);

    const RenderArguments& m_arguments;
    const RenderJob& m_job;
    std::span<rhi::Device* const> m_devices;
    Session& m_session;
    os::SignalWatch& m_signals;
    Console& m_console;
    ProcessGroup* m_group;
    Stopwatch m_sinceSave;
    std::vector<image::Image8> m_sheet;  // pictures of a contact sheet
    std::string m_sheetSummary;          // of the last of them
    bool m_isInterrupted = false, m_isTerminated = false, m_isIncomplete = false;
    std::set<std::filesystem::path> m_saved;  // files for IsSaved()
    // Holds the reason, by file that the last checkpoint lacks.
    std::map<std::filesystem::path, std::string> m_notSaved;
    ExitCode m_result = ExitCode::Done;
};

// Makes the report of a render, with everything but the settings. It renders one extra frame to count rays
// if paths are traced.
Report DescribeRun(std::span<rhi::Device* const> devices, Session& session, const SessionResult& result,
                   const RunSummary& run);

}  // namespace raygraph::cli
