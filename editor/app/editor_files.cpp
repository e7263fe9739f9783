// Implements the files of Editor: the dialogs that ask for a path, and pictures that are being written.
#include <algorithm>
#include <array>
#include <system_error>
#include <utility>

#include "base/files.h"
#include "base/text.h"
#include "editor/app/editor.h"
#include "editor/app/file_content.h"
#include "renderer/graph/readback_values.h"
#include "renderer/image/exr.h"
#include "renderer/image/image.h"

namespace raygraph::editor {

namespace {

image::Image8 ToImage(const Readback& texels, bool isSwapped, bool hasAlpha) {
    image::Image8 picture{texels.Extent().width, texels.Extent().height, ValuesOf<uint8_t>(texels)};
    for (size_t i = 0; i + 3 < picture.rgba.size(); i += 4) {
        if (isSwapped) std::swap(picture.rgba[i], picture.rgba[i + 2]);
        if (!hasAlpha) picture.rgba[i + 3] = 255;
    }
    return picture;
}

// Returns what the message about a saved file adds to its name. Throws as AtomicFile does.
std::string NoteFor(const std::filesystem::path& file) {
    const std::string note = InPlaceWarning(file);
    return note.empty() ? note : ", " + note;
}

}  // namespace

void Editor::ConfirmDiscard(const std::string& loss, std::function<void()> then) {
    if (!m_work.document.IsEdited()) {
        then();
        return;
    }
    const std::filesystem::path file = m_work.document.File();
    m_unsaved.Ask(
        Text("{} has edits that are not saved; they are lost by {}. Save writes over the file.", file, loss),
        [this, file, then = std::move(then)](UnsavedDialog::Answer answer) {
            if (answer == UnsavedDialog::Answer::Cancel) {
                m_lostRenders = 0;
                return;
            }
            // If saving fails, the edits are kept, and the message says why
            if (answer == UnsavedDialog::Answer::Save && !SaveScene(file)) return;
            then();
        });
}

void Editor::Open(const std::filesystem::path& file) {
    std::error_code error;
    if (!std::filesystem::exists(file, error))
        m_work.ReportError(Text("{}: there is no such file", file));
    else if (Workspace::IsEnvironment(file))
        m_work.Open(file);
    else
        ConfirmDiscard(Text("opening {}", file), [this, file] {
            if (!m_work.loader.IsLoading()) m_discardedChanges = m_work.document.ChangeCount();
            m_work.Open(file);
        });
}

void Editor::FinishLoading() {
    if (std::optional<LoadedScene> loaded = m_work.FinishLoading()) m_loaded = std::move(loaded);
    if (!m_loaded || IsPrompting() || m_isQuitting) return;
    const auto loaded = std::make_shared<LoadedScene>(std::move(*m_loaded));
    m_loaded.reset();
    const auto show = [this, loaded] {
        if (!m_work.Show(std::move(*loaded))) return;
        m_isPicking = false;  // the pick's scene is gone
        ++m_sceneCount;
        if (m_render.IsOpen()) m_render.Open(m_work);
        StoreSettings();  // stores the file in the list of recent ones
    };
    if (m_work.document.ChangeCount() == m_discardedChanges)
        show();
    else  // the scene was edited after Open had asked
        ConfirmDiscard(Text("opening {}", loaded->document.File()), show);
}

void Editor::Leave() {
    const RenderQueue& renders = m_render.Queue();
    if (renders.IsBusy() && std::exchange(m_lostRenders, renders.AddedCount()) != renders.AddedCount())
        return m_work.ReportError("renders are not done yet: closing the editor again cancels them");
    ConfirmDiscard("closing the editor", [this] { m_isQuitting = true; });
}

namespace {

constexpr std::array<std::string_view, 4> kOpened{".gltf", ".glb", ".hdr", ".exr"};

// Returns why no scene and no map can be read from there; "": perhaps one can.
std::string WhyNotOpened(const std::filesystem::path& file) {
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) return Text("{} is a folder", file);
    if (!std::filesystem::exists(file, error)) return Text("{}: there is no such file", file);
    if (std::ranges::count(kOpened, LowerExtension(file)) == 0)
        return Text("{} is neither a scene (.gltf, .glb) nor a map (.hdr, .exr)", file);
    return {};
}

}  // namespace

