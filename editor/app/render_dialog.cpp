#include "editor/app/render_dialog.h"

#include <imgui.h>
#include <algorithm>
#include <iterator>
#include <random>
#include <system_error>
#include <tuple>
#include <utility>

#include "base/files.h"
#include "base/text.h"
#include "editor/app/panels.h"
#include "editor/app/render_words.h"
#include "editor/session/settings/parse.h"
#include "renderer/scene/gltf/still_scene.h"

namespace raygraph::editor {

namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 4> kFormats{".png", ".jpg", ".exr", ".hdr"};
constexpr int kMaxSide = 16384;                       // pixels, of session::PictureSettings
constexpr float kField = 260.0f, kProgress = 260.0f;  // points
constexpr ImGuiSliderFlags kClamp = ImGuiSliderFlags_AlwaysClamp;

// Returns the names; those of files that are there come first, after "replaces".
std::string OutputsText(const std::vector<fs::path>& outputs) {
    std::string replaced, made;
    for (const fs::path& file : outputs) {
        std::error_code ignored;
        std::string& list = fs::exists(file, ignored) ? replaced : made;
        list += (list.empty() ? "" : ", ") + file.filename().string();
    }
    if (replaced.empty()) return made;
    return Text("replaces {}{}{}", replaced, made.empty() ? "" : "; ", made);
}

// Returns the place in the name of a file for what tells its pictures apart (docs/cli.md); "": there is one.
const char* PlaceOf(RenderedPictures pictures) {
    switch (pictures) {
        case RenderedPictures::View:
            return "";
        case RenderedPictures::Cameras:
            return "{camera}";
        case RenderedPictures::Frames:
            return "####";
    }
    return "";
}

bool HasPlace(const fs::path& file, RenderedPictures pictures) {
    const std::string name = file.filename().string();
    return name.find(pictures == RenderedPictures::Frames ? "#" : PlaceOf(pictures)) != std::string::npos;
}

session::PictureSettings RequestedSettings(const Workspace& work, const RenderRequest& request) {
    session::PictureSettings settings = ShownSettings(work, passes::View::PathTraced);
    settings.size = request.size;
    settings.crop = request.crop;
    return settings;
}

double SecondsOfFrame(const RenderRequest& request) {
    return 1.0 / double{request.framesPerSecond};
}

// Writes the scene with its unsaved edits, as a file of the same name in a new folder.
std::shared_ptr<const PrivateCopy> CopyOf(const Document& document) {
    fs::path cache = CacheFolder();
    if (cache.empty()) cache = fs::temp_directory_path() / "raygraph";
    std::random_device random;
    SweepCopies(cache / "renders");
    const fs::path folder = cache / "renders" / Text("{:08x}{:08x}", random(), random());
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw MakeError(ErrorKind::Io, "{}: {}", folder, error.message());
    auto copy = std::make_shared<PrivateCopy>(folder / document.File().filename());
    document.SaveCopy(copy->File());
    return copy;
}

}  // namespace

