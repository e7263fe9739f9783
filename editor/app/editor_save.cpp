// Reads and writes files for the editor: the dialogs that ask for a path, and pictures that are being
// written.
#include <utility>

#include "base/atomic_file.h"
#include "base/counted.h"
#include "base/extension.h"
#include "base/path_text.h"
#include "base/text.h"
#include "editor/app/editor.h"
#include "editor/app/saved_render.h"
#include "renderer/graph/readback_values.h"
#include "renderer/image/exr_threads.h"
#include "renderer/image/image.h"

namespace raygraph::editor {

namespace {

image::Image8 ToImage(const Readback& texels, bool isSwapped) {
    image::Image8 picture{texels.Extent().width, texels.Extent().height, ValuesOf<uint8_t>(texels)};
    for (size_t i = 0; i + 3 < picture.rgba.size(); i += 4) {
        if (isSwapped) std::swap(picture.rgba[i], picture.rgba[i + 2]);
        picture.rgba[i + 3] = 255;
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
            if (answer == UnsavedDialog::Answer::Cancel) return;
            // If saving fails, the edits are kept, and the message says why
            if (answer == UnsavedDialog::Answer::Save && !SaveScene(file)) return;
            then();
        });
}

void Editor::Open(const std::filesystem::path& file) {
    if (Workspace::IsEnvironment(file))
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
        StoreSettings();      // stores the file in the list of recent ones
    };
    if (m_work.document.ChangeCount() == m_discardedChanges)
        show();
    else  // edited since Open asked
        ConfirmDiscard(Text("opening {}", loaded->document.File()), show);
}

void Editor::Leave() {
    ConfirmDiscard("closing the editor", [this] { m_isQuitting = true; });
}

void Editor::ShowOpenDialog() {
    m_dialog.Ask("Open a scene",
                 "glTF file (.gltf or .glb), or an environment map (.hdr or .exr); both may be dropped onto "
                 "the window",
                 PathDialog::For::Reading, m_work.document.File(),
                 [this](const std::filesystem::path& file) { Open(file); });
}

void Editor::ShowSavePictureDialog() {
    const std::string name = m_work.document.File().stem().string();
    m_dialog.Ask("Save the picture", "As shown: .png. Linear, with variance and AOVs: .exr",
                 PathDialog::For::Writing, (name.empty() ? "raygraph" : name) + ".png",
                 [this](const std::filesystem::path& file) { SavePicture(file); });
}

void Editor::ShowSaveSceneDialog() {
    if (m_work.document.File().empty()) return;
    std::filesystem::path suggestion = m_work.document.File();
    m_dialog.Ask("Save the scene", "With all edits: .gltf or .glb", PathDialog::For::Writing, suggestion,
                 [this](const std::filesystem::path& file) { SaveScene(file); });
}

void Editor::SetConfigFolder(const std::filesystem::path& folder) {
    m_config = folder;
    std::string message;
    m_kept = ReadSettings(folder, message);
    m_work.Take(m_kept);
    if (!message.empty()) m_work.Refuse(message);
}

void Editor::StoreSettings() {
    if (m_config.empty()) return;
    Settings settings = m_work.Kept();
    settings.window = m_windowSize.IsEmpty() ? m_kept.window : m_windowSize;
    if (settings == m_kept) return;
    try {
        WriteSettings(m_config, settings);
        m_kept = settings;
    } catch (const Error& error) {
        m_work.Refuse(error.what());
    }
}

void Editor::SavePicture(const std::filesystem::path& file) {
    const std::string extension = LowerExtension(file);
    if (extension != ".exr") {
        if (extension != ".png")
            m_work.Refuse(Text("{}: must end in .png or .exr", file));
        else
            m_pictureFile = file;
        return;
    }
    if (m_work.view.Show().view == viewport::View::Surface) {
        m_work.Refuse(
            Text("{}: this view shows no light; an .exr holds the path-traced or the raster view", file));
    } else if (m_work.view.Size().IsEmpty()) {
        m_work.Refuse(Text("{}: there is no picture", file));
    } else {
        m_work.Say(Text("saving {} ...", file));
        m_savingRenders.push_back({.file = file, .capture = m_work.view.RequestCapture()});
    }
}

bool Editor::IsSaving(bool hasDrawn) {
    const auto giveUp = [&](const std::filesystem::path& file) {
        if (!file.empty())
            m_work.Refuse(Text("{}: not saved, the editor was closed without a picture", file));
    };
    // A drawn frame has taken these files unless there was no picture
    giveUp(std::exchange(m_pictureFile, {}));
    giveUp(std::exchange(m_windowFile, {}));
    // A surface view has no render
    if (!hasDrawn || m_work.view.Show().view == viewport::View::Surface)
        std::erase_if(m_savingRenders, [&](const SavingRender& saving) {
            if (!saving.isTaken) giveUp(saving.file);
            return !saving.isTaken;
        });
    return !m_saving.empty() || !m_savingRenders.empty() || m_worker.IsBusy();
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
    m_worker.Add(std::move(write), [this](const std::string& why) { m_work.Refuse(why); });
}

void Editor::ReportSaved(std::string text) {
    ++m_savedCount;
    m_work.Say(std::move(text));
}

void Editor::FinishSaving() {
    m_worker.FinishTasks();
    std::erase_if(m_saving, [&](const Saving& saving) {
        if (!saving.texels.IsReady()) return false;
        WriteBeside([this, saving]() -> Worker::Finish {
            const std::string note = NoteFor(saving.file);
            image::WritePng(saving.file, ToImage(saving.texels, saving.isSwapped));
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
                const std::string note = NoteFor(saving.file);
                session::WriteRenderFile(saving.file, render, log);
                return [this, content,
                        text = Text("saved {}, {}{}", saving.file,
                                    Counted(SampleCount(render.samples), "sample"), note)] {
                    m_work.document.Know(content);
                    ReportSaved(text);
                };
            });
        return true;
    });
}

}  // namespace raygraph::editor