void Editor::ShowOpenDialog() {
    m_dialog.Ask(
        {.title = "Open a scene",
         .hint = "A scene (.gltf, .glb) or an environment map (.hdr, .exr); both may be dropped onto "
                 "the window",
         .purpose = FileQuestion::For::Reading,
         .suggestion = m_work.document.File(),
         .extensions = {kOpened.begin(), kOpened.end()}},
        [this](const std::filesystem::path& file) {
            const std::string why = WhyNotOpened(file);
            if (why.empty()) Open(file);
            return why;
        });
}

void Editor::ShowReplaceImageDialog(uint32_t texture) {
    const std::string current = m_work.document.ImageOf(texture).file;
    m_dialog.Ask({.title = "Exchange the image",
                  .hint = "A picture for the textures that show this image: .png, .jpg, .webp, .dds, .ktx2",
                  .purpose = FileQuestion::For::Reading,
                  .suggestion = m_work.document.File().parent_path() / current,
                  .extensions = {".png", ".jpg", ".jpeg", ".webp", ".dds", ".ktx2"}},
                 [this, texture, scene = m_sceneCount](const std::filesystem::path& file) {
                     if (scene == m_sceneCount) return m_work.ReplaceImage(texture, file);
                     m_work.ReportError("no image was exchanged: its scene has been closed");
                     return std::string();  // ends the dialog
                 });
}

std::string Editor::PictureName(const std::string& stem) const {
    return stem + (m_work.view.Progress().denoisedSamples > 0 ? "-denoised.png" : ".png");
}

void Editor::ShowSavePictureDialog() {
    const std::string name = m_work.document.File().stem().string();
    m_dialog.Ask({.title = "Save the picture",
                  .hint = "As shown: .png. Linear, with variance and AOVs: .exr",
                  .purpose = FileQuestion::For::Writing,
                  .suggestion = PictureName(name.empty() ? "raygraph" : name),
                  .extensions = {".png", ".exr"}},
                 [this](const std::filesystem::path& file) {
                     const std::string why = WhyNotSaved(file);
                     if (why.empty()) SavePicture(file);
                     return why;
                 });
}

RenderDialog& Editor::OpenRenderDialog() {
    m_render.Open(m_work);
    return m_render;
}

void Editor::SaveEdits() {
    if (m_work.document.IsEdited())
        SaveScene(m_work.document.File());
    else
        m_work.SaveView();
}

std::filesystem::path Editor::ScreenshotName() const {
    const std::string stem = m_work.document.File().stem().string();
    for (uint32_t number = 1;; ++number) {
        const std::filesystem::path name =
            PictureName(Text("{}-{:04}", stem.empty() ? "raygraph" : stem, number));
        std::error_code error;
        if (!std::filesystem::exists(name, error)) return name;
    }
}

void Editor::ShowSaveSceneDialog() {
    m_dialog.Ask({.title = "Save the scene",
                  .hint = "With all edits: .gltf or .glb",
                  .purpose = FileQuestion::For::Writing,
                  .suggestion = m_work.document.File(),
                  .extensions = {".gltf", ".glb"}},
                 [this](const std::filesystem::path& file) {
                     return SaveScene(file) ? std::string() : m_work.message;
                 });
}

void Editor::SetConfigFolder(const std::filesystem::path& folder) {
    m_config = folder;
    std::string message;
    m_kept = ReadSettings(folder, message);
    m_work.Take(m_kept);
    if (!message.empty()) m_work.ReportError(message);
}

void Editor::StoreSettings() {
    if (m_config.empty()) return;
    Settings settings = m_work.SettingsToSave();
    settings.window = m_windowSize.IsEmpty() ? m_kept.window : m_windowSize;
    if (settings == m_kept) return;
    try {
        WriteSettings(m_config, settings);
        m_kept = settings;
    } catch (const Error& error) {
        m_work.ReportError(error.what());
    }
}

