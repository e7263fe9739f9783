#include "editor/app/script.h"

#include <algorithm>
#include <chrono>

#include "base/overloaded.h"
#include "base/read_file.h"
#include "base/text.h"
#include "renderer/scene/gltf/still_scene.h"
#include "renderer/scene/model/variants.h"

namespace raygraph::editor {

namespace {

constexpr int kDragSteps = 8;
constexpr std::string_view kNoVariant = "none";
constexpr std::chrono::seconds kMaxWait{300};
constexpr uint64_t kMaxScriptBytes = 1 << 20;

std::string TextOf(const std::filesystem::path& file) {
    const std::vector<std::byte> bytes = ReadFile(file, kMaxScriptBytes);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Returns whether the view has `wanted` samples, or as many as it can have.
bool HasSamples(const viewport::Viewport& view, uint32_t wanted) {
    const viewport::ViewportProgress progress = view.Progress();
    const viewport::View shown = view.Show().view;
    return (!ShowsPathTraced(shown) || progress.pathTracedSamples >= wanted) &&
           (!ShowsRaster(shown) ||
            (progress.rasterSamples > 0 &&
             (progress.rasterSamples >= wanted || progress.rasterSamples == progress.rasterSamplesWanted)));
}

}  // namespace

Script::Script(const std::filesystem::path& file)
    : m_file(file), m_lines(ParseScript(TextOf(file), file.string())) {
    m_input.extent = {1280, 720};
}

void Script::Fail(const ScriptLine& line, const std::string& why) const {
    ThrowLineError(m_file.string(), line.number, line.text, why);
}

void Script::Frame(Editor& editor, Screen& screen) {
    editor.Frame(m_input, screen);
    if (!editor.FrameError().empty()) throw Error(ErrorKind::BadInput, editor.FrameError());
    m_input.pressed.clear();
    m_input.text.clear();
    m_input.dropped.clear();
    m_input.isClosing = false;
    m_input.wheel = 0.0f;
}

void Script::PlayAnimation(double seconds, Editor& editor, Screen& screen) {
    const float step = m_input.seconds;
    editor.Work().timeline.Play();
    while (seconds > 0.0) {
        m_input.seconds = static_cast<float>(std::min(seconds, double{step}));
        seconds -= double{m_input.seconds};
        Frame(editor, screen);
    }
    m_input.seconds = step;
    editor.Work().timeline.Pause();
}

void Script::Play(Editor& editor, Screen& screen) {
    Frame(editor, screen);
    for (const ScriptLine& line : m_lines) {
        try {
            Do(line, editor, screen);
        } catch (const Error& error) {
            if (error.Kind() != ErrorKind::Usage) throw;
            Fail(line, error.what());
        }
    }
    editor.StoreSettings();
}

void Script::Do(const ScriptLine& line, Editor& editor, Screen& screen) {
    const auto frame = [&] { Frame(editor, screen); };
    const auto until = [&](const char* what, auto&& isDone) {
        const auto start = std::chrono::steady_clock::now();
        while (std::chrono::steady_clock::now() - start < kMaxWait) {
            frame();
            if (isDone()) return;
        }
        Fail(line, Text("still not {} after {} s; {}", what, kMaxWait.count(), editor.Work().message));
    };
    const auto orFail = [&](auto&& action) {
        try {
            action();
        } catch (const Error& error) {
            Fail(line, error.what());
        }
    };
    const auto requireAnimations = [&] {
        if (editor.Work().timeline.IsEmpty()) Fail(line, "the scene has no animations");
    };
    std::visit(
        Overloaded{[&](const SetSize& command) {
                       m_input.extent = command.extent;
                       frame();
                   },
                   [&](const SetScale& command) {
                       m_input.scale = command.scale;
                       frame();
                   },
                   [&](const DropFile& command) {
                       m_input.dropped.push_back(command.file);
                       frame();
                   },
                   [&](const CloseWindow&) {
                       m_input.isClosing = true;
                       frame();
                       frame();  // draws the question, if there is one
                   },
                   [&](const PressKey& command) {
                       m_input.isControl = command.isControl;
                       m_input.isShift = command.isShift;
                       m_input.pressed.push_back(command.key);
                       m_input.keys[static_cast<size_t>(command.key)] = true;
                       frame();
                       m_input.keys[static_cast<size_t>(command.key)] = false;
                       m_input.isControl = m_input.isShift = false;
                       frame();
                   },
                   [&](const MoveMouse& command) {
                       m_input.mouse = command.place;
                       frame();
                   },
                   [&](const HoldButton& command) {
                       bool& isHeld = m_input.buttons[static_cast<size_t>(command.button)];
                       if (command.isDown) {
                           isHeld = true;
                           frame();
                       }
                       for (int i = 0; i < kDragSteps && command.isDragged; ++i) {
                           m_input.mouse += command.way / float(kDragSteps);
                           frame();
                       }
                       if (command.isUp) {
                           isHeld = false;
                           frame();
                       }
                   },
                   [&](const ScrollWheel& command) {
                       m_input.wheel = command.notches;
                       frame();
                   },
                   [&](const TypeText& command) {
                       m_input.text = command.text;
                       frame();
                   },
                   [&](const AdvanceFrames& command) {
                       for (uint32_t i = 0; i < command.count; ++i) frame();
                   },
                   [&](const WaitUntilDone&) { until("done", [&] { return !editor.IsBusy(); }); },
                   [&](const WaitForSamples& command) {
                       until("there", [&] { return HasSamples(editor.Work().view, command.count); });
                   },
                   [&](const SaveShown& command) {
                       const uint64_t before = editor.SavedCount();
                       if (command.isWindow)
                           editor.SaveWindow(command.file);
                       else
                           editor.SavePicture(command.file);
                       until("saved", [&] { return !editor.IsBusy(); });
                       // The existence of the file is no proof: it may be an old one
                       if (editor.SavedCount() == before) Fail(line, editor.Work().message);
                   },
                   [&](const SetBudget& command) { editor.Work().frameMs = command.frameMs; },
                   [&](const UseConfigFolder& command) {
                       editor.SetConfigFolder(command.folder);
                       frame();
                   },
                   [&](const SaveSceneFile& command) {
                       if (!editor.SaveScene(command.file)) Fail(line, editor.Work().message);
                       frame();
                   },
                   [&](const ShowView& command) {
                       editor.Work().view.SetView(command.view);
                       frame();
                   },
                   [&](const ShowVariant& command) {
                       Workspace& work = editor.Work();
                       const scene::SceneData& scene = work.document.Scene();
                       const std::string choice = command.choice == kNoVariant ? "" : command.choice;
                       orFail([&] { work.ShowVariant(FindVariant(scene, choice)); });
                       frame();
                   },
                   [&](const PlayFor& command) {
                       requireAnimations();
                       PlayAnimation(command.seconds, editor, screen);
                   },
                   [&](const ShowTime& command) {
                       requireAnimations();
                       editor.Work().timeline.Seek(command.seconds);
                       frame();
                   },
                   [&](const StopPlaying&) {
                       editor.Work().timeline.Stop();
                       frame();
                   },
                   [&](const ChooseClips& command) {
                       Workspace& work = editor.Work();
                       const scene::SceneData& scene = work.document.Scene();
                       orFail([&] {
                           const std::vector<scene::ClipState> clips = FindClips(scene, command.list, 0.0);
                           RequirePlayable(scene, clips);
                           work.timeline.Choose(clips);
                       });
                       frame();
                   },
                   [&](const SetBaseColor& command) {
                       Workspace& work = editor.Work();
                       if (!work.selectedMaterial) Fail(line, "no material is selected");
                       scene::Material material = work.document.Scene().materials[*work.selectedMaterial];
                       material.baseColorFactor = glm::vec4(command.color, 1.0f);
                       work.Apply(MaterialEdit{*work.selectedMaterial, material});
                       work.document.Settle();
                       frame();
                   },
                   [&](const Expectation& expected) { Expect(line, expected, editor); }},
        line.command);
}

void Script::Expect(const ScriptLine& line, const Expectation& expected, Editor& editor) const {
    using Of = Expectation::Of;
    Workspace& work = editor.Work();
    const auto require = [&](bool holds, const std::string& actual) {
        if (!holds) Fail(line, Text("it is '{}'", actual));
    };
    const auto requireAnswer = [&](bool actual) {
        require(actual == (expected.number != 0), actual ? "yes" : "no");
    };
    const uint32_t samples = work.view.Progress().pathTracedSamples;
    const size_t edits = work.document.EditCount();
    const std::string view = Name(work.view.Show().view);
    const std::string selected =
        work.selectedNode ? work.document.Scene().nodes[*work.selectedNode].name : "nothing";
    const Timeline& timeline = work.timeline;
    const std::string time = timeline.IsAtRest() ? "rest" : Text("{:.3f}", timeline.Seconds());
    const uint32_t variant = work.document.Scene().variant;
    const std::string shown = variant == scene::kNone ? std::string(kNoVariant)
                                                      : scene::VariantText(work.document.Scene(), variant);
    switch (expected.of) {
        case Of::Selected:
            return require(selected == expected.text, selected);
        case Of::View:
            return require(view == Name(expected.view), view);
        case Of::Variant:
            return require(shown == expected.text, shown);
        case Of::Message:
            return require(work.message.find(expected.text) != std::string::npos, work.message);
        case Of::Edits:
            return require(edits == expected.number, std::to_string(edits));
        case Of::Time:
            return require(time == expected.text, time);
        case Of::Playing:
            return requireAnswer(timeline.IsPlaying());
        case Of::Asking:
            return requireAnswer(editor.IsPrompting());
        case Of::Leaving:
            return requireAnswer(editor.IsQuitting());
        case Of::SamplesBelow:
            return require(samples < expected.number, std::to_string(samples));
        case Of::SamplesAbove:
            return require(samples > expected.number, std::to_string(samples));
    }
}

}  // namespace raygraph::editor