std::string WhyNotRendered(const Workspace& work, const RenderRequest& request) {
    if (work.document.File().empty()) return "there is no scene to render";
    if (request.outputs.empty()) return "choose a name and at least one format";
    for (const fs::path& file : request.outputs) {
        std::error_code error;
        if (std::ranges::count(kFormats, LowerExtension(file)) == 0)
            return Text("{}: must end in .png, .jpg, .exr or .hdr", file);
        if (file.has_parent_path() && !fs::is_directory(file.parent_path(), error))
            return Text("{}: there is no folder {}", file, file.parent_path());
        if (fs::is_directory(file, error)) return Text("{} is a folder", file);
        if (!HasPlace(file, request.pictures))
            return Text("{}: needs {} for its pictures", file, PlaceOf(request.pictures));
    }
    const auto isJpg = [](const fs::path& file) { return LowerExtension(file) == ".jpg"; };
    if (!work.backdrop && std::ranges::any_of(request.outputs, isJpg)) return "a .jpg cannot be transparent";
    if (request.pictures == RenderedPictures::Cameras && !work.FirstCamera())
        return "the scene has no camera";
    if (request.pictures == RenderedPictures::Frames) {
        if (work.timeline.IsEmpty()) return "the scene has no animation";
        if (request.last < request.first) return "the last frame is before the first one";
    }
    try {
        std::ignore = session::SettingsFrom(session::Texts(RequestedSettings(work, request)));
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

RenderTask TaskOf(const Workspace& work, const RenderRequest& request, std::vector<std::string> command) {
    RenderTask task{.command = std::move(command)};
    std::vector<std::string>& words = task.command;
    if (work.document.IsEdited()) {
        task.copy = CopyOf(work.document);
    } else {
        task.scene = work.document.File();
        task.stamp = StampOf(task.scene);
    }
    session::PictureSettings settings = RequestedSettings(work, request);
    words.push_back(FullPath(task.copy ? task.copy->File() : work.document.File()));
    if (request.pictures == RenderedPictures::Cameras) {
        const std::vector<std::string> cameras = CameraChoices(work);
        task.pictures = static_cast<uint32_t>(cameras.size());
        for (const std::string& camera : cameras) AddOption(words, "camera", camera);
        settings.camera.clear();
    } else if (request.pictures == RenderedPictures::Frames) {
        const double step = SecondsOfFrame(request);
        task.pictures = static_cast<uint32_t>((request.last - request.first) / step + 1e-6) + 1;
        AddOption(words, "frames", Text("{}:{}:{}", request.first, request.last, step));
        settings.at.reset();
        settings.clips = scene::ClipsText(work.document.Scene(), work.timeline.Chosen());
        // A camera of the scene may be animated
        if (const std::optional<uint32_t> camera = work.FollowedCamera())
            settings.camera = CameraChoice(work, *camera);
    }
    // A copy needs no files outside of its folder
    if (!task.copy && !work.root.empty()) AddOption(words, "root", FullPath(work.root));
    const bool isShown = std::ranges::any_of(request.outputs, [](const fs::path& file) {
        return LowerExtension(file) == ".png" || LowerExtension(file) == ".jpg";
    });
    std::ranges::move(RenderWords(work, settings, isShown), std::back_inserter(words));
    switch (request.stop) {
        case RenderStop::Clean:
            break;
        case RenderStop::Samples:
            AddOption(words, "spp", std::to_string(request.samples));
            break;
        case RenderStop::Error:
            AddOption(words, "error", session::ToText(0.01f * request.percent));
            break;
        case RenderStop::Time:
            AddOption(words, "time", session::ToText(60.0f * request.minutes));
            break;
    }
    // An .hdr has the mean of the samples
    const bool canDenoise = !std::ranges::all_of(
        request.outputs, [](const fs::path& file) { return LowerExtension(file) == ".hdr"; });
    words.emplace_back(request.isDenoised && canDenoise ? "--denoise" : "--no-denoise");
    for (const fs::path& file : request.outputs) {
        AddOption(words, "output", FullPath(file));
        task.outputs.push_back(file);
        task.name += Text("{}{}", task.name.empty() ? "" : ", ", file);
    }
    AddOption(words, "progress", "json");
    return task;
}

void RenderDialog::Open(const Workspace& work) {
    if (m_request.size.IsEmpty()) m_request.size = work.view.Size();
    const double length = work.timeline.Length();
    if (const fs::path& scene = work.document.File(); m_scene != scene) {
        m_scene = scene;
        SetName(scene.stem().string());
        m_request.first = 0.0;
        m_request.last = length;
    }
    for (double* const seconds : {&m_request.first, &m_request.last}) *seconds = std::min(*seconds, length);
    m_isOpen = m_isNew = true;
    ++m_openedCount;
}

void RenderDialog::SetName(const std::string& name) {
    m_file = {};
    name.copy(m_file.data(), m_file.size() - 1);
}

void RenderDialog::Fill(Extent2D size, uint32_t samples, const fs::path& file) {
    m_request.size = size;
    m_request.stop = RenderStop::Samples;
    m_request.samples = samples;
    m_request.isDenoised = false;
    SetFile(file);
}

void RenderDialog::SetFile(fs::path file) {
    for (size_t i = 0; i < kFormats.size(); ++i) m_formats[i] = LowerExtension(file) == kFormats[i];
    SetName(file.replace_extension().string());
}

RenderRequest RenderDialog::Request() const {
    RenderRequest request = m_request;
    if (request.crop) request.crop = m_crop;
    std::string name = ExpandHome(m_file.data()).string();
    if (name.empty() || name.ends_with('/')) return request;
    if (!HasPlace(name, request.pictures)) name += Text("-{}", PlaceOf(request.pictures));
    for (size_t i = 0; i < kFormats.size(); ++i)
        if (m_formats[i]) request.outputs.emplace_back(name + kFormats[i]);
    return request;
}

std::string RenderDialog::WhyNot(const Workspace& work, const RenderRequest& request) const {
    if (std::string why = WhyNotRendered(work, request); !why.empty()) return why;
    for (const fs::path& file : request.outputs)
        if (m_queue.IsWriting(file)) return Text("{}: a render of the list writes it", file);
    return m_command.empty() ? "there is no program that renders" : "";
}

void RenderDialog::Start(Workspace& work, const RenderRequest& request) {
    if (const std::string why = WhyNot(work, request); !why.empty()) return work.ReportError(why);
    try {
        RenderTask task = TaskOf(work, request, m_command);
        work.ShowMessage(Text("queued {}", task.name));
        m_queue.Add(std::move(task));
    } catch (const Error& error) {
        work.ReportError(Text("not rendered: {}", error.what()));
    }
}

void RenderDialog::Update(Workspace& work) {
    const RenderQueue::Job* job = m_queue.Update();
    if (!job) return;
    if (job->state == RenderQueue::State::Failed)
        work.ReportError(job->result);
    else
        work.ShowMessage(job->result);
}

// --- Drawing ---

namespace {

// Edits pixels, from 0 to kMaxSide.
void PixelFields(const char* label, std::initializer_list<uint32_t*> values) {
    std::array<int, 4> numbers{};
    std::ranges::transform(values, numbers.begin(), [](const uint32_t* value) { return int(*value); });
    const int count = static_cast<int>(values.size());
    if (!ImGui::InputScalarN(label, ImGuiDataType_S32, numbers.data(), count)) return;
    for (size_t i = 0; uint32_t * value : values)
        *value = static_cast<uint32_t>(std::clamp(numbers[i++], 0, kMaxSide));
}

}  // namespace

void RenderDialog::DrawPictures(const Workspace& work) {
    Choose("pictures", m_request.pictures);
    if (m_request.pictures == RenderedPictures::Frames) {
        const double least = 0.0, most = work.timeline.Length();
        std::array seconds{m_request.first, m_request.last};
        if (ImGui::DragScalarN("from, to", ImGuiDataType_Double, seconds.data(), 2, 0.01f, &least, &most,
                               "%.3f s", kClamp)) {
            m_request.first = seconds[0];
            m_request.last = seconds[1];
        }
        ImGui::DragFloat("frames", &m_request.framesPerSecond, 0.1f, 0.1f, 1000.0f, "%.4g a second", kClamp);
    }
    PixelFields("size", {&m_request.size.width, &m_request.size.height});
    bool isCropped = m_request.crop.has_value();
    if (ImGui::Checkbox("crop", &isCropped)) {
        m_request.crop.reset();
        if (isCropped) m_request.crop.emplace();
        if (m_crop.IsEmpty()) m_crop = {0, 0, m_request.size.width, m_request.size.height};
    }
    if (!isCropped) return;
    const float indent = ImGui::CalcTextSize("crop").x + ImGui::GetFrameHeightWithSpacing();
    ImGui::SameLine();
    ImGui::SetNextItemWidth(kField - indent - ImGui::GetStyle().ItemSpacing.x);
    PixelFields("x y w h", {&m_crop.x, &m_crop.y, &m_crop.width, &m_crop.height});
}

void RenderDialog::DrawOptions() {
    Choose("until", m_request.stop);
    int samples = static_cast<int>(m_request.samples);
    if (m_request.stop == RenderStop::Samples && ImGui::InputInt("samples", &samples))
        m_request.samples = static_cast<uint32_t>(std::clamp(samples, 1, 1 << 24));
    if (m_request.stop == RenderStop::Error)
        ImGui::DragFloat("error", &m_request.percent, 0.01f, 0.001f, 100.0f, "%.3g %%", kClamp);
    if (m_request.stop == RenderStop::Time)
        ImGui::DragFloat("time", &m_request.minutes, 0.1f, 0.01f, 1e5f, "%.3g min", kClamp);
    ImGui::Checkbox("denoise", &m_request.isDenoised);
}

bool RenderDialog::DrawFile(FileDialog& files) {
    if (std::exchange(m_isNew, false)) ImGui::SetKeyboardFocusHere();
    // A field that is being edited would write over a new name
    ImGui::PushID(m_openedCount);
    const bool isEntered =
        ImGui::InputText("##file", m_file.data(), m_file.size(),
                         ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
    ImGui::PopID();
    ImGui::SameLine();
    if (ImGui::Button("file..."))
        files.Ask({.title = "Render to",
                   .hint = "The file of the picture: .png, .jpg, .exr or .hdr",
                   .purpose = FileQuestion::For::Writing,
                   .suggestion = std::string(m_file.data()) + kFormats[0],
                   .extensions = {kFormats.begin(), kFormats.end()}},
                  [this](const fs::path& file) {
                      if (std::ranges::count(kFormats, LowerExtension(file)) == 0)
                          return Text("{}: must end in .png, .jpg, .exr or .hdr", file);
                      SetFile(file);
                      return std::string();
                  });
    for (size_t i = 0; i < kFormats.size(); ++i) {
        if (i > 0) ImGui::SameLine();
        ImGui::Checkbox(kFormats[i], &m_formats[i]);
    }
    return isEntered;
}

void RenderDialog::Draw(Workspace& work, FileDialog& files) {
    if (!m_isOpen) return;
    const ImVec2 window = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({0.5f * window.x, 0.45f * window.y}, ImGuiCond_Appearing, {0.5f, 0.5f});
    ImGui::SetNextWindowSizeConstraints({0.0f, 0.0f}, {0.95f * window.x, 0.85f * window.y});
    if (ImGui::Begin("Render image", &m_isOpen,
                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings)) {
        ImGui::PushItemWidth(kField);
        const bool isEntered = DrawFile(files);
        ImGui::Separator();
        DrawPictures(work);
        ImGui::Separator();
        DrawOptions();
        ImGui::PopItemWidth();

        const RenderRequest request = Request();
        const std::string why = WhyNot(work, request);
        ImGui::BeginDisabled(!why.empty());
        const bool isPressed = ImGui::Button("Render");
        ImGui::EndDisabled();
        if (isPressed || isEntered) Start(work, request);
        ImGui::SameLine();
        if (!why.empty())
            ImGui::TextColored({0.95f, 0.35f, 0.3f, 1.0f}, "%s", why.c_str());
        else
            ImGui::TextDisabled("%s", OutputsText(request.outputs).c_str());
        DrawQueue();
    }
    ImGui::End();
}

void RenderDialog::DrawQueue() {
    if (m_queue.Jobs().empty()) return;
    ImGui::Separator();
    bool hasOver = false;
    for (size_t i = 0; i < m_queue.Jobs().size(); ++i) {
        const RenderQueue::Job& job = m_queue.Jobs()[i];
        const bool isRunning = job.state == RenderQueue::State::Running;
        ImGui::PushID(static_cast<int>(i));
        ImGui::ProgressBar(job.Fraction(), {kProgress, 0.0f}, isRunning ? nullptr : Name(job.state));
        if (isRunning) {
            ImGui::SameLine();
            if (ImGui::Button("Stop and save")) m_queue.Stop(i);
        }
        if (!job.IsOver()) {
            ImGui::SameLine();
            if (ImGui::Button("Cancel")) m_queue.Cancel(i);
        }
        hasOver |= job.IsOver();
        ImGui::PushTextWrapPos(kProgress + 180.0f);
        const std::string text = isRunning            ? Text("{}: {}", job.task.name, job.progress.text)
                                 : job.result.empty() ? job.task.name
                                                      : job.result;
        ImGui::TextDisabled("%s", text.c_str());
        ImGui::PopTextWrapPos();
        ImGui::PopID();
    }
    if (hasOver && ImGui::Button("Clear the list")) m_queue.RemoveOver();
}

void RenderDialog::DrawStatus() {
    const RenderQueue::Job* const job = m_queue.Running();
    if (!job) return;
    ImGui::SameLine();
    ImGui::Text("rendering: %s", job->progress.text.c_str());
}

}  // namespace raygraph::editor