std::string Editor::WhyNotSaved(const std::filesystem::path& picture) const {
    const std::string extension = LowerExtension(picture);
    std::error_code error;
    if (extension != ".exr" && extension != ".png") return Text("{}: must end in .png or .exr", picture);
    if (picture.has_parent_path() && !std::filesystem::is_directory(picture.parent_path(), error))
        return Text("{}: there is no folder {}", picture, picture.parent_path());
    if (extension == ".png") return {};
    if (m_work.view.Show().view == viewport::View::Surface)
        return Text("{}: this view shows no light; an .exr holds the path-traced or the raster view",
                    picture);
    return m_work.view.Size().IsEmpty() ? Text("{}: there is no picture", picture) : "";
}

void Editor::SavePicture(const std::filesystem::path& file) {
    if (const std::string why = WhyNotSaved(file); !why.empty()) {
        m_work.ReportError(why);
    } else if (LowerExtension(file) == ".png") {
        m_pictureFile = file;
    } else {
        m_work.ShowMessage(Text("saving {} ...", file));
        m_savingRenders.push_back({.file = file, .capture = m_work.view.RequestCapture()});
    }
}

bool Editor::IsSaving(bool hasDrawn) {
    const auto giveUp = [&](const std::filesystem::path& file) {
        if (!file.empty())
            m_work.ReportError(Text("{}: not saved, the editor was closed without a picture", file));
    };
    // A drawn frame has taken these files unless there was no picture, or no sample of it yet
    const bool isAwaitingSample = hasDrawn && !m_pictureFile.empty() && !HasSample();
    if (!isAwaitingSample) giveUp(std::exchange(m_pictureFile, {}));
    giveUp(std::exchange(m_windowFile, {}));
    // A surface view has no render
    if (!hasDrawn || m_work.view.Show().view == viewport::View::Surface)
        std::erase_if(m_savingRenders, [&](const SavingRender& saving) {
            if (!saving.isTaken) giveUp(saving.file);
            return !saving.isTaken;
        });
    return isAwaitingSample || !m_saving.empty() || !m_savingRenders.empty() || m_worker.IsBusy();
}

void Editor::HandleCaptures() {
    for (SavingRender& saving : m_savingRenders) {
        if (saving.isTaken || !saving.capture.IsTaken()) continue;
        saving.isTaken = true;
        saving.shown = m_work.Shown();
        saving.content = m_work.document.Content();
        saving.content.pointsAndLines = m_work.pointsAndLines;
    }
}

void Editor::WriteBeside(Worker::Task write) {
    m_worker.Add(std::move(write), [this](const std::string& why) { m_work.ReportError(why); });
}

void Editor::ReportSaved(std::string text) {
    ++m_savedCount;
    m_work.ShowMessage(std::move(text));
}

void Editor::FinishSaving() {
    m_worker.FinishTasks();
    std::erase_if(m_saving, [&](const Saving& saving) {
        if (!saving.texels.IsReady()) return false;
        WriteBeside([this, saving]() -> Worker::Finish {
            const std::string denoised =
                saving.denoisedSamples > 0
                    ? Text(", denoised from {}", Counted(saving.denoisedSamples, "sample"))
                    : "";
            const std::string note = denoised + NoteFor(saving.file);
            image::WritePng(saving.file, ToImage(saving.texels, saving.isSwapped, saving.hasAlpha));
            return [this, text = Text("saved {}{}", saving.file, note)] { ReportSaved(text); };
        });
        return true;
    });
    std::erase_if(m_savingRenders, [&](const SavingRender& saving) {
        if (!saving.capture.IsReady()) return false;
        // The scene may have to be read again to find out whether its hash is still valid
        WriteBeside(
            [this, saving, device = m_work.device.Info(), log = m_work.device.Log()]() -> Worker::Finish {
                const FileContent content = WithHash(saving.content, log);
                ShownScene shown = saving.shown;
                shown.input.hash = content.hash;
                const session::RenderFile render = RenderOf(saving.capture.Result(), shown, device);
                const image::ExrThreads threads;
                const std::string note =
                    (render.denoised.empty() ? "" : ", with a denoised picture") + NoteFor(saving.file);
                session::WriteRenderFile(saving.file, render, log);
                return [this, content,
                        text = Text("saved {}, {}{}", saving.file,
                                    Counted(SampleCount(render.samples), "sample"), note)] {
                    m_work.document.RecordContent(content);
                    ReportSaved(text);
                };
            });
        return true;
    });
}

}  // namespace raygraph::editor
